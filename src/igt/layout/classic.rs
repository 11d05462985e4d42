//! The paper's layout (section 2.3).
//!
//! Hash: one word a texel, RGBA8: 24-bit address, 8-bit length (0: no list). List: RGBA8 entries, 24-bit triangle and (ours,
//! where the paper has a spare byte) 8-bit layer; lists never straddle a row of the list texture. Length 255 means that the
//! list's first word holds the length.

/// Length byte of a hash texel whose list starts with its length.
pub const LONG: u32 = 255;

/// The width of the list texture's rows: a power of two that holds the longest list.
pub fn row(longest: u32) -> u32 {
    (longest + 1).next_power_of_two().max(512)
}
