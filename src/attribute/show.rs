//! An attribute in place of base colour: the twin of `glsl/common/show.glsl`.
//!
//! In: a point of the reference and what its material says there. Out: the same with the product of the factors as base
//! colour. Factors stand as [`FACTOR_WORDS`] words each in every material record; see [`word`].

use super::arithmetic::{V3, mul3};
use super::material::MATERIAL_WORDS;
use super::solid::{self, id_color};
use super::surface::{AttributeSet, Surface, SurfacePoint};

/// Where a material record says how many factors there are, and whether metalness and emission are kept ([`KEEP`]).
pub(crate) const SHOWN_AT: usize = 15;
/// Where they begin, and the words of each.
pub(crate) const FACTORS_AT: usize = 56;
pub(crate) const FACTOR_WORDS: usize = 2;
/// Added to the number of factors.
pub(crate) const KEEP: u32 = 0x100;

/// What a factor is, the low bits of its first word.
pub(crate) const BASE_COLOR: u32 = 1;
pub(crate) const NORMAL_MAP: u32 = 2;
pub(crate) const METALLIC_ROUGHNESS: u32 = 3;
pub(crate) const EMISSIVE: u32 = 4;
pub(crate) const OCCLUSION_MAP: u32 = 5;
pub(crate) const NORMAL: u32 = 6;
pub(crate) const VERTEX: u32 = 7;
pub(crate) const TRIANGLE_COLOR: u32 = 8;
pub(crate) const MATERIAL: u32 = 9;
pub(crate) const PART: u32 = 10;
pub(crate) const SOLID: u32 = 11;
pub(crate) const VOLUME: u32 = 12;
pub(crate) const FUNCTION: u32 = 13;
const KIND_MASK: u32 = 0xff;
const FLAT: u32 = 0x800;
/// Added to the second word of a solid texture that does not move.
pub(super) const STILL: u32 = 0x100;

/// The first word of a factor: its kind; for numbers of vertices how many (1 to 4), whether only the first corner's count,
/// and where in a vertex's words they begin.
pub(crate) fn word(kind: u32, width: usize, flat: bool, at: usize) -> u32 {
    kind | ((width as u32) << 8) | (u32::from(flat) * FLAT) | ((at as u32) << 16)
}

/// What a factor with this first word is.
pub(super) fn kind(word: u32) -> u32 {
    word & KIND_MASK
}

/// What a factor is evaluated from.
struct At<'a> {
    /// [`super::arithmetic::srgb_decode_table`].
    decode: &'a [f32],
    corner: [u32; 4],
    b: V3,
    /// Number of the triangle in its own mesh.
    triangle: u32,
    /// Seconds.
    time: f32,
}

impl AttributeSet {
    /// Puts the attribute that is shown, if any, in place of `surface`'s base colour at `p`; `triangle` is its number in its
    /// own mesh. `surface.normal` is the one that is lit.
    pub(crate) fn show(
        &self,
        decode: &[f32],
        surface: &mut Surface,
        p: &SurfacePoint,
        triangle: u32,
        time: f32,
    ) {
        let corner = self.triangles[p.triangle as usize][0];
        let m = corner[3] as usize * MATERIAL_WORDS;
        let shown = self.materials[m + SHOWN_AT];
        if shown == 0 {
            return;
        }
        let at = At {
            decode,
            corner,
            b: p.b,
            triangle,
            time,
        };
        let mut product = [1.0; 3];
        for k in 0..(shown & KIND_MASK) as usize {
            let words = &self.materials[m + FACTORS_AT + k * FACTOR_WORDS..];
            product = mul3(product, self.factor([words[0], words[1]], surface, &at));
        }
        let [r, g, b] = product;
        surface.base = [r, g, b, surface.base[3]];
        if shown & KEEP == 0 {
            surface.metallic = 0.0;
            surface.emissive = [0.0; 3];
        }
    }

    fn factor(&self, [word, more]: [u32; FACTOR_WORDS], surface: &Surface, at: &At) -> V3 {
        let (first, corner, b) = (word >> 16, at.corner, at.b);
        match word & KIND_MASK {
            BASE_COLOR => [surface.base[0], surface.base[1], surface.base[2]],
            NORMAL_MAP => surface.bump,
            METALLIC_ROUGHNESS => [0.0, surface.roughness, surface.metallic],
            EMISSIVE => surface.emissive,
            OCCLUSION_MAP => [surface.occlusion; 3],
            NORMAL => surface.normal.map(|c| c * 0.5 + 0.5),
            VERTEX => {
                let number = |k: u32| self.vertex_number(word, corner, first + k, b);
                match word >> 8 & 7 {
                    1 => [number(0); 3],
                    2 => [number(0), number(1), 0.0],
                    _ => [0, 1, 2].map(number),
                }
            }
            TRIANGLE_COLOR => id_color(at.triangle),
            MATERIAL => id_color(corner[3]),
            PART => id_color(self.float(corner[0] + first) as i32 as u32),
            SOLID => {
                let time = if more & STILL != 0 { 0.0 } else { at.time };
                solid::color(more & KIND_MASK, self.place(corner, first, b), time)
            }
            VOLUME => self.volume(at.decode, more, self.place(corner, first, b)),
            _ => [0.0; 3],
        }
    }

    /// The place that three vertices' numbers from `word` on say, by the last two barycentrics alone: these are what a point
    /// of the surface is told by, and one point has one place to the bit.
    fn place(&self, corner: [u32; 4], word: u32, b: V3) -> V3 {
        [0, 1, 2].map(|i| {
            let [p, q, r] = [0, 1, 2].map(|k| self.float(corner[k] + word + i));
            p + (b[1] * (q - p) + b[2] * (r - p))
        })
    }

    fn vertex_number(&self, word: u32, corner: [u32; 4], at: u32, b: V3) -> f32 {
        if word & FLAT != 0 {
            self.float(corner[0] + at)
        } else {
            self.weighted(corner, at, b)
        }
    }
}
