// Solid textures: colours of space itself. Twin of src/attribute/solid.rs, where the reasons are.
// Coordinates are integers: 2^20 steps to a unit. Time is in seconds, in steps of 2^-16.
#ifndef IGT_SOLID
#define IGT_SOLID
#include "common/arithmetic.glsl"
#include "common/igt_int.glsl"

const int IGT_UNIT_BITS = 20;
const int IGT_PERIOD = 1 << 18;

// A colour for a number, linear: hues a golden section apart, so that neighbours differ, in four shades.
vec3 igt_id_color(uint id) {
    precise float hue = float(int((id * 0x9e3779b9u) >> 16)) * (6.0 / 65536.0);
    precise float light = 0.9 - 0.17 * float(int((id * 0x85ebca6bu) >> 30));
    precise vec3 ramp = vec3(abs(hue - 3.0) - 1.0, 2.0 - abs(hue - 2.0), 2.0 - abs(hue - 4.0));
    precise vec3 r = (vec3(0.12) + 0.88 * min(max(ramp, vec3(0.0)), vec3(1.0))) * light;
    return r;
}

// Steps of a point given in units.
ivec3 igt_solid_steps(vec3 p) {
    precise vec3 r = floor(min(max(p, vec3(-2000.0)), vec3(2000.0)) * 1048576.0 + vec3(0.5));
    return ivec3(r);
}

// Steps into the four seconds after which every solid begins again.
int igt_solid_phase(float time) {
    precise float r = floor(min(max(time, -16000.0), 16000.0) * 65536.0 + 0.5);
    return int(r) & (IGT_PERIOD - 1);
}

float igt_units(int steps) {
    precise float r = igt_float(steps) * (1.0 / 1048576.0);
    return r;
}

uint igt_cell_hash(ivec3 c, uint seed) {
    uint h = uint(c.x) * 0x8da6b343u + uint(c.y) * 0xd8163841u + uint(c.z) * 0xcb1ab31fu + seed * 0x9e3779b9u;
    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    return h ^ (h >> 16);
}

// How far into its cell of 2^bits steps a coordinate is, in 65536ths at most.
float igt_cell_fraction(int q, int bits) {
    int kept = min(bits, 16);
    precise float r = float((q & ((1 << bits) - 1)) >> (bits - kept)) / float(1 << kept);
    return r;
}

float igt_ease(float t) {
    precise float r = t * t * (3.0 - 2.0 * t);
    return r;
}

float igt_between(float a, float b, float t) {
    precise float r = a + t * (b - a);
    return r;
}

vec3 igt_between3(vec3 a, vec3 b, float t) {
    precise vec3 r = a + t * (b - a);
    return r;
}

// One of twelve directions, dotted with d.
float igt_slope(uint h, vec3 d) {
    uint g = h & 15u;
    float u = g < 8u ? d.x : d.y;
    float v = g < 4u ? d.y : (g == 12u || g == 14u ? d.x : d.z);
    precise float r = ((g & 1u) == 0u ? u : -u) + ((g & 2u) == 0u ? v : -v);
    return r;
}

// Gradient noise, about -1..1, with 2^octave cells to a unit.
float igt_noise(ivec3 q, int octave, uint seed) {
    int bits = IGT_UNIT_BITS - octave;
    ivec3 c = q >> bits;
    vec3 f = vec3(igt_cell_fraction(q.x, bits), igt_cell_fraction(q.y, bits), igt_cell_fraction(q.z, bits));
    vec3 t = vec3(igt_ease(f.x), igt_ease(f.y), igt_ease(f.z));
    float at_x = 0.0, at_y = 0.0, at_z = 0.0;
    float before_x = 0.0, before_y = 0.0, before_z = 0.0;
    for (int k = 0; k < 8; k++) {
        ivec3 corner = ivec3(k & 1, (k >> 1) & 1, k >> 2);
        precise vec3 d = f - vec3(corner);
        at_x = igt_slope(igt_cell_hash(c + corner, seed), d);
        if ((k & 1) == 0) {
            before_x = at_x;
            continue;
        }
        at_y = igt_between(before_x, at_x, t.x);
        if ((k & 2) == 0) {
            before_y = at_y;
            continue;
        }
        at_z = igt_between(before_y, at_y, t.y);
        if (k == 3) before_z = at_z;
    }
    return igt_between(before_z, at_z, t.z);
}

// Sizes of four octaves of noise, each half as large as the one before.
float igt_turbulence(ivec3 q, int octave, uint seed) {
    precise float sum = 0.0;
    float size = 1.0;
    for (int k = 0; k < 4; k++) {
        sum = sum + abs(igt_noise(q, octave + k, seed + uint(k))) * size;
        size = size * 0.5;
    }
    return sum;
}

float igt_fraction_of(float x) {
    precise float r = x - floor(x);
    return r;
}

vec3 igt_wood(ivec3 q, int phase) {
    precise float x = igt_units(q.x) + 0.55, z = igt_units(q.z) + 0.2;
    precise float radius = sqrt(x * x + z * z) + 0.05 * igt_noise(q, 1, 11u) + 0.008 * igt_noise(q, 4, 12u);
    precise float ring = radius * 16.0 - float(phase) / 262144.0;
    float late = igt_ease(igt_fraction_of(ring));
    precise float dark = late * late;
    precise float fibre = 1.0 + 0.22 * igt_noise(ivec3(q.x, q.y >> 4, q.z), 6, 13u);
    precise vec3 r = igt_between3(vec3(0.60, 0.34, 0.15), vec3(0.25, 0.10, 0.035), dark) * fibre;
    return r;
}

vec3 igt_marble(ivec3 q, int phase) {
    precise float along = igt_units(q.x) * 5.0 + igt_units(q.y) * 3.0 + 2.2 * igt_turbulence(q, 2, 21u) + float(phase) / 262144.0;
    precise float wave = abs(igt_fraction_of(along) - 0.5) * 2.0;
    float eased = igt_ease(wave);
    precise float vein = eased * eased * eased;
    return igt_between3(vec3(0.86, 0.84, 0.80), vec3(0.10, 0.13, 0.17), vein);
}

// Where in its cell a point of the pattern is along one axis: it goes to and fro in four seconds.
float igt_wander(uint h, int phase) {
    int at = (int(h & 1023u) * 256 + phase) & (IGT_PERIOD - 1);
    precise float wave = abs(float(at) / 262144.0 - 0.5) * 2.0;
    precise float r = 0.1 + 0.8 * wave;
    return r;
}

vec3 igt_cellular(ivec3 q, int phase) {
    int bits = IGT_UNIT_BITS - 3;
    ivec3 c = q >> bits;
    vec3 f = vec3(igt_cell_fraction(q.x, bits), igt_cell_fraction(q.y, bits), igt_cell_fraction(q.z, bits));
    float nearest = 1e9, second = 1e9;
    uint owner = 0u;
    for (int k = 0; k < 27; k++) {
        ivec3 step = ivec3(k % 3, (k / 3) % 3, k / 9) - ivec3(1);
        uint h = igt_cell_hash(c + step, 31u);
        precise vec3 d = vec3(step) + vec3(igt_wander(h, phase), igt_wander(h >> 10, phase), igt_wander(h >> 20, phase)) - f;
        float squared = igt_dot3(d, d);
        if (squared < nearest) {
            second = nearest;
            nearest = squared;
            owner = h;
        } else {
            second = min(second, squared);
        }
    }
    precise float wall = (sqrt(second) - sqrt(nearest)) * 7.0;
    float inside = igt_ease(min(wall, 1.0));
    return igt_between3(vec3(0.02, 0.02, 0.03), igt_id_color(owner), inside);
}

vec3 igt_checker3d(ivec3 q, int phase) {
    ivec3 c = ivec3(q.x, q.y - phase, q.z) >> (IGT_UNIT_BITS - 3);
    return ((c.x + c.y + c.z) & 1) == 0 ? vec3(0.8, 0.8, 0.78) : vec3(0.05, 0.05, 0.06);
}

vec3 igt_solid(uint kind, vec3 p, float time) {
    ivec3 q = igt_solid_steps(p);
    int phase = igt_solid_phase(time);
    switch (kind) {
        case 0u: return igt_wood(q, phase);
        case 1u: return igt_marble(q, phase);
        case 2u: return igt_cellular(q, phase);
        default: return igt_checker3d(q, phase);
    }
}

#endif
