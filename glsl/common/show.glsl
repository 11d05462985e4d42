// An attribute in place of base colour. Twin of src/attribute/show.rs. The includer includes surface.glsl first, and
// defines uint igt_texture_word(uint i), a word of the texture records. Where IGT_PROCEDURAL is defined it also has
//   vec3 igt_procedural(vec3 position, vec3 normal, float time)
// behind everything: a point of the reference at rest, in the unit of the file, and its unit normal; seconds. Linear RGB.
// It may define IGT_KNOWN_SOLID, whether a solid texture, a 3-D image or a function is shown, as a constant of the pipeline.
#ifndef IGT_SHOW
#define IGT_SHOW
#ifndef IGT_KNOWN_SOLID
#define IGT_KNOWN_SOLID true
#endif
#include "common/solid.glsl"

const uint IGT_SHOWN_AT = 15u;
const uint IGT_FACTORS_AT = 56u;
const uint IGT_FACTOR_WORDS = 2u;
const uint IGT_KEEP = 0x100u;
const uint IGT_FLAT = 0x800u;
const uint IGT_STILL = 0x100u;

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
const uint IGT_SOLID_TEXTURE = 11u;
const uint IGT_VOLUME = 12u;
const uint IGT_FUNCTION = 13u;

#ifdef IGT_PROCEDURAL
vec3 igt_procedural(vec3 position, vec3 normal, float time);
#endif

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

// The place that three vertices' numbers from `word` on say, by the last two barycentrics alone.
vec3 igt_place(uvec4 corner, uint word, vec3 b) {
    precise vec3 r;
    for (uint i = 0u; i < 3u; i++) {
        float p = igt_attribute_float(corner.x + word + i);
        float q = igt_attribute_float(corner.y + word + i);
        float s = igt_attribute_float(corner.z + word + i);
        precise float along = p + (b.y * (q - p) + b.z * (s - p));
        if (i == 0u) r.x = along;
        if (i == 1u) r.y = along;
        if (i == 2u) r.z = along;
    }
    return r;
}

ivec3 igt_wrapped(ivec3 i, ivec3 n) {
    return i + n * (ivec3(lessThan(i, ivec3(0))) - ivec3(greaterThanEqual(i, n)));
}

// A 3-D image at p units, interpolated between its eight nearest texels. Twin of AttributeSet::volume.
vec3 igt_volume(uint word, vec3 p) {
    uint id = word & 0x3fffu;
    int columns = int(word >> 14 & 255u) + 1;
    int depth = int(word >> 22) + 1;
    ivec2 sheet = ivec2(igt_texture_word(id * IGT_TEXTURE_WORDS + 1u), igt_texture_word(id * IGT_TEXTURE_WORDS + 2u));
    ivec3 size = ivec3(sheet.x / columns, sheet.y / ((depth + columns - 1) / columns), depth);
    ivec3 along = ((igt_solid_steps(p) + ivec3(1 << 19)) & ivec3((1 << 20) - 1)) * size - ivec3(1 << 19);
    ivec3 texel = along >> 20;
    precise vec3 f = vec3((along >> 4) & ivec3(0xffff)) / 65536.0;
    vec3 here = vec3(0.0), before_x = vec3(0.0), before_y = vec3(0.0), before_z = vec3(0.0);
    for (int k = 0; k < 8; k++) {
        ivec3 at = igt_wrapped(texel + ivec3(k & 1, (k >> 1) & 1, k >> 2), size);
        ivec2 place = ivec2(at.z % columns, at.z / columns) * size.xy + ivec2(at.x, size.y - 1 - at.y);
        precise vec2 uv = (vec2(place) + vec2(0.5)) / vec2(sheet);
        here = igt_sample(id, IgtUvGradient(uv, vec2(0.0), vec2(0.0))).xyz;
        if ((k & 1) == 0) {
            before_x = here;
            continue;
        }
        here = igt_between3(before_x, here, f.x);
        if ((k & 2) == 0) {
            before_y = here;
            continue;
        }
        here = igt_between3(before_y, here, f.y);
        if (k == 3) before_z = here;
    }
    return igt_between3(before_z, here, f.z);
}

// A factor that is evaluated at a place of the reference at rest.
vec3 igt_solid_factor(uvec2 factor, uvec4 corner, vec3 b, float time) {
    uint at = factor.x >> 16;
    vec3 place = igt_place(corner, at, b);
    switch (factor.x & 0xffu) {
        case IGT_SOLID_TEXTURE: return igt_solid(factor.y & 0xffu, place, (factor.y & IGT_STILL) != 0u ? 0.0 : time);
        case IGT_VOLUME: return igt_volume(factor.y, place);
#ifdef IGT_PROCEDURAL
        case IGT_FUNCTION: return igt_procedural(place, igt_unit3(igt_weighted3(corner, at + 3u, b), vec3(0.0, 0.0, 1.0)), time);
#endif
        default: return vec3(0.0);
    }
}

vec3 igt_factor(uvec2 factor, uvec4 corner, IgtSurface s, vec3 b, uint triangle, float time) {
    uint word = factor.x, at = word >> 16;
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
        case IGT_PART: return igt_id_color(uint(int(igt_attribute_float(corner.x + at))));
        default: return IGT_KNOWN_SOLID ? igt_solid_factor(factor, corner, b, time) : vec3(0.0);
    }
}

// Puts the attribute that is shown, if any, in place of the base colour at p; `triangle` is its number in its own mesh, and
// s.normal the one that is lit.
void igt_show(inout IgtSurface s, IgtSurfacePoint p, uint triangle, float time) {
    uvec4 corner = igt_attribute_triangle(p.triangle);
    uint m = corner.w * IGT_MATERIAL_WORDS;
    uint shown = igt_material_word(m + IGT_SHOWN_AT);
    if (shown == 0u) {
        return;
    }
    precise vec3 product = vec3(1.0);
    for (uint k = 0u; k < (shown & 0xffu); k++) {
        uint at = m + IGT_FACTORS_AT + k * IGT_FACTOR_WORDS;
        uvec2 factor = uvec2(igt_material_word(at), igt_material_word(at + 1u));
        product = product * igt_factor(factor, corner, s, p.b, triangle, time);
    }
    s.base.xyz = product;
    if ((shown & IGT_KEEP) == 0u) {
        s.metallic = 0.0;
        s.emissive = vec3(0.0);
    }
}

#endif
