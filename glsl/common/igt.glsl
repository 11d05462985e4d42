// The lookup: from a T3 point on the query grid to the point of the reference mesh it stands for.
// Twin of src/igt/lookup.rs (policies) and src/igt/layout.rs (words).
//
// The includer defines how the tables' words are loaded, and fills IgtTables:
//   uvec2 igt_load_hash2(uint i)      words 2i, 2i+1 of the hash (packed)
//   uint  igt_load_hash1(uint i)      word i of the hash (classic)
//   uint  igt_load_list(uint i)       word i of the lists
//   uvec4 igt_load_triangle4(uint i)  words 4i .. 4i+3 of the triangle table (packed)
//   uint  igt_load_triangle1(uint i)  word i of the triangle table (classic)
// No set, binding or name of a buffer is fixed here.
#ifndef IGT_GLSL
#define IGT_GLSL

#include "common/igt_line.glsl"

#define IGT_LAYOUT_PACKED 0u
#define IGT_LAYOUT_CLASSIC 1u
// Who asks: the layer of the LoD triangle's part in bits 0..7, or this flag for any;
#define IGT_ANY_LAYER 0x80000000u
// and the side it shows in bits 8..9 (0: any), see Asker in src/igt/lookup.rs.
#define IGT_SIDE_FRONT 0x100u
#define IGT_SIDE_BACK 0x200u
#define IGT_SIDES 0x300u
// and whether projection lines run along the triangle: the nearest point is then asked for at once.
#define IGT_GRAZED 0x400u
// IgtFound.triangle where nothing is mapped.
#define IGT_NOTHING 0xffffffffu

struct IgtTables {
    uint line;        // IGT_LINE_*
    uint table_layout; // IGT_LAYOUT_*
    uint flat_t3;     // 1: uv charts, two coordinates
    uint bits;        // log2 of the hash resolution
};

struct IgtFound {
    uint triangle;
    vec3 barycentric;
    uint fetches;
    bool hit;
};

struct IgtCandidate {
    uint rank;
    float distance2;
    uint triangle;
    vec3 barycentric;
};

struct IgtTriangle {
    ivec3 v0, v1, v2;
    uint layer;
};

int igt_coordinate24(uint word) {
    return int(word & 0xffffffu) - (1 << 23);
}

int igt_coordinate20(uint word) {
    return int((word & 0xfffffu) << 4) - (1 << 23);
}

ivec3 igt_rgb9e5(uint word, uint flat_t3) {
    uint exponent = min(word >> 27, 15u);
    ivec3 v = ivec3(uvec3(word & 511u, word >> 9 & 511u, word >> 18 & 511u) << exponent) - (1 << 23);
    return flat_t3 != 0u ? ivec3(v.xy, 0) : v;
}

IgtTriangle igt_load_triangle(IgtTables t, uint triangle, inout uint fetches) {
    IgtTriangle r;
    if (t.table_layout == IGT_LAYOUT_CLASSIC) {
        fetches += 3u;
        r.v0 = igt_rgb9e5(igt_load_triangle1(3u * triangle), t.flat_t3);
        r.v1 = igt_rgb9e5(igt_load_triangle1(3u * triangle + 1u), t.flat_t3);
        r.v2 = igt_rgb9e5(igt_load_triangle1(3u * triangle + 2u), t.flat_t3);
        r.layer = 0u;
    } else if (t.flat_t3 != 0u) {
        fetches += 1u;
        uvec4 w = igt_load_triangle4(triangle);
        r.v0 = ivec3(igt_coordinate20(w.x), igt_coordinate20(w.x >> 20 | w.y << 12), 0);
        r.v1 = ivec3(igt_coordinate20(w.y >> 8), igt_coordinate20(w.y >> 28 | w.z << 4), 0);
        r.v2 = ivec3(igt_coordinate20(w.z >> 16 | w.w << 16), igt_coordinate20(w.w >> 4), 0);
        r.layer = w.w >> 24;
    } else {
        fetches += 2u;
        uvec4 a = igt_load_triangle4(2u * triangle), b = igt_load_triangle4(2u * triangle + 1u);
        r.v0 = ivec3(igt_coordinate24(a.x), igt_coordinate24(a.y), igt_coordinate24(a.z));
        r.v1 = ivec3(igt_coordinate24(a.w), igt_coordinate24(b.x), igt_coordinate24(b.y));
        uint last = a.x >> 24 | a.y >> 24 << 8 | a.z >> 24 << 16;
        r.v2 = ivec3(igt_coordinate24(b.z), igt_coordinate24(b.w), igt_coordinate24(last));
        r.layer = a.w >> 24;
    }
    return r;
}

// Offsets are scaled by 2^-20 before float arithmetic, so that no product leaves float's range.
vec3 igt_scaled(ivec3 w) {
    precise vec3 scaled = vec3(igt_float(w.x), igt_float(w.y), igt_float(w.z)) * (1.0 / 1048576.0);
    return scaled;
}

bool igt_better(IgtCandidate a, IgtCandidate b) {
    if (a.rank != b.rank) return a.rank < b.rank;
    if (a.distance2 != b.distance2) return a.distance2 < b.distance2;
    return a.triangle < b.triangle;
}

// 1 where the asker shows one side and the hit the other.
uint igt_turned(uint asker, int sense) {
    uint side = asker & IGT_SIDES;
    return uint(side == (sense > 0 ? IGT_SIDE_BACK : IGT_SIDE_FRONT));
}

void igt_consider(IgtTables t, ivec3 q, uint asker, bool nearest, uint triangle, IgtTriangle r, inout IgtCandidate best) {
    uint other = (asker & IGT_ANY_LAYER) == 0u && (asker & 255u) != r.layer ? 4u : 0u;
    IgtCandidate c;
    c.triangle = triangle;
    if (nearest) {
        vec3 w0 = igt_scaled(igt_offset(r.v0, q)), w1 = igt_scaled(igt_offset(r.v1, q)), w2 = igt_scaled(igt_offset(r.v2, q));
        c.rank = other + 2u;
        c.barycentric = igt_nearest(w0, w1, w2);
        vec3 p = igt_combine(c.barycentric, w0, w1, w2);
        c.distance2 = igt_dot(p, p);
    } else {
        uvec3 sides[3];
        int sense = igt_hit(t.line, q, r.v0, r.v1, r.v2, sides);
        if (sense == 0) return;
        vec3 w0 = igt_scaled(igt_offset(r.v0, q)), w1 = igt_scaled(igt_offset(r.v1, q)), w2 = igt_scaled(igt_offset(r.v2, q));
        c.rank = other + igt_turned(asker, sense);
        c.barycentric = igt_barycentric(sides);
        vec3 p = igt_combine(c.barycentric, w0, w1, w2);
        c.distance2 = igt_dot(p, p);
    }
    if (igt_better(c, best)) best = c;
}

// One walk over the texel's list: hits (ranks 0, 1, 4, 5) or nearest points (ranks 2 and 6).
void igt_scan(IgtTables t, ivec3 q, uint asker, bool nearest, inout IgtCandidate best, inout uint fetches) {
    uvec2 at = igt_texel(t.line, t.bits, q);
    uint texel = at.y << t.bits | at.x;
    fetches += 1u;
    if (t.table_layout == IGT_LAYOUT_CLASSIC) {
        uint word = igt_load_hash1(texel);
        uint start = word & 0xffffffu, len = word >> 24;
        if (len == 255u) {
            len = igt_load_list(start);
            start += 1u;
            fetches += 1u;
        }
        for (uint i = 0u; i < len; i++) {
            uint entry = igt_load_list(start + i);
            fetches += 1u;
            IgtTriangle r = igt_load_triangle(t, entry & 0xffffffu, fetches);
            r.layer = entry >> 24;
            igt_consider(t, q, asker, nearest, entry & 0xffffffu, r, best);
        }
        return;
    }
    uvec2 head = igt_load_hash2(texel);
    uint entry = head.x, next = head.y;
    if (entry == 0xffffffffu) return;
    while (true) {
        uint triangle = entry & 0x7fffffffu;
        IgtTriangle r = igt_load_triangle(t, triangle, fetches);
        igt_consider(t, q, asker, nearest, triangle, r, best);
        if ((entry & 0x80000000u) != 0u) return;
        entry = igt_load_list(next);
        next += 1u;
        fetches += 1u;
    }
}

// The reference point that q (query grid) stands for. asker: layer and side of the LoD triangle that asks, or
// IGT_ANY_LAYER. nearest: whether points outside every chart get the nearest listed one.
IgtFound igt_lookup(IgtTables t, ivec3 q, uint asker, bool nearest) {
    IgtCandidate best = IgtCandidate(8u, 0.0, IGT_NOTHING, vec3(0.0));
    uint fetches = 0u;
    // A loop, so that a compiler that inlines everything holds one copy of the walk.
    bool grazed = nearest && (asker & IGT_GRAZED) != 0u;
    for (uint pass = grazed ? 1u : 0u; pass < (nearest ? 2u : 1u) && best.rank > 1u; pass++) {
        igt_scan(t, q, asker, pass == 1u, best, fetches);
    }
    return IgtFound(best.triangle, best.barycentric, fetches, (best.rank & 2u) == 0u && best.rank < 8u);
}

#endif
