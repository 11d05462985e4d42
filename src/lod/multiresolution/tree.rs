//! Nodes in an order in which those that views judge alike stand together, and blocks of 64 over them.
//!
//! In: a history and the bounds of its collapses. Out: a [`Multiresolution`]. Collapses are sorted by how far they displace, in
//! octaves, and along a space-filling curve within an octave. Triangles that no collapse takes away go into nodes of their own
//! at the end, which are never accepted.

use super::bound::{Bound, FAR};
use super::node::{By, Space, by};
use super::{Colours, Face, FaceColours, Multiresolution, NEVER};
use crate::lod::progressive::Progressive;

/// Nodes in a block.
pub(super) const BLOCK: usize = 64;

/// Triangles in a node of those that stay.
const STAYING: usize = 8;

pub(super) fn model(
    history: &Progressive,
    positions: &[[f32; 3]],
    colours: Option<FaceColours<'_>>,
) -> Multiresolution {
    let space = Space::new(history, positions);
    let bounds = space.bounds();
    let order = order(&bounds);
    let mut node = vec![0; bounds.len()];
    for (n, &c) in order.iter().enumerate() {
        node[c as usize] = n as u32;
    }
    let gone = by(history, |t| t.gone);
    let mut model = Multiresolution {
        unit: space.unit,
        levels: vec![Vec::with_capacity(order.len() + 1)],
        faces: Vec::with_capacity(history.triangles.len()),
        of: Vec::with_capacity(history.triangles.len()),
        node,
        colours: None,
    };
    for &c in &order {
        model.add(bounds[c as usize], gone.of(c as usize), history);
    }
    let stay: Vec<u32> = (0..history.triangles.len() as u32)
        .filter(|&t| history.triangles[t as usize].gone.is_none())
        .collect();
    for few in stay.chunks(STAYING) {
        model.add(never(), few, history);
    }
    model.block();
    model.colours = colours.map(|colours| coded(&colours, history, (&model, &order)));
    model
}

impl Multiresolution {
    fn add(&mut self, bound: Bound, triangles: &[u32], history: &Progressive) {
        self.levels[0].push(Bound {
            first: self.faces.len() as u32,
            ..bound
        });
        for &t in triangles {
            let made = &history.triangles[t as usize];
            self.faces.push(Face {
                corners: made.corners,
                made: made.made.map_or(NEVER, |c| self.node[c as usize]),
            });
            self.of.push(t);
        }
    }

    /// Blocks over nodes, and over blocks.
    fn block(&mut self) {
        while let Some(last) = self.levels.last().filter(|last| last.len() > BLOCK) {
            let blocks = last.chunks(BLOCK).map(|nodes| {
                let mut block = Bound::nothing();
                nodes.iter().for_each(|node| block.join(node));
                block
            });
            let blocks = blocks.collect();
            self.levels.push(blocks);
        }
    }
}

/// What no view accepts: it is everywhere, faces everywhere, and is displaced by more than anything.
fn never() -> Bound {
    let mut bound = Bound::nothing();
    bound.hold([[0.0; 3]; 3], FAR);
    bound.displace(FAR, FAR);
    [0, 1].into_iter().for_each(|which| bound.face(which, None));
    bound
}

/// Collapses by octaves of their deviation, and along a Z-curve within them; those that displace nothing first.
fn order(bounds: &[Bound]) -> Vec<u32> {
    let key = |bound: &Bound| {
        let octave = bound.total.max(f32::MIN_POSITIVE).log2().floor() as i32;
        let middle: [u32; 3] = std::array::from_fn(|k| {
            let middle = (bound.low[k] + bound.high[k]) * 0.25 + 0.5;
            (middle.clamp(0.0, 1.0) * 1023.0) as u32
        });
        (octave, z_curve(middle))
    };
    let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
    order.sort_by_cached_key(|&c| key(&bounds[c as usize]));
    order
}

/// Three numbers of ten bits, their bits in turn.
fn z_curve(p: [u32; 3]) -> u32 {
    let bit = |b: u32| {
        (0..3)
            .map(|k| (p[k] >> b & 1) << (3 * b + k as u32))
            .sum::<u32>()
    };
    (0..10).map(bit).sum()
}

/// Colours of nodes: those of the triangles that they make and of the nodes that they depend on; and of blocks.
fn coded(
    of: &FaceColours<'_>,
    history: &Progressive,
    (model, order): (&Multiresolution, &[u32]),
) -> Colours {
    let levels = of.levels;
    let made = by(history, |t| t.made);
    let gone = by(history, |t| t.gone);
    let nodes = model.levels[0].len();
    // What stays is never accepted: the worst code.
    let mut codes = vec![[u8::MAX; 2]; nodes * levels];
    let mut row = vec![[0u8; 2]; levels];
    for c in 0..history.collapses.len() {
        row.fill([0; 2]);
        of_faces(&mut row, of, &made, c);
        for &t in gone.of(c) {
            if let Some(before) = history.triangles[t as usize].made {
                let first = model.node[before as usize] as usize * levels;
                worst(&mut row, &codes[first..first + levels]);
            }
        }
        let first = model.node[c] as usize * levels;
        codes[first..first + levels].copy_from_slice(&row);
    }
    debug_assert_eq!(order.len(), history.collapses.len());
    let mut all = vec![codes];
    for _ in 1..model.levels.len() {
        let of_blocks = all[all.len() - 1].chunks(BLOCK * levels).flat_map(|block| {
            let mut row = vec![[0u8; 2]; levels];
            block.chunks(levels).for_each(|node| worst(&mut row, node));
            row
        });
        let of_blocks = of_blocks.collect();
        all.push(of_blocks);
    }
    Colours {
        footprint: of.footprint,
        levels,
        codes: all,
    }
}

fn of_faces(row: &mut [[u8; 2]], of: &FaceColours<'_>, made: &By, c: usize) {
    for &t in made.of(c) {
        let first = t as usize * of.levels;
        for (codes, values) in row.iter_mut().zip(&of.of[first..first + of.levels]) {
            for k in 0..2 {
                codes[k] = codes[k].max(Colours::encoded(values[k]));
            }
        }
    }
}

fn worst(row: &mut [[u8; 2]], other: &[[u8; 2]]) {
    for (mine, other) in row.iter_mut().zip(other) {
        *mine = [mine[0].max(other[0]), mine[1].max(other[1])];
    }
}

impl Colours {
    /// The value that a code stands for: 0, then from 1/16 on an eighth of an octave more each, up to what no limit reaches.
    pub fn decoded(code: u8) -> f32 {
        match code {
            0 => 0.0,
            u8::MAX => f32::MAX.sqrt(),
            _ => {
                // Exact: powers of two, and multiples of eighths between them.
                let step = u32::from(code) - 1;
                let octave = (step / 8) as f32;
                (1.0 + (step % 8) as f32 / 8.0) * octave.exp2() / 16.0
            }
        }
    }

    /// The lowest code whose value is not below `value`.
    pub fn encoded(value: f32) -> u8 {
        let is_enough = |code: &u8| Self::decoded(*code) >= value;
        match value {
            v if v.is_nan() => u8::MAX,
            v if v <= 0.0 => 0,
            _ => (0..=u8::MAX)
                .collect::<Vec<u8>>()
                .partition_point(|code| !is_enough(code))
                .min(255) as u8,
        }
    }

    /// Tangential deviation and product of node `n` of tree level `level` at a footprint's level.
    pub(super) fn at(&self, level: usize, n: usize, footprint: usize) -> [f32; 2] {
        self.codes[level][n * self.levels + footprint].map(Self::decoded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_never_below_what_they_stand_for() {
        for k in 0..100_000 {
            let value = k as f32 * 0.013;
            let (code, back) = (
                Colours::encoded(value),
                Colours::decoded(Colours::encoded(value)),
            );
            assert!(back >= value, "{value}");
            assert!(
                code == 0 || Colours::decoded(code - 1) < value,
                "{value} is {code}"
            );
            // No more than an eighth above, or the first step.
            assert!(
                back <= (value * 1.1251).max(1.0 / 16.0),
                "{value} becomes {back}"
            );
        }
        assert_eq!(Colours::encoded(f32::INFINITY), u8::MAX);
        assert_eq!(Colours::encoded(f32::NAN), u8::MAX);
        assert_eq!(Colours::encoded(1e12), u8::MAX);
        assert_eq!(Colours::encoded(-0.0), 0);
    }

    #[test]
    fn the_curve_mixes_bits() {
        assert_eq!(z_curve([1, 0, 0]), 1);
        assert_eq!(z_curve([0, 1, 1]), 6);
        assert_eq!(z_curve([1023; 3]), (1 << 30) - 1);
    }
}
