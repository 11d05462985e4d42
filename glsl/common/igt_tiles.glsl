// How passes of the build hand boxes and tiles to one another, in words.
#ifndef IGT_TILES_GLSL
#define IGT_TILES_GLSL

#include "common/igt_boxes.glsl"

uvec4 igt_box_record(uint triangle, IgtBox b) {
    return uvec4(triangle, b.column | b.row << 16, b.width | b.height << 16, b.octant);
}

IgtBox igt_box_of_record(uvec4 record) {
    return IgtBox(record.y & 0xffffu, record.y >> 16, record.z & 0xffffu, record.z >> 16, record.w);
}

// A tile's place (13 bits of column, 13 of row, 5 of width less one) and the mask of its touched texels.
uvec2 igt_tile_record(uint bits, IgtBox tile, uint mask) {
    uint column = tile.column & ((1u << bits) - 1u);
    return uvec2(column | tile.row << 13 | (tile.width - 1u & 31u) << 26, mask);
}

IgtBox igt_tile_of_record(uvec2 record) {
    return IgtBox(record.x & 0x1fffu, record.x >> 13 & 0x1fffu, (record.x >> 26) + 1u, 0u, 0u);
}

// With it i / width is i * reciprocal >> 10: the error, below i * width / 1024, is less than one step for both up to 31, and a
// width of 32 divides 1024.
uint igt_reciprocal(uint width) {
    return (1023u + width) / width;
}

// The texel of a mask's lowest bit.
uint igt_tile_texel(uint bits, IgtBox tile, uint reciprocal, uint mask) {
    uint i = uint(findLSB(mask));
    uint row = i * reciprocal >> 10;
    uint column = tile.column + i - row * tile.width;
    return (tile.row + row) << bits | (column & ((1u << bits) - 1u));
}

#endif
