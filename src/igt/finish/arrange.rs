//! What becomes of a texel's list in the packed layout: its order, its masks, whether the texel is divided.
//!
//! In: a texel's triangles. Out: a head, and blocks and children where it needs some ([`Band`]). The order is that of the
//! share of the texel that each triangle covers: the most likely is tested first. Longer lists say for each other triangle
//! where it is to be tested: in which regions around the first, or in which quadrants of the texel. A texel where many
//! triangles of one layer meet is cut into smaller ones, again and again while that helps, so that no query tests many.
//!
//! Where a texel, or a quadrant, is missed by all triangles of a layer, the nearest few of them serve its points, as in the
//! gutter.

use super::super::Reference;
use super::super::layout::packed::{EMPTY, Kind, MOST_INLINE, Masked, inline};
use super::estimate::Frame;
use super::near;
use super::packed::Band;
use super::ranked::Ranked;
use super::weigh::{self, Corners};
use crate::param::projection::Line;

/// log2 of the resolution at which the smallest texels lie.
pub(in super::super) const MAX_BITS: u32 = 19;
/// The most triangles of one layer in an undivided texel, if dividing helps: where a sorted list would do, and elsewhere.
pub(super) const CROWDED: [usize; 2] = [16, 10];
/// How often a texel is divided at most.
const MOST_DIVISIONS: u32 = 3;

/// A texel of a table of `2^bits` squared ones.
#[derive(Clone, Copy)]
pub(super) struct Texel {
    bits: u32,
    x: u32,
    y: u32,
}

impl Texel {
    pub(super) fn new(bits: u32, number: usize) -> Self {
        let width = 1 << bits;
        Texel {
            bits,
            x: number as u32 % width,
            y: number as u32 / width,
        }
    }

    /// log2 of the texels along a side of the table.
    pub(super) fn bits(self) -> u32 {
        self.bits
    }

    /// Column and row.
    pub(super) fn place(self) -> [u32; 2] {
        [self.x, self.y]
    }

    pub(super) fn child(self, by: u32, i: u32) -> Self {
        Texel {
            bits: self.bits + by,
            x: self.x << by | i & ((1 << by) - 1),
            y: self.y << by | i >> by,
        }
    }

    pub(super) fn corners(self, line: Line) -> Corners {
        weigh::corners(line, self.bits, self.x, self.y)
    }

    pub(super) fn frame(self, line: Line) -> Frame {
        Frame::new(line, self.bits, self.x, self.y)
    }
}

/// A texel with its triangles.
#[derive(Clone, Copy)]
pub(super) struct Listed<'a> {
    pub(super) texel: Texel,
    /// Those that touch the texel.
    pub(super) own: &'a [u32],
    /// Those that serve points outside of all.
    pub(super) more: &'a [u32],
}

impl Listed<'_> {
    pub(super) fn all(&self) -> impl Iterator<Item = u32> {
        self.own.iter().chain(self.more).copied()
    }
}

/// Arranges the texels of a band of a reference's tables; has its workspace.
pub(super) struct Arranger<'a> {
    pub(super) reference: &'a Reference,
    pub(super) line: Line,
    ranked: Ranked<'a>,
    entries: Vec<Masked>,
}

impl<'a> Arranger<'a> {
    pub(super) fn new(reference: &'a Reference) -> Self {
        let line = reference.primary.line();
        Arranger {
            reference,
            line,
            ranked: Ranked::new(reference),
            entries: Vec::new(),
        }
    }

    /// The head of a texel; blocks and children go to `out`. `own`: the triangles that touch the texel; `more`: those that
    /// serve points outside of all.
    pub(super) fn texel(&mut self, texel: Texel, own: &[u32], more: &[u32], out: &mut Band) -> u64 {
        self.arrange(Listed { texel, own, more }, MOST_DIVISIONS, out)
    }

    pub(super) fn arrange(&mut self, listed: Listed<'_>, divisions: u32, out: &mut Band) -> u64 {
        match (listed.own, listed.more) {
            ([], []) => EMPTY,
            ([one], []) | ([], [one]) => out.short(self.reference.format, &[*one]),
            _ => self.several(listed, divisions, out),
        }
    }

    fn several(&mut self, listed: Listed<'_>, divisions: u32, out: &mut Band) -> u64 {
        let Listed { texel, own, more } = listed;
        let crowd = self.largest_layer(own);
        let [sorted, others] = CROWDED;
        if crowd > sorted
            && let Some(divided) = self.divided(crowd, listed, divisions, out)
        {
            return divided;
        }
        self.ranked.rank(texel.bits, texel.place(), own);
        let sortable = more.is_empty() && self.sortable();
        if (others + 1..=sorted).contains(&crowd)
            && !sortable
            && let Some(divided) = self.divided(crowd, listed, divisions, out)
        {
            return divided;
        }
        self.list(listed, sortable, out)
    }

    /// Regions tell triangles apart that lines meet. Points that none meets want the nearest of all: where there may be such
    /// the list is not sorted.
    fn sortable(&mut self) -> bool {
        let order = self.ranked.order();
        let one_layer = self.reference.format.layer_bits == 0
            || order
                .windows(2)
                .all(|w| self.layer(w[0].triangle) == self.layer(w[1].triangle));
        one_layer && self.ranked.cover_all()
    }

    fn layer(&self, triangle: u32) -> u8 {
        self.reference.layer[triangle as usize]
    }

    fn list(&mut self, listed: Listed<'_>, sortable: bool, out: &mut Band) -> u64 {
        let reference = self.reference;
        let near = if listed.more.is_empty() {
            Vec::new()
        } else {
            self.nearest_of_layers(&listed.texel.corners(self.line), listed.more, &[])
        };
        let single = self.ranked.is_single();
        let mut layers = listed.all();
        let first = layers.next().map(|t| self.layer(t));
        let mixed =
            reference.format.layer_bits != 0 && layers.any(|t| Some(self.layer(t)) != first);
        let count = listed.own.len() + near.len();
        if count <= inline(reference.format.id_bits) as usize && single && !mixed {
            let mut entries = [0; MOST_INLINE as usize];
            let own = self.ranked.order().iter().map(|w| w.triangle);
            let all = own.chain(near);
            entries.iter_mut().zip(all).for_each(|(e, t)| *e = t);
            return out.short(reference.format, &entries[..count]);
        }
        self.entries.clear();
        if sortable {
            self.sorted();
        } else {
            self.quartered(listed, mixed);
        }
        let kind = Kind {
            single,
            mixed,
            sorted: sortable,
        };
        out.long(reference.format, &self.entries, kind)
    }

    /// Entries with the regions around the first triangle in which they are to be tested.
    fn sorted(&mut self) {
        let format = self.reference.format;
        for i in 0..self.ranked.order().len() {
            let mask = self.ranked.regions(i);
            let triangle = self.ranked.order()[i].triangle;
            let entry = format.entry(false, triangle, 0);
            self.entries.push(Masked { entry, mask });
        }
    }

    /// Entries with the quadrants in which they are to be tested; the first is tested everywhere.
    fn quartered(&mut self, listed: Listed<'_>, mixed: bool) {
        let own_ids = self.ranked.order().iter().map(|w| w.triangle);
        let all: Vec<u32> = own_ids.chain(listed.more.iter().copied()).collect();
        let mut masks = vec![0u32; all.len()];
        let mut here = Vec::with_capacity(all.len());
        for quadrant in 0..4 {
            let corners = listed.texel.child(1, quadrant).corners(self.line);
            here.clear();
            for (i, mask) in masks[..listed.own.len()].iter_mut().enumerate() {
                if weigh::touches(self.line, &self.ranked.piece(i).at_corners(&corners)) {
                    *mask |= 1 << quadrant;
                    here.push(all[i]);
                }
            }
            for t in self.nearest_of_layers(&corners, &all, &here) {
                let found = all.iter().position(|other| *other == t);
                found.into_iter().for_each(|i| masks[i] |= 1 << quadrant);
            }
        }
        let (reference, format) = (self.reference, self.reference.format);
        let listed = all.iter().zip(masks).filter(|(_, mask)| *mask != 0);
        self.entries.extend(listed.map(|(t, mask)| Masked {
            entry: format.entry(mixed, *t, reference.layer[*t as usize]),
            mask,
        }));
    }

    /// Of each layer among `candidates` that none of `here` has: the triangles nearest to the middle of `corners`.
    pub(super) fn nearest_of_layers(
        &self,
        corners: &Corners,
        candidates: &[u32],
        here: &[u32],
    ) -> Vec<u32> {
        let one_layer = self.reference.format.layer_bits == 0;
        if candidates.is_empty() || one_layer && !here.is_empty() {
            return Vec::new();
        }
        let mut is_here = [false; 256];
        here.iter()
            .for_each(|t| is_here[self.layer(*t) as usize] = true);
        let mut missing: Vec<(u8, u32)> = candidates
            .iter()
            .map(|t| (self.layer(*t), *t))
            .filter(|(layer, _)| !is_here[*layer as usize])
            .collect();
        missing.sort_unstable();
        missing.dedup();
        missing
            .chunk_by(|a, b| a.0 == b.0)
            .flat_map(|of_layer| {
                let triangles = of_layer.iter().map(|(_, t)| *t);
                near::nearest(self.line, corners, triangles, |t| {
                    self.reference.corners(t as usize)
                })
            })
            .collect()
    }

    /// The most triangles of one layer.
    fn largest_layer(&self, list: &[u32]) -> usize {
        if list.len() <= CROWDED[1] || self.reference.format.layer_bits == 0 {
            return list.len();
        }
        let mut counts = [0; 256];
        list.iter()
            .for_each(|t| counts[self.layer(*t) as usize] += 1);
        counts.into_iter().max().unwrap_or(0)
    }
}
