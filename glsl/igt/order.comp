#version 460
// Sorts each texel's list by triangle and drops doubles; writes the length that is left and which layers the list has.
//
// Lists over LONGEST are left to the host (src/igt/gpu/build.rs): llvmpipe ends the loops of an invocation after 65535 iterations in
// total, without a word, and sorting takes about n log n.
layout(local_size_x = 64) in;
#define LONGEST 2048u

layout(std430, binding = 0) readonly buffer Starts { uint words[]; } starts;
layout(std430, binding = 1) buffer Lists { uint words[]; } lists;
layout(std430, binding = 2) writeonly buffer Lengths { uint words[]; } lengths;
layout(std430, binding = 3) readonly buffer Layers { uint words[]; } layers;
// Bit (layer mod 32) is set where the list has the layer.
layout(std430, binding = 4) writeonly buffer Masks { uint words[]; } masks;
layout(push_constant) uniform Push { uint texels; } push;

void sift(uint base, uint root, uint count) {
    uint value = lists.words[base + root];
    while (true) {
        uint child = 2u * root + 1u;
        if (child >= count) break;
        uint larger = lists.words[base + child];
        if (child + 1u < count && lists.words[base + child + 1u] > larger) {
            child++;
            larger = lists.words[base + child];
        }
        if (larger <= value) break;
        lists.words[base + root] = larger;
        root = child;
    }
    lists.words[base + root] = value;
}

void heap_sort(uint base, uint count) {
    for (uint i = count / 2u; i > 0u; i--) sift(base, i - 1u, count);
    for (uint end = count - 1u; end > 0u; end--) {
        uint top = lists.words[base];
        lists.words[base] = lists.words[base + end];
        lists.words[base + end] = top;
        sift(base, 0u, end);
    }
}

void insertion_sort(uint base, uint count) {
    for (uint i = 1u; i < count; i++) {
        uint value = lists.words[base + i];
        uint at = i;
        while (at > 0u && lists.words[base + at - 1u] > value) {
            lists.words[base + at] = lists.words[base + at - 1u];
            at--;
        }
        lists.words[base + at] = value;
    }
}

void main() {
    uint t = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (t >= push.texels) return;
    uint base = starts.words[t], count = starts.words[t + 1u] - base;
    if (count > LONGEST) {
        lengths.words[t] = count;
        masks.words[t] = 0xffffffffu;
        return;
    }
    if (count > 24u) heap_sort(base, count);
    else if (count > 1u) insertion_sort(base, count);
    uint kept = 0u, mask = 0u;
    for (uint i = 0u; i < count; i++) {
        uint value = lists.words[base + i];
        mask |= 1u << (layers.words[value >> 2] >> (8u * (value & 3u)) & 31u);
        if (kept == 0u || lists.words[base + kept - 1u] != value) {
            if (kept != i) lists.words[base + kept] = value;
            kept++;
        }
    }
    lengths.words[t] = kept;
    masks.words[t] = mask;
}
