#version 460
#extension GL_GOOGLE_include_directive : require
// Which needed (texel, layer) pairs have no triangle of the layer in their texel: their numbers, in any order. The host sorts
// what is found for them. Driven by src/igt/gpu/gutter.rs; twin of igt::gutter.
layout(local_size_x = 64) in;

#include "common/igt_lists.glsl"

layout(std430, binding = 5) readonly buffer Needs { uvec2 pairs[]; } needs;
layout(std430, binding = 6) buffer Missing { uint count; uint pairs[]; } missing;
layout(push_constant) uniform Push { uint count; } push;

void main() {
    uint n = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (n >= push.count) return;
    uvec2 pair = needs.pairs[n];
    if (!has(pair.x, pair.y)) missing.pairs[atomicAdd(missing.count, 1u)] = n;
}
