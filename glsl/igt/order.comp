#version 460
// Sorts each texel's list by triangle and drops doubles; writes the length that is left and which layers the list has.
//
// Lists over LONGEST are left to the host (src/igt/gpu/build.rs): llvmpipe ends the loops of an invocation after 65535 iterations in
// total, without a word, and sorting takes about n log n.
// Lists of up to SHORT entries, nearly all, are sorted in registers by Batcher's network (Knuth, TAOCP 3, 5.2.2, algorithm M).
layout(local_size_x = 64) in;
// Whether triangles have different layers.
layout(constant_id = 0) const bool mixed = true;
#define LONGEST 2048u
#define SHORT 16u
#define NONE 0xffffffffu

layout(std430, binding = 0) readonly buffer Starts { uint words[]; } starts;
layout(std430, binding = 1) buffer Lists { uint words[]; } lists;
layout(std430, binding = 2) writeonly buffer Lengths { uint words[]; } lengths;
layout(std430, binding = 3) readonly buffer Layers { uint words[]; } layers;
// Bit (layer mod 32) is set where the list has the layer.
layout(std430, binding = 4) writeonly buffer Masks { uint words[]; } masks;
// Not zero where some list is not as long as it was, or is left to the host.
layout(std430, binding = 5) buffer Changed { uint any; } changed;
layout(push_constant) uniform Push { uint texels; uint mask; } push;

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
    for (uint end = max(count, 1u) - 1u; end > 0u; end--) {
        uint top = lists.words[base];
        lists.words[base] = lists.words[base + end];
        lists.words[base + end] = top;
        sift(base, 0u, end);
    }
}

#define EACH(DO) DO(0) DO(1) DO(2) DO(3) DO(4) DO(5) DO(6) DO(7) DO(8) DO(9) DO(10) DO(11) DO(12) DO(13) DO(14) DO(15)
#define SWAP(I, J) { uint low = min(x[I], x[J]); x[J] = max(x[I], x[J]); x[I] = low; }
#define LOAD(I) x[I] = NONE; if (I < count) x[I] = lists.words[base + I];
#define STORE(I) if (I < count) lists.words[base + I] = x[I];
#define DOUBLE(I) doubles = doubles || (I + 1 < count && x[I] == x[(I + 1) & 15]);

// Whether the list has doubles.
bool sort_short(uint base, uint count) {
    uint x[SHORT];
    EACH(LOAD)
    SWAP(0, 1) SWAP(2, 3) SWAP(4, 5) SWAP(6, 7) SWAP(8, 9) SWAP(10, 11) SWAP(12, 13) SWAP(14, 15)
    SWAP(0, 2) SWAP(1, 3) SWAP(4, 6) SWAP(5, 7) SWAP(8, 10) SWAP(9, 11) SWAP(12, 14) SWAP(13, 15)
    SWAP(1, 2) SWAP(5, 6) SWAP(9, 10) SWAP(13, 14)
    SWAP(0, 4) SWAP(1, 5) SWAP(2, 6) SWAP(3, 7) SWAP(8, 12) SWAP(9, 13) SWAP(10, 14) SWAP(11, 15)
    SWAP(2, 4) SWAP(3, 5) SWAP(10, 12) SWAP(11, 13)
    SWAP(1, 2) SWAP(3, 4) SWAP(5, 6) SWAP(9, 10) SWAP(11, 12) SWAP(13, 14)
    SWAP(0, 8) SWAP(1, 9) SWAP(2, 10) SWAP(3, 11) SWAP(4, 12) SWAP(5, 13) SWAP(6, 14) SWAP(7, 15)
    SWAP(4, 8) SWAP(5, 9) SWAP(6, 10) SWAP(7, 11)
    SWAP(2, 4) SWAP(3, 5) SWAP(6, 8) SWAP(7, 9) SWAP(10, 12) SWAP(11, 13)
    SWAP(1, 2) SWAP(3, 4) SWAP(5, 6) SWAP(7, 8) SWAP(9, 10) SWAP(11, 12) SWAP(13, 14)
    EACH(STORE)
    bool doubles = false;
    EACH(DOUBLE)
    return doubles;
}

void main() {
    uint t = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (t >= push.texels) return;
    uint base = starts.words[t], count = starts.words[t + 1u] - base;
    if (count > LONGEST) {
        lengths.words[t] = count;
        masks.words[t] = 0xffffffffu;
        atomicOr(changed.any, 1u);
        return;
    }
    bool is_short = count <= SHORT;
    bool doubles = sort_short(base, is_short ? count : 0u) || !is_short;
    heap_sort(base, is_short ? 0u : count);
    uint kept = doubles ? 0u : count;
    for (uint i = kept; i < count; i++) {
        uint value = lists.words[base + i];
        if (kept == 0u || lists.words[base + kept - 1u] != value) {
            if (kept != i) lists.words[base + kept] = value;
            kept++;
        }
    }
    lengths.words[t] = kept;
    if (kept != count) atomicOr(changed.any, 1u);
    uint mask = push.mask;
    if (mixed) {
        mask = 0u;
        for (uint i = 0u; i < kept; i++) {
            uint triangle = lists.words[base + i];
            mask |= 1u << (layers.words[triangle >> 2] >> (8u * (triangle & 3u)) & 31u);
        }
    }
    masks.words[t] = kept == 0u ? 0u : mask;
}
