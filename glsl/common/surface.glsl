// What can be fetched at a point of the reference surface. Twin of src/attribute/surface.rs (records of materials:
// src/attribute/material.rs). The includer defines, besides what texture.glsl asks for:
//   uvec4 igt_attribute_triangle(uint i)   word offsets of three vertices, and the material
//   uvec4 igt_attribute_uv(uint i)         the artist's uv of a triangle's corners
//   float igt_attribute_float(uint i)      a word of the vertices
//   uint  igt_material_word(uint i)        a word of the material records
// It may define what it knows before the shader is compiled (specialization constants), so that a compiler leaves code out:
//   IGT_KNOWN_SLOTS     bits of the texture slots that some material uses
//   IGT_KNOWN_RECORDED  whether the triangles' records hold the uv of all of them
#ifndef IGT_SURFACE
#define IGT_SURFACE
#ifndef IGT_KNOWN_SLOTS
#define IGT_KNOWN_SLOTS 31u
#endif
#ifndef IGT_KNOWN_RECORDED
#define IGT_KNOWN_RECORDED false
#endif
#include "common/texture.glsl"

const uint IGT_MATERIAL_WORDS = 64u;
const uint IGT_SLOTS_AT = 16u;
const uint IGT_SLOT_WORDS = 8u;
const uint IGT_NO_TEXTURE = 0xffffffffu;
const float IGT_STEEP = 1e6;
const uint IGT_RECORD_AT = 14u;
const uint IGT_FLAGS_AT = 13u;
const uint IGT_USED_SHIFT = 8u;
const uint IGT_NO_RECORD = 0xffffffffu;

// A point of the reference and how its barycentrics change to the next pixel in x and in y, where that has a meaning.
struct IgtSurfacePoint {
    uint triangle;
    vec3 b;
    vec3 dx;
    vec3 dy;
    bool has_dx;
    bool has_dy;
    uint taps; // texture samples along the longer gradient, at most: 1 is isotropic
};

struct IgtSurface {
    vec4 base;
    vec3 normal;
    vec3 emissive;
    float metallic;
    float roughness;
    float occlusion;
    vec3 bump; // the normal map's texel
    bool masked;
    bool unlit;
};

float igt_weighted(uvec4 corner, uint word, vec3 b) {
    precise float r = b.x * igt_attribute_float(corner.x + word) + b.y * igt_attribute_float(corner.y + word) +
                      b.z * igt_attribute_float(corner.z + word);
    return r;
}

vec3 igt_weighted3(uvec4 corner, uint word, vec3 b) {
    return vec3(igt_weighted(corner, word, b), igt_weighted(corner, word + 1u, b), igt_weighted(corner, word + 2u, b));
}

float igt_material_float(uint at) {
    return uintBitsToFloat(igt_material_word(at));
}

// The artist's uv of a triangle's three corners.
struct IgtCornerUv { vec2 c0, c1, c2; };

// Twin of src/attribute/uv_record.rs: six fields of 20 bits, in steps of 2^-19 from a whole number on.
IgtCornerUv igt_uv_record(uvec4 w) {
    uvec2 f0 = uvec2(w.x, w.x >> 20 | w.y << 12) & 0xfffffu;
    uvec2 f1 = uvec2(w.y >> 8, w.y >> 28 | w.z << 4) & 0xfffffu;
    uvec2 f2 = uvec2(w.z >> 16 | w.w << 16, w.w >> 4) & 0xfffffu;
    vec2 whole = vec2(uvec2(w.w >> 24 & 15u, w.w >> 28)) - 8.0;
    precise vec2 c0 = vec2(f0) * (1.0 / 524288.0) + whole;
    precise vec2 c1 = vec2(f1) * (1.0 / 524288.0) + whole;
    precise vec2 c2 = vec2(f2) * (1.0 / 524288.0) + whole;
    return IgtCornerUv(c0, c1, c2);
}

// Uv of the corners from their vertices.
IgtCornerUv igt_vertex_uv(uvec4 corner, uint word) {
    return IgtCornerUv(vec2(igt_attribute_float(corner.x + word), igt_attribute_float(corner.x + word + 1u)),
                       vec2(igt_attribute_float(corner.y + word), igt_attribute_float(corner.y + word + 1u)),
                       vec2(igt_attribute_float(corner.z + word), igt_attribute_float(corner.z + word + 1u)));
}

vec2 igt_weighted_uv(IgtCornerUv c, vec3 b) {
    precise vec2 r = b.x * c.c0 + b.y * c.c1 + b.z * c.c2;
    return r;
}

// Uv of a texture slot and its gradients.
IgtUvGradient igt_slot_uv(uvec4 corner, uvec4 record, uint at, IgtSurfacePoint p) {
    uint word = igt_material_word(at + 1u);
    vec4 m = vec4(igt_material_float(at + 2u), igt_material_float(at + 3u), igt_material_float(at + 4u), igt_material_float(at + 5u));
    vec2 shift = vec2(igt_material_float(at + 6u), igt_material_float(at + 7u));
    IgtCornerUv corners = igt_uv_record(record);
    bool recorded = IGT_KNOWN_RECORDED ||
                    (record.w != IGT_NO_RECORD && word == igt_material_word(corner.w * IGT_MATERIAL_WORDS + IGT_RECORD_AT));
    if (!recorded) corners = igt_vertex_uv(corner, word);
    vec2 c = igt_weighted_uv(corners, p.b), cx = igt_weighted_uv(corners, p.dx), cy = igt_weighted_uv(corners, p.dy);
    precise vec2 uv = vec2(m.x * c.x + m.y * c.y + shift.x, m.z * c.x + m.w * c.y + shift.y);
    precise vec2 dx = vec2(m.x * cx.x + m.y * cx.y, m.z * cx.x + m.w * cx.y);
    precise vec2 dy = vec2(m.x * cy.x + m.y * cy.y, m.z * cy.x + m.w * cy.y);
    return IgtUvGradient(uv, p.has_dx ? dx : vec2(IGT_STEEP), p.has_dy ? dy : vec2(IGT_STEEP));
}

float igt_squared_gradient(vec2 d, vec2 size) {
    precise vec2 t = d * size;
    precise float r = t.x * t.x + t.y * t.y;
    return r;
}

// Texture `id` over a footprint that is up to `most` times as long as wide: the mean of samples along the longer gradient.
vec4 igt_sample_along(uint id, IgtUvGradient at, uint most) {
    vec2 size = vec2(ivec2(igt_texture_word(id * IGT_TEXTURE_WORDS + 1u), igt_texture_word(id * IGT_TEXTURE_WORDS + 2u)));
    float x = igt_squared_gradient(at.dx, size), y = igt_squared_gradient(at.dy, size);
    float longer = max(x, y), shorter = max(min(x, y), 1.0);
    uint count = 1u;
    for (uint k = 1u; k < most; k++) {
        precise float reached = shorter * float(int(k * k));
        if (longer > reached) count = k + 1u;
    }
    float n = float(int(count));
    precise vec2 along = (x >= y ? at.dx : at.dy) / n;
    IgtUvGradient one = at;
    if (x >= y) {
        one.dx = along;
    } else {
        one.dy = along;
    }
    vec4 sum = vec4(0.0);
    for (uint k = 0u; k < count; k++) {
        precise float t = float(int(2u * k + 1u)) * 0.5 - n * 0.5;
        precise vec2 uv = at.uv + along * t;
        one.uv = uv;
        precise vec4 added = sum + igt_sample(id, one);
        sum = added;
    }
    precise vec4 mean = sum / n;
    return mean;
}

// The texture of slot `slot`, or `missing` where there is none.
vec4 igt_slot(uvec4 corner, uvec4 record, uint slot, IgtSurfacePoint p, vec4 missing) {
    uint at = corner.w * IGT_MATERIAL_WORDS + IGT_SLOTS_AT + slot * IGT_SLOT_WORDS;
    uint id = igt_material_word(at);
    if (id == IGT_NO_TEXTURE) {
        return missing;
    }
    return igt_sample_along(id, igt_slot_uv(corner, record, at, p), p.taps);
}

// Two-level normal: the reference's interpolated one, tilted by the artist's map (`texel`) in the reference's tangent frame.
vec3 igt_two_level_normal(uvec4 corner, IgtSurfacePoint p, vec4 texel, vec4 world[3], vec4 normal[3]) {
    vec3 object = igt_weighted3(corner, 0u, p.b);
    vec3 n = igt_unit3(vec3(igt_dot3(normal[0].xyz, object), igt_dot3(normal[1].xyz, object), igt_dot3(normal[2].xyz, object)),
                       vec3(0.0, 0.0, 1.0));
    uint slot = corner.w * IGT_MATERIAL_WORDS + IGT_SLOTS_AT + 2u * IGT_SLOT_WORDS;
    if ((IGT_KNOWN_SLOTS & 4u) == 0u || igt_material_word(slot) == IGT_NO_TEXTURE) {
        return n;
    }
    object = igt_weighted3(corner, 3u, p.b);
    vec3 t = vec3(igt_dot3(world[0].xyz, object), igt_dot3(world[1].xyz, object), igt_dot3(world[2].xyz, object));
    if (!(igt_dot3(t, t) > 1e-30)) {
        return n;
    }
    float scale = igt_material_float(corner.w * IGT_MATERIAL_WORDS + 9u);
    t = igt_unit3(t, vec3(1.0, 0.0, 0.0));
    precise float side = igt_attribute_float(corner.x + 6u) * normal[0].w;
    precise vec3 bitangent = igt_cross3(n, t) * side;
    precise float x = (texel.x * 2.0 - 1.0) * scale;
    precise float y = (texel.y * 2.0 - 1.0) * scale;
    precise float z = texel.z * 2.0 - 1.0;
    precise vec3 tilted = (t * x + bitangent * y) + n * z;
    return igt_unit3(tilted, n);
}

// Everything the material says at p.
IgtSurface igt_surface(IgtSurfacePoint p, vec4 world[3], vec4 normal[3]) {
    uvec4 corner = igt_attribute_triangle(p.triangle);
    uvec4 record = igt_attribute_uv(p.triangle);
    uint m = corner.w * IGT_MATERIAL_WORDS;
    vec4 texel = vec4(1.0);
    vec4 orm = vec4(1.0);
    vec4 bump = vec4(0.5, 0.5, 1.0, 1.0);
    float occluded = 1.0;
    vec3 glow = vec3(1.0);
    // One copy of the sampling code for all slots, and only the material's own: where branches are not taken apart, a slot
    // without a texture would cost as much as one that has it.
    for (uint rest = igt_material_word(m + IGT_FLAGS_AT) >> IGT_USED_SHIFT; rest != 0u; rest &= rest - 1u) {
        uint slot = uint(findLSB(rest));
        vec4 value = igt_slot(corner, record, slot, p, vec4(1.0));
        if (slot == 0u) texel = value;
        if (slot == 1u) orm = value;
        if (slot == 2u) bump = value;
        if (slot == 3u) occluded = value.x;
        if (slot == 4u) glow = value.xyz;
    }
    vec4 color = vec4(igt_weighted3(corner, 7u, p.b), igt_weighted(corner, 10u, p.b));
    vec4 factor = vec4(igt_material_float(m), igt_material_float(m + 1u), igt_material_float(m + 2u), igt_material_float(m + 3u));
    precise vec4 base = texel * factor * color;
    precise vec3 emissive = vec3(igt_material_float(m + 4u), igt_material_float(m + 5u), igt_material_float(m + 6u)) * glow;
    precise float metallic = orm.z * igt_material_float(m + 7u);
    precise float roughness = orm.y * igt_material_float(m + 8u);
    precise float occlusion = 1.0 + igt_material_float(m + 10u) * (occluded - 1.0);
    IgtSurface s;
    s.base = base;
    s.normal = igt_two_level_normal(corner, p, bump, world, normal);
    s.emissive = emissive;
    s.metallic = metallic;
    s.roughness = roughness;
    s.occlusion = occlusion;
    s.bump = bump.xyz;
    s.masked = igt_material_word(m + 12u) == 1u && base.w < igt_material_float(m + 11u);
    s.unlit = (igt_material_word(m + IGT_FLAGS_AT) & 1u) != 0u;
    return s;
}

#endif
