//! An attribute in place of base colour: the twin of `glsl/common/show.glsl`.
//!
//! In: a point of the reference and what its material says there. Out: the same with the product of the factors as base
//! colour. Factors stand as [`FACTOR_WORDS`] words each in every material record; see [`word`].

use super::arithmetic::{V3, mul3};
use super::material::MATERIAL_WORDS;
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
const KIND_MASK: u32 = 0xff;
const FLAT: u32 = 0x800;

/// The first word of a factor: its kind; for numbers of vertices how many (1 to 4), whether only the first corner's count,
/// and where in a vertex's words they begin.
pub(crate) fn word(kind: u32, width: usize, flat: bool, at: usize) -> u32 {
    kind | ((width as u32) << 8) | (u32::from(flat) * FLAT) | ((at as u32) << 16)
}

impl AttributeSet {
    /// Puts the attribute that is shown, if any, in place of `surface`'s base colour at `p`; `triangle` is its number in its
    /// own mesh. `surface.normal` is the one that is lit.
    pub(crate) fn show(&self, surface: &mut Surface, p: &SurfacePoint, triangle: u32) {
        let corner = self.triangles[p.triangle as usize][0];
        let m = corner[3] as usize * MATERIAL_WORDS;
        let shown = self.materials[m + SHOWN_AT];
        if shown == 0 {
            return;
        }
        let mut product = [1.0; 3];
        for k in 0..(shown & KIND_MASK) as usize {
            let factor = self.materials[m + FACTORS_AT + k * FACTOR_WORDS];
            product = mul3(product, self.factor(factor, corner, surface, p.b, triangle));
        }
        let [r, g, b] = product;
        surface.base = [r, g, b, surface.base[3]];
        if shown & KEEP == 0 {
            surface.metallic = 0.0;
            surface.emissive = [0.0; 3];
        }
    }

    fn factor(&self, word: u32, corner: [u32; 4], surface: &Surface, b: V3, triangle: u32) -> V3 {
        let at = word >> 16;
        match word & KIND_MASK {
            BASE_COLOR => [surface.base[0], surface.base[1], surface.base[2]],
            NORMAL_MAP => surface.bump,
            METALLIC_ROUGHNESS => [0.0, surface.roughness, surface.metallic],
            EMISSIVE => surface.emissive,
            OCCLUSION_MAP => [surface.occlusion; 3],
            NORMAL => surface.normal.map(|c| c * 0.5 + 0.5),
            VERTEX => {
                let b = if word & FLAT != 0 { [1.0, 0.0, 0.0] } else { b };
                let number = |k: u32| self.vertex_number(word, corner, at + k, b);
                match word >> 8 & 7 {
                    1 => [number(0); 3],
                    2 => [number(0), number(1), 0.0],
                    _ => [0, 1, 2].map(number),
                }
            }
            TRIANGLE_COLOR => id_color(triangle),
            MATERIAL => id_color(corner[3]),
            PART => id_color(self.float(corner[0] + at) as i32 as u32),
            _ => [0.0; 3],
        }
    }

    fn vertex_number(&self, word: u32, corner: [u32; 4], at: u32, b: V3) -> f32 {
        if word & FLAT != 0 {
            self.float(corner[0] + at)
        } else {
            self.weighted(corner, at, b)
        }
    }
}

/// A colour for a number, linear: hues a golden section apart, so that neighbours differ, in four shades.
pub(crate) fn id_color(id: u32) -> V3 {
    let turned = id.wrapping_mul(0x9e37_79b9);
    let hue = (turned >> 16) as i32 as f32 * (6.0 / 65536.0);
    let shade = (id.wrapping_mul(0x85eb_ca6b) >> 30) as i32 as f32;
    let light = 0.9 - 0.17 * shade;
    let ramp = [
        (hue - 3.0).abs() - 1.0,
        2.0 - (hue - 2.0).abs(),
        2.0 - (hue - 4.0).abs(),
    ];
    ramp.map(|x| (0.12 + 0.88 * x.clamp(0.0, 1.0)) * light)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_numbers_are_in_range_and_neighbours_differ() {
        let apart = |a: V3, b: V3| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max);
        for id in 0..5000u32 {
            let here = id_color(id);
            assert!(
                here.iter().all(|c| (0.0..=1.0).contains(c)),
                "{id}: {here:?}"
            );
            for near in 1..4 {
                assert!(
                    apart(here, id_color(id + near)) > 0.12,
                    "{id} and {near} more"
                );
            }
        }
    }
}
