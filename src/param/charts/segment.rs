//! Nearly flat, compact pieces of a surface: where charts begin.
//!
//! In: a [`Surface`] and how far from flat a piece may be. Out: for each triangle its piece. Neighbours are merged, cheapest
//! first, while the union stays flat enough. A piece's error is the area that its normals lose when they are summed, A - |sum
//! of area times normal|: 0 where all are one, (1 - cos a) / 2 of the area for a cap of half angle a. Long borders cost too,
//! so that pieces are round.
//! Source: the error is the L2,1 metric of Cohen-Steiner, Alliez, Desbrun, Variational Shape Approximation (2004); merging by
//! a heap is the hierarchical face clustering of Garland, Willmott, Heckbert (2001).

use super::surface::Surface;
use crate::mesh::NONE;
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Weight of the border's length, squared, over the area, beside the error.
const ROUND: f64 = 0.002;

/// A piece while it grows.
struct Piece {
    area: f64,
    normal: DVec3,
    perimeter: f64,
    /// Neighbours and the length of the common border; may name pieces that are merged since.
    neighbours: Vec<(u32, f64)>,
    /// Times it has grown; a heap entry of another time is stale.
    stamp: u32,
}

/// A merge that may be done: least cost first, then least numbers.
#[derive(PartialEq)]
struct Merge {
    cost: f64,
    pieces: [u32; 2],
    stamps: [u32; 2],
}

impl Eq for Merge {}

impl Ord for Merge {
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .cost
            .total_cmp(&self.cost)
            .then(other.pieces.cmp(&self.pieces))
    }
}

impl PartialOrd for Merge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// For each triangle its piece, `0..count`, numbered by first triangle; [`NONE`] for those that cannot be laid flat. `bend` is
/// the largest error of a piece as a share of its area.
pub(crate) fn pieces(surface: &Surface, bend: f64) -> (Vec<u32>, usize) {
    let count = surface.triangles.len();
    let mut growing = Growing {
        pieces: (0..count).map(|t| single(surface, t)).collect(),
        parent: (0..count as u32).collect(),
        heap: BinaryHeap::new(),
        bend,
    };
    for t in 0..count as u32 {
        let later: Vec<(u32, f64)> = growing.pieces[t as usize]
            .neighbours
            .iter()
            .copied()
            .filter(|n| n.0 > t)
            .collect();
        later
            .iter()
            .for_each(|&(n, length)| growing.offer(t, n, length));
    }
    growing.grow();
    let mut label = vec![NONE; count];
    let mut labels = 0;
    let of = (0..count)
        .map(|t| {
            if !surface.usable(t) {
                return NONE;
            }
            let slot = &mut label[growing.root(t as u32) as usize];
            if *slot == NONE {
                *slot = labels;
                labels += 1;
            }
            *slot
        })
        .collect();
    (of, labels as usize)
}

fn single(surface: &Surface, t: usize) -> Piece {
    let mut neighbours: Vec<(u32, f64)> = vec![];
    let mut perimeter = 0.0;
    for h in 3 * t..3 * t + 3 {
        let length = surface.length(h);
        perimeter += length;
        if let Some(other) = surface.neighbour(h) {
            match neighbours.iter_mut().find(|(n, _)| *n == other as u32) {
                Some((_, common)) => *common += length,
                None => neighbours.push((other as u32, length)),
            }
        }
    }
    let area = surface.areas[t];
    Piece {
        area,
        normal: surface.normals[t] * area,
        perimeter,
        neighbours,
        stamp: 0,
    }
}

struct Growing {
    pieces: Vec<Piece>,
    parent: Vec<u32>,
    heap: BinaryHeap<Merge>,
    bend: f64,
}

impl Growing {
    fn root(&mut self, mut piece: u32) -> u32 {
        while self.parent[piece as usize] != piece {
            let up = self.parent[self.parent[piece as usize] as usize];
            self.parent[piece as usize] = up;
            piece = up;
        }
        piece
    }

    /// Puts the merge of two pieces with a common border into the heap, if the union is flat enough.
    fn offer(&mut self, a: u32, b: u32, common: f64) {
        let (p, q) = (&self.pieces[a as usize], &self.pieces[b as usize]);
        let area = p.area + q.area;
        let error = area - (p.normal + q.normal).length();
        if error > self.bend * area {
            return;
        }
        let perimeter = p.perimeter + q.perimeter - 2.0 * common;
        // Errors of large pieces count for more: flat regions merge first, and all over the surface at once.
        let cost = error + ROUND * perimeter * perimeter;
        let (a, b) = (a.min(b), a.max(b));
        let stamps = [a, b].map(|piece| self.pieces[piece as usize].stamp);
        self.heap.push(Merge {
            cost,
            pieces: [a, b],
            stamps,
        });
    }

    fn grow(&mut self) {
        while let Some(merge) = self.heap.pop() {
            let current = |k: usize| {
                let piece = merge.pieces[k];
                self.parent[piece as usize] == piece
                    && self.pieces[piece as usize].stamp == merge.stamps[k]
            };
            if current(0) && current(1) {
                let [a, b] = merge.pieces;
                self.merge(a, b);
            }
        }
    }

    /// Merges `b` into `a`, or `a` into `b` where `b` has more neighbours.
    fn merge(&mut self, a: u32, b: u32) {
        let more = |p: u32| self.pieces[p as usize].neighbours.len();
        let (into, from) = if more(b) > more(a) { (b, a) } else { (a, b) };
        self.parent[from as usize] = into;
        let gone = std::mem::replace(
            &mut self.pieces[from as usize],
            Piece {
                area: 0.0,
                normal: DVec3::ZERO,
                perimeter: 0.0,
                neighbours: vec![],
                stamp: 0,
            },
        );
        let kept = std::mem::take(&mut self.pieces[into as usize].neighbours);
        let mut neighbours: Vec<(u32, f64)> = kept
            .into_iter()
            .chain(gone.neighbours)
            .map(|(n, length)| (self.root(n), length))
            .collect();
        neighbours.sort_unstable_by(|x, y| x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)));
        neighbours.dedup_by(|later, first| {
            let same = later.0 == first.0;
            if same {
                first.1 += later.1;
            }
            same
        });
        // The border between the two is listed by both.
        let common: f64 = neighbours
            .iter()
            .filter(|n| n.0 == into)
            .map(|n| 0.5 * n.1)
            .sum();
        neighbours.retain(|n| n.0 != into);
        let piece = &mut self.pieces[into as usize];
        piece.area += gone.area;
        piece.normal += gone.normal;
        piece.perimeter += gone.perimeter - 2.0 * common;
        piece.stamp += 1;
        piece.neighbours = neighbours.clone();
        for (n, length) in neighbours {
            self.offer(into, n, length);
        }
    }
}
