#version 460
#extension GL_GOOGLE_include_directive : require
// The boxes of triangles that reach into several octants of the sphere, one thread for each octant of each of them.
// Driven by src/igt/gpu/cover.rs; twin of igt::cover::boxes.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Vertices { int words[]; } vertices;
layout(std430, binding = 1) readonly buffer Triangles { uint words[]; } triangles;
layout(std430, binding = 2) writeonly buffer Boxes { uvec4 records[]; } boxes;
layout(std430, binding = 3) writeonly buffer Starts { uint words[]; } starts;
layout(std430, binding = 4) buffer Counters { uint boxes; uint kilotiles; } counters;
// The triangles' numbers.
layout(std430, binding = 5) readonly buffer Several { uint words[]; } several;
layout(push_constant) uniform Push { uint bits; uint count; } push;

#include "common/igt_boxes.glsl"
#include "common/igt_tiles.glsl"

void main() {
    uint n = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (n >= 8u * push.count) return;
    uint t = several.words[n >> 3];
    ivec3 v[3];
    for (uint i = 0u; i < 3u; i++) {
        uint at = 3u * triangles.words[3u * t + i];
        v[i] = ivec3(vertices.words[at], vertices.words[at + 1u], vertices.words[at + 2u]);
    }
    IgtBox box = igt_clipped_box(push.bits, v, n & 7u);
    if (box.width == 0u) return;
    uint at = atomicAdd(counters.boxes, 1u), number = igt_tiles(box);
    boxes.records[at] = igt_box_record(t, box);
    starts.words[at] = number;
    if (number >= 1024u) atomicAdd(counters.kilotiles, number >> 10);
}
