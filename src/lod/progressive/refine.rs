//! Bounds brought close to what is attained: cells that may hide more than a little are asked in parts.
//!
//! In: for each cell the largest deviations at its corners, and how much more there may be between them. Out: bounds that no point
//! exceeds, at most a fiftieth above what is attained at some point. A cell of which that cannot be said yet is made anew
//! from the four parts of its triangle of the reference, whose weights and radii vary half as much.

use super::overlay::{Largest, Squares};
use glam::DVec3;

/// What a bound may be above the largest distance that is attained, as a share of it.
const CLOSE: f64 = 0.02;

/// How often a triangle of the reference is parted.
const DEEP: u8 = 6;

/// So many cells are not parted any more: where lines graze the surface no bound comes close.
const MANY: usize = 400;

/// A corner of a piece of the reference.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Corner {
    /// What is linear on the reference and tells where the corner lies: its place in T3, or its shares in the simplified
    /// triangle.
    pub(super) h: DVec3,
    /// Its place in space.
    pub(super) p: DVec3,
}

/// A triangle of the reference, or a part of one.
pub(super) type Piece = [Corner; 3];

/// What is known of a cell: squares at its corners, and what may be more between them.
pub(super) type Known = (Squares, f64);

/// Cells of one simplified triangle.
#[derive(Debug, Default)]
pub(super) struct Refine {
    attained: Squares,
    /// The root of its total.
    farthest: f64,
    bound: Largest,
    open: Vec<(Piece, Known)>,
}

impl Refine {
    /// Begins with another triangle.
    pub(super) fn clear(&mut self) {
        self.attained = Squares::default();
        self.farthest = 0.0;
        self.bound = Largest::default();
        self.open.clear();
    }

    /// What a cell may have more than its corners.
    pub(super) fn little(&self) -> f64 {
        CLOSE * self.farthest
    }

    /// The largest distance that is attained so far.
    pub(super) fn farthest(&self) -> f64 {
        self.farthest
    }

    /// Likewise, with its parts.
    pub(super) fn attained(&self) -> Largest {
        let mut largest = Largest::default();
        largest.join(&self.attained, 0.0);
        largest
    }

    /// Takes a cell, which is that of a triangle of the reference or of a part of one.
    #[inline]
    pub(super) fn take(&mut self, known: Known, piece: impl FnOnce() -> Piece) {
        self.attain(&known.0);
        match self.is_close(&known) {
            true => self.bound.join(&known.0, known.1),
            false => self.open.push((piece(), known)),
        }
    }

    /// The bounds, once `measure` has told what is known of the cells of pieces; none where a piece is not met. It is told what is
    /// [`Refine::little`].
    pub(super) fn finish(
        &mut self,
        mut measure: impl FnMut(&Piece, f64) -> Option<Known>,
    ) -> Largest {
        for depth in 0..=DEEP {
            let last = depth == DEEP || self.open.len() > MANY;
            for (piece, known) in std::mem::take(&mut self.open) {
                if last || !known.1.is_finite() || self.is_close(&known) {
                    self.bound.join(&known.0, known.1);
                    continue;
                }
                for part in parts(&piece) {
                    if let Some(known) = measure(&part, self.little()) {
                        self.take(known, || part);
                    }
                }
            }
        }
        self.bound.join(&self.attained, 0.0);
        self.bound
    }

    fn attain(&mut self, squares: &Squares) {
        if self.attained.raise(squares) {
            self.farthest = self.attained.total().sqrt();
        }
    }

    /// Whether a cell's bound is no more than a little above what is attained: of the whole vector, and of its parts by as much.
    fn is_close(&self, (squares, more): &Known) -> bool {
        let little = self.little();
        *more <= little || squares.are_below(&self.attained, little - more)
    }
}

/// The four triangles between the corners and the middles of the edges.
fn parts(&[a, b, c]: &Piece) -> [Piece; 4] {
    let middle = |a: Corner, b: Corner| Corner {
        h: (a.h + b.h) * 0.5,
        p: (a.p + b.p) * 0.5,
    };
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}
