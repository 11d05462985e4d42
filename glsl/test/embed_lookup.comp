#version 460
#extension GL_GOOGLE_include_directive : require
// A lookup as an engine embeds it: its own bindings, its own way to load the tables' words, and igt.glsl.
layout(local_size_x = 64) in;

struct EmbedAnswer { vec3 barycentric; uint triangle; uint fetches; uint hit; uint pad0; uint pad1; };

// xyz: a point on the query grid; w: the layer that asks.
layout(std430, binding = 2) readonly buffer Points { ivec4 list[]; } points;
layout(std430, binding = 3) readonly buffer HashWords { uvec2 pairs[]; } hash;
layout(std430, binding = 5) readonly buffer ListWords { uvec4 quads[]; } list;
layout(std430, binding = 7) readonly buffer TriangleWords { uvec4 quads[]; } triangles;
layout(std430, binding = 8) writeonly buffer Answers { EmbedAnswer list[]; } answers;

uvec2 igt_load_hash2(uint i) { return hash.pairs[i]; }
uint igt_load_hash1(uint i) { return hash.pairs[i >> 1][i & 1u]; }
uvec4 igt_load_list4(uint i) { return list.quads[i]; }
uint igt_load_list1(uint i) { return list.quads[i >> 2][i & 3u]; }
uvec4 igt_load_triangle4(uint i) { return triangles.quads[i]; }
uint igt_load_triangle1(uint i) { return triangles.quads[i >> 2][i & 3u]; }

#include "common/igt.glsl"

layout(push_constant) uniform Push { uvec4 tables; uvec2 window; uint count; uint nearest; } push;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    ivec4 point = points.list[i];
    IgtFound found = igt_lookup(igt_tables(push.tables, push.window), point.xyz, uint(point.w), push.nearest != 0u);
    answers.list[i] = EmbedAnswer(found.barycentric, found.triangle, found.fetches, uint(found.hit), 0u, 0u);
}
