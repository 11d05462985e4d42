#version 460
// Puts every pair into its texel's list. The atomic hands out slots in any order; the order pass sorts.
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Pairs { uvec2 items[]; } pairs;
layout(std430, binding = 1) buffer Cursors { uint words[]; } cursors;
layout(std430, binding = 2) writeonly buffer Lists { uint words[]; } lists;
layout(push_constant) uniform Push { uint items; } push;

void main() {
    uint i = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (i >= push.items) return;
    uvec2 pair = pairs.items[i];
    if (pair.x == 0xffffffffu) return;
    lists.words[atomicAdd(cursors.words[pair.x], 1u)] = pair.y;
}
