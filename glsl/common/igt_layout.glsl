// Words of the tables: heads, blocks and triangle records. Twin of src/igt/layout/, which draws them.
#ifndef IGT_LAYOUT_GLSL
#define IGT_LAYOUT_GLSL

#define IGT_LAYOUT_PACKED 0u
#define IGT_LAYOUT_CLASSIC 1u
// Records; any other number: compact, with so many bits a coordinate.
#define IGT_RECORD_CHART 0u
#define IGT_RECORD_WIDE 1u
#define IGT_RECORD_RGB9E5 2u

#define IGT_HALF_GRID (1 << 23)

struct IgtTables {
    uint line;         // IGT_LINE_*
    uint table_layout; // IGT_LAYOUT_*
    uint record;       // IGT_RECORD_*
    uint bits;         // log2 of the hash resolution
    uint id_bits;      // of a triangle's number in a list
    uint layer_bits;   // of its layer, in mixed lists
    uint flat_t3;      // 1: uv charts, two coordinates
    uvec2 at;          // the first texel that is stored,
    uvec2 size;        // and how many columns and rows are
};

// The tables that Tables::shader_words of src/igt/mod.rs describes.
IgtTables igt_tables(uvec4 words, uvec2 window) {
    uint record = words.y >> 8;
    return IgtTables(words.x, words.y & 255u, record & 255u, words.z, words.w & 255u, words.w >> 8, record >> 8,
                     uvec2(window.x & 0xffffu, window.x >> 16), uvec2(window.y & 0xffffu, window.y >> 16));
}

// What the includer knows of all its tables when a pipeline is made (specialization constants), IGT_ANY where it does not:
// a compiler then leaves out what other tables need.
#define IGT_ANY 255u
IgtTables igt_known(IgtTables t, uint line, uint table_layout, uint record) {
    if (line != IGT_ANY) t.line = line;
    if (table_layout != IGT_ANY) t.table_layout = table_layout;
    if (record != IGT_ANY) t.record = record;
    return t;
}

struct IgtTriangle {
    ivec3 v0, v1, v2;
};

// A window of 128 bits, moved on by 1 to 31 of them.
uvec4 igt_shifted(uvec4 w, uint bits) {
    uint up = 32u - bits;
    return uvec4(w.x >> bits | w.y << up, w.y >> bits | w.z << up, w.z >> bits | w.w << up, w.w >> bits);
}

uint igt_take(inout uvec4 window, uint bits) {
    uint field = window.x & ((1u << bits) - 1u);
    window = igt_shifted(window, bits);
    return field;
}

// A two's complement field.
int igt_take_signed(inout uvec4 window, uint bits) {
    uint field = igt_take(window, bits);
    return int(field << (32u - bits)) >> (32u - bits);
}

int igt_take_chart(inout uvec4 window) {
    return int(igt_take(window, 21u) << 3u) - IGT_HALF_GRID;
}

int igt_coordinate24(uint word) {
    return int(word & 0xffffffu) - IGT_HALF_GRID;
}

IgtTriangle igt_chart(uvec4 w) {
    IgtTriangle r;
    r.v0.x = igt_take_chart(w);
    r.v0.y = igt_take_chart(w);
    r.v1.x = igt_take_chart(w);
    r.v1.y = igt_take_chart(w);
    r.v2.x = igt_take_chart(w);
    r.v2.y = igt_take_chart(w);
    r.v0.z = r.v1.z = r.v2.z = 0;
    return r;
}

IgtTriangle igt_wide(uvec4 a, uvec4 b) {
    IgtTriangle r;
    r.v0 = ivec3(igt_coordinate24(a.x), igt_coordinate24(a.y), igt_coordinate24(a.z));
    r.v1 = ivec3(igt_coordinate24(a.w), igt_coordinate24(b.x), igt_coordinate24(b.y));
    uint last = a.x >> 24 | a.y >> 24 << 8 | a.z >> 24 << 16;
    r.v2 = ivec3(igt_coordinate24(b.z), igt_coordinate24(b.w), igt_coordinate24(last));
    return r;
}

ivec3 igt_take_difference(inout uvec4 window, uint bits, uint up) {
    ivec3 d;
    d.x = igt_take_signed(window, bits);
    d.y = igt_take_signed(window, bits);
    d.z = igt_take_signed(window, bits);
    return d * (1 << up);
}

IgtTriangle igt_compact(uvec4 w, uint precision_bits) {
    uint up = 24u - precision_bits, bits = (127u - 3u * precision_bits) / 6u;
    IgtTriangle r;
    r.v0.x = int(igt_take(w, precision_bits) << up) - IGT_HALF_GRID;
    r.v0.y = int(igt_take(w, precision_bits) << up) - IGT_HALF_GRID;
    r.v0.z = int(igt_take(w, precision_bits) << up) - IGT_HALF_GRID;
    ivec3 low = ivec3(-IGT_HALF_GRID), high = ivec3(IGT_HALF_GRID - 1);
    r.v1 = clamp(r.v0 + igt_take_difference(w, bits, up), low, high);
    r.v2 = clamp(r.v0 + igt_take_difference(w, bits, up), low, high);
    return r;
}

ivec3 igt_rgb9e5(uint word, uint flat_t3) {
    uint exponent = min(word >> 27, 15u);
    ivec3 v = ivec3(uvec3(word & 511u, word >> 9 & 511u, word >> 18 & 511u) << exponent) - IGT_HALF_GRID;
    return flat_t3 != 0u ? ivec3(v.xy, 0) : v;
}

IgtTriangle igt_load_triangle(IgtTables t, uint triangle, inout uint fetches) {
    IgtTriangle r;
    if (t.record == IGT_RECORD_RGB9E5) {
        fetches += 3u;
        r.v0 = igt_rgb9e5(igt_load_triangle1(3u * triangle), t.flat_t3);
        r.v1 = igt_rgb9e5(igt_load_triangle1(3u * triangle + 1u), t.flat_t3);
        r.v2 = igt_rgb9e5(igt_load_triangle1(3u * triangle + 2u), t.flat_t3);
        return r;
    }
    bool is_wide = t.record == IGT_RECORD_WIDE;
    uint at = is_wide ? 2u * triangle : triangle;
    uvec4 w = igt_load_triangle4(at);
    fetches += 1u;
    if (t.record == IGT_RECORD_CHART) return igt_chart(w);
    if (!is_wide) {
        if ((w.w & 0x80000000u) == 0u) return igt_compact(w, t.record);
        // The record is a wide one, behind all others.
        at = w.x;
        w = igt_load_triangle4(at);
        fetches += 1u;
    }
    fetches += 1u;
    return igt_wide(w, igt_load_triangle4(at + 1u));
}

// A list on the way: entries in a window, and where more are.
struct IgtList {
    uvec4 window;
    uint left;     // entries in the window, at most
    uint rest;     // IGT_REST_*
    uint address;  // of what is left, in 64-bit units (classic: of the next entry)
    uint bits;     // of an entry
    bool blocks;   // the window is a block's: entries are masked
    bool single;   // no two triangles of a layer overlap
    bool mixed;    // entries have layers
    bool sorted;   // masks name regions around the first triangle, not quadrants
    uint quadrant; // the bit of the query's
    uint begin;    // address and rest of the first block
    uint begin_rest;
};

#define IGT_REST_NONE 0u
#define IGT_REST_HALF 1u
#define IGT_REST_FULL 2u

// The list in a head; `divided` is not 0 where the texel is cut into 2^divided x 2^divided, the first head at `address`.
IgtList igt_list_of_head(IgtTables t, uvec2 head, out uint divided) {
    uint tag = head.x & 15u, flags = tag - 6u;
    uvec2 payload = uvec2(head.x >> 4 | head.y << 28, head.y >> 4);
    uint behind = payload.x >> 28 | payload.y << 4;
    divided = tag == 14u ? behind & 7u : 0u;
    bool in_blocks = tag >= 6u;
    IgtList r;
    r.window = in_blocks ? uvec4(behind & 0x7fffffffu, 0u, 0u, 0u) : uvec4(payload, 0u, 0u);
    r.left = in_blocks ? 1u : tag;
    r.rest = in_blocks ? ((flags & 1u) != 0u ? IGT_REST_FULL : IGT_REST_HALF) : IGT_REST_NONE;
    r.address = payload.x & 0xfffffffu;
    r.blocks = false;
    r.single = !in_blocks || (flags & 2u) == 0u;
    r.mixed = in_blocks && (flags & 4u) != 0u;
    r.sorted = in_blocks && (behind & 0x80000000u) != 0u;
    r.bits = t.id_bits + (r.mixed ? t.layer_bits : 0u);
    r.quadrant = 0u;
    r.begin = r.address;
    r.begin_rest = r.rest;
    return r;
}

// The next block of a list.
void igt_next_block(inout IgtList list) {
    uvec4 block = igt_load_list4(list.address >> 1);
    list.blocks = true;
    if (list.rest == IGT_REST_HALF) {
        list.window = uvec4((list.address & 1u) != 0u ? block.zw : block.xy, 0u, 0u);
        list.left = 64u / (list.bits + 6u);
        list.rest = IGT_REST_NONE;
    } else {
        list.window = uvec4(block.xyz, block.w & 0x7fffffffu);
        list.left = 127u / (list.bits + 6u);
        list.rest = (block.w & 0x80000000u) != 0u ? IGT_REST_NONE : IGT_REST_FULL;
        list.address += 2u;
    }
}

#endif
