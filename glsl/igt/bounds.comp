#version 460
#extension GL_GOOGLE_include_directive : require
// For each triangle the box of texels it may touch. A box of one tile is tested here, texel by texel; a larger one, or one at
// an octant's border, is left to the cover pass. Driven by src/igt/gpu/cover.rs; twin of igt::cover.
//
// Boxes are appended by an atomic, in any order: lists are sorted later, so the order never shows.
layout(local_size_x = 64) in;
// The family of lines. A pipeline for each: a processor that runs both sides of a branch then pays for one.
layout(constant_id = 0) const uint line = 0u;

layout(std430, binding = 0) readonly buffer Vertices { int words[]; } vertices;
layout(std430, binding = 1) readonly buffer Triangles { uint words[]; } triangles;
layout(std430, binding = 2) writeonly buffer Boxes { uvec4 records[]; } boxes;
// Tiles of each box.
layout(std430, binding = 3) writeonly buffer Starts { uint words[]; } starts;
layout(std430, binding = 4) buffer Counters { uint boxes; uint kilotiles; } counters;
layout(std430, binding = 5) writeonly buffer Tiles { uvec2 records[]; } tiles;
layout(std430, binding = 6) buffer Counts { uint words[]; } counts;
layout(push_constant) uniform Push { uint bits; uint count; } push;

#include "common/igt_touches.glsl"
#include "common/igt_tiles.glsl"

void main() {
    uint t = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (t >= push.count) return;
    ivec3 v[3];
    for (uint i = 0u; i < 3u; i++) {
        uint at = 3u * triangles.words[3u * t + i];
        v[i] = ivec3(vertices.words[at], vertices.words[at + 1u], vertices.words[at + 2u]);
    }
    IgtBox box;
    bool here = true;
    if (line == IGT_LINE_PARALLEL) {
        box = igt_parallel_box(push.bits, v);
    } else if (line == IGT_LINE_CYLINDER) {
        box = igt_cylinder_box(push.bits, v);
    } else {
        // Triangles in several octants have a pass of their own; those with a vertex at the centre have no image.
        uint octant = igt_common_octant(v);
        here = octant < 8u && v[0] != ivec3(0) && v[1] != ivec3(0) && v[2] != ivec3(0);
        box = igt_octant_box(push.bits, v, octant & 7u);
    }
    uint area = box.width * box.height;
    bool alone = here && area == 1u;
    bool small = here && area <= IGT_TILE && (line != IGT_LINE_SPHERE || igt_interior(push.bits, box));
    IgtBox tile = box;
    if (alone || !small) tile.height = 0u;
    uint mask;
    if (line == IGT_LINE_PARALLEL) mask = igt_touched_squares(push.bits, v, tile);
    else if (line == IGT_LINE_CYLINDER) mask = igt_touched_one_by_one(line, push.bits, v, tile);
    else mask = igt_touched_cones(push.bits, v, tile);
    mask |= uint(alone);
    tiles.records[t] = igt_tile_record(push.bits, box, mask);
    uint reciprocal = igt_reciprocal(box.width);
    for (; mask != 0u; mask &= mask - 1u) atomicAdd(counts.words[igt_tile_texel(push.bits, box, reciprocal, mask)], 1u);
    if (here && !alone && !small) {
        uint at = atomicAdd(counters.boxes, 1u), number = igt_tiles(box);
        boxes.records[at] = igt_box_record(t, box);
        starts.words[at] = number;
        if (number >= 1024u) atomicAdd(counters.kilotiles, number >> 10);
    }
}
