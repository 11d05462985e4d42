// Which hash texels a triangle touches: conservative, exact, in integers. Twin of src/igt/cover.rs, which explains it.
#ifndef IGT_COVER_GLSL
#define IGT_COVER_GLSL

#include "common/igt_line.glsl"

// The octant's number in IgtBox.octant is joined by this flag where the triangle reaches into several.
#define IGT_SEVERAL_OCTANTS 8u

struct IgtBox {
    uint column, row, width, height, octant;
};

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

uvec2 igt_size64(uvec2 a) {
    return int(a.y) < 0 ? igt_negate64(a) : a;
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

// Whether no edge has all corners strictly on its far side, for one of the two orientations: signs of edge i at the
// corners are gathered as bits 0 (some >= 0) and 1 (some <= 0) of marks[i].
uint igt_mark(int s) {
    return uint(s >= 0) | uint(s <= 0) << 1;
}

bool igt_one_side(uvec3 marks) {
    uint either = marks.x & marks.y & marks.z;
    return either != 0u;
}

bool igt_touches_square(uint bits, ivec3 v[3], uvec2 texel) {
    int shift = int(IGT_VERTEX_BITS - bits);
    ivec2 low = ivec2(texel << shift) - (1 << (IGT_VERTEX_BITS - 1u));
    uvec3 marks = uvec3(0u);
    for (int i = 0; i < 3; i++) {
        ivec2 a = v[(i + 1) % 3].xy, b = v[(i + 2) % 3].xy;
        for (int c = 0; c < 4; c++) {
            ivec2 p = low + ivec2((c & 1) << shift, (c >> 1) << shift);
            marks[i] |= igt_mark(igt_sign64(igt_cross64(a.x - p.x, b.y - p.y, a.y - p.y, b.x - p.x)));
        }
    }
    return igt_one_side(marks);
}

ivec2 igt_wedge_direction(uint bits, uint column) {
    int quarter = 1 << (bits - 2u);
    int along = int(column) & (quarter - 1);
    int x = quarter - along, y = along;
    switch (column >> (bits - 2u) & 3u) {
        case 0u: return ivec2(x, y);
        case 1u: return ivec2(-y, x);
        case 2u: return ivec2(-x, -y);
        default: return ivec2(y, -x);
    }
}

bool igt_touches_wedge(uint bits, ivec3 v[3], uvec2 texel) {
    ivec2 d0 = igt_wedge_direction(bits, texel.x), d1 = igt_wedge_direction(bits, texel.x + 1u);
    bool beyond0 = true, beyond1 = true;
    for (int i = 0; i < 3; i++) {
        beyond0 = beyond0 && igt_sign64(igt_cross64(d0.x, v[i].y, d0.y, v[i].x)) < 0;
        beyond1 = beyond1 && igt_sign64(igt_cross64(d1.x, v[i].y, d1.y, v[i].x)) > 0;
    }
    if (beyond0 || beyond1) return false;
    int shift = int(IGT_VERTEX_BITS - bits);
    int bottom = int(texel.y << shift) - (1 << (IGT_VERTEX_BITS - 1u));
    uvec3 marks = uvec3(0u);
    for (int i = 0; i < 3; i++) {
        ivec3 a = v[(i + 1) % 3], b = v[(i + 2) % 3];
        for (int c = 0; c < 4; c++) {
            ivec2 d = (c & 1) == 0 ? d0 : d1;
            int z = bottom + ((c >> 1) << shift);
            uvec2 left = igt_mul64(igt_cross64(b.x, d.y, b.y, d.x), a.z - z);
            uvec2 right = igt_mul64(igt_cross64(a.x, d.y, a.y, d.x), b.z - z);
            marks[i] |= igt_mark(igt_sign64(igt_sub64(left, right)));
        }
    }
    return igt_one_side(marks);
}

// The corners of a texel's part inside an octant: four, three on the fold, two or one where it only touches it, or none.
int igt_cone_corners(uint bits, uvec2 texel, uint octant, out ivec3 corners[4]) {
    int width = 1 << bits;
    bvec3 negative = igt_negatives(octant);
    int count = 0;
    for (int i = 0; i < 4; i++) {
        corners[i] = ivec3(0);
    }
    for (int i = 0; i < 4; i++) {
        ivec2 at = ivec2(texel) + ivec2(int(i == 1 || i == 2), int(i >= 2));
        ivec2 p = 2 * at - width;
        int u = negative.x ? -p.x : p.x, v = negative.y ? -p.y : p.y;
        if (u < 0 || v < 0 || (negative.z ? u + v < width : u + v > width)) continue;
        ivec3 folded = negative.z ? ivec3(width - v, width - u, u + v - width) : ivec3(u, v, width - u - v);
        corners[count] = ivec3(negative.x ? -folded.x : folded.x, negative.y ? -folded.y : folded.y, negative.z ? -folded.z : folded.z);
        count++;
    }
    return count;
}

int igt_dot_sign(uvec2 x, uvec2 y, uvec2 z, ivec3 p) {
    return igt_sign64(igt_add64(igt_add64(igt_mul64(x, p.x), igt_mul64(y, p.y)), igt_mul64(z, p.z)));
}

bool igt_touches_cone(uint bits, ivec3 v[3], uvec2 texel, uint octant) {
    ivec3 corners[4];
    int count = igt_cone_corners(bits, texel, octant & 7u, corners);
    if (count == 0) return false;
    uvec3 marks = uvec3(0u);
    for (int i = 0; i < 3; i++) {
        ivec3 a = v[(i + 1) % 3], b = v[(i + 2) % 3];
        uvec2 nx = igt_cross64(a.y, b.z, a.z, b.y), ny = igt_cross64(a.z, b.x, a.x, b.z), nz = igt_cross64(a.x, b.y, a.y, b.x);
        for (int c = 0; c < count; c++) marks[i] |= igt_mark(igt_dot_sign(nx, ny, nz, corners[c]));
    }
    if (!igt_one_side(marks)) return false;
    if ((octant & IGT_SEVERAL_OCTANTS) == 0u) return true;
    ivec3 middle = ivec3(0);
    for (int c = 0; c < count; c++) middle += corners[c];
    for (int c = 0; c < count; c++) {
        ivec3 a = corners[c], b = corners[c + 1 == count ? 0 : c + 1];
        uvec2 nx = igt_cross64(a.y, b.z, a.z, b.y), ny = igt_cross64(a.z, b.x, a.x, b.z), nz = igt_cross64(a.x, b.y, a.y, b.x);
        int inside = igt_dot_sign(nx, ny, nz, middle);
        bool any_inside = false;
        for (int i = 0; i < 3; i++) any_inside = any_inside || inside * igt_dot_sign(nx, ny, nz, v[i]) >= 0;
        if (!any_inside) return false;
    }
    return true;
}

bool igt_touches(uint line, uint bits, ivec3 v[3], uvec2 texel, uint octant) {
    if (line == IGT_LINE_PARALLEL) return igt_touches_square(bits, v, texel);
    if (line == IGT_LINE_CYLINDER) return igt_touches_wedge(bits, v, texel);
    return igt_touches_cone(bits, v, texel, octant);
}

#endif
