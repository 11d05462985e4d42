// Boxes: the texels that a triangle may touch, from its corners alone, and the tiles they are cut into. Twin of
// src/igt/cover/boxes.rs.
#ifndef IGT_BOXES_GLSL
#define IGT_BOXES_GLSL

#include "common/igt_line.glsl"

// The octant's number in IgtBox.octant is joined by this flag where the triangle reaches into several.
#define IGT_SEVERAL_OCTANTS 8u
// The most texels of a tile: the bits of a mask.
#define IGT_TILE 32u

struct IgtBox {
    uint column, row, width, height, octant;
};

// Columns and rows of the tiles a box is cut into.
uvec2 igt_tile_size(IgtBox b) {
    if (b.width * b.height <= IGT_TILE) return uvec2(b.width, b.height);
    if (b.height < 4u) return uvec2(IGT_TILE / b.height, b.height);
    if (b.width < 8u) return uvec2(b.width, IGT_TILE / b.width);
    return uvec2(8u, 4u);
}

uint igt_tiles(IgtBox b) {
    uvec2 size = igt_tile_size(b);
    return ((b.width + size.x - 1u) / size.x) * ((b.height + size.y - 1u) / size.y);
}

// The i-th tile of a box. Its columns are not yet taken modulo the table's width.
IgtBox igt_tile(IgtBox b, uint i) {
    uvec2 size = igt_tile_size(b);
    uint across = (b.width + size.x - 1u) / size.x;
    uvec2 at = uvec2(i % across, i / across) * size;
    return IgtBox(b.column + at.x, b.row + at.y, min(size.x, b.width - at.x), min(size.y, b.height - at.y), b.octant);
}

uvec2 igt_rows(uint bits, int a, int b, int c) {
    int low = min(min(a, b), c), high = max(max(a, b), c);
    return uvec2(igt_row(bits, low * (1 << IGT_QUERY_SHIFT)), igt_row(bits, high * (1 << IGT_QUERY_SHIFT)));
}

IgtBox igt_parallel_box(uint bits, ivec3 v[3]) {
    uvec2 x = igt_rows(bits, v[0].x, v[1].x, v[2].x), y = igt_rows(bits, v[0].y, v[1].y, v[2].y);
    return IgtBox(x.x, y.x, x.y - x.x + 1u, y.y - y.x + 1u, 0u);
}

int igt_turn(ivec3 a, ivec3 b) {
    return igt_sign64(igt_cross64(a.x, b.y, a.y, b.x));
}

// The vertex that has all others on one side (sign 1: left) within half a turn; 3 where there is none.
int igt_extreme(ivec3 v[3], int side) {
    for (int i = 0; i < 3; i++) {
        if (v[i].xy == ivec2(0)) continue;
        bool all_there = true;
        for (int j = 0; j < 3; j++) {
            all_there = all_there && (v[j].xy == ivec2(0) || side * igt_turn(v[i], v[j]) >= 0);
        }
        if (all_there) return i;
    }
    return 3;
}

IgtBox igt_cylinder_box(uint bits, ivec3 v[3]) {
    uvec2 y = igt_rows(bits, v[0].z, v[1].z, v[2].z);
    IgtBox around = IgtBox(0u, y.x, 1u << bits, y.y - y.x + 1u, 0u);
    ivec3 turns = ivec3(igt_turn(v[0], v[1]), igt_turn(v[1], v[2]), igt_turn(v[2], v[0]));
    if (turns == ivec3(1) || turns == ivec3(-1)) return around;
    int first = igt_extreme(v, 1), last = igt_extreme(v, -1);
    if (first == 3 || last == 3) return around;
    if (turns == ivec3(0)) {
        for (int i = 0; i < 3; i++) {
            uvec2 along = igt_add64(igt_mul(v[i].x, v[first].x), igt_mul(v[i].y, v[first].y));
            if (igt_sign64(along) < 0) return around;
        }
    }
    uint a = igt_diamond_column(bits, v[first]), b = igt_diamond_column(bits, v[last]);
    around.column = a;
    around.width = ((b + (1u << bits) - a) & ((1u << bits) - 1u)) + 1u;
    return around;
}

// The octant that holds all three vertices, zero counted with either side; 8 where there is none.
uint igt_common_octant(ivec3 v[3]) {
    uint octant = 0u;
    for (int k = 0; k < 3; k++) {
        int low = min(min(v[0][k], v[1][k]), v[2][k]), high = max(max(v[0][k], v[1][k]), v[2][k]);
        if (low >= 0) continue;
        if (high > 0) return 8u;
        octant |= 1u << k;
    }
    return octant;
}

bvec3 igt_negatives(uint octant) {
    return bvec3((octant & 1u) != 0u, (octant & 2u) != 0u, (octant & 4u) != 0u);
}

void igt_grow(uint bits, ivec3 p, uint octant, inout uvec2 low, inout uvec2 high) {
    uvec2 texel = igt_octahedral_texel(bits, p, igt_negatives(octant));
    low = min(low, texel);
    high = max(high, texel);
}

IgtBox igt_octant_box(uint bits, ivec3 v[3], uint octant) {
    uvec2 low = uvec2((1u << bits) - 1u), high = uvec2(0u);
    for (int i = 0; i < 3; i++) igt_grow(bits, v[i], octant, low, high);
    return IgtBox(low.x, low.y, high.x - low.x + 1u, high.y - low.y + 1u, octant);
}

bool igt_in_octant(bvec3 negative, ivec3 signs) {
    for (int k = 0; k < 3; k++) {
        if (negative[k] ? signs[k] > 0 : signs[k] < 0) return false;
    }
    return true;
}

// A parallel vector that fits the query grid's range.
ivec3 igt_shorten(uvec2 x, uvec2 y, uvec2 z) {
    uvec2 ax = igt_size64(x), ay = igt_size64(y), az = igt_size64(z);
    int shift = max(igt_bits96(uvec3(ax | ay | az, 0u)) - 29, 0);
    ivec3 p = ivec3(igt_shift96(uvec3(ax, 0u), shift), igt_shift96(uvec3(ay, 0u), shift), igt_shift96(uvec3(az, 0u), shift));
    return ivec3(int(x.y) < 0 ? -p.x : p.x, int(y.y) < 0 ? -p.y : p.y, int(z.y) < 0 ? -p.z : p.z);
}

// The box of the part of a triangle inside an octant; width 0 where there is none.
IgtBox igt_clipped_box(uint bits, ivec3 v[3], uint octant) {
    bvec3 negative = igt_negatives(octant);
    uint most = (1u << bits) - 1u;
    uvec2 low = uvec2(most), high = uvec2(0u);
    bool found = false;
    for (int i = 0; i < 3; i++) {
        ivec3 a = v[i], b = v[(i + 1) % 3];
        if (igt_in_octant(negative, sign(a))) {
            igt_grow(bits, a, octant, low, high);
            found = true;
        }
        for (int k = 0; k < 3; k++) {
            if (!((a[k] < 0 && b[k] > 0) || (a[k] > 0 && b[k] < 0))) continue;
            int alpha = abs(b[k]), beta = abs(a[k]);
            uvec2 x = igt_add64(igt_mul(a.x, alpha), igt_mul(b.x, beta));
            uvec2 y = igt_add64(igt_mul(a.y, alpha), igt_mul(b.y, beta));
            uvec2 z = igt_add64(igt_mul(a.z, alpha), igt_mul(b.z, beta));
            ivec3 signs = ivec3(igt_sign64(x), igt_sign64(y), igt_sign64(z));
            if (signs != ivec3(0) && igt_in_octant(negative, signs)) {
                igt_grow(bits, igt_shorten(x, y, z), octant, low, high);
                found = true;
            }
        }
    }
    for (int k = 0; k < 3; k++) {
        int l = (k + 1) % 3, m = (k + 2) % 3;
        ivec3 s;
        for (int i = 0; i < 3; i++) {
            ivec3 a = v[(i + 1) % 3], b = v[(i + 2) % 3];
            s[i] = igt_sign64(igt_cross64(a[l], b[m], a[m], b[l]));
        }
        if (all(greaterThanEqual(s, ivec3(0))) || all(lessThanEqual(s, ivec3(0)))) {
            ivec3 axis = ivec3(0);
            axis[k] = negative[k] ? -1 : 1;
            igt_grow(bits, axis, octant, low, high);
            found = true;
        }
    }
    if (!found) return IgtBox(0u, 0u, 0u, 0u, octant);
    // Crossings are rounded, hence a margin of one texel.
    low = uvec2(low.x - min(low.x, 1u), low.y - min(low.y, 1u));
    high = min(high + 1u, uvec2(most));
    return IgtBox(low.x, low.y, high.x - low.x + 1u, high.y - low.y + 1u, octant | IGT_SEVERAL_OCTANTS);
}

#endif
