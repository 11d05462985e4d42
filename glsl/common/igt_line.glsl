// Projection lines, exactly. Twin of src/param/projection.rs, which explains them.
#ifndef IGT_LINE_GLSL
#define IGT_LINE_GLSL

#include "common/igt_int.glsl"

#define IGT_LINE_PARALLEL 0u
#define IGT_LINE_CYLINDER 1u
#define IGT_LINE_SPHERE 2u

#define IGT_VERTEX_BITS 24u
#define IGT_QUERY_SHIFT 6
#define IGT_QUERY_BITS 30u

ivec3 igt_direction(uint line, ivec3 q) {
    if (line == IGT_LINE_PARALLEL) return ivec3(0, 0, 1);
    ivec3 d = line == IGT_LINE_CYLINDER ? ivec3(q.xy, 0) : q;
    return d == ivec3(0) ? ivec3(1, 0, 0) : d;
}

uint igt_row(uint bits, int q) {
    return uint(q + (1 << (IGT_QUERY_BITS - 1u))) >> (IGT_QUERY_BITS - bits);
}

uint igt_fraction(uint bits, uint numerator, uint denominator) {
    uint rest = numerator, quotient = 0u;
    for (uint i = 0u; i < bits; i++) {
        rest <<= 1;
        quotient <<= 1;
        if (rest >= denominator) {
            rest -= denominator;
            quotient |= 1u;
        }
    }
    return quotient;
}

uint igt_quadrant(ivec3 d) {
    if (d.x > 0 && d.y >= 0) return 0u;
    if (d.x <= 0 && d.y > 0) return 1u;
    if (d.x < 0 && d.y <= 0) return 2u;
    return 3u;
}

uint igt_diamond_column(uint bits, ivec3 d) {
    uvec2 a = uvec2(abs(d.xy));
    uint quadrant = igt_quadrant(d);
    uint along = (quadrant & 1u) == 0u ? a.y : a.x;
    return (quadrant << (bits - 2u)) + igt_fraction(bits - 2u, along, a.x + a.y);
}

uint igt_half(uint bits, uint u, uint len, bool negative) {
    uint rest = negative ? len - u : len + u;
    uint quotient = 0u;
    for (uint i = 0u; i < bits; i++) {
        quotient <<= 1;
        if (rest >= len) {
            rest -= len;
            quotient |= 1u;
        }
        rest <<= 1;
    }
    return quotient;
}

uvec2 igt_octahedral_texel(uint bits, ivec3 d, bvec3 negative) {
    uvec3 a = uvec3(abs(d));
    uint len = a.x + a.y + a.z;
    uint u = negative.z ? len - a.y : a.x;
    uint v = negative.z ? len - a.x : a.y;
    return uvec2(igt_half(bits, u, len, negative.x), igt_half(bits, v, len, negative.y));
}

// The hash texel (column, row) of a query point in a table of 2^bits squared texels.
uvec2 igt_texel(uint line, uint bits, ivec3 q) {
    if (line == IGT_LINE_PARALLEL) return uvec2(igt_row(bits, q.x), igt_row(bits, q.y));
    ivec3 d = igt_direction(line, q);
    if (line == IGT_LINE_CYLINDER) return uvec2(igt_diamond_column(bits, d), igt_row(bits, q.z));
    return igt_octahedral_texel(bits, d, lessThan(d, ivec3(0)));
}

ivec3 igt_offset(ivec3 v, ivec3 q) {
    return v * (1 << IGT_QUERY_SHIFT) - q;
}

// det(d, a, b)
uvec3 igt_side(uint line, ivec3 d, ivec3 a, ivec3 b) {
    uvec2 xy = igt_cross64(a.x, b.y, a.y, b.x);
    if (line == IGT_LINE_PARALLEL) return igt_widen(xy);
    uvec3 sum = igt_add96(igt_mul96(igt_cross64(a.y, b.z, a.z, b.y), d.x),
                          igt_mul96(igt_cross64(a.z, b.x, a.x, b.z), d.y));
    return line == IGT_LINE_CYLINDER ? sum : igt_add96(sum, igt_mul96(xy, d.z));
}

// The sign of a zero side after the infinitesimal step.
int igt_tie(uint line, ivec3 d, ivec3 q, ivec3 a, ivec3 b) {
    int s;
    if (line == IGT_LINE_PARALLEL) {
        s = sign(a.y - b.y);
        return s != 0 ? s : sign(b.x - a.x);
    }
    if (line == IGT_LINE_SPHERE) {
        s = igt_sign64(igt_cross64(a.y, b.z, a.z, b.y));
        if (s == 0) s = igt_sign64(igt_cross64(a.z, b.x, a.x, b.z));
        return s != 0 ? s : igt_sign64(igt_cross64(a.x, b.y, a.y, b.x));
    }
    int above_a = a.z * (1 << IGT_QUERY_SHIFT) - q.z, above_b = b.z * (1 << IGT_QUERY_SHIFT) - q.z;
    s = igt_sign64(igt_sub64(igt_cross64(a.x, d.y, a.y, d.x), igt_cross64(b.x, d.y, b.y, d.x)));
    if (s == 0) s = igt_sign64(igt_cross64(a.y, above_b, b.y, above_a));
    if (s == 0) s = sign(b.y - a.y);
    if (s == 0) s = igt_sign64(igt_cross64(b.x, above_a, a.x, above_b));
    return s != 0 ? s : sign(a.x - b.x);
}

// Whether a triangle whose sides all have sign s lies on the half-line.
bool igt_facing(uint line, ivec3 q, ivec3 v0, ivec3 v1, ivec3 v2, int s) {
    if (line == IGT_LINE_PARALLEL) return true;
    ivec3 start = line == IGT_LINE_CYLINDER ? ivec3(0, 0, q.z) : ivec3(0);
    int volume = igt_sign96(igt_side(IGT_LINE_SPHERE, igt_offset(v0, start), igt_offset(v1, start), igt_offset(v2, start)));
    if (volume != 0) return volume == s;
    int area = igt_sign64(igt_cross64(v1.x - v0.x, v2.y - v0.y, v1.y - v0.y, v2.x - v0.x));
    return line == IGT_LINE_CYLINDER && area != 0 && -area == s;
}

// The sense (1 or -1) in which the projection line through q meets the triangle, 0 where it does not; side products in
// `sides`. `region`: bit i where side i is positive, 1 to 6 around the triangle; 0 where all signs are equal, or one is missing.
int igt_hit(uint line, ivec3 q, ivec3 v0, ivec3 v1, ivec3 v2, out uvec3 sides[3], out uint region) {
    ivec3 d = igt_direction(line, q);
    ivec3 w0 = igt_offset(v0, q), w1 = igt_offset(v1, q), w2 = igt_offset(v2, q);
    sides[0] = igt_side(line, d, w1, w2);
    sides[1] = igt_side(line, d, w2, w0);
    sides[2] = igt_side(line, d, w0, w1);
    ivec3 s = ivec3(igt_sign96(sides[0]), igt_sign96(sides[1]), igt_sign96(sides[2]));
    if (s.x == 0) s.x = igt_tie(line, d, q, v1, v2);
    if (s.y == 0) s.y = igt_tie(line, d, q, v2, v0);
    if (s.z == 0) s.z = igt_tie(line, d, q, v0, v1);
    region = 0u;
    if (s.x == 0 || s.y == 0 || s.z == 0) return 0;
    if (s.x == s.y && s.y == s.z) return igt_facing(line, q, v0, v1, v2, s.x) ? s.x : 0;
    region = uint(s.x > 0) | uint(s.y > 0) << 1 | uint(s.z > 0) << 2;
    return 0;
}

vec3 igt_barycentric(uvec3 sides[3]) {
    uvec3 a = igt_abs96(sides[0]), b = igt_abs96(sides[1]), c = igt_abs96(sides[2]);
    uvec3 any = a | b | c;
    if (any == uvec3(0u)) return vec3(1.0 / 3.0);
    int shift = max(igt_bits96(any) - 22, 0);
    uint n0 = igt_shift96(a, shift), n1 = igt_shift96(b, shift), n2 = igt_shift96(c, shift);
    float sum = float(n0 + n1 + n2);
    precise vec3 result = vec3(float(n0) / sum, float(n1) / sum, float(n2) / sum);
    return result;
}

float igt_dot(vec3 a, vec3 b) {
    precise float d = a.x * b.x + a.y * b.y + a.z * b.z;
    return d;
}

vec3 igt_combine(vec3 b, vec3 w0, vec3 w1, vec3 w2) {
    precise vec3 p = b.x * w0 + b.y * w1 + b.z * w2;
    return p;
}

float igt_ratio(float a, float b) {
    if (b == 0.0) return 0.0;
    precise float r = a / b;
    return r;
}

// The point of a triangle nearest to the origin (Ericson, Real-Time Collision Detection, 5.1.5), barycentric.
vec3 igt_nearest(vec3 w0, vec3 w1, vec3 w2) {
    precise vec3 ab = w1 - w0;
    precise vec3 ac = w2 - w0;
    float d1 = -igt_dot(ab, w0), d2 = -igt_dot(ac, w0);
    if (d1 <= 0.0 && d2 <= 0.0) return vec3(1.0, 0.0, 0.0);
    float d3 = -igt_dot(ab, w1), d4 = -igt_dot(ac, w1);
    if (d3 >= 0.0 && d4 <= d3) return vec3(0.0, 1.0, 0.0);
    precise float vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        precise float v = igt_ratio(d1, d1 - d3);
        return vec3(1.0 - v, v, 0.0);
    }
    float d5 = -igt_dot(ab, w2), d6 = -igt_dot(ac, w2);
    if (d6 >= 0.0 && d5 <= d6) return vec3(0.0, 0.0, 1.0);
    precise float vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        precise float v = igt_ratio(d2, d2 - d6);
        return vec3(1.0 - v, 0.0, v);
    }
    precise float va = d3 * d6 - d5 * d4;
    precise float e1 = d4 - d3;
    precise float e2 = d5 - d6;
    if (va <= 0.0 && e1 >= 0.0 && e2 >= 0.0) {
        precise float v = igt_ratio(e1, e1 + e2);
        return vec3(0.0, 1.0 - v, v);
    }
    precise float sum = va + vb + vc;
    precise float v = igt_ratio(vb, sum);
    precise float t = igt_ratio(vc, sum);
    precise float u = 1.0 - v - t;
    return vec3(u, v, t);
}

#endif
