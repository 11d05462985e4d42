#version 460
#extension GL_GOOGLE_include_directive : require
// A lookup for each query point. Driven by src/igt/gpu/query.rs.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Hash { uint words[]; } hash;
layout(std430, binding = 1) readonly buffer List { uint words[]; } list;
layout(std430, binding = 2) readonly buffer Triangle { uint words[]; } triangle;
layout(std430, binding = 3) readonly buffer Points { ivec4 points[]; } points;
layout(std430, binding = 4) writeonly buffer Found { uvec4 answers[]; } found;
layout(push_constant) uniform Push { uvec4 tables; uint count; uint asker; uint nearest; } push;

uvec2 igt_load_hash2(uint i) { return uvec2(hash.words[2u * i], hash.words[2u * i + 1u]); }
uint igt_load_hash1(uint i) { return hash.words[i]; }
uint igt_load_list(uint i) { return list.words[i]; }
uvec4 igt_load_triangle4(uint i) {
    return uvec4(triangle.words[4u * i], triangle.words[4u * i + 1u], triangle.words[4u * i + 2u], triangle.words[4u * i + 3u]);
}
uint igt_load_triangle1(uint i) { return triangle.words[i]; }

#include "common/igt.glsl"

void main() {
    uint i = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    IgtTables t = IgtTables(push.tables.x, push.tables.y, push.tables.z, push.tables.w);
    IgtFound f = igt_lookup(t, points.points[i].xyz, push.asker, push.nearest != 0u);
    found.answers[2u * i] = uvec4(f.triangle, floatBitsToUint(f.barycentric.x), floatBitsToUint(f.barycentric.y), floatBitsToUint(f.barycentric.z));
    found.answers[2u * i + 1u] = uvec4(f.fetches, uint(f.hit), 0u, 0u);
}
