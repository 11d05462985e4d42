#version 460
#extension GL_GOOGLE_include_directive : require
// For each triangle the boxes of texels it may touch and their areas: the work items of the cover pass. Driven by
// src/igt/gpu/build.rs; twin of igt::cover::boxes.
//
// Box i < count belongs to triangle i; further boxes (a triangle in several octants) are appended by an atomic, in any
// order: lists are sorted later, so the order never shows.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Vertices { int words[]; } vertices;
layout(std430, binding = 1) readonly buffer Triangles { uint words[]; } triangles;
layout(std430, binding = 2) writeonly buffer Boxes { uvec4 records[]; } boxes;
layout(std430, binding = 3) buffer Areas { uint words[]; } areas;
layout(std430, binding = 4) buffer Extra { uint next; } extra;
layout(push_constant) uniform Push { uint line; uint bits; uint count; uint boxes; } push;

#include "common/igt_cover.glsl"

void put(uint at, uint triangle, IgtBox b) {
    boxes.records[at] = uvec4(triangle, b.column | b.row << 16, b.width | b.height << 16, b.octant);
    areas.words[at] = b.width * b.height;
}

void main() {
    uint t = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (t >= push.count) return;
    ivec3 v[3];
    for (uint i = 0u; i < 3u; i++) {
        uint at = 3u * triangles.words[3u * t + i];
        v[i] = ivec3(vertices.words[at], vertices.words[at + 1u], vertices.words[at + 2u]);
    }
    if (push.line != IGT_LINE_SPHERE) {
        if (push.line == IGT_LINE_PARALLEL) put(t, t, igt_parallel_box(push.bits, v));
        else put(t, t, igt_cylinder_box(push.bits, v));
        return;
    }
    areas.words[t] = 0u;
    if (v[0] == ivec3(0) || v[1] == ivec3(0) || v[2] == ivec3(0)) return;
    uint octant = igt_common_octant(v);
    if (octant < 8u) {
        put(t, t, igt_octant_box(push.bits, v, octant));
        return;
    }
    bool first = true;
    for (octant = 0u; octant < 8u; octant++) {
        IgtBox b = igt_clipped_box(push.bits, v, octant);
        if (b.width == 0u) continue;
        uint at = t;
        if (!first) at = push.count + atomicAdd(extra.next, 1u);
        first = false;
        if (at < push.boxes) put(at, t, b);
    }
}
