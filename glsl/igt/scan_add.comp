#version 460
// Adds its block's sum to every word of a block of 4096.
layout(local_size_x = 256) in;

layout(std430, binding = 0) buffer Values { uint words[]; } values;
layout(std430, binding = 1) readonly buffer Sums { uint words[]; } sums;
layout(push_constant) uniform Push { uint count; } push;

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint add = sums.words[group];
    uint base = group * 4096u;
    for (uint i = base + gl_LocalInvocationID.x; i < min(base + 4096u, push.count); i += 256u) values.words[i] += add;
}
