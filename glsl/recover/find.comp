#version 460
#extension GL_GOOGLE_include_directive : require
// Closest points and first hits of many questions, one thread each: the twin of src/mesh/bvh, where the reasons are. Driven
// by src/recover/many/gpu.rs.
//
// Answers do not depend on the order in which boxes are visited, so they are the processor's, bit for bit.
layout(local_size_x = 64) in;

// A node: low corners of four boxes (an axis each), high corners, children. A pack: corners of four triangles, their numbers.
layout(std430, binding = 0) readonly buffer Nodes { vec4 quads[]; } nodes;
layout(std430, binding = 1) readonly buffer Packs { vec4 quads[]; } packs;
// A question: a point or the beginning of a ray, and how far (squared for points); a direction, and what is asked.
layout(std430, binding = 2) readonly buffer Questions { vec4 quads[]; } questions;
// An answer: triangle and barycentrics; the distance, and whether the stack was too short.
layout(std430, binding = 3) writeonly buffer Answers { uvec4 quads[]; } answers;
layout(push_constant) uniform Push { uint count; uint any_node; float largest; } push;

const uint NODE = 7u;
const uint PACK = 10u;
const uint IS_LEAF = 0x80000000u;
const uint NONE = 0xffffffffu;
const int DEPTH = 96;
const uint ASK_CLOSEST = 0u;
const uint ASK_CLOSEST_FACING = 1u;
const uint ASK_RAY = 2u;
const uint ASK_RAY_FRONT = 3u;
const uint ASK_RAY_BACK = 4u;
const float LEAST = 1e-37;
const float MARGIN = 4e-6;
const float ENDLESS = 1e30;
const float SHORTEST = 1e-30;
#define INFINITE uintBitsToFloat(0x7f800000u)

struct Best {
    uint triangle;
    vec3 b;
    float distance;
};

struct Prepared {
    vec3 begin;
    vec3 inverse;
    vec3 near_from;
    vec3 far_from;
    ivec3 axes;
    vec3 shear;
    float reach;
    uint ask;
};

vec4 corner(uint pack, int c, int axis) {
    return packs.quads[pack * PACK + uint(c * 3 + axis)];
}

uvec4 ids(uint pack) {
    return floatBitsToUint(packs.quads[pack * PACK + 9u]);
}

vec4 dot4(vec4 a[3], vec4 b[3]) {
    precise vec4 r = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    return r;
}

bvec4 both(bvec4 a, bvec4 b) {
    return bvec4(uvec4(a) & uvec4(b));
}

// Squares of the distances to four boxes.
vec4 box_distances(uint node, vec3 p) {
    precise vec4 sum = vec4(0.0);
    for (int k = 0; k < 3; k++) {
        vec4 low = nodes.quads[node * NODE + uint(k)];
        vec4 high = nodes.quads[node * NODE + 3u + uint(k)];
        precise vec4 outside = max(max(low - p[k], p[k] - high), vec4(0.0));
        precise vec4 square = outside * outside;
        sum = k == 0 ? square : sum + square;
    }
    return sum;
}

void take_closest(uint pack, vec3 p, bool facing, vec3 way, inout Best best) {
    vec4 ab[3], ac[3], ap[3], bp[3], cp[3];
    for (int k = 0; k < 3; k++) {
        vec4 a = corner(pack, 0, k), b = corner(pack, 1, k), c = corner(pack, 2, k);
        precise vec4 e = b - a, f = c - a, g = p[k] - a, h = p[k] - b, i = p[k] - c;
        ab[k] = e; ac[k] = f; ap[k] = g; bp[k] = h; cp[k] = i;
    }
    precise vec4 d1 = dot4(ab, ap), d2 = dot4(ac, ap);
    precise vec4 d3 = dot4(ab, bp), d4 = dot4(ac, bp);
    precise vec4 d5 = dot4(ab, cp), d6 = dot4(ac, cp);
    precise vec4 va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    vec4 zero = vec4(0.0), one = vec4(1.0), least = vec4(LEAST);
    precise vec4 sum = max(va + vb + vc, least);
    precise vec4 v = vb / sum, w = vc / sum;
    precise vec4 e = d4 - d3, f = d5 - d6;
    precise vec4 along_bc = e / max(e + f, least);
    precise vec4 rest_bc = one - along_bc;
    bvec4 on = both(lessThanEqual(va, zero), both(greaterThanEqual(e, zero), greaterThanEqual(f, zero)));
    v = mix(v, rest_bc, on); w = mix(w, along_bc, on);
    precise vec4 along_ac = d2 / max(d2 - d6, least);
    on = both(lessThanEqual(vb, zero), both(greaterThanEqual(d2, zero), lessThanEqual(d6, zero)));
    v = mix(v, zero, on); w = mix(w, along_ac, on);
    on = both(greaterThanEqual(d6, zero), lessThanEqual(d5, d6));
    v = mix(v, zero, on); w = mix(w, one, on);
    precise vec4 along_ab = d1 / max(d1 - d3, least);
    on = both(lessThanEqual(vc, zero), both(greaterThanEqual(d1, zero), lessThanEqual(d3, zero)));
    v = mix(v, along_ab, on); w = mix(w, zero, on);
    on = both(greaterThanEqual(d3, zero), lessThanEqual(d4, d3));
    v = mix(v, one, on); w = mix(w, zero, on);
    on = both(lessThanEqual(d1, zero), lessThanEqual(d2, zero));
    v = mix(v, zero, on); w = mix(w, zero, on);
    v = min(max(v, zero), one);
    w = min(max(w, zero), one - v);
    precise vec4 apart2 = zero;
    for (int k = 0; k < 3; k++) {
        vec4 a = corner(pack, 0, k), b = corner(pack, 1, k), c = corner(pack, 2, k);
        precise vec4 q = a + ab[k] * v + ac[k] * w;
        q = min(max(q, min(min(a, b), c)), max(max(a, b), c));
        precise vec4 apart = max(max(q - p[k], p[k] - q), zero);
        precise vec4 square = apart * apart;
        apart2 = k == 0 ? square : apart2 + square;
    }
    bvec4 counts = lessThanEqual(apart2, vec4(best.distance));
    if (facing) {
        precise vec4 x = ab[1] * ac[2] - ab[2] * ac[1];
        precise vec4 y = ab[2] * ac[0] - ab[0] * ac[2];
        precise vec4 z = ab[0] * ac[1] - ab[1] * ac[0];
        precise vec4 towards = x * way.x + y * way.y + z * way.z;
        counts = both(counts, greaterThanEqual(towards, zero));
    }
    uvec4 id = ids(pack);
    for (int lane = 0; lane < 4; lane++) {
        bool better = apart2[lane] < best.distance || (apart2[lane] == best.distance && id[lane] < best.triangle);
        if (counts[lane] && better) {
            precise float rest = 1.0 - v[lane] - w[lane];
            best = Best(id[lane], vec3(rest, v[lane], w[lane]), apart2[lane]);
        }
    }
}

Prepared prepare(vec3 begin, vec3 way, float reach, uint ask) {
    Prepared r;
    float most = max(max(push.largest, abs(begin.x)), max(abs(begin.y), abs(begin.z)));
    precise float margin = MARGIN * most;
    for (int k = 0; k < 3; k++) {
        bool backwards = (floatBitsToUint(way[k]) & 0x80000000u) != 0u;
        precise float inverse = 1.0 / way[k];
        r.inverse[k] = abs(way[k]) > SHORTEST ? inverse : backwards ? -ENDLESS : ENDLESS;
        precise float near_from = begin[k] + (backwards ? -margin : margin);
        precise float far_from = begin[k] - (backwards ? -margin : margin);
        r.near_from[k] = near_from;
        r.far_from[k] = far_from;
    }
    int z = 0;
    for (int k = 1; k < 3; k++) {
        if (abs(way[k]) > abs(way[z])) z = k;
    }
    int x = (z + 1) % 3, y = (z + 2) % 3;
    if (way[z] < 0.0) {
        int t = x; x = y; y = t;
    }
    precise vec3 shear = vec3(way[x] / way[z], way[y] / way[z], 1.0 / way[z]);
    r.begin = begin;
    r.axes = ivec3(x, y, z);
    r.shear = shear;
    r.reach = reach;
    r.ask = ask;
    return r;
}

vec4 box_enters(uint node, Prepared ray, float end) {
    precise vec4 from = vec4(0.0), to = vec4(end);
    for (int k = 0; k < 3; k++) {
        vec4 low = nodes.quads[node * NODE + uint(k)];
        vec4 high = nodes.quads[node * NODE + 3u + uint(k)];
        bool forwards = ray.inverse[k] >= 0.0;
        precise vec4 enters = ((forwards ? low : high) - ray.near_from[k]) * ray.inverse[k];
        precise vec4 leaves = ((forwards ? high : low) - ray.far_from[k]) * ray.inverse[k];
        from = max(from, enters);
        to = min(to, leaves);
    }
    return mix(vec4(INFINITE), from, lessThanEqual(from, to));
}

bool within(uint pack, int lane, Prepared ray, float t) {
    bool inside = true;
    for (int k = 0; k < 3; k++) {
        float a = corner(pack, 0, k)[lane], b = corner(pack, 1, k)[lane], c = corner(pack, 2, k)[lane];
        float low = min(min(a, b), c), high = max(max(a, b), c);
        bool forwards = ray.inverse[k] >= 0.0;
        precise float enters = ((forwards ? low : high) - ray.near_from[k]) * ray.inverse[k];
        precise float leaves = ((forwards ? high : low) - ray.far_from[k]) * ray.inverse[k];
        inside = inside && enters <= t && t <= leaves;
    }
    return inside;
}

void take_hit(uint pack, Prepared ray, inout Best best) {
    vec4 seen[3][3];
    for (int c = 0; c < 3; c++) {
        precise vec4 depth = corner(pack, c, ray.axes.z) - ray.begin[ray.axes.z];
        precise vec4 x = (corner(pack, c, ray.axes.x) - ray.begin[ray.axes.x]) - ray.shear.x * depth;
        precise vec4 y = (corner(pack, c, ray.axes.y) - ray.begin[ray.axes.y]) - ray.shear.y * depth;
        precise vec4 z = ray.shear.z * depth;
        seen[c][0] = x; seen[c][1] = y; seen[c][2] = z;
    }
    precise vec4 u = seen[2][0] * seen[1][1] - seen[2][1] * seen[1][0];
    precise vec4 v = seen[0][0] * seen[2][1] - seen[0][1] * seen[2][0];
    precise vec4 w = seen[1][0] * seen[0][1] - seen[1][1] * seen[0][0];
    precise vec4 sum = u + v + w;
    precise vec4 t = (u * seen[0][2] + v * seen[1][2] + w * seen[2][2]) / sum;
    precise vec4 b0 = u / sum, b1 = v / sum, b2 = w / sum;
    uvec4 id = ids(pack);
    for (int lane = 0; lane < 4; lane++) {
        bool front = u[lane] >= 0.0 && v[lane] >= 0.0 && w[lane] >= 0.0;
        bool back = u[lane] <= 0.0 && v[lane] <= 0.0 && w[lane] <= 0.0;
        bool inside = (front && ray.ask != ASK_RAY_BACK) || (back && ray.ask != ASK_RAY_FRONT);
        if (!inside || sum[lane] == 0.0 || !(t[lane] >= 0.0 && t[lane] <= ray.reach)) continue;
        bool better = t[lane] < best.distance || (t[lane] == best.distance && id[lane] < best.triangle);
        if (better && within(pack, lane, ray, t[lane])) {
            best = Best(id[lane], vec3(b0[lane], b1[lane], b2[lane]), t[lane]);
        }
    }
}

void main() {
    uint number = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (number >= push.count) return;
    vec4 place = questions.quads[2u * number];
    vec4 way = questions.quads[2u * number + 1u];
    uint ask = floatBitsToUint(way.w);
    bool is_ray = ask >= ASK_RAY;
    Prepared ray = prepare(place.xyz, is_ray ? way.xyz : vec3(0.0, 0.0, 1.0), place.w, ask);
    Best best = Best(NONE, vec3(1.0, 0.0, 0.0), place.w);
    float distances[DEPTH];
    uint at[DEPTH];
    int left = 0;
    bool deep = false;
    if (push.any_node != 0u) {
        distances[0] = 0.0;
        at[0] = 0u;
        left = 1;
    }
    while (left > 0) {
        left--;
        uint here = at[left];
        if (distances[left] > best.distance) continue;
        if ((here & IS_LEAF) != 0u) {
            uint pack = here & ~IS_LEAF;
            if (is_ray) take_hit(pack, ray, best);
            else take_closest(pack, place.xyz, ask == ASK_CLOSEST_FACING, way.xyz, best);
            continue;
        }
        vec4 near = is_ray ? box_enters(here, ray, best.distance) : box_distances(here, place.xyz);
        uvec4 child = floatBitsToUint(nodes.quads[here * NODE + 6u]);
        // The farthest first, so that the nearest is taken next.
        bvec4 open = both(lessThanEqual(near, vec4(best.distance)), lessThan(near, vec4(INFINITE)));
        for (int round = 0; round < 4; round++) {
            int farthest = -1;
            for (int lane = 0; lane < 4; lane++) {
                if (open[lane] && (farthest < 0 || near[lane] > near[farthest])) farthest = lane;
            }
            if (farthest < 0) break;
            open[farthest] = false;
            if (left < DEPTH) {
                distances[left] = near[farthest];
                at[left] = child[farthest];
                left++;
            } else {
                deep = true;
            }
        }
    }
    answers.quads[2u * number] = uvec4(best.triangle, floatBitsToUint(best.b));
    answers.quads[2u * number + 1u] = uvec4(floatBitsToUint(best.distance), uint(deep), 0u, 0u);
}
