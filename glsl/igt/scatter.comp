#version 460
#extension GL_GOOGLE_include_directive : require
// Puts every touched texel of every tile into the texel's list. The atomic hands out slots in any order; the order pass sorts.
layout(local_size_x = 64) in;

// One tile for each triangle, then those of the cover pass.
layout(std430, binding = 0) readonly buffer Tiles { uvec2 records[]; } tiles;
layout(std430, binding = 1) readonly buffer Owners { uint words[]; } owners;
layout(std430, binding = 2) buffer Cursors { uint words[]; } cursors;
layout(std430, binding = 3) writeonly buffer Lists { uint words[]; } lists;
layout(push_constant) uniform Push { uint bits; uint triangles; uint tiles; } push;

#include "common/igt_tiles.glsl"

void main() {
    uint n = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (n >= push.tiles) return;
    uvec2 record = tiles.records[n];
    uint triangle = n;
    if (n >= push.triangles) triangle = owners.words[n - push.triangles];
    IgtBox tile = igt_tile_of_record(record);
    uint reciprocal = igt_reciprocal(tile.width);
    for (uint mask = record.y; mask != 0u; mask &= mask - 1u) {
        uint texel = igt_tile_texel(push.bits, tile, reciprocal, mask);
        lists.words[atomicAdd(cursors.words[texel], 1u)] = triangle;
    }
}
