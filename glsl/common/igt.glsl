// The lookup: from a T3 point on the query grid to the point of the reference mesh it stands for.
// Twin of src/igt/lookup.rs (policies) and src/igt/layout/ (words).
//
// The includer defines how the tables' words are loaded, and fills IgtTables (igt_tables):
//   uvec2 igt_load_hash2(uint i)      words 2i, 2i+1 of the hash (packed)
//   uint  igt_load_hash1(uint i)      word i of the hash (classic)
//   uvec4 igt_load_list4(uint i)      words 4i .. 4i+3 of the lists (packed)
//   uint  igt_load_list1(uint i)      word i of the lists (classic)
//   uvec4 igt_load_triangle4(uint i)  words 4i .. 4i+3 of the triangle table (packed)
//   uint  igt_load_triangle1(uint i)  word i of the triangle table (classic)
// No set, binding or name of a buffer is fixed here.
#ifndef IGT_GLSL
#define IGT_GLSL

#include "common/igt_line.glsl"
#include "common/igt_layout.glsl"

// Who asks: the layer of the LoD triangle's part in bits 0..7, or this flag for any;
#define IGT_ANY_LAYER 0x80000000u
// and the side it shows in bits 8..9 (0: any), see Asker in src/igt/asker.rs.
#define IGT_SIDE_FRONT 0x100u
#define IGT_SIDE_BACK 0x200u
#define IGT_SIDES 0x300u
// and whether projection lines run along the triangle: the nearest point is then asked for at once.
#define IGT_GRAZED 0x400u
// IgtFound.triangle where nothing is mapped.
#define IGT_NOTHING 0xffffffffu
// Added to a candidate's rank: the hit shows the other side; there is no hit; the layer is another one. 8: no candidate.
#define IGT_TURNED 1u
#define IGT_NO_HIT 2u
#define IGT_OTHER_LAYER 4u
#define IGT_NO_RANK 8u

struct IgtFound {
    uint triangle;
    vec3 barycentric;
    IgtTriangle corners; // of the triangle, on the vertex grid
    uint fetches;        // loads of at most 128 bits
    uint tests;          // triangles tested
    bool hit;
};

struct IgtCandidate {
    uint rank;
    float distance2;
    uint triangle;
    vec3 barycentric;
    IgtTriangle corners;
};

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
    return uint(side == (sense > 0 ? IGT_SIDE_BACK : IGT_SIDE_FRONT)) * IGT_TURNED;
}

// What a triangle has to offer; a rank of IGT_NO_RANK: nothing. `region`: see igt_hit, 0 where lines are not asked.
IgtCandidate igt_candidate(uint line, ivec3 q, uint asker, bool nearest, uint triangle, IgtTriangle r, out uint region) {
    IgtCandidate c;
    c.triangle = triangle;
    c.corners = r;
    bool grazed = nearest && (asker & IGT_GRAZED) != 0u;
    uvec3 sides[3];
    int sense = igt_hit(line, q, r.v0, r.v1, r.v2, sides, region);
    vec3 w0 = igt_scaled(igt_offset(r.v0, q)), w1 = igt_scaled(igt_offset(r.v1, q)), w2 = igt_scaled(igt_offset(r.v2, q));
    if (grazed) {
        sense = 0;
        region = 0u;
    }
    if (sense != 0) {
        c.rank = igt_turned(asker, sense);
        c.barycentric = igt_barycentric(sides);
    } else {
        c.rank = nearest ? IGT_NO_HIT : IGT_NO_RANK;
        c.barycentric = igt_nearest(w0, w1, w2);
    }
    vec3 p = igt_combine(c.barycentric, w0, w1, w2);
    c.distance2 = igt_dot(p, p);
    return c;
}

// The list of the query's texel, down through divided texels.
IgtList igt_first(IgtTables t, ivec3 q, inout uint fetches) {
    // Twice as fine as the texels: the lowest bits are the quadrant.
    uint bits = t.bits;
    uvec2 at = igt_texel(t.line, bits + 1u, q), stored = (at >> 1) - t.at;
    uint texel = stored.y * t.size.x + stored.x;
    if (stored.x >= t.size.x || stored.y >= t.size.y) {
        return IgtList(uvec4(0u), 0u, IGT_REST_NONE, 0u, 1u, false, false, false, false, 0u, 0u, IGT_REST_NONE);
    }
    fetches += 1u;
    if (t.table_layout == IGT_LAYOUT_CLASSIC) {
        uint word = igt_load_hash1(texel);
        uint start = word & 0xffffffu, len = word >> 24;
        if (len == 255u) {
            len = igt_load_list1(start);
            start += 1u;
            fetches += 1u;
        }
        return IgtList(uvec4(0u), len, IGT_REST_NONE, start, 0u, false, false, true, false, 0u, 0u, IGT_REST_NONE);
    }
    uint divided;
    IgtList list = igt_list_of_head(t, igt_load_hash2(texel), divided);
    while (divided != 0u) {
        bits += divided;
        at = igt_texel(t.line, bits + 1u, q);
        uvec2 within = at >> 1 & ((1u << divided) - 1u);
        texel = list.address + (within.y << divided | within.x);
        fetches += 1u;
        list = igt_list_of_head(t, igt_load_hash2(texel), divided);
    }
    list.quadrant = 1u << ((at.y & 1u) << 1 | at.x & 1u);
    return list;
}

// The next entry, false at the end. Mask: all ones where it has none.
bool igt_next(IgtTables t, inout IgtList list, inout uint fetches, out uint triangle, out uint layer, out uint mask) {
    mask = 0xffffffffu;
    if (t.table_layout == IGT_LAYOUT_CLASSIC) {
        if (list.left == 0u) return false;
        uint word = igt_load_list1(list.address);
        list.address += 1u;
        list.left -= 1u;
        fetches += 1u;
        triangle = word & 0xffffffu;
        layer = word >> 24;
        return true;
    }
    if (list.left == 0u) {
        if (list.rest == IGT_REST_NONE) return false;
        igt_next_block(list);
        fetches += 1u;
    }
    uint end = (1u << list.bits) - 1u, entry = list.window.x & end;
    if (entry == end) {
        list.left = 0u;
        return false;
    }
    list.left -= 1u;
    list.window = igt_shifted(list.window, list.bits);
    if (list.blocks) mask = igt_take(list.window, 6u);
    triangle = list.mixed ? entry >> t.layer_bits : entry;
    layer = list.mixed ? entry & ((1u << t.layer_bits) - 1u) : 0u;
    return true;
}

// The reference point that q (query grid) stands for. asker: layer and side of the LoD triangle that asks, or
// IGT_ANY_LAYER. nearest: whether points outside every chart get the nearest listed one.
IgtFound igt_lookup(IgtTables t, ivec3 q, uint asker, bool nearest) {
    IgtTriangle none = IgtTriangle(ivec3(0), ivec3(0), ivec3(0));
    IgtCandidate best = IgtCandidate(IGT_NO_RANK, 0.0, IGT_NOTHING, vec3(0.0), none);
    uint fetches = 0u, tests = 0u;
    bool any = (asker & IGT_ANY_LAYER) != 0u;
    // One walk over the asker's layer; one over all others if its own is not listed. A loop, so that a compiler that inlines
    // everything holds one copy of the walk.
    for (uint others = 0u; others < (any ? 1u : 2u) && best.rank == IGT_NO_RANK; others++) {
        IgtList list = igt_first(t, q, fetches);
        // Where all entries are of one layer they count as the asker's.
        if (others != 0u && !list.mixed) break;
        bool only = list.single && others == 0u && (!any || !list.mixed);
        bool again = false;
        uint region = 0u;
        while (true) {
            uint triangle, layer, mask;
            if (!igt_next(t, list, fetches, triangle, layer, mask)) {
                // No hit: what the first triangle's test ruled out may be nearest.
                if (again || region == 0u || !list.sorted || !nearest || best.rank < IGT_NO_HIT) break;
                again = true;
                list.left = 0u;
                list.address = list.begin;
                list.rest = list.begin_rest;
                continue;
            }
            if (list.blocks) {
                uint here = list.sorted ? (1u << region) >> 1 : list.quadrant;
                bool listed = here == 0u || (mask & here) != 0u;
                if (listed == again) continue;
            }
            uint other = uint(list.mixed && !any && (asker & 255u) != layer);
            if (other != others) continue;
            IgtTriangle r = igt_load_triangle(t, triangle, fetches);
            tests += 1u;
            uint around;
            IgtCandidate c = igt_candidate(t.line, q, asker, nearest, triangle, r, around);
            if (!list.blocks) region = around;
            if (c.rank == IGT_NO_RANK) continue;
            c.rank += other * IGT_OTHER_LAYER;
            if (igt_better(c, best)) best = c;
            if (only && c.rank <= IGT_TURNED) break;
        }
    }
    bool hit = (best.rank & IGT_NO_HIT) == 0u && best.rank < IGT_NO_RANK;
    return IgtFound(best.triangle, best.barycentric, best.corners, fetches, tests, hit);
}

#endif
