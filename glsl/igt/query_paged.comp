#version 460
#extension GL_GOOGLE_include_directive : require
// query.comp for tables in pages. Driven by src/igt/gpu/query_paged.rs.
layout(local_size_x = 64) in;
layout(constant_id = 0) const uint known_line = 255u;
layout(constant_id = 1) const uint known_layout = 255u;
layout(constant_id = 2) const uint known_record = 255u;
layout(constant_id = 3) const uint igt_page_bits = 27u;

layout(std430, binding = 0) readonly buffer Hash0 { uvec2 pairs[]; } igt_hash_0;
layout(std430, binding = 1) readonly buffer Hash1 { uvec2 pairs[]; } igt_hash_1;
layout(std430, binding = 2) readonly buffer Hash2 { uvec2 pairs[]; } igt_hash_2;
layout(std430, binding = 3) readonly buffer Hash3 { uvec2 pairs[]; } igt_hash_3;
layout(std430, binding = 4) readonly buffer List0 { uvec4 quads[]; } igt_list_0;
layout(std430, binding = 5) readonly buffer List1 { uvec4 quads[]; } igt_list_1;
layout(std430, binding = 6) readonly buffer List2 { uvec4 quads[]; } igt_list_2;
layout(std430, binding = 7) readonly buffer List3 { uvec4 quads[]; } igt_list_3;
layout(std430, binding = 8) readonly buffer Triangle0 { uvec4 quads[]; } igt_triangle_0;
layout(std430, binding = 9) readonly buffer Triangle1 { uvec4 quads[]; } igt_triangle_1;
layout(std430, binding = 10) readonly buffer Triangle2 { uvec4 quads[]; } igt_triangle_2;
layout(std430, binding = 11) readonly buffer Triangle3 { uvec4 quads[]; } igt_triangle_3;
layout(std430, binding = 12) readonly buffer Points { ivec4 points[]; } points;
layout(std430, binding = 13) writeonly buffer Found { uvec4 answers[]; } found;
layout(push_constant) uniform Push { uvec4 tables; uvec2 window; uint count; uint asker; uint nearest; } push;

#include "common/igt_pages.glsl"
#include "common/igt.glsl"

void main() {
    uint i = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    IgtTables t = igt_known(igt_tables(push.tables, push.window), known_line, known_layout, known_record);
    IgtFound f = igt_lookup(t, points.points[i].xyz, push.asker, push.nearest != 0u);
    found.answers[2u * i] = uvec4(f.triangle, floatBitsToUint(f.barycentric.x), floatBitsToUint(f.barycentric.y), floatBitsToUint(f.barycentric.z));
    found.answers[2u * i + 1u] = uvec4(f.fetches, uint(f.hit), f.tests, 0u);
}
