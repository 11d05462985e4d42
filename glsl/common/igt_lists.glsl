// The lists as the gutter's passes read them: sorted, with gaps.
#ifndef IGT_LISTS_GLSL
#define IGT_LISTS_GLSL

layout(std430, binding = 0) readonly buffer Starts { uint words[]; } starts;
layout(std430, binding = 1) readonly buffer Lengths { uint words[]; } lengths;
layout(std430, binding = 2) readonly buffer Lists { uint words[]; } lists;
layout(std430, binding = 3) readonly buffer Layers { uint words[]; } layers;
// Bit (layer mod 32) is set where the texel's list may have the layer.
layout(std430, binding = 4) readonly buffer Masks { uint words[]; } masks;

uint layer_of(uint triangle) {
    return layers.words[triangle >> 2] >> (8u * (triangle & 3u)) & 255u;
}

bool has(uint texel, uint layer) {
    if ((masks.words[texel] >> (layer & 31u) & 1u) == 0u) return false;
    uint start = starts.words[texel], count = lengths.words[texel];
    for (uint i = 0u; i < count; i++) {
        if (layer_of(lists.words[start + i]) == layer) return true;
    }
    return false;
}

#endif
