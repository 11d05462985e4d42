//! Which collapses a view accepts, and the triangles between those and the others.
//!
//! In: a [`Multiresolution`], a [`View`], what was accepted in the picture before. Out: a [`Cut`]. From the top of the tree
//! down, nodes of blocks that are not accepted as a whole are asked one by one; of collapses that are not accepted those
//! triangles are drawn whose makers are.
//!
//! Hysteresis: what the last cut had finer becomes coarser only under the tighter limit. Both limits give closed sets, and what
//! was accepted before is one: so is the new one.

use super::tree::BLOCK;
use super::view::{Limit, View};
use super::{Multiresolution, NEVER};

/// Triangles that a view is drawn with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cut {
    /// Numbers in [`Multiresolution::faces`], in growing order.
    pub faces: Vec<u32>,
    /// Nodes and blocks that were asked.
    pub asked: usize,
}

/// What was accepted in a picture: where blocks were looked into, and the collapses found there.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Memory {
    /// For each level of the tree a bit for each node: of a collapse whether it was accepted, of a block whether it was as a
    /// whole. Bits below a block that was accepted say nothing.
    levels: Vec<Vec<u64>>,
}

impl Memory {
    /// Whether node `n` of level `level` was accepted.
    fn accepted(&self, level: usize, n: usize) -> bool {
        (level..self.levels.len()).rev().any(|l| {
            let at = n / BLOCK.pow((l - level) as u32);
            self.levels[l][at / BLOCK] >> (at % BLOCK) & 1 == 1
        })
    }
}

/// A selection under way.
struct Selection<'a> {
    model: &'a Multiresolution,
    views: &'a [View],
    before: &'a Memory,
    now: Memory,
    asked: usize,
}

impl Multiresolution {
    /// The cut for a view, or the one that will do for several: of each instance that is drawn. `memory` holds what was accepted in the picture before, none at first, and this one's afterwards.
    pub fn select(&self, views: &[View], memory: &mut Memory) -> Cut {
        let mut selection = Selection::new(self, views, memory);
        let refused = selection.refused();
        let mut faces: Vec<u32> = refused.iter().flat_map(|&n| selection.drawn(n)).collect();
        faces.sort_unstable();
        let asked = selection.asked;
        *memory = selection.now;
        Cut { faces, asked }
    }

    /// Pixels that no point of `cut` is displaced by more than in any of `views`, but for what turns its back to the eye: the
    /// largest of what its triangles' collapses say, at most the limit in pixels where that alone decides. Infinite where a
    /// region reaches to the eye.
    pub fn displacement(&self, views: &[View], cut: &Cut) -> f64 {
        let made = |&f: &u32| match self.faces[f as usize].made {
            NEVER => None,
            n => Some(&self.levels[0][n as usize]),
        };
        let of = |bound| {
            views
                .iter()
                .filter_map(move |view| view.displacement(bound))
        };
        let all = cut.faces.iter().filter_map(made).flat_map(of);
        all.fold(0.0, f64::max)
    }

    /// The triangles of node `n`.
    fn faces_of(&self, n: usize) -> std::ops::Range<u32> {
        let nodes = &self.levels[0];
        let end = nodes
            .get(n + 1)
            .map_or(self.faces.len() as u32, |next| next.first);
        nodes[n].first..end
    }
}

impl<'a> Selection<'a> {
    fn new(model: &'a Multiresolution, views: &'a [View], before: &'a Memory) -> Self {
        let words = |nodes: &Vec<_>| vec![0; nodes.len().div_ceil(BLOCK)];
        Selection {
            model,
            views,
            before,
            now: Memory {
                levels: model.levels.iter().map(words).collect(),
            },
            asked: 0,
        }
    }

    /// The collapses that are not accepted; those that stay for ever among them.
    fn refused(&mut self) -> Vec<u32> {
        let top = self.model.levels.len() - 1;
        let mut asked: Vec<u32> = (0..self.model.levels[top].len() as u32).collect();
        for level in (0..=top).rev() {
            asked.retain(|&n| !self.ask(level, n as usize));
            if level > 0 {
                let below = self.model.levels[level - 1].len();
                let nodes = |&block: &u32| {
                    let first = block as usize * BLOCK;
                    first as u32..(first + BLOCK).min(below) as u32
                };
                asked = asked.iter().flat_map(nodes).collect();
            }
        }
        asked
    }

    /// Whether a node is accepted; it is remembered.
    fn ask(&mut self, level: usize, n: usize) -> bool {
        self.asked += 1;
        let accepts = |limit: Limit| {
            let colour = |footprint: usize| match &self.model.colours {
                Some(colours) => colours.at(level, n, footprint),
                None => [0.0; 2],
            };
            let bound = &self.model.levels[level][n];
            self.views
                .iter()
                .all(|view| view.accepts(bound, &colour, limit))
        };
        // What stays for ever is at the end: no block with some of it is accepted.
        let is_collapse = n < self.model.collapses() / BLOCK.pow(level as u32);
        let accepted = is_collapse
            && (accepts(Limit::Coarsen)
                || (level == 0 && self.before.accepted(0, n) && accepts(Limit::Stay)));
        if accepted {
            self.now.levels[level][n / BLOCK] |= 1 << (n % BLOCK);
        }
        accepted
    }

    /// The triangles that go by a collapse that is not accepted, and were made by one that is, or never.
    fn drawn(&self, n: u32) -> impl Iterator<Item = u32> {
        self.model.faces_of(n as usize).filter(|&f| {
            let made = self.model.faces[f as usize].made;
            made == NEVER || self.now.accepted(0, made as usize)
        })
    }
}
