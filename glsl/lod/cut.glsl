// What selection and emission share: the tree's bits, and the flow diagram of a view. Twin of
// src/lod/multiresolution/view.rs and select.rs, where the reasons are.

const uint NEVER = 0xffffffffu;
const uint BLOCK = 64u;

// A bit for each node of each level: accepted, a block as a whole. Bits below a block that was accepted say nothing.
layout(std430, binding = 0) buffer Bits { uint words[]; } bits;
layout(push_constant) uniform Push {
    // Where the bits of each level begin; those of the picture before lie `other` words farther, or nearer.
    uvec4 level_bits;
    uvec2 level_bits_above;
    uint depth;
    // Words to this picture's bits, and to the ones before; NEVER where there was none.
    uint now;
    uint before;
    // The level that is asked, where its nodes begin, how many there are.
    uint level;
    uint first_node;
    uint node_count;
    // Collapses; nodes beyond them stay for ever.
    uint collapses;
    uint views;
    // Words of a node's colour codes; 0 for none.
    uint code_words;
    // Where the list of this level's blocks begins, and the next one's.
    uint list;
    uint next_list;
} push;

uint bits_of(uint level) {
    return level < 4u ? push.level_bits[level] : push.level_bits_above[level - 4u];
}

// Whether a collapse was accepted, in the picture whose bits begin at `first`.
bool accepted(uint first, uint node) {
    for (uint level = push.depth; level-- > 0u;) {
        uint at = node >> (6u * level);
        if ((bits.words[first + bits_of(level) + (at >> 5u)] >> (at & 31u) & 1u) == 1u) return true;
    }
    return false;
}
