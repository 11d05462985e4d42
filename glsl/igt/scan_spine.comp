#version 460
// Exclusive sums of the block sums, in place, by one workgroup.
layout(local_size_x = 256) in;

layout(std430, binding = 0) buffer Sums { uint words[]; } sums;
layout(push_constant) uniform Push { uint count; } push;

shared uint totals[256];

void main() {
    uint me = gl_LocalInvocationID.x;
    uint per_thread = (push.count + 255u) / 256u;
    uint first = min(me * per_thread, push.count), last = min(first + per_thread, push.count);
    uint sum = 0u;
    for (uint i = first; i < last; i++) sum += sums.words[i];
    totals[me] = sum;
    barrier();
    for (uint step = 1u; step < 256u; step <<= 1) {
        uint add = me >= step ? totals[me - step] : 0u;
        barrier();
        totals[me] += add;
        barrier();
    }
    uint before = totals[me] - sum;
    for (uint i = first; i < last; i++) {
        uint value = sums.words[i];
        sums.words[i] = before;
        before += value;
    }
}
