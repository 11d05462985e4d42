#version 460
#extension GL_GOOGLE_include_directive : require
// Asks the nodes of blocks that are not accepted as a whole, a block a workgroup, a node a thread. Driven by
// src/lod/multiresolution/gpu.rs; twin of select.rs and view.rs beside it.
//
// Everything is a sum of products of ends of intervals: a box that holds another is never judged better, whatever is rounded.
layout(local_size_x = 64) in;

#include "lod/cut.glsl"

layout(std430, binding = 1) readonly buffer Nodes { uvec4 quads[]; } nodes;
layout(std430, binding = 2) readonly buffer Codes { uint words[]; } codes;
layout(std430, binding = 3) readonly buffer Views { uvec4 quads[]; } views;
// For each level the workgroups of its dispatch: three words and one for nothing.
layout(std430, binding = 4) buffer Counts { uvec4 groups[]; } counts;
layout(std430, binding = 5) buffer Lists { uint blocks[]; } lists;

const uint PERSPECTIVE = 1u;
const uint DOUBLE_SIDED = 2u;
const uint ANGLES = 4u;
const uint COLOURS = 8u;
const uint OUTSIDE_IS_COARSE = 16u;
const uint SURFACE_ALONE = 32u;
const uint VIEW_QUADS = 13u;
const float STEPS_SQUARED = 127.0 * 127.0;

struct Bound {
    vec3 low;
    vec3 high;
    float total;
    float normal;
    uvec3 facing;
};

struct View {
    vec3 eye;
    uint flags;
    vec3 forward;
    float by_distance;
    float by_depth;
    uint levels;
    vec2 pixels;
    vec2 colour;
    uint first;
};

struct Place {
    vec3 low;
    vec3 high;
    float near;
    float far;
    float depth;
};

Bound bound_of(uint node) {
    uvec4 a = nodes.quads[node * 3u];
    uvec4 b = nodes.quads[node * 3u + 1u];
    uvec4 c = nodes.quads[node * 3u + 2u];
    Bound bound;
    bound.low = uintBitsToFloat(a.xyz);
    bound.high = uintBitsToFloat(uvec3(a.w, b.xy));
    bound.total = uintBitsToFloat(b.z);
    bound.normal = uintBitsToFloat(b.w);
    bound.facing = c.xyz;
    return bound;
}

View view_of(uint k) {
    uint first = k * VIEW_QUADS;
    uvec4 a = views.quads[first];
    uvec4 b = views.quads[first + 1u];
    uvec4 c = views.quads[first + 2u];
    uvec4 d = views.quads[first + 3u];
    View view;
    view.eye = uintBitsToFloat(a.xyz);
    view.flags = a.w;
    view.forward = uintBitsToFloat(b.xyz);
    view.by_distance = uintBitsToFloat(b.w);
    view.by_depth = uintBitsToFloat(c.x);
    view.levels = c.y;
    view.pixels = uintBitsToFloat(c.zw);
    view.colour = uintBitsToFloat(d.xy);
    view.first = first;
    return view;
}

float squares(vec3 v) {
    precise float sum = v.x * v.x + v.y * v.y + v.z * v.z;
    return sum;
}

Place place_of(View view, Bound bound) {
    if ((view.flags & PERSPECTIVE) == 0u) return Place(view.eye, view.eye, 1.0, 1.0, 0.0);
    precise vec3 low = bound.low - view.eye;
    precise vec3 high = bound.high - view.eye;
    precise vec3 to_low = view.forward * low;
    precise vec3 to_high = view.forward * high;
    vec3 depths = min(to_low, to_high);
    precise float depth = depths.x + depths.y + depths.z;
    float near = squares(max(max(low, -high), vec3(0.0)));
    return Place(low, high, near, squares(max(high, -low)), depth);
}

// The least and the most that a way from the eye into the box goes along a normal; `first` byte of its box.
vec2 along(Place place, uvec3 facing, uint first) {
    precise vec2 sum = vec2(0.0);
    for (uint k = 0u; k < 3u; k++) {
        uint a = first + k, b = first + k + 3u;
        float low = float(bitfieldExtract(int(facing[a >> 2u]), int(a & 3u) * 8, 8));
        float high = float(bitfieldExtract(int(facing[b >> 2u]), int(b & 3u) * 8, 8));
        precise vec4 ends = vec4(place.low[k] * low, place.low[k] * high, place.high[k] * low, place.high[k] * high);
        sum.x = sum.x + min(min(ends.x, ends.y), min(ends.z, ends.w));
        sum.y = sum.y + max(max(ends.x, ends.y), max(ends.z, ends.w));
    }
    return sum;
}

bool is_outside(View view, Bound bound) {
    if ((view.flags & OUTSIDE_IS_COARSE) == 0u) return false;
    for (uint k = 0u; k < 5u; k++) {
        vec4 plane = uintBitsToFloat(views.quads[view.first + 8u + k]);
        precise vec3 low = plane.xyz * bound.low;
        precise vec3 high = plane.xyz * bound.high;
        vec3 most = max(low, high);
        precise float value = most.x + most.y + most.z + plane.w;
        if (value < 0.0) return true;
    }
    return false;
}

bool within(View view, Place place, float displacement, float pixels) {
    precise float spans = displacement * view.by_distance;
    precise float over = spans * spans;
    precise float limit = pixels * pixels * place.near;
    if (over <= limit) return true;
    precise float deep = displacement * view.by_depth;
    precise float square = place.depth * place.depth;
    precise float most = pixels * square;
    precise float left = deep * deep * place.far;
    precise float right = most * most;
    return place.depth > 0.0 && left <= right;
}

uint level_of(View view, Place place) {
    uint level = 0u;
    while (level + 1u < view.levels) {
        uint k = level + 1u;
        if (!(place.near >= uintBitsToFloat(views.quads[view.first + 4u + (k >> 2u)][k & 3u]))) break;
        level = k;
    }
    return level;
}

float decoded(uint code) {
    if (code == 0u) return 0.0;
    return code == 255u ? 1e15 : uintBitsToFloat(code - 1u + (123u << 3u) << 20u);
}

vec2 colour_of(uint node, uint level) {
    uint word = codes.words[node * push.code_words + (level >> 1u)] >> (16u * (level & 1u));
    return vec2(decoded(word & 255u), decoded(word >> 8u & 255u));
}

bool is_steep(Place place, uvec3 facing, float product, float left) {
    float upright = -along(place, facing, 6u).y;
    precise float sine = upright * upright;
    precise float one = place.far * STEPS_SQUARED;
    precise float rest = one - sine;
    float cosine = max(rest, 0.0);
    precise float half_of_one = 0.5 * one;
    precise float off = product * product * cosine;
    precise float most = left * left * sine;
    return upright > 0.0 && left >= 0.0 && sine >= half_of_one && off <= most;
}

bool accepts(View view, Bound bound, uint node, uint limit) {
    Place place = place_of(view, bound);
    if (is_outside(view, bound)) return true;
    if ((view.flags & DOUBLE_SIDED) == 0u && along(place, bound.facing, 0u).x >= 0.0) return true;
    float pixels = view.pixels[limit];
    float displaced = (view.flags & SURFACE_ALONE) == 0u ? bound.total : bound.normal;
    if (within(view, place, displaced, pixels)) return true;
    if ((view.flags & COLOURS) == 0u) return false;
    vec2 off = colour_of(node, level_of(view, place));
    float most = view.colour[limit];
    if (within(view, place, bound.normal, pixels)) return off.x <= most;
    precise float left = most - off.x;
    return (view.flags & ANGLES) != 0u && is_steep(place, bound.facing, off.y, left);
}

bool all_accept(uint node, uint limit) {
    Bound bound = bound_of(node);
    for (uint k = 0u; k < push.views; k++) {
        if (!accepts(view_of(k), bound, node, limit)) return false;
    }
    return true;
}

shared uint words[2];

void main() {
    uint block = lists.blocks[push.list + gl_WorkGroupID.x];
    uint me = gl_LocalInvocationID.x;
    if (me < 2u) words[me] = 0u;
    barrier();
    uint n = block * BLOCK + me;
    if (n < push.node_count) {
        bool collapse = n < push.collapses >> (6u * push.level);
        uint node = push.first_node + n;
        bool yes = collapse && all_accept(node, 0u);
        if (collapse && !yes && push.level == 0u && push.before != NEVER) {
            yes = accepted(push.before, n) && all_accept(node, 1u);
        }
        if (yes) {
            atomicOr(words[me >> 5u], 1u << (me & 31u));
        } else if (push.level > 0u) {
            uint slot = atomicAdd(counts.groups[push.level - 1u].x, 1u);
            lists.blocks[push.next_list + slot] = n;
        }
    }
    barrier();
    if (me < 2u) bits.words[push.now + bits_of(push.level) + block * 2u + me] = words[me];
}
