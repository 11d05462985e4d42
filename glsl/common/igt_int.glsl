// Exact integers beyond 32 bits, without the int64 feature (some drivers crash on it).
// 64-bit values are uvec2 (low, high), 96-bit values uvec3, both in two's complement.
#ifndef IGT_INT_GLSL
#define IGT_INT_GLSL

uvec2 igt_mul(int a, int b) {
    int high, low;
    imulExtended(a, b, high, low);
    return uvec2(uint(low), uint(high));
}

uvec2 igt_add64(uvec2 a, uvec2 b) {
    uint low = a.x + b.x;
    return uvec2(low, a.y + b.y + uint(low < a.x));
}

uvec2 igt_sub64(uvec2 a, uvec2 b) {
    return uvec2(a.x - b.x, a.y - b.y - uint(a.x < b.x));
}

uvec2 igt_negate64(uvec2 a) {
    return igt_sub64(uvec2(0u), a);
}

uvec2 igt_size64(uvec2 a) {
    return int(a.y) < 0 ? igt_negate64(a) : a;
}

// The larger of a value and zero.
uvec2 igt_positive64(uvec2 a) {
    return int(a.y) < 0 ? uvec2(0u) : a;
}

// a b - c d
uvec2 igt_cross64(int a, int b, int c, int d) {
    return igt_sub64(igt_mul(a, b), igt_mul(c, d));
}

// The low 64 bits of a 64-bit value times a 32-bit one.
uvec2 igt_mul64(uvec2 a, int b) {
    bool negative = b < 0;
    uint m = uint(negative ? -b : b);
    uint high, low;
    umulExtended(a.x, m, high, low);
    uvec2 product = uvec2(low, high + a.y * m);
    return negative ? igt_negate64(product) : product;
}

int igt_sign64(uvec2 a) {
    return int(a.y) < 0 ? -1 : ((a.x | a.y) == 0u ? 0 : 1);
}

uvec3 igt_add96(uvec3 a, uvec3 b) {
    uint low = a.x + b.x;
    uint carry = uint(low < a.x);
    uint middle = a.y + b.y;
    uint carry2 = uint(middle < a.y);
    uint sum = middle + carry;
    carry2 += uint(sum < middle);
    return uvec3(low, sum, a.z + b.z + carry2);
}

uvec3 igt_negate96(uvec3 a) {
    return igt_add96(~a, uvec3(1u, 0u, 0u));
}

uvec3 igt_widen(uvec2 a) {
    return uvec3(a, uint(int(a.y) >> 31));
}

// A 64-bit value (not -2^63) times a 32-bit one.
uvec3 igt_mul96(uvec2 a, int b) {
    bool negative = (int(a.y) < 0) != (b < 0);
    uvec2 size = int(a.y) < 0 ? igt_negate64(a) : a;
    uint m = uint(b < 0 ? -b : b);
    uint high0, low0, high1, low1;
    umulExtended(size.x, m, high0, low0);
    umulExtended(size.y, m, high1, low1);
    uint middle = high0 + low1;
    uvec3 product = uvec3(low0, middle, high1 + uint(middle < high0));
    return negative ? igt_negate96(product) : product;
}

int igt_sign96(uvec3 a) {
    return int(a.z) < 0 ? -1 : ((a.x | a.y | a.z) == 0u ? 0 : 1);
}

uvec3 igt_abs96(uvec3 a) {
    return int(a.z) < 0 ? igt_negate96(a) : a;
}

// The number of bits of a non-negative value.
int igt_bits96(uvec3 a) {
    return a.z != 0u ? findMSB(a.z) + 65 : (a.y != 0u ? findMSB(a.y) + 33 : findMSB(a.x) + 1);
}

// The low 32 bits of a non-negative value shifted right.
uint igt_shift96(uvec3 a, int shift) {
    // Branches, not a loop: llvmpipe 22.3 leaves a loop of two rounds with a wrong value.
    if (shift >= 64) {
        a = uvec3(a.z, 0u, 0u);
        shift -= 64;
    } else if (shift >= 32) {
        a = uvec3(a.y, a.z, 0u);
        shift -= 32;
    }
    return shift == 0 ? a.x : (a.x >> shift) | (a.y << (32 - shift));
}

// float(x), rounded to nearest even on every driver (plain conversions of large integers differ by an ULP).
float igt_float(int x) {
    precise float high = float(x >> 12) * 4096.0;
    precise float sum = high + float(x & 4095);
    return sum;
}

#endif
