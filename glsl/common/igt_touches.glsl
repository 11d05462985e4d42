// Touches: which texels of a tile a triangle may own a query point in. Twin of src/igt/cover/touches.rs, which explains it.
#ifndef IGT_TOUCHES_GLSL
#define IGT_TOUCHES_GLSL

#include "common/igt_boxes.glsl"

// Beyond this a side in a chart keeps its sign over a whole tile.
#define IGT_FAR (1 << 30)

// floor(side / 2^shift), clamped; shift is from 1 to 31.
int igt_far(uvec2 side, uint shift) {
    int high = int(side.y) >> shift;
    int low = int(side.x >> shift | side.y << (32u - shift));
    if (high != low >> 31) return high < 0 ? -IGT_FAR : IGT_FAR;
    return clamp(low, -IGT_FAR, IGT_FAR);
}

// The largest side among a texel's corners, given the one at its first.
int igt_largest(int side, int right, int up) {
    return side + max(right, 0) + max(up, 0);
}

uint igt_touched_squares(uint bits, ivec3 v[3], IgtBox tile) {
    uint shift = IGT_VERTEX_BITS - bits;
    ivec2 low = ivec2(uvec2(tile.column, tile.row) << shift) - (1 << (IGT_VERTEX_BITS - 1u));
    int last = int(tile.width) - 1;
    ivec3 front, back, right, wrap;
    for (int i = 0; i < 3; i++) {
        ivec2 a = v[(i + 1) % 3].xy - low, b = v[(i + 2) % 3].xy - low;
        uvec2 side = igt_cross64(a.x, b.y, a.y, b.x);
        int up = b.x - a.x;
        right[i] = a.y - b.y;
        wrap[i] = up - last * right[i];
        front[i] = igt_largest(igt_far(side, shift), right[i], up);
        back[i] = igt_largest(igt_far(igt_negate64(side), shift), -right[i], -up);
    }
    uint mask = 0u, area = tile.width * tile.height;
    int column = 0;
    for (uint i = 0u; i < area; i++) {
        int missed = (front.x | front.y | front.z) & (back.x | back.y | back.z);
        mask |= uint(missed >= 0) << i;
        bool ends = column == last;
        column = ends ? 0 : column + 1;
        ivec3 step = ends ? wrap : right;
        front += step;
        back -= step;
    }
    return mask;
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

// One texel of a cylinder.
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

// One texel of the octahedral map: on an octant's border, or of a triangle in several octants.
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

uvec2 igt_flip64(bool negative, uvec2 a) {
    return negative ? igt_negate64(a) : a;
}

// Columns (or rows) a to b from the middle line, the nearest first; negative on the other side of the octant's quadrant.
ivec2 igt_away(bool negative, int half_width, int a, int b) {
    return negative ? half_width - 1 - ivec2(b, a) : ivec2(a, b) - half_width;
}

// Whether all texels of a tile lie inside its octant.
bool igt_interior(uint bits, IgtBox tile) {
    bvec3 negative = igt_negatives(tile.octant);
    int half_width = 1 << (bits - 1u);
    ivec2 u = igt_away(negative.x, half_width, int(tile.column), int(tile.column + tile.width) - 1);
    ivec2 v = igt_away(negative.y, half_width, int(tile.row), int(tile.row + tile.height) - 1);
    return u.x >= 0 && v.x >= 0 && (negative.z ? u.x + v.x >= half_width : u.y + v.y + 2 <= half_width);
}

// For a tile inside its octant, of a triangle in no other.
uint igt_touched_cones(uint bits, ivec3 v[3], IgtBox tile) {
    bvec3 negative = igt_negatives(tile.octant);
    int width = 1 << bits;
    ivec2 low = 2 * ivec2(tile.column, tile.row) - width;
    int last = int(tile.width) - 1;
    uvec2 front[3], span[3], right[3], wrap[3];
    for (int i = 0; i < 3; i++) {
        ivec3 a = v[(i + 1) % 3], b = v[(i + 2) % 3];
        uvec2 x = igt_flip64(negative.x, igt_cross64(a.y, b.z, a.z, b.y));
        uvec2 y = igt_flip64(negative.y, igt_cross64(a.z, b.x, a.x, b.z));
        uvec2 z = igt_flip64(negative.z, igt_cross64(a.x, b.y, a.y, b.x));
        uvec2 su = negative.z ? igt_sub64(z, y) : igt_sub64(x, z);
        uvec2 sv = negative.z ? igt_sub64(z, x) : igt_sub64(y, z);
        uvec2 s = negative.z ? igt_sub64(igt_add64(x, y), z) : z;
        su = igt_flip64(negative.x, su);
        sv = igt_flip64(negative.y, sv);
        uvec2 up = igt_add64(sv, sv);
        right[i] = igt_add64(su, su);
        wrap[i] = igt_sub64(up, igt_mul64(right[i], last));
        uvec2 first = igt_add64(igt_add64(igt_mul64(su, low.x), igt_mul64(sv, low.y)), igt_mul64(s, width));
        front[i] = igt_add64(first, igt_add64(igt_positive64(right[i]), igt_positive64(up)));
        span[i] = igt_add64(igt_size64(right[i]), igt_size64(up));
    }
    uint mask = 0u, area = tile.width * tile.height;
    int column = 0;
    for (uint i = 0u; i < area; i++) {
        uint back = igt_sub64(span[0], front[0]).y | igt_sub64(span[1], front[1]).y | igt_sub64(span[2], front[2]).y;
        uint missed = (front[0].y | front[1].y | front[2].y) & back;
        mask |= uint(int(missed) >= 0) << i;
        bool ends = column == last;
        column = ends ? 0 : column + 1;
        for (int k = 0; k < 3; k++) front[k] = igt_add64(front[k], ends ? wrap[k] : right[k]);
    }
    return mask;
}

// The texels of a tile, one by one, where they are not linear: a cylinder's, and an octant's borders.
uint igt_touched_one_by_one(uint line, uint bits, ivec3 v[3], IgtBox tile) {
    uint mask = 0u, column = 0u, row = 0u;
    for (uint i = 0u; i < tile.width * tile.height; i++) {
        uvec2 texel = uvec2((tile.column + column) & ((1u << bits) - 1u), tile.row + row);
        bool touches = line == IGT_LINE_CYLINDER ? igt_touches_wedge(bits, v, texel) : igt_touches_cone(bits, v, texel, tile.octant);
        mask |= uint(touches) << i;
        column++;
        if (column == tile.width) {
            column = 0u;
            row++;
        }
    }
    return mask;
}

#endif
