// An attribute in place of base colour. Twin of src/attribute/show.rs. The includer includes surface.glsl first.
#ifndef IGT_SHOW
#define IGT_SHOW

const uint IGT_SHOWN_AT = 15u;
const uint IGT_FACTORS_AT = 56u;
const uint IGT_FACTOR_WORDS = 2u;
const uint IGT_KEEP = 0x100u;
const uint IGT_FLAT = 0x800u;

const uint IGT_BASE_COLOR = 1u;
const uint IGT_NORMAL_MAP = 2u;
const uint IGT_METALLIC_ROUGHNESS = 3u;
const uint IGT_EMISSIVE = 4u;
const uint IGT_OCCLUSION_MAP = 5u;
const uint IGT_NORMAL = 6u;
const uint IGT_VERTEX = 7u;
const uint IGT_TRIANGLE_COLOR = 8u;
const uint IGT_MATERIAL = 9u;
const uint IGT_PART = 10u;

// A colour for a number, linear: hues a golden section apart, so that neighbours differ, in four shades.
vec3 igt_id_color(uint id) {
    precise float hue = float(int((id * 0x9e3779b9u) >> 16)) * (6.0 / 65536.0);
    precise float light = 0.9 - 0.17 * float(int((id * 0x85ebca6bu) >> 30));
    precise vec3 ramp = vec3(abs(hue - 3.0) - 1.0, 2.0 - abs(hue - 2.0), 2.0 - abs(hue - 4.0));
    precise vec3 r = (vec3(0.12) + 0.88 * min(max(ramp, vec3(0.0)), vec3(1.0))) * light;
    return r;
}

// The numbers of a triangle's vertices at b, or those of the first; one in grey, two with 0 for blue.
vec3 igt_vertex_factor(uint word, uvec4 corner, vec3 b) {
    uint at = word >> 16;
    uint width = word >> 8 & 7u;
    vec3 r = vec3(0.0);
    for (uint k = 0u; k < min(width, 3u); k++) {
        float number = (word & IGT_FLAT) != 0u ? igt_attribute_float(corner.x + at + k) : igt_weighted(corner, at + k, b);
        if (k == 0u) r.x = number;
        if (k == 1u) r.y = number;
        if (k == 2u) r.z = number;
    }
    return width == 1u ? r.xxx : r;
}

vec3 igt_factor(uint word, uvec4 corner, IgtSurface s, vec3 b, uint triangle) {
    switch (word & 0xffu) {
        case IGT_BASE_COLOR: return s.base.xyz;
        case IGT_NORMAL_MAP: return s.bump;
        case IGT_METALLIC_ROUGHNESS: return vec3(0.0, s.roughness, s.metallic);
        case IGT_EMISSIVE: return s.emissive;
        case IGT_OCCLUSION_MAP: return vec3(s.occlusion);
        case IGT_NORMAL: {
            precise vec3 n = s.normal * 0.5 + vec3(0.5);
            return n;
        }
        case IGT_VERTEX: return igt_vertex_factor(word, corner, b);
        case IGT_TRIANGLE_COLOR: return igt_id_color(triangle);
        case IGT_MATERIAL: return igt_id_color(corner.w);
        case IGT_PART: return igt_id_color(uint(int(igt_attribute_float(corner.x + (word >> 16)))));
        default: return vec3(0.0);
    }
}

// Puts the attribute that is shown, if any, in place of the base colour at p; `triangle` is its number in its own mesh, and
// s.normal the one that is lit.
void igt_show(inout IgtSurface s, IgtSurfacePoint p, uint triangle) {
    uvec4 corner = igt_attribute_triangle(p.triangle);
    uint m = corner.w * IGT_MATERIAL_WORDS;
    uint shown = igt_material_word(m + IGT_SHOWN_AT);
    if (shown == 0u) {
        return;
    }
    precise vec3 product = vec3(1.0);
    for (uint k = 0u; k < (shown & 0xffu); k++) {
        uint word = igt_material_word(m + IGT_FACTORS_AT + k * IGT_FACTOR_WORDS);
        product = product * igt_factor(word, corner, s, p.b, triangle);
    }
    s.base.xyz = product;
    if ((shown & IGT_KEEP) == 0u) {
        s.metallic = 0.0;
        s.emissive = vec3(0.0);
    }
}

#endif
