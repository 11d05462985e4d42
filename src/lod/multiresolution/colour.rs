//! What colours are off by, in a byte for each collapse and footprint.
//!
//! In: colour deviations of the triangles of a history. Out: [`StepColours`], for each collapse the largest of those it makes,
//! and [`Colours`], for each node and block of the tree the largest of all that it holds.

use super::bound::FAR;
use super::node::by;
use super::tree::BLOCK;
use super::{MAX_LEVELS, Multiresolution};
use crate::lod::progressive::Progressive;
use crate::lod::progressive::colour::{ColourDeviations, Distance};

/// Colour deviations of the collapses of a history.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepColours {
    /// What they are measured by.
    pub distance: Distance,
    /// Object units of a pixel at level 0; each level's are twice those of the one before.
    pub footprint: f32,
    /// Levels of footprints, at most [`MAX_LEVELS`].
    pub levels: usize,
    /// For each collapse, for each level: codes of the tangential deviation and of the product, each the largest of the
    /// triangles that the collapse makes ([`decoded`]).
    pub codes: Vec<[u8; 2]>,
}

/// Colour deviations of nodes and blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Colours {
    /// Object units of a pixel at level 0.
    pub footprint: f32,
    /// Levels of footprints.
    pub levels: usize,
    /// For each level of the tree, for each of its nodes, for each footprint: codes of the tangential deviation and of the
    /// product ([`decoded`]).
    pub codes: Vec<Vec<[u8; 2]>>,
}

impl StepColours {
    /// The largest of the triangles that each collapse makes.
    pub fn of(history: &Progressive, deviations: &ColourDeviations, distance: Distance) -> Self {
        let levels = deviations.levels.min(MAX_LEVELS);
        let mut codes = vec![[0u8; 2]; history.collapses.len() * levels];
        for (t, made) in history.triangles.iter().enumerate() {
            let Some(c) = made.made else { continue };
            let first = c as usize * levels;
            for (level, codes) in codes[first..first + levels].iter_mut().enumerate() {
                let off = deviations.at(t, level);
                worst(codes, [encoded(off.tangential), encoded(off.product)]);
            }
        }
        StepColours {
            distance,
            footprint: deviations.footprint,
            levels,
            codes,
        }
    }

    /// Whether there is a row for each of so many collapses, and a footprint.
    pub fn fits(&self, collapses: usize) -> bool {
        (1..=MAX_LEVELS).contains(&self.levels)
            && self.codes.len() == collapses * self.levels
            && self.footprint.is_normal()
            && self.footprint > 0.0
    }
}

fn worst(codes: &mut [u8; 2], other: [u8; 2]) {
    *codes = [codes[0].max(other[0]), codes[1].max(other[1])];
}

fn worst_row(row: &mut [[u8; 2]], other: &[[u8; 2]]) {
    row.iter_mut()
        .zip(other)
        .for_each(|(mine, other)| worst(mine, *other));
}

/// Nodes hold what they depend on, and no level says more than a finer one; blocks hold their nodes.
pub(super) fn saturated(
    steps: &StepColours,
    history: &Progressive,
    model: &Multiresolution,
) -> Colours {
    let levels = steps.levels;
    let gone = by(history, |t| t.gone);
    // What stays is never accepted: the worst code.
    let mut codes = vec![[u8::MAX; 2]; model.levels[0].len() * levels];
    for (c, own) in steps.codes.chunks(levels).enumerate() {
        let mut row = own.to_vec();
        for &t in gone.of(c) {
            if let Some(before) = history.triangles[t as usize].made {
                let first = model.node[before as usize] as usize * levels;
                worst_row(&mut row, &codes[first..first + levels]);
            }
        }
        for level in (1..levels).rev() {
            let coarser = row[level];
            worst(&mut row[level - 1], coarser);
        }
        let first = model.node[c] as usize * levels;
        codes[first..first + levels].copy_from_slice(&row);
    }
    let mut all = vec![codes];
    for _ in 1..model.levels.len() {
        let of_block = |block: &[[u8; 2]]| {
            let mut row = vec![[0u8; 2]; levels];
            block
                .chunks(levels)
                .for_each(|node| worst_row(&mut row, node));
            row
        };
        let last = &all[all.len() - 1];
        let of_blocks = last.chunks(BLOCK * levels).flat_map(of_block).collect();
        all.push(of_blocks);
    }
    Colours {
        footprint: steps.footprint,
        levels,
        codes: all,
    }
}

/// The value that a code stands for, in the unit of the colour deviations: 0, then from 1/16 on an eighth of an octave more
/// each; the last is more than any limit.
pub fn decoded(code: u8) -> f32 {
    match code {
        0 => 0.0,
        u8::MAX => FAR,
        // Three bits of a float's fraction, and its exponent.
        _ => f32::from_bits((u32::from(code) - 1 + SIXTEENTH) << 20),
    }
}

/// The lowest code whose value is not below `value`.
pub fn encoded(value: f32) -> u8 {
    match value {
        v if v.is_nan() => u8::MAX,
        v if v <= 0.0 => 0,
        _ => {
            let eighths = value.to_bits().div_ceil(1 << 20);
            (eighths.saturating_sub(SIXTEENTH) + 1).min(255) as u8
        }
    }
}

/// The first bits of 1/16 as a float.
const SIXTEENTH: u32 = 123 << 3;

impl Colours {
    /// Tangential deviation and product of node `n` of tree level `level` at a footprint's level.
    pub(super) fn at(&self, level: usize, n: usize, footprint: usize) -> [f32; 2] {
        self.codes[level][n * self.levels + footprint].map(decoded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_never_below_what_they_stand_for() {
        for k in 0..100_000 {
            let value = k as f32 * 0.013;
            let (code, back) = (encoded(value), decoded(encoded(value)));
            assert!(back >= value, "{value}");
            assert!(code == 0 || decoded(code - 1) < value, "{value} is {code}");
            // No more than an eighth above, or the first step.
            assert!(
                back <= (value * 1.1251).max(1.0 / 16.0),
                "{value} becomes {back}"
            );
        }
        assert_eq!(encoded(f32::INFINITY), u8::MAX);
        assert_eq!(encoded(f32::NAN), u8::MAX);
        assert_eq!(encoded(1e12), u8::MAX);
        assert_eq!(encoded(-0.0), 0);
    }
}
