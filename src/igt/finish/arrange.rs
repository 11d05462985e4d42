//! What becomes of a texel's list in the packed layout: its order, its masks, whether the texel is divided.
//!
//! In: a texel's triangles. Out: [`Arranged`]. The order is that of the share of the texel that each triangle covers: the
//! most likely is tested first. Longer lists say for each other triangle where it is to be tested: in which regions around
//! the first, or in which quadrants of the texel. A texel where many triangles of one layer meet is cut into smaller ones,
//! again and again while that helps, so that no query tests many.
//!
//! Where a texel, or a quadrant, is missed by all triangles of a layer, the nearest few of them serve its points, as in the
//! gutter.

use super::super::Reference;
use super::super::layout::packed::{Kind, Masked, inline};
use super::near;
use super::sides::{Piece, apart, regions};
use super::weigh::{self, Corners};
use crate::param::projection::Line;

/// log2 of the resolution at which the smallest texels lie.
pub(in super::super) const MAX_BITS: u32 = 19;
/// The most triangles of one layer in an undivided texel, if dividing helps: where a sorted list would do, and elsewhere.
const CROWDED: [usize; 2] = [16, 10];
/// A division helps if the parts' lists together are at most this many times as long.
const MOST_COPIES: usize = 3;
/// How often a texel is divided at most.
const MOST_DIVISIONS: u32 = 3;
/// A texel of which so much is covered has hardly a point outside of all triangles.
const FULLY: f64 = 1.0 - 1e-6;
/// Longer lists are not looked at pair by pair: they count as overlapping.
const MOST_PAIRED: usize = 64;

/// A texel's list, ready to be laid out.
#[derive(Debug, PartialEq)]
pub(super) enum Arranged {
    /// No triangle.
    Empty,
    /// Triangles that fit a head, single and of one layer, the most likely first.
    Short(Vec<u32>),
    /// Another list.
    Long {
        /// The entry of the most likely triangle.
        first: u32,
        /// The others, the most likely first.
        rest: Vec<Masked>,
        /// What kind of list.
        kind: Kind,
    },
    /// The texel is cut into `2^by` x `2^by`.
    Divided {
        /// log2 of the parts along a side.
        by: u32,
        /// The parts, row by row.
        children: Vec<Arranged>,
    },
}

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

    /// Column and row.
    pub(super) fn place(self) -> [u32; 2] {
        [self.x, self.y]
    }

    fn child(self, by: u32, i: u32) -> Self {
        Texel {
            bits: self.bits + by,
            x: self.x << by | i & ((1 << by) - 1),
            y: self.y << by | i >> by,
        }
    }

    fn corners(self, line: Line) -> Corners {
        weigh::corners(line, self.bits, self.x, self.y)
    }
}

/// Lists up to this long are put in order one by one.
const SHORT: usize = 8;

/// A triangle of a texel and the share of the texel that it covers.
struct Weighed {
    share: f64,
    triangle: u32,
    piece: Piece,
}

/// Arranges the texels of a reference's tables.
pub(super) struct Arranger<'a> {
    reference: &'a Reference,
    line: Line,
}

impl<'a> Arranger<'a> {
    pub(super) fn new(reference: &'a Reference) -> Self {
        Arranger {
            reference,
            line: reference.primary.line(),
        }
    }

    /// `own`: the triangles that touch the texel; `more`: those that serve points outside of all.
    pub(super) fn texel(&self, texel: Texel, own: &[u32], more: &[u32]) -> Arranged {
        self.arrange(texel, own, more, MOST_DIVISIONS)
    }

    fn arrange(&self, texel: Texel, own: &[u32], more: &[u32], divisions: u32) -> Arranged {
        match own.len() + more.len() {
            0 => Arranged::Empty,
            1 => Arranged::Short(own.iter().chain(more).copied().collect()),
            _ => self.several(texel, own, more, divisions),
        }
    }

    fn several(&self, texel: Texel, own: &[u32], more: &[u32], divisions: u32) -> Arranged {
        let crowd = self.largest_layer(own);
        let [sorted, others] = CROWDED;
        if crowd > sorted
            && let Some(divided) = self.divided(crowd, texel, own, more, divisions)
        {
            return divided;
        }
        let weighed = self.weighed(texel, own);
        if (others + 1..=sorted).contains(&crowd)
            && !self.sortable(&weighed, more)
            && let Some(divided) = self.divided(crowd, texel, own, more, divisions)
        {
            return divided;
        }
        self.list(texel, &weighed, more)
    }

    /// The triangles of a texel, the one that covers most of it first.
    fn weighed(&self, texel: Texel, own: &[u32]) -> Vec<Weighed> {
        let corners = texel.corners(self.line);
        let mut weighed: Vec<Weighed> = own
            .iter()
            .map(|&triangle| {
                let piece = self.piece(triangle);
                let share = weigh::coverage(&piece.at_corners(&corners));
                Weighed {
                    share,
                    triangle,
                    piece,
                }
            })
            .collect();
        // Short, and elements are large: the largest is looked for rather than elements moved about.
        for first in 0..weighed.len().min(SHORT) {
            let before = |a: &Weighed, b: &Weighed| {
                a.share > b.share || a.share == b.share && a.triangle < b.triangle
            };
            let rest = &weighed[first..];
            let best = (1..rest.len()).fold(0, |best, i| {
                if before(&rest[i], &rest[best]) {
                    i
                } else {
                    best
                }
            });
            weighed.swap(first, first + best);
        }
        if let Some(rest) = weighed.get_mut(SHORT..) {
            rest.sort_unstable_by(|a, b| {
                let by_share = b.share.total_cmp(&a.share);
                by_share.then(a.triangle.cmp(&b.triangle))
            });
        }
        weighed
    }

    /// Regions tell triangles apart that lines meet. Points that none meets want the nearest of all: where there may be such
    /// the list is not sorted.
    fn sortable(&self, own: &[Weighed], more: &[u32]) -> bool {
        let covered: f64 = own.iter().map(|w| w.share).sum();
        let one_layer = own
            .windows(2)
            .all(|w| self.layer(w[0].triangle) == self.layer(w[1].triangle));
        more.is_empty() && one_layer && covered > FULLY && own[0].share > 0.0
    }

    fn piece(&self, triangle: u32) -> Piece {
        let vertices = self.reference.triangles[triangle as usize];
        Piece::new(
            self.line,
            vertices,
            self.reference.corners(triangle as usize),
        )
    }

    fn layer(&self, triangle: u32) -> u8 {
        self.reference.layer[triangle as usize]
    }

    fn list(&self, texel: Texel, own: &[Weighed], more: &[u32]) -> Arranged {
        let near = if more.is_empty() {
            Vec::new()
        } else {
            self.nearest_of_layers(&texel.corners(self.line), more, &[])
        };
        let single = self.is_single(own);
        let mut layers = own.iter().map(|w| w.triangle).chain(more.iter().copied());
        let first = layers.next().map(|t| self.layer(t));
        let mixed = layers.any(|t| Some(self.layer(t)) != first);
        let fits = own.len() + near.len() <= inline(self.reference.format.id_bits) as usize;
        if fits && single && !mixed {
            return Arranged::Short(own.iter().map(|w| w.triangle).chain(near).collect());
        }
        let sorted = self.sortable(own, more);
        let mut entries = if sorted {
            self.sorted(own)
        } else {
            self.quartered(texel, own, more, mixed)
        };
        let first = entries.remove(0).entry;
        let kind = Kind {
            single,
            mixed,
            sorted,
        };
        Arranged::Long {
            first,
            rest: entries,
            kind,
        }
    }

    /// Entries with the regions around the first triangle in which they are to be tested.
    fn sorted(&self, own: &[Weighed]) -> Vec<Masked> {
        own.iter()
            .map(|w| Masked {
                entry: self.reference.format.entry(false, w.triangle, 0),
                mask: regions(&own[0].piece, &w.piece),
            })
            .collect()
    }

    /// Entries with the quadrants in which they are to be tested; the first is tested everywhere.
    fn quartered(&self, texel: Texel, own: &[Weighed], more: &[u32], mixed: bool) -> Vec<Masked> {
        let own_ids = own.iter().map(|w| w.triangle);
        let all: Vec<u32> = own_ids.chain(more.iter().copied()).collect();
        let mut masks = vec![0u32; all.len()];
        for quadrant in 0..4 {
            let corners = texel.child(1, quadrant).corners(self.line);
            let mut here = Vec::new();
            for (w, mask) in own.iter().zip(&mut masks) {
                if weigh::touches(self.line, &w.piece.at_corners(&corners)) {
                    *mask |= 1 << quadrant;
                    here.push(w.triangle);
                }
            }
            for t in self.nearest_of_layers(&corners, &all, &here) {
                let found = all.iter().position(|other| *other == t);
                found.into_iter().for_each(|i| masks[i] |= 1 << quadrant);
            }
        }
        let listed = all.iter().zip(masks).filter(|(_, mask)| *mask != 0);
        listed
            .map(|(t, mask)| Masked {
                entry: self.reference.format.entry(mixed, *t, self.layer(*t)),
                mask,
            })
            .collect()
    }

    /// Of each layer among `candidates` that none of `here` has: the triangles nearest to the middle of `corners`.
    fn nearest_of_layers(&self, corners: &Corners, candidates: &[u32], here: &[u32]) -> Vec<u32> {
        if candidates.is_empty() {
            return Vec::new();
        }
        let mut missing: Vec<(u8, u32)> = candidates
            .iter()
            .map(|t| (self.layer(*t), *t))
            .filter(|(layer, _)| here.iter().all(|t| self.layer(*t) != *layer))
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

    /// Whether no two triangles of a layer have a line in common.
    fn is_single(&self, list: &[Weighed]) -> bool {
        let apart = |a: &Weighed, b: &Weighed| {
            self.layer(a.triangle) != self.layer(b.triangle) || apart(&a.piece, &b.piece)
        };
        let pairs_apart = |i: usize| list[..i].iter().all(|other| apart(&list[i], other));
        list.len() <= MOST_PAIRED && (0..list.len()).all(pairs_apart)
    }

    /// The texel cut into parts, where that is worth while.
    fn divided(
        &self,
        crowd: usize,
        texel: Texel,
        own: &[u32],
        more: &[u32],
        left: u32,
    ) -> Option<Arranged> {
        let by = match crowd {
            0..24 => 1,
            24..96 => 2,
            _ => 3,
        };
        let tries: &[u32] = if by == 1 { &[1] } else { &[by, 1] };
        if left == 0 {
            return None;
        }
        tries
            .iter()
            .find_map(|by| self.divided_by(*by, texel, own, more, left))
    }

    fn divided_by(
        &self,
        by: u32,
        texel: Texel,
        own: &[u32],
        more: &[u32],
        left: u32,
    ) -> Option<Arranged> {
        if texel.bits + by > MAX_BITS {
            return None;
        }
        let parts = 1 << (2 * by);
        let corners: Vec<Corners> = (0..parts)
            .map(|i| texel.child(by, i).corners(self.line))
            .collect();
        let mut lists = vec![Vec::new(); parts as usize];
        let mut room = own.len() * MOST_COPIES;
        for t in own {
            let piece = self.piece(*t);
            for (corners, list) in corners.iter().zip(&mut lists) {
                if weigh::touches(self.line, &piece.at_corners(corners)) {
                    room = room.checked_sub(1)?;
                    list.push(*t);
                }
            }
        }
        if lists.iter().any(|list| list.len() == own.len()) && own.len() < 3 * CROWDED[0] {
            // They all meet in one place.
            return None;
        }
        let all: Vec<u32> = own.iter().chain(more).copied().collect();
        let children = (0..parts as usize)
            .map(|i| {
                let more = self.nearest_of_layers(&corners[i], &all, &lists[i]);
                self.arrange(texel.child(by, i as u32), &lists[i], &more, left - 1)
            })
            .collect();
        Some(Arranged::Divided { by, children })
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
