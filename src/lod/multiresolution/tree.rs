//! Nodes in an order in which those that views judge alike stand together, and blocks of 64 over them.
//!
//! In: a history and the bounds of its collapses. Out: a [`Multiresolution`]. Collapses are sorted by how far they displace, in
//! octaves, and along a space-filling curve within an octave. Triangles that no collapse takes away go into nodes of their own
//! at the end, which are never accepted.

use super::bound::{Bound, FAR};
use super::colour::{StepColours, saturated};
use super::node::{Space, by};
use super::{Face, Multiresolution, NEVER};
use crate::lod::progressive::Progressive;

/// Nodes in a block.
pub(super) const BLOCK: usize = 64;

/// Triangles in a node of those that stay.
const STAYING: usize = 8;

pub(super) fn model(
    history: &Progressive,
    positions: &[[f32; 3]],
    colours: Option<&StepColours>,
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
    model.colours = colours.map(|colours| saturated(colours, history, &model));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_mixes_bits() {
        assert_eq!(z_curve([1, 0, 0]), 1);
        assert_eq!(z_curve([0, 1, 1]), 6);
        assert_eq!(z_curve([1023; 3]), (1 << 30) - 1);
    }
}
