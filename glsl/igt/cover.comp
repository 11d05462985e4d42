#version 460
#extension GL_GOOGLE_include_directive : require
// For each work item (a texel of a box) whether the triangle touches the texel: writes the pair and counts the texel's entries.
// Items are spread evenly, however many texels a triangle covers. Twin of igt::cover::Toucher.
layout(local_size_x = 64) in;
#define ITEMS_PER_THREAD 8u
#define NOT_TOUCHED 0xffffffffu

layout(std430, binding = 0) readonly buffer Vertices { int words[]; } vertices;
layout(std430, binding = 1) readonly buffer Triangles { uint words[]; } triangles;
layout(std430, binding = 2) readonly buffer Boxes { uvec4 records[]; } boxes;
// First item of each box (exclusive sums of the areas), and one past the last.
layout(std430, binding = 3) readonly buffer Starts { uint words[]; } starts;
layout(std430, binding = 4) writeonly buffer Pairs { uvec2 items[]; } pairs;
layout(std430, binding = 5) buffer Counts { uint words[]; } counts;
layout(push_constant) uniform Push { uint line; uint bits; uint boxes; uint items; } push;

#include "common/igt_cover.glsl"

// The box of an item: the last one that starts at or before it.
uint box_of(uint item) {
    uint low = 0u, high = push.boxes;
    while (high - low > 1u) {
        uint middle = (low + high) >> 1;
        if (starts.words[middle] <= item) low = middle;
        else high = middle;
    }
    return low;
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint item = (group * gl_WorkGroupSize.x + gl_LocalInvocationID.x) * ITEMS_PER_THREAD;
    uint last = min(item + ITEMS_PER_THREAD, push.items);
    if (item >= last) return;
    uint box = box_of(item);
    uint end = starts.words[box + 1u];
    bool fresh = true;
    ivec3 v[3];
    uvec4 record;
    for (; item < last; item++) {
        while (item >= end) {
            box++;
            end = starts.words[box + 1u];
            fresh = true;
        }
        if (fresh) {
            record = boxes.records[box];
            for (uint i = 0u; i < 3u; i++) {
                uint at = 3u * triangles.words[3u * record.x + i];
                v[i] = ivec3(vertices.words[at], vertices.words[at + 1u], vertices.words[at + 2u]);
            }
            fresh = false;
        }
        uint at = item - starts.words[box];
        uint width = record.z & 0xffffu;
        uint height = record.z >> 16;
        uint column = ((record.y & 0xffffu) + at % width) & ((1u << push.bits) - 1u);
        uint row = (record.y >> 16) + at / width;
        bool alone = width * height == 1u && (record.w & IGT_SEVERAL_OCTANTS) == 0u;
        if (alone || igt_touches(push.line, push.bits, v, uvec2(column, row), record.w)) {
            uint texel = row << push.bits | column;
            pairs.items[item] = uvec2(texel, record.x);
            atomicAdd(counts.words[texel], 1u);
        } else {
            pairs.items[item] = uvec2(NOT_TOUCHED, 0u);
        }
    }
}
