#version 460
#extension GL_GOOGLE_include_directive : require
// A lookup for each query point. Driven by src/igt/gpu/query.rs.
layout(local_size_x = 64) in;

layout(constant_id = 0) const uint known_line = 255u;
layout(constant_id = 1) const uint known_layout = 255u;
layout(constant_id = 2) const uint known_record = 255u;

layout(std430, binding = 0) readonly buffer Hash { uvec2 pairs[]; } hash;
layout(std430, binding = 1) readonly buffer List { uvec4 quads[]; } list;
layout(std430, binding = 2) readonly buffer Triangle { uvec4 quads[]; } triangle;
layout(std430, binding = 3) readonly buffer Points { ivec4 points[]; } points;
layout(std430, binding = 4) writeonly buffer Found { uvec4 answers[]; } found;
layout(push_constant) uniform Push { uvec4 tables; uvec2 window; uint count; uint asker; uint nearest; } push;

uvec2 igt_load_hash2(uint i) { return hash.pairs[i]; }
uint igt_load_hash1(uint i) { return hash.pairs[i >> 1][i & 1u]; }
uvec4 igt_load_list4(uint i) { return list.quads[i]; }
uint igt_load_list1(uint i) { return list.quads[i >> 2][i & 3u]; }
uvec4 igt_load_triangle4(uint i) { return triangle.quads[i]; }
uint igt_load_triangle1(uint i) { return triangle.quads[i >> 2][i & 3u]; }

#include "common/igt.glsl"

void main() {
    uint i = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    IgtTables t = igt_known(igt_tables(push.tables, push.window), known_line, known_layout, known_record);
    IgtFound f = igt_lookup(t, points.points[i].xyz, push.asker, push.nearest != 0u);
    found.answers[2u * i] = uvec4(f.triangle, floatBitsToUint(f.barycentric.x), floatBitsToUint(f.barycentric.y), floatBitsToUint(f.barycentric.z));
    found.answers[2u * i + 1u] = uvec4(f.fetches, uint(f.hit), f.tests, 0u);
}
