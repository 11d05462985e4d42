// Lit shading. Twin of src/render/light.rs.
#ifndef RENDER_LIGHT
#define RENDER_LIGHT
#include "common/surface.glsl"
#include "render/draw.glsl"

// Light that `surface` sends towards the eye; `toward` is the unit direction to the light.
vec3 lit(IgtSurface surface, vec3 eye, vec3 toward, float intensity, float ambient) {
    vec3 n = surface.normal;
    float nl = max(igt_dot3(n, toward), 0.0);
    float nv = max(igt_dot3(n, eye), 0.001);
    precise vec3 between = toward + eye;
    vec3 h = igt_unit3(between, n);
    float nh = max(igt_dot3(n, h), 0.0);
    float vh = max(igt_dot3(eye, h), 0.0);
    precise float rough = surface.roughness * surface.roughness;
    float alpha = max(rough, 0.002);
    precise float a2 = alpha * alpha;
    precise float d = (nh * nh) * (a2 - 1.0) + 1.0;
    precise float smith_v = nl * sqrt((nv * nv) * (1.0 - a2) + a2);
    precise float smith_l = nv * sqrt((nl * nl) * (1.0 - a2) + a2);
    precise float smith = smith_v + smith_l;
    precise float specular = (a2 / (d * d)) * (0.5 / max(smith, 1e-6));
    precise float away = 1.0 - vh;
    float p = max(away, 0.0);
    precise float p5 = (p * p) * (p * p) * p;
    precise float matte = 1.0 - surface.metallic;
    precise float radiance = nl * intensity;
    precise float around = ambient * surface.occlusion;
    vec3 base = surface.base.xyz;
    precise vec3 f0 = vec3(0.04 * matte) + base * surface.metallic;
    precise vec3 fresnel = f0 + (vec3(1.0) - f0) * p5;
    precise vec3 direct = (base * matte * (vec3(1.0) - fresnel) + specular * fresnel) * radiance;
    precise vec3 indirect = (base * matte + f0) * around;
    precise vec3 r = direct + indirect + surface.emissive;
    return r;
}

vec3 towards_eye(vec4 eye, vec3 position) {
    if (eye.w == 0.0) {
        return eye.xyz;
    }
    precise vec3 d = eye.xyz + position * -1.0;
    return igt_unit3(d, vec3(0.0, 0.0, 1.0));
}

// A drawn point that the tables know no reference point for: mid grey.
IgtSurface unknown_surface() {
    IgtSurface s;
    s.base = vec4(0.2, 0.2, 0.2, 1.0);
    s.normal = vec3(0.0, 0.0, 1.0);
    s.emissive = vec3(0.0);
    s.metallic = 0.0;
    s.roughness = 1.0;
    s.occlusion = 1.0;
    s.bump = vec3(0.5, 0.5, 1.0);
    s.masked = false;
    s.unlit = true;
    return s;
}

// Light leaving the surface towards the eye, linear; base colour where the view or the material is not lit.
vec3 radiance(IgtSurface surface, vec3 position) {
    if ((view.flags & 3u) != 0u || surface.unlit) {
        return surface.base.xyz;
    }
    precise float intensity = sqrt(igt_dot3(view.light.xyz, view.light.xyz));
    vec3 toward = igt_unit3(view.light.xyz, vec3(0.0, 1.0, 0.0));
    return lit(surface, towards_eye(view.eye, position), toward, intensity, view.light.w);
}

#endif
