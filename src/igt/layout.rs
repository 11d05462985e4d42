//! How tables are laid out in 32-bit words. Twin of `glsl/common/igt_layout.glsl`.
//!
//! **packed.** Hash: two words a texel: `first triangle | LAST`, `index of the rest of the list`; no list: [`EMPTY`]. List:
//! one word an entry, `triangle | LAST` on the last one; no length is stored and none is limited. Triangle: uv charts 4
//! words (six 20-bit coordinates, 8-bit layer), T3 positions 8 words (nine 24-bit coordinates, 8-bit layer).
//!
//! **classic**, after the paper (section 2.3). Hash: one word a texel, RGBA8: 24-bit address, 8-bit length (0: no list). List:
//! RGBA8 entries, 24-bit triangle and (ours, where the paper has a spare byte) 8-bit layer; lists never straddle a row of the list
//! texture. Length 255 means that the list's first word holds the length. Triangle: three RGB9E5 texels.

use super::Layout;
use crate::param::grid::VERTEX_BITS;
use crate::param::projection::GridTriangle;
use crate::param::{Primary, PrimaryKind};

/// Flag of a packed list's last entry.
pub const LAST: u32 = 1 << 31;
/// First word of a packed hash texel without a list.
pub const EMPTY: u32 = u32::MAX;
/// Bits dropped from chart coordinates in the packed layout.
const CHART_SHIFT: u32 = VERTEX_BITS - 20;
/// Half of the vertex grid: added to make coordinates unsigned.
const HALF: i32 = 1 << (VERTEX_BITS - 1);
/// Length byte of a classic hash texel whose list starts with its length.
pub const LONG: u32 = 255;

/// Words of a hash texel.
pub fn hash_words(layout: Layout) -> usize {
    match layout {
        Layout::Packed => 2,
        Layout::Classic => 1,
    }
}

/// Whether T3 has two coordinates (the third is always zero).
pub fn is_flat(primary: &Primary) -> bool {
    matches!(primary.kind, PrimaryKind::UvSet(_))
}

/// Words of a triangle record.
pub fn triangle_words(layout: Layout, primary: &Primary) -> usize {
    match layout {
        Layout::Packed if is_flat(primary) => 4,
        Layout::Packed => 8,
        Layout::Classic => 3,
    }
}

/// Loads of at most 128 bits that a triangle record takes.
pub fn triangle_fetches(layout: Layout, primary: &Primary) -> u32 {
    match layout {
        Layout::Packed if is_flat(primary) => 1,
        Layout::Packed => 2,
        Layout::Classic => 3,
    }
}

/// The grid point nearest to `v` that the layout can hold.
pub fn round_vertex(layout: Layout, primary: &Primary, v: [i32; 3]) -> [i32; 3] {
    match layout {
        Layout::Packed if is_flat(primary) => v.map(|x| {
            let most = (HALF >> CHART_SHIFT) - 1;
            ((x + (1 << (CHART_SHIFT - 1))) >> CHART_SHIFT).clamp(-most, most) << CHART_SHIFT
        }),
        Layout::Packed => v,
        Layout::Classic => decode_rgb9e5(encode_rgb9e5(v, is_flat(primary)), is_flat(primary)),
    }
}

/// The shared-exponent texel of a vertex: coordinate c/2^24 of the domain with 9 bits of mantissa (EXT_texture_shared_exponent).
pub fn encode_rgb9e5(v: [i32; 3], flat: bool) -> u32 {
    let c = [v[0] + HALF, v[1] + HALF, if flat { 0 } else { v[2] + HALF }].map(|x| x as u32);
    let largest = c[0].max(c[1]).max(c[2]);
    let mut exponent = (32 - largest.leading_zeros()).saturating_sub(9);
    let mantissa = |exponent: u32, x: u32| {
        if exponent == 0 {
            x
        } else {
            (x + (1 << (exponent - 1))) >> exponent
        }
    };
    if mantissa(exponent, largest) > 511 {
        exponent += 1;
    }
    // Rounding up at the domain's upper border would need a sixteenth exponent: stay below it.
    let exponent = exponent.min(15);
    let m = c.map(|x| mantissa(exponent, x).min(511));
    m[0] | m[1] << 9 | m[2] << 18 | exponent << 27
}

/// The vertex of a shared-exponent texel.
pub fn decode_rgb9e5(word: u32, flat: bool) -> [i32; 3] {
    let exponent = word >> 27;
    // Exponents above 15 are never written; clamp so that a corrupt table cannot leave the grid.
    let coordinate = |at: u32| (((word >> at & 511) << exponent.min(15)) as i32) - HALF;
    [
        coordinate(0),
        coordinate(9),
        if flat { 0 } else { coordinate(18) },
    ]
}

/// The words of a triangle record.
pub fn encode_triangle(layout: Layout, flat: bool, t: &GridTriangle, layer: u8, out: &mut [u32]) {
    match layout {
        Layout::Classic => {
            for (word, v) in out.iter_mut().zip(t) {
                *word = encode_rgb9e5(*v, flat);
            }
        }
        Layout::Packed if flat => {
            let c = |i: usize, k: usize| ((t[i][k] + HALF) >> CHART_SHIFT) as u32;
            out[0] = c(0, 0) | c(0, 1) << 20;
            out[1] = c(0, 1) >> 12 | c(1, 0) << 8 | c(1, 1) << 28;
            out[2] = c(1, 1) >> 4 | c(2, 0) << 16;
            out[3] = c(2, 0) >> 16 | c(2, 1) << 4 | (layer as u32) << 24;
        }
        Layout::Packed => {
            let c = |i: usize| (t[i / 3][i % 3] + HALF) as u32;
            for (i, word) in out.iter_mut().enumerate() {
                let top = match i {
                    0..=2 => c(8) >> (8 * i) & 255,
                    3 => layer as u32,
                    _ => 0,
                };
                *word = c(i) | top << 24;
            }
        }
    }
}

/// A triangle record's vertices and layer (classic: layer 0, lists hold it).
pub fn decode_triangle(layout: Layout, flat: bool, w: &[u32]) -> (GridTriangle, u8) {
    match layout {
        Layout::Classic => ([0, 1, 2].map(|i| decode_rgb9e5(w[i], flat)), 0),
        Layout::Packed if flat => {
            let c = |x: u32| (((x & 0xf_ffff) << CHART_SHIFT) as i32) - HALF;
            let t = [
                [c(w[0]), c(w[0] >> 20 | w[1] << 12), 0],
                [c(w[1] >> 8), c(w[1] >> 28 | w[2] << 4), 0],
                [c(w[2] >> 16 | w[3] << 16), c(w[3] >> 4), 0],
            ];
            (t, (w[3] >> 24) as u8)
        }
        Layout::Packed => {
            let c = |x: u32| ((x & 0xff_ffff) as i32) - HALF;
            let last = w[0] >> 24 | w[1] >> 24 << 8 | w[2] >> 24 << 16;
            let t = [
                [c(w[0]), c(w[1]), c(w[2])],
                [c(w[3]), c(w[4]), c(w[5])],
                [c(w[6]), c(w[7]), c(last)],
            ];
            (t, (w[3] >> 24) as u8)
        }
    }
}

/// The width of the classic list texture's rows: a power of two that holds the longest list.
pub fn classic_row(longest: u32) -> u32 {
    (longest + 1).next_power_of_two().max(512)
}
