// Float arithmetic whose every bit is ours: the twin of src/attribute/arithmetic.rs, where the reasons are.
// Everything is `precise` and built of + - * / sqrt floor and conversions between int and float.
#ifndef IGT_ARITHMETIC
#define IGT_ARITHMETIC

float igt_dot3(vec3 a, vec3 b) {
    precise float r = a.x * b.x + a.y * b.y + a.z * b.z;
    return r;
}

vec3 igt_cross3(vec3 a, vec3 b) {
    precise vec3 r = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return r;
}

// v at unit length, or `fallback` where it has none.
vec3 igt_unit3(vec3 v, vec3 fallback) {
    precise float squared = igt_dot3(v, v);
    if (squared > 1e-30) {
        precise float l = sqrt(squared);
        precise vec3 r = vec3(v.x / l, v.y / l, v.z / l);
        return r;
    }
    return fallback;
}

// log2 of a positive, normal, finite x; error below 2e-7 plus the rounding of the sum.
float igt_log2(float x) {
    int bits = floatBitsToInt(x);
    int exponent = (bits >> 23) - 127;
    precise float mantissa = intBitsToFloat((bits & 0x007fffff) | 0x3f800000);
    if (mantissa > 1.4142135) {
        mantissa = mantissa * 0.5;
        exponent += 1;
    }
    precise float t = (mantissa - 1.0) / (mantissa + 1.0);
    precise float s = t * t;
    precise float series = 1.0 + s * (0.33333334 + s * (0.2 + s * 0.14285715));
    precise float r = float(exponent) + (t * series) * 2.88539;
    return r;
}

// The 8-bit code of a value in [0, 1] that is coded already.
uint igt_unit_encode(float value) {
    precise float r = floor(min(max(value, 0.0), 1.0) * 255.0 + 0.5);
    return uint(int(r));
}

#endif
