#version 460
// Exclusive sums within blocks of 4096 words, in place, and the block sums. With scan_spine and scan_add: a whole scan.
layout(local_size_x = 256) in;
#define PER_THREAD 16u

layout(std430, binding = 0) buffer Values { uint words[]; } values;
layout(std430, binding = 1) writeonly buffer Sums { uint words[]; } sums;
layout(push_constant) uniform Push { uint count; } push;

shared uint totals[256];

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint base = (group * 256u + gl_LocalInvocationID.x) * PER_THREAD;
    uint sum = 0u;
    for (uint i = base; i < min(base + PER_THREAD, push.count); i++) sum += values.words[i];
    uint me = gl_LocalInvocationID.x;
    totals[me] = sum;
    barrier();
    for (uint step = 1u; step < 256u; step <<= 1) {
        uint add = me >= step ? totals[me - step] : 0u;
        barrier();
        totals[me] += add;
        barrier();
    }
    uint before = totals[me] - sum;
    for (uint i = base; i < min(base + PER_THREAD, push.count); i++) {
        uint value = values.words[i];
        values.words[i] = before;
        before += value;
    }
    if (me == 255u && base < push.count + 4096u) sums.words[group] = totals[255];
}
