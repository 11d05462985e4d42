#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the triangles of collapses that are not accepted, as far as their makers are: indices, numbers, and how many. The
// same blocks and threads as lod/select.comp at the lowest level. Driven by src/lod/multiresolution/gpu.rs.
layout(local_size_x = 64) in;

#include "lod/cut.glsl"

layout(std430, binding = 1) readonly buffer Nodes { uvec4 quads[]; } nodes;
// Three corners, and the node of the collapse that made it.
layout(std430, binding = 2) readonly buffer Faces { uvec4 quads[]; } faces;
layout(std430, binding = 3) readonly buffer Lists { uint blocks[]; } lists;
// VkDrawIndexedIndirectCommand.
layout(std430, binding = 4) buffer Command { uint words[]; } command;
layout(std430, binding = 5) writeonly buffer Indices { uint words[]; } indices;
layout(std430, binding = 6) writeonly buffer Numbers { uint words[]; } numbers;

void main() {
    uint n = lists.blocks[push.list + gl_WorkGroupID.x] * BLOCK + gl_LocalInvocationID.x;
    if (n >= push.node_count || accepted(push.now, n)) return;
    uint end = nodes.quads[(n + 1u) * 3u + 2u].w;
    for (uint f = nodes.quads[n * 3u + 2u].w; f < end; f++) {
        uvec4 face = faces.quads[f];
        if (face.w != NEVER && !accepted(push.now, face.w)) continue;
        uint first = atomicAdd(command.words[0], 3u);
        for (uint k = 0u; k < 3u; k++) indices.words[first + k] = face[k];
        numbers.words[first / 3u] = f;
    }
}
