// Which pixels a triangle covers, at what depth, and where inside it a pixel lies. Twin of src/render/cover.rs, where
// the mathematics is told.
#ifndef RENDER_COVER
#define RENDER_COVER
#include "render/draw.glsl"

struct Edges {
    vec3 value;
    vec3 weight;
    vec2 step0;
    vec2 step1;
    vec2 step2;
};

struct Relative {
    ivec2 i;
    vec2 f;
    bool near;
};

Relative relative(Projected v, int px, int py) {
    Relative r;
    if (v.ordinary != 0u) {
        r.i = ivec2(v.x - (px * 16 + 8), v.y - (py * 16 + 8));
        r.f = vec2(float(r.i.x), float(r.i.y));
        r.near = abs(r.i.x) < 32768 && abs(r.i.y) < 32768;
    } else {
        precise float x = (v.hx - (float(px) + 0.5) * v.w) * 16.0;
        precise float y = (v.hy - (float(py) + 0.5) * v.w) * 16.0;
        r.i = ivec2(0);
        r.f = vec2(x, y);
        r.near = false;
    }
    return r;
}

vec2 homogeneous(Relative at, Projected v) {
    precise vec2 r = v.ordinary != 0u ? at.f * v.w : at.f;
    return r;
}

// Value and weight of the edge from a to b, opposite to a corner with `inverse_w`; its direction in zw.
vec4 edge(Relative a, Relative b, Projected va, Projected vb, float inverse_w, bool all_ordinary) {
    precise float value;
    precise float weight;
    precise vec2 direction;
    if (va.ordinary != 0u && vb.ordinary != 0u) {
        if (a.near && b.near) {
            value = float(a.i.x * b.i.y - b.i.x * a.i.y);
        } else {
            value = a.f.x * b.f.y - b.f.x * a.f.y;
        }
        direction = b.f - a.f;
        if (all_ordinary) {
            weight = value * inverse_w;
        } else {
            weight = value * va.w * vb.w;
        }
    } else {
        precise vec2 ha = homogeneous(a, va);
        precise vec2 hb = homogeneous(b, vb);
        value = ha.x * hb.y - hb.x * ha.y;
        direction = hb - ha;
        weight = value;
    }
    return vec4(value, weight, direction);
}

Edges edges_at(Projected v0, Projected v1, Projected v2, int px, int py) {
    Relative a0 = relative(v0, px, py);
    Relative a1 = relative(v1, px, py);
    Relative a2 = relative(v2, px, py);
    bool all_ordinary = v0.ordinary != 0u && v1.ordinary != 0u && v2.ordinary != 0u;
    vec4 e0 = edge(a1, a2, v1, v2, v0.inverse_w, all_ordinary);
    vec4 e1 = edge(a2, a0, v2, v0, v1.inverse_w, all_ordinary);
    vec4 e2 = edge(a0, a1, v0, v1, v2.inverse_w, all_ordinary);
    Edges r;
    r.value = vec3(e0.x, e1.x, e2.x);
    r.weight = vec3(e0.y, e1.y, e2.y);
    r.step0 = e0.zw;
    r.step1 = e1.zw;
    r.step2 = e2.zw;
    return r;
}

bool owned(vec2 direction, float sense) {
    precise float x = direction.x * sense;
    precise float y = direction.y * sense;
    return y < 0.0 || (y == 0.0 && x > 0.0);
}

// +1 or -1 where the triangle covers the pixel, 0 where it does not.
int covers(Edges e) {
    vec3 v = e.value;
    if (v.x >= 0.0 && v.y >= 0.0 && v.z >= 0.0 && (v.x > 0.0 || v.y > 0.0 || v.z > 0.0)) {
        return (v.x > 0.0 || owned(e.step0, 1.0)) && (v.y > 0.0 || owned(e.step1, 1.0)) && (v.z > 0.0 || owned(e.step2, 1.0)) ? 1 : 0;
    }
    if (v.x <= 0.0 && v.y <= 0.0 && v.z <= 0.0 && (v.x < 0.0 || v.y < 0.0 || v.z < 0.0)) {
        return (v.x < 0.0 || owned(e.step0, -1.0)) && (v.y < 0.0 || owned(e.step1, -1.0)) && (v.z < 0.0 || owned(e.step2, -1.0)) ? -1 : 0;
    }
    return 0;
}

// Barycentrics in the triangle's plane; false where the plane is behind the eye.
bool barycentric_of(Edges e, int sense, out vec3 b) {
    precise float sum = e.weight.x + e.weight.y + e.weight.z;
    precise float seen = sum * float(sense);
    precise float size = abs(e.weight.x) + abs(e.weight.y) + abs(e.weight.z);
    precise float most = seen * 1e6;
    if (seen > 1e-30 && size < most) {
        precise vec3 r = vec3(e.weight.x / sum, e.weight.y / sum, e.weight.z / sum);
        b = r;
        return true;
    }
    b = vec3(0.0);
    return false;
}

// Depth at barycentrics b after a step back in world units; -1 outside 0..1 and behind the eye.
float depth_at(Projected v0, Projected v1, Projected v2, vec3 b, float back) {
    precise float z = b.x * v0.z + b.y * v1.z + b.z * v2.z + back * view.away_z;
    precise float w = b.x * v0.w + b.y * v1.w + b.z * v2.w + back * view.away_w;
    if (w > 1e-20) {
        precise float depth = z / w;
        if (depth >= 0.0 && depth < 1.0) {
            return depth;
        }
    }
    return -1.0;
}

// First and last column and row the triangle may cover, inside the image; false if it cannot be seen.
bool bounds_of(Projected v0, Projected v1, Projected v2, out ivec4 box) {
    int right = int(view.width) - 1;
    int bottom = int(view.height) - 1;
    float w = float(int(view.width));
    float h = float(int(view.height));
    box = ivec4(0, right, 0, bottom);
    if (v0.z < 0.0 && v1.z < 0.0 && v2.z < 0.0) return false;
    if (v0.z > v0.w && v1.z > v1.w && v2.z > v2.w) return false;
    if (v0.ordinary != 0u && v1.ordinary != 0u && v2.ordinary != 0u) {
        box.x = max((min(min(v0.x, v1.x), v2.x) + 7) >> 4, 0);
        box.y = min((max(max(v0.x, v1.x), v2.x) - 8) >> 4, right);
        box.z = max((min(min(v0.y, v1.y), v2.y) + 7) >> 4, 0);
        box.w = min((max(max(v0.y, v1.y), v2.y) - 8) >> 4, bottom);
        return box.x <= box.y && box.z <= box.w;
    }
    precise vec3 across = vec3(w * v0.w, w * v1.w, w * v2.w);
    precise vec3 down = vec3(h * v0.w, h * v1.w, h * v2.w);
    if (v0.hx < 0.0 && v1.hx < 0.0 && v2.hx < 0.0) return false;
    if (v0.hx > across.x && v1.hx > across.y && v2.hx > across.z) return false;
    if (v0.hy < 0.0 && v1.hy < 0.0 && v2.hy < 0.0) return false;
    if (v0.hy > down.x && v1.hy > down.y && v2.hy > down.z) return false;
    return true;
}

#endif
