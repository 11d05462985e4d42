// How many points of the reference a pixel gathers. Twin of src/render/filter.rs, which explains it. The includer defines
//   Correspondence sample_at(uint draw, vec2 at)                                   at a place of the pixel, its middle at 0
//   bool sample_within(uint draw, vec2 at, Correspondence centre, out vec3 b)      in the triangle of the middle?
//   bool sample_moves()                                                            whether the pixel has other places
#ifndef RENDER_FILTER
#define RENDER_FILTER
#include "common/show.glsl"
#include "render/beforehand.glsl"

const uint FILTER_NEAREST = 0u;
const uint FILTER_FIVE = 1u;
const uint FILTER_FOOTPRINT = 2u;
// 1 / sqrt(48) and three times that.
const float PLACE_NEAR = 0.14433757;
const float PLACE_FAR = 0.4330127;
const float SHARE = 0.45;
const uint FOOTPRINT_TAPS = 4u;

vec2 place(uint k) {
    vec2 at = (k & 1u) == 1u ? vec2(PLACE_NEAR, PLACE_FAR) : vec2(PLACE_FAR, -PLACE_NEAR);
    return k > 2u ? -at : at;
}

struct Gathered {
    Correspondence centre;
    IgtSurface surface;
    uint fetches;
};

// What the material says at a point, the normal on the side that is seen, and what is shown in place of it.
IgtSurface surface_seen(uint draw, IgtSurfacePoint p, Frame frame, float turned) {
    IgtSurface s = igt_surface(p, frame.world, frame.normal);
    if (turned > 0.0) {
        s.normal = -s.normal;
    }
    if (known_shown) {
        igt_show(s, p, p.triangle - draws.records[draw].attribute_base, view.time);
    }
    return s;
}

void add_surface(inout IgtSurface sum, IgtSurface s) {
    precise vec4 base = sum.base + s.base;
    precise vec3 normal = sum.normal + s.normal;
    precise vec3 emissive = sum.emissive + s.emissive;
    precise vec3 bump = sum.bump + s.bump;
    precise float metallic = sum.metallic + s.metallic;
    precise float roughness = sum.roughness + s.roughness;
    precise float occlusion = sum.occlusion + s.occlusion;
    sum.base = base;
    sum.normal = normal;
    sum.emissive = emissive;
    sum.bump = bump;
    sum.metallic = metallic;
    sum.roughness = roughness;
    sum.occlusion = occlusion;
}

IgtSurface mean_surface(IgtSurface sum, IgtSurface centre, uint count) {
    float n = float(int(count));
    IgtSurface r = centre;
    precise vec4 base = sum.base / n;
    precise vec3 emissive = sum.emissive / n;
    precise vec3 bump = sum.bump / n;
    precise float metallic = sum.metallic / n;
    precise float roughness = sum.roughness / n;
    precise float occlusion = sum.occlusion / n;
    r.base = base;
    r.normal = igt_unit3(sum.normal, centre.normal);
    r.emissive = emissive;
    r.bump = bump;
    r.metallic = metallic;
    r.roughness = roughness;
    r.occlusion = occlusion;
    r.masked = false;
    return r;
}

// One of five points, with its share of the gradients.
void take_share(inout IgtSurfacePoint p) {
    precise vec3 dx = p.dx * SHARE;
    precise vec3 dy = p.dy * SHARE;
    p.dx = dx;
    p.dy = dy;
    if (known_filter == FILTER_FOOTPRINT) p.taps = FOOTPRINT_TAPS;
}

Gathered gather(uint draw, Frame frame, float turned) {
    Gathered g;
    g.surface = unknown_surface();
    g.centre = nowhere();
    Beforehand before;
    before.share = 0.0;
    before.fetches = 0u;
    if (known_prefiltered) before = beforehand_at(draw, frame, turned);
    bool enough = before.share >= 1.0;
    g.fetches = before.fetches;
    bool many = known_filter != FILTER_NEAREST && draws.records[draw].correspondence != 0u && sample_moves();
    IgtSurface sum = IgtSurface(vec4(0.0), vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0, vec3(0.0), false, false);
    Correspondence seen[5];
    uint count = 0u, shown = 0u, masked = 0u;
    // One copy of the lookup and of the surface for all places.
    for (uint k = 0u; k < (enough ? 0u : many ? 5u : 1u); k++) {
        vec2 at = k == 0u ? vec2(0.0) : place(k);
        Correspondence found;
        bool again = false;
        for (uint i = 0u; i < count; i++) {
            vec3 b;
            if (!again && sample_within(draw, at, seen[i], b)) {
                again = true;
                found = seen[i];
                found.point.b = b;
                found.fetches = 0u;
            }
        }
        if (!again) found = sample_at(draw, at);
        g.fetches += found.fetches;
        if (k == 0u) {
            g.centre = found;
            many = many && found.known;
        }
        if (!found.known) continue;
        seen[count++] = found;
        if (many) take_share(found.point);
        IgtSurface s = surface_seen(draw, found.point, frame, turned);
        if (k == 0u) g.surface = s;
        masked += uint(s.masked);
        shown += uint(!s.masked);
        if (!s.masked) add_surface(sum, s);
    }
    if (many && !enough) {
        bool gone = masked > shown;
        if (!gone) g.surface = mean_surface(sum, g.surface, shown);
        g.surface.masked = gone;
    }
    if (known_prefiltered) {
        if (enough) {
            g.surface = before.surface;
        } else if (before.share > 0.0 && g.centre.known) {
            g.surface = blend_surface(g.surface, before);
        }
    }
    return g;
}

#endif
