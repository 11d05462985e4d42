// The shader LoD: what was filtered beforehand in place of the lookup. Twin of src/render/beforehand.rs, which explains it.
// The includer defines, besides what filter.glsl asks for:
//   uint sample_asker()                                                                     who asks
//   bool sample_queries(uint draw, out ivec3 query, out ivec3 query_x, out ivec3 query_y)   false: no footprint
#ifndef RENDER_BEFOREHAND
#define RENDER_BEFOREHAND

const uint TEXTURES_AT = 10u;
const uint SCOPE_AT = 11u;
const uint LAYER = 0xffu;
const uint LAYER_AND_SIDE = 0x3ffu;
const uint ROLE_BASE = 0u;
const uint ROLE_NORMAL = 1u;
const uint ROLE_MATTER = 2u;
const uint ROLE_EMISSIVE = 3u;

struct Beforehand {
    float share;
    uint fetches;
    IgtSurface surface;
};

float middle_of(float c) {
    precise float r = c * 0.5 + 0.5;
    return r;
}

float round_axis(vec2 p) {
    float quadrant = 3.0;
    if (p.x > 0.0 && p.y >= 0.0) {
        quadrant = 0.0;
    } else if (p.x <= 0.0 && p.y > 0.0) {
        quadrant = 1.0;
    } else if (p.x < 0.0 && p.y <= 0.0) {
        quadrant = 2.0;
    }
    vec2 a = abs(p);
    float along = quadrant == 1.0 || quadrant == 3.0 ? a.x : a.y;
    precise float sum = max(a.x + a.y, 1e-30);
    precise float within = along / sum;
    precise float r = (quadrant + within) * 0.25;
    return r;
}

float folded(float side, float other) {
    precise float r = 1.0 - abs(other);
    return middle_of(side < 0.0 ? -r : r);
}

vec2 address_of(uint line, ivec3 query) {
    vec3 p = unit_of(query);
    if (line == IGT_LINE_PARALLEL) return vec2(middle_of(p.x), middle_of(p.y));
    if (line == IGT_LINE_CYLINDER) return vec2(round_axis(p.xy), middle_of(p.z));
    precise float sum = abs(p.x) + abs(p.y) + abs(p.z);
    float length1 = max(sum, 1e-30);
    precise float a = p.x / length1;
    precise float b = p.y / length1;
    if (p.z >= 0.0) return vec2(middle_of(a), middle_of(b));
    return vec2(folded(a, b), folded(b, a));
}

vec2 half_way(uint line, vec2 here, vec2 there) {
    precise vec2 d = there - here;
    if (line == IGT_LINE_CYLINDER) {
        precise float turns = floor(d.x + 0.5);
        precise float rest = d.x - turns;
        d.x = rest;
    }
    precise vec2 r = d * 0.5;
    return r;
}

float share_of(float apart, float bound) {
    if (!(bound > 0.0)) return 0.0;
    precise float steps = apart * 31.875;
    precise float r = (2.0 * bound - steps) / bound;
    return min(max(r, 0.0), 1.0);
}

bool sees(uint asker, uint scope) {
    uint wanted = scope & LAYER_AND_SIDE;
    uint kept = wanted > LAYER ? LAYER_AND_SIDE : LAYER;
    return (asker & ~(LAYER_AND_SIDE & ~kept)) == wanted;
}

Beforehand beforehand_at(uint draw, Frame frame, float turned) {
    Beforehand r;
    r.share = 0.0;
    r.fetches = 0u;
    r.surface = unknown_surface();
    uint textures = draws.records[draw].igt[TEXTURES_AT];
    ivec3 query, query_x, query_y;
    bool has = sample_queries(draw, query, query_x, query_y);
    uint scope = draws.records[draw].igt[SCOPE_AT];
    if (textures == 0u || !has || !sees(sample_asker(), scope)) return r;
    uint first = textures - 1u;
    uint line = tables_of(draw).line;
    vec2 here = address_of(line, query);
    IgtUvGradient at = IgtUvGradient(here, half_way(line, here, address_of(line, query_x)), half_way(line, here, address_of(line, query_y)));
    vec2 size = vec2(float(int(igt_texture_word(first * IGT_TEXTURE_WORDS + 1u))));
    precise float over = max(igt_squared_gradient(at.dx, size), igt_squared_gradient(at.dy, size)) - 1.0;
    float finer = min(max(over, 0.0), 1.0);
    if (!(finer > 0.0)) return r;
    vec4 base = vec4(0.0), normal = vec4(0.0), matter = vec4(0.0), emissive = vec4(0.0);
    // One copy of the sampling code for all four.
    for (uint role = 0u; role < 4u; role++) {
        vec4 value = igt_sample(first + role, at);
        if (role == ROLE_BASE) base = value;
        if (role == ROLE_NORMAL) normal = value;
        if (role == ROLE_MATTER) matter = value;
        if (role == ROLE_EMISSIVE) emissive = value;
    }
    float apart = (view.flags & 3u) == 1u ? base.w : normal.w;
    precise float share = share_of(apart, float(int(view.flags >> 24)) * 0.25) * finer;
    precise vec3 object = normal.xyz * 2.0 - 1.0;
    vec3 n = igt_unit3(vec3(igt_dot3(frame.normal[0].xyz, object), igt_dot3(frame.normal[1].xyz, object), igt_dot3(frame.normal[2].xyz, object)),
                       vec3(0.0, 0.0, 1.0));
    r.share = share;
    r.fetches = 1u;
    r.surface = IgtSurface(vec4(base.xyz, 1.0), turned > 0.0 ? -n : n, emissive.xyz, matter.z, matter.y, matter.x,
                           vec3(0.5, 0.5, 1.0), false, scope >> 31 != 0u);
    return r;
}

IgtSurface blend_surface(IgtSurface full, Beforehand before) {
    float b = before.share;
    precise float f = 1.0 - b;
    IgtSurface s = before.surface;
    precise vec4 base = full.base * f + s.base * b;
    precise vec3 normal = full.normal * f + s.normal * b;
    precise vec3 emissive = full.emissive * f + s.emissive * b;
    precise float metallic = full.metallic * f + s.metallic * b;
    precise float roughness = full.roughness * f + s.roughness * b;
    precise float occlusion = full.occlusion * f + s.occlusion * b;
    IgtSurface r = full;
    r.base = base;
    r.normal = igt_unit3(normal, s.normal);
    r.emissive = emissive;
    r.metallic = metallic;
    r.roughness = roughness;
    r.occlusion = occlusion;
    return r;
}

#endif
