#version 460
#extension GL_GOOGLE_include_directive : require
// For each missing (texel, layer) the nearest texels' triangles. Driven by src/igt/gpu/gutter.rs; twin of igt::gutter, which
// says why the work of a thread is bounded.
layout(local_size_x = 64) in;
#define MOST 8
#define PER_TEXEL 16u
#define UNREACHED 0xffffffffu
// Words of an answer: pair, ring, count, triangles.
#define ANSWER 11u
// The family of lines, see bounds.comp.
layout(constant_id = 0) const uint line = 0u;

#include "common/igt_lists.glsl"

layout(std430, binding = 5) readonly buffer Needs { uvec2 pairs[]; } needs;
layout(std430, binding = 6) readonly buffer Missing { uint count; uint pairs[]; } missing;
layout(std430, binding = 7) writeonly buffer Answers { uint words[]; } answers;
layout(push_constant) uniform Push { uint bits; uint count; uint reach; } push;

#include "common/igt_line.glsl"

uint distances[MOST];
uint found[MOST];

// The texel at an offset; -1 outside.
int neighbour(ivec2 at, ivec2 offset) {
    int width = 1 << push.bits;
    ivec2 p = at + offset;
    if (line == IGT_LINE_CYLINDER) p.x &= width - 1;
    if (line == IGT_LINE_SPHERE) {
        if (p.x < 0 || p.x >= width) p = ivec2(p.x < 0 ? -1 - p.x : 2 * width - 1 - p.x, width - 1 - p.y);
        if (p.y < 0 || p.y >= width) p = ivec2(width - 1 - p.x, p.y < 0 ? -1 - p.y : 2 * width - 1 - p.y);
    }
    bool inside = p.x >= 0 && p.x < width && p.y >= 0 && p.y < width;
    return inside ? p.y << push.bits | p.x : -1;
}

bool smaller(uint da, uint ta, uint db, uint tb) {
    return da != db ? da < db : ta < tb;
}

void keep(uint distance2, uint triangle) {
    int at = MOST - 1;
    bool present = false;
    for (int i = 0; i < MOST; i++) {
        if (distances[i] != UNREACHED && found[i] == triangle) {
            present = true;
            at = i;
        }
    }
    if (!smaller(distance2, triangle, distances[at], found[at])) return;
    while (at > 0 && smaller(distance2, triangle, distances[at - 1], found[at - 1])) {
        distances[at] = distances[at - 1];
        found[at] = found[at - 1];
        at--;
    }
    distances[at] = distance2;
    found[at] = triangle;
}

// The i-th of the 8r offsets at Chebyshev distance r.
ivec2 ring_offset(int r, int i) {
    int side = i / (2 * r), along = i % (2 * r);
    switch (side) {
        case 0: return ivec2(-r + along, -r);
        case 1: return ivec2(r, -r + along);
        case 2: return ivec2(r - along, r);
        default: return ivec2(-r, r - along);
    }
}

void gather(ivec2 at, int r, uint layer) {
    uint nearest = UNREACHED;
    for (int i = 0; i < 8 * r; i++) {
        ivec2 d = ring_offset(r, i);
        int texel = neighbour(at, d);
        if (texel >= 0 && has(uint(texel), layer)) nearest = min(nearest, uint(d.x * d.x + d.y * d.y));
    }
    for (int i = 0; i < 8 * r; i++) {
        ivec2 d = ring_offset(r, i);
        uint distance2 = uint(d.x * d.x + d.y * d.y);
        int texel = neighbour(at, d);
        if (texel < 0 || distance2 > nearest + uint(r)) continue;
        uint start = starts.words[texel], count = min(lengths.words[texel], PER_TEXEL);
        for (uint k = 0u; k < count; k++) {
            uint triangle = lists.words[start + k];
            if (layer_of(triangle) == layer) keep(distance2, triangle);
        }
    }
}

void main() {
    uint m = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (m >= push.count) return;
    uint n = missing.pairs[m];
    uint texel = needs.pairs[n].x, layer = needs.pairs[n].y;
    ivec2 at = ivec2(texel & ((1u << push.bits) - 1u), texel >> push.bits);
    uint ring = UNREACHED;
    for (int r = 1; r <= int(push.reach) && ring == UNREACHED; r++) {
        for (int i = 0; i < 8 * r && ring == UNREACHED; i++) {
            int t = neighbour(at, ring_offset(r, i));
            if (t >= 0 && has(uint(t), layer)) ring = uint(r);
        }
    }
    for (int i = 0; i < MOST; i++) {
        distances[i] = UNREACHED;
        found[i] = UNREACHED;
    }
    if (ring != UNREACHED) gather(at, int(ring), layer);
    uint count = 0u;
    for (int i = 0; i < MOST; i++) {
        bool there = distances[i] != UNREACHED;
        answers.words[m * ANSWER + 3u + uint(i)] = there ? found[i] : 0u;
        count += uint(there);
    }
    answers.words[m * ANSWER] = n;
    answers.words[m * ANSWER + 1u] = ring;
    answers.words[m * ANSWER + 2u] = count;
}
