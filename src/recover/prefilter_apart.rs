//! How far what was filtered beforehand lies from the lookup.
//!
//! In: textures of all levels. Out: for each texel of a level the farthest that the two come apart in its neighbourhood, over
//! footprints of several shapes.

use super::low::{ROWS, UPRIGHT};
use super::prefilter::{Filtering, places};
use crate::attribute::TextureSet;
use crate::attribute::arithmetic::srgb_encode;
use crate::attribute::prefiltered::Role;
use crate::attribute::surface::Surface;
use crate::render::{THRESHOLDS_AT, beforehand};
use rayon::prelude::*;

/// Footprints that the two are compared over: shares of two texels along each axis. Round ones up to half a level finer and
/// coarser, and long ones, whose level is that of their length.
const FOOTPRINTS: [[f32; 2]; 5] = [
    [1.0, 1.0],
    [1.0, 0.25],
    [0.25, 1.0],
    [std::f32::consts::SQRT_2, std::f32::consts::SQRT_2],
    [
        std::f32::consts::FRAC_1_SQRT_2,
        std::f32::consts::FRAC_1_SQRT_2,
    ],
];
/// The distance, in steps of 8 bits, of what is never to be used.
const FAR: f32 = 255.0;

/// How far apart base colours, and all that light needs, are; steps of 8 bits.
pub(super) type Apart = [f32; 2];

impl Filtering<'_> {
    /// What a shader gets there.
    fn shown(&self, textures: &TextureSet, st: [f64; 2], side: usize, shares: [f32; 2]) -> Surface {
        let step = 2.0 / side as f32;
        let here = st.map(|c| c as f32);
        let x = [here[0] + step * shares[0], here[1]];
        let y = [here[0], here[1] + step * shares[1]];
        let footprint = beforehand::footprint(self.line(), here, x, y);
        let decode = &self.constants[..256];
        let images = Role::ALL.map(|role| textures.sample(decode, role as u32, &footprint));
        beforehand::surface(&images, self.scope.unlit, &(ROWS, UPRIGHT), false)
    }

    /// For each texel of a level how far the two come apart in it.
    pub(super) fn apart(
        &self,
        textures: &TextureSet,
        side: usize,
        unusable: &[bool],
    ) -> Vec<Apart> {
        let along = if side == self.size as usize { 2 } else { 4 };
        let texel = |i: usize| {
            if unusable[i] {
                return [FAR; 2];
            }
            let mut most: Option<Apart> = None;
            for st in places(side, [i % side, i / side], along) {
                let Some(place) = self.place(st, side) else {
                    continue;
                };
                for shares in FOOTPRINTS {
                    let full = self.seen(&place, shares);
                    let apart = self.between(&full, &self.shown(textures, st, side, shares));
                    let so_far = most.get_or_insert([0.0; 2]);
                    *so_far = [0, 1].map(|k| so_far[k].max(apart[k]));
                }
            }
            most.unwrap_or_default()
        };
        (0..side * side).into_par_iter().map(texel).collect()
    }

    /// How far what is shown lies from the full surface.
    fn between(&self, full: &Surface, shown: &Surface) -> Apart {
        if full.masked || full.unlit != self.scope.unlit {
            return [FAR; 2];
        }
        let thresholds = &self.constants[THRESHOLDS_AT..THRESHOLDS_AT + 256];
        let colour = |a: f32, b: f32| {
            if a > 1.001 {
                return FAR;
            }
            srgb_encode(thresholds, a).abs_diff(srgb_encode(thresholds, b)) as f32
        };
        let three = |a: [f32; 3], b: [f32; 3], by: &dyn Fn(f32, f32) -> f32| {
            (0..3).map(|i| by(a[i], b[i])).fold(0.0, f32::max)
        };
        let linear = |a: f32, b: f32| (a - b).abs() * 255.0;
        let [r, g, b, alpha] = full.base;
        let base = three(
            [r, g, b],
            [shown.base[0], shown.base[1], shown.base[2]],
            &colour,
        );
        let base = base.max(linear(alpha, 1.0));
        let rest = [
            three(full.normal, shown.normal, &linear) / 2.0,
            three(full.emissive, shown.emissive, &colour),
            linear(full.occlusion, shown.occlusion),
            linear(full.roughness, shown.roughness),
            linear(full.metallic, shown.metallic),
        ];
        [base, rest.into_iter().fold(base, f32::max)]
    }

    /// Each texel with the most of itself and its neighbours: what is interpolated between texels is never less than what
    /// was measured there.
    pub(super) fn widened(&self, apart: &[Apart], side: usize) -> Vec<Apart> {
        let near = |at: usize, round: bool| {
            let (before, after) = (at.checked_sub(1), Some(at + 1).filter(|&a| a < side));
            match round {
                true => [before.or(Some(side - 1)), Some(at), after.or(Some(0))],
                false => [before, Some(at), after],
            }
        };
        let texel = |i: usize| {
            let mut most: Apart = [0.0; 2];
            for y in near(i / side, false).into_iter().flatten() {
                for x in near(i % side, self.goes_round()).into_iter().flatten() {
                    most = [0, 1].map(|k| most[k].max(apart[y * side + x][k]));
                }
            }
            most
        };
        (0..side * side).into_par_iter().map(texel).collect()
    }
}

/// A level's marks from those of the level above it, which is twice as wide.
pub(super) fn halved(above: &[bool], side: usize) -> Vec<bool> {
    let at = |x: usize, y: usize| above[y * 2 * side + x];
    (0..side * side)
        .map(|i| {
            let (x, y) = (2 * (i % side), 2 * (i / side));
            at(x, y) || at(x + 1, y) || at(x, y + 1) || at(x + 1, y + 1)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_is_inherited() {
        let mut marks = vec![false; 16];
        marks[7] = true;
        assert_eq!(halved(&marks, 2), [false, true, false, false]);
        assert_eq!(halved(&halved(&marks, 2), 1), [true]);
    }
}
