// Tables in pages, for devices whose storage buffers are shorter than a table. Twin of src/igt/gpu/pages.rs.
//
// The includer declares four buffers each, igt_hash_0 .. 3 with `uvec2 pairs[]`, igt_list_0 .. 3 and igt_triangle_0 .. 3 with
// `uvec4 quads[]`, and `igt_page_bits`, log2 of a page's bytes (a specialization constant is best). Buffers are picked by
// branches: descriptors are not indexed, which some devices cannot do.
#ifndef IGT_PAGES_GLSL
#define IGT_PAGES_GLSL

#define IGT_PAGED(TYPE, LOAD, BUFFER, MEMBER, UNIT) \
    TYPE LOAD(uint i) {                                                               \
        uint page = i >> (igt_page_bits - UNIT);                                      \
        uint at = i & ((1u << (igt_page_bits - UNIT)) - 1u);                          \
        if (page == 0u) return BUFFER##_0.MEMBER[at];                                 \
        if (page == 1u) return BUFFER##_1.MEMBER[at];                                 \
        if (page == 2u) return BUFFER##_2.MEMBER[at];                                 \
        return BUFFER##_3.MEMBER[at];                                                 \
    }

// The last number: log2 of the bytes that are loaded.
IGT_PAGED(uvec2, igt_load_hash2, igt_hash, pairs, 3u)
IGT_PAGED(uvec4, igt_load_list4, igt_list, quads, 4u)
IGT_PAGED(uvec4, igt_load_triangle4, igt_triangle, quads, 4u)

uint igt_load_hash1(uint i) { return igt_load_hash2(i >> 1)[i & 1u]; }
uint igt_load_list1(uint i) { return igt_load_list4(i >> 2)[i & 3u]; }
uint igt_load_triangle1(uint i) { return igt_load_triangle4(i >> 2)[i & 3u]; }

#endif
