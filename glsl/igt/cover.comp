#version 460
#extension GL_GOOGLE_include_directive : require
// For each tile of the boxes that the bounds pass left: the texels that the triangle touches. Tiles are spread evenly, however
// many texels a triangle covers. Driven by src/igt/gpu/cover.rs; twin of igt::cover::Toucher.
layout(local_size_x = 64) in;
// The family of lines, see bounds.comp.
layout(constant_id = 0) const uint line = 0u;

layout(std430, binding = 0) readonly buffer Vertices { int words[]; } vertices;
layout(std430, binding = 1) readonly buffer Triangles { uint words[]; } triangles;
layout(std430, binding = 2) readonly buffer Boxes { uvec4 records[]; } boxes;
// First tile of each box.
layout(std430, binding = 3) readonly buffer Starts { uint words[]; } starts;
layout(std430, binding = 4) writeonly buffer Tiles { uvec2 records[]; } tiles;
// The triangle of each tile.
layout(std430, binding = 5) writeonly buffer Owners { uint words[]; } owners;
layout(std430, binding = 6) buffer Counts { uint words[]; } counts;
layout(push_constant) uniform Push { uint bits; uint boxes; uint tiles; uint first; } push;

#include "common/igt_touches.glsl"
#include "common/igt_tiles.glsl"

// The box of a tile: the last one that starts at or before it.
uint box_of(uint tile) {
    uint low = 0u, high = push.boxes;
    while (high - low > 1u) {
        uint middle = (low + high) >> 1;
        if (starts.words[middle] <= tile) low = middle;
        else high = middle;
    }
    return low;
}

void main() {
    uint n = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (n >= push.tiles) return;
    uint at = box_of(n);
    uvec4 record = boxes.records[at];
    uint t = record.x;
    IgtBox tile = igt_tile(igt_box_of_record(record), n - starts.words[at]);
    ivec3 v[3];
    for (uint i = 0u; i < 3u; i++) {
        uint vertex = 3u * triangles.words[3u * t + i];
        v[i] = ivec3(vertices.words[vertex], vertices.words[vertex + 1u], vertices.words[vertex + 2u]);
    }
    // The way that does not apply gets an empty tile: its loop is over at once.
    bool linear = line == IGT_LINE_PARALLEL || (line == IGT_LINE_SPHERE && (tile.octant & IGT_SEVERAL_OCTANTS) == 0u && igt_interior(push.bits, tile));
    IgtBox stepped = tile, others = tile;
    if (linear) others.height = 0u;
    else stepped.height = 0u;
    uint mask = 0u;
    if (line == IGT_LINE_PARALLEL) mask = igt_touched_squares(push.bits, v, stepped);
    if (line == IGT_LINE_SPHERE) mask = igt_touched_cones(push.bits, v, stepped);
    if (line != IGT_LINE_PARALLEL) mask |= igt_touched_one_by_one(line, push.bits, v, others);
    tiles.records[push.first + n] = igt_tile_record(push.bits, tile, mask);
    owners.words[n] = t;
    uint reciprocal = igt_reciprocal(tile.width);
    for (; mask != 0u; mask &= mask - 1u) atomicAdd(counts.words[igt_tile_texel(push.bits, tile, reciprocal, mask)], 1u);
}
