// Exact texture filtering: the twin of src/attribute/sample.rs (records: src/attribute/texture.rs).
// The includer defines before the include:
//   uint  igt_texture_word(uint i)     a word of the texture records
//   uint  igt_texel_word(uint address) a texel, R in the low byte
//   float igt_srgb_decoded(uint code)  linear light of an 8-bit sRGB code
// or IGT_SAMPLE_ELSEWHERE, and then its own vec4 igt_sample(uint id, IgtUvGradient at) after it.
#ifndef IGT_TEXTURE
#define IGT_TEXTURE
#include "common/arithmetic.glsl"

const uint IGT_TEXTURE_WORDS = 24u;
const uint IGT_LEVELS_AT = 8u;
const uint IGT_FLAG_SRGB = 1u;
const uint IGT_FLAG_NEAREST = 2u;
const uint IGT_FLAG_NO_MIPS = 4u;

// Uv and its change to the next pixel in x and in y.
struct IgtUvGradient {
    vec2 uv;
    vec2 dx;
    vec2 dy;
};

#ifndef IGT_SAMPLE_ELSEWHERE

vec4 igt_blend(vec4 a, vec4 b, float f) {
    precise float g = 1.0 - f;
    precise vec4 r = a * g + b * f;
    return r;
}

float igt_wrap_coordinate(float u, uint mode) {
    precise float r;
    if (mode == 0u) {
        r = u - floor(u);
    } else if (mode == 1u) {
        r = u - 2.0 * floor(u * 0.5);
    } else {
        r = min(max(u, -1.0), 2.0);
    }
    return r;
}

int igt_wrap_index(int i, int n, uint mode) {
    if (mode == 0u) {
        if (i < 0) i += n;
        if (i >= n) i -= n;
    } else if (mode == 1u) {
        if (i < 0) i = -1 - i;
        if (i >= 2 * n) i -= 2 * n;
        if (i >= n) i = 2 * n - 1 - i;
    }
    return min(max(i, 0), n - 1);
}

vec4 igt_unpack(uint word, uint flags) {
    uint r = word & 0xffu;
    uint g = (word >> 8) & 0xffu;
    uint b = (word >> 16) & 0xffu;
    precise vec4 c = vec4(float(int(r)), float(int(g)), float(int(b)), float(int(word >> 24))) / 255.0;
    if ((flags & IGT_FLAG_SRGB) != 0u) {
        return vec4(igt_srgb_decoded(r), igt_srgb_decoded(g), igt_srgb_decoded(b), c.w);
    }
    return c;
}

vec4 igt_texel(uint base, int x, int y, int w, int h, uint wraps, uint flags) {
    int i = igt_wrap_index(x, w, wraps & 3u);
    int j = igt_wrap_index(y, h, (wraps >> 2) & 3u);
    return igt_unpack(igt_texel_word(uint(int(base) + j * w + i)), flags);
}

// One level of a texture, bilinear or nearest. Loops keep one copy of the fetch in the program; drivers that compile it
// to machine code take seconds for each.
vec4 igt_sample_level(uint record, int level, vec2 uv) {
    int w = int(max(igt_texture_word(record + 1u) >> uint(level), 1u));
    int h = int(max(igt_texture_word(record + 2u) >> uint(level), 1u));
    uint wraps = igt_texture_word(record + 4u);
    uint flags = igt_texture_word(record + 5u);
    uint base = igt_texture_word(record) + igt_texture_word(record + IGT_LEVELS_AT + uint(level));
    precise float x = igt_wrap_coordinate(uv.x, wraps & 3u) * float(w);
    precise float y = igt_wrap_coordinate(uv.y, (wraps >> 2) & 3u) * float(h);
    bool nearest = (flags & IGT_FLAG_NEAREST) != 0u;
    if (!nearest) {
        x = x - 0.5;
        y = y - 0.5;
    }
    precise float fx = x - floor(x);
    precise float fy = y - floor(y);
    int x0 = int(floor(x));
    int y0 = int(floor(y));
    vec4 left = vec4(0.0);
    vec4 upper = vec4(0.0);
    vec4 value = vec4(0.0);
    for (int k = 0; k < 4; k++) {
        value = igt_texel(base, x0 + (k & 1), y0 + (k >> 1), w, h, wraps, flags);
        if (nearest) {
            return value;
        }
        if ((k & 1) == 0) {
            left = value;
        } else {
            value = igt_blend(left, value, fx);
            if (k == 1) {
                upper = value;
            }
        }
    }
    return igt_blend(upper, value, fy);
}

float igt_squared_texels(vec2 d, float w, float h) {
    precise float x = d.x * w;
    precise float y = d.y * h;
    precise float r = x * x + y * y;
    return r;
}

// log2 of the longer gradient in texels of level 0.
float igt_level_of(uint record, IgtUvGradient at) {
    float w = float(int(igt_texture_word(record + 1u)));
    float h = float(int(igt_texture_word(record + 2u)));
    float longer = max(igt_squared_texels(at.dx, w, h), igt_squared_texels(at.dy, w, h));
    precise float r = 0.5 * igt_log2(min(max(longer, 1e-20), 1e20));
    return r;
}

// RGBA of texture `id` in linear light, filtered.
vec4 igt_sample(uint id, IgtUvGradient at) {
    uint record = id * IGT_TEXTURE_WORDS;
    int top = int(igt_texture_word(record + 3u)) - 1;
    precise float lambda = igt_level_of(record, at);
    if (lambda <= 0.0 || top == 0 || (igt_texture_word(record + 5u) & IGT_FLAG_NO_MIPS) != 0u) {
        lambda = 0.0;
    }
    lambda = min(lambda, float(top));
    precise float f = lambda - floor(lambda);
    int level = int(floor(lambda));
    vec4 finer = vec4(0.0);
    vec4 value = vec4(0.0);
    for (int k = 0; k < 2; k++) {
        value = igt_sample_level(record, level + k, at.uv);
        if (f == 0.0) {
            return value;
        }
        if (k == 0) {
            finer = value;
        }
    }
    return igt_blend(finer, value, f);
}

#endif

#endif
