//! Where in T3 the triangles of the reference lie: for chords of rims that come to lie beyond the surface.
//!
//! In: the reference. Out: [`Grounds`], which tells whether ground that a chord would add is that of triangles nobody has measured
//! there. Beyond a rim there is nothing, or what another chord left out, or another part, of the same layer or not, either
//! way round: a lookup that finds nothing of its own part would answer with that one's points, of which the bound says nothing.

use super::lists::Lists;
use super::overlay::Overlay;
use super::radial;
use crate::param::PrimaryKind;
use crate::param::fit_domain::{Domain, Piece};
use crate::param::projection::{GridTriangle, Line, orientation};
use rayon::prelude::*;
use smallvec::SmallVec;
use std::ops::RangeInclusive;

/// Cells for each triangle, at most, on average.
const CELLS: f64 = 8.0;

/// The triangles of the reference, by cells of the domain that their images may touch.
pub(super) struct Grounds {
    domain: Domain,
    /// Cells along each side of a sheet.
    side: usize,
    cells: Lists,
}

impl Grounds {
    pub(super) fn new(overlay: &Overlay<'_>, kind: PrimaryKind) -> Self {
        let points: Vec<[f64; 3]> = overlay.t3.iter().map(|p| p.to_array()).collect();
        let domain = Domain::new(kind, &points, 0.0);
        let of = |t: u32| {
            let corners = overlay.triangles[t as usize].map(|v| points[v as usize]);
            let mut pieces: SmallVec<[(Piece, u32); 2]> = SmallVec::new();
            domain.pieces(&corners, |piece| pieces.push((piece, t)));
            pieces
        };
        let triangles = (0..overlay.triangles.len() as u32).into_par_iter();
        let pieces: Vec<(Piece, u32)> = triangles.flat_map_iter(of).collect();
        let side = side(&domain, &pieces, overlay.triangles.len());
        let at = |(piece, t): &(Piece, u32)| {
            let t = *t;
            cells(side, piece).map(move |cell| (cell, t))
        };
        let count = domain.sheets() * side * side;
        Grounds {
            cells: Lists::of(count, pieces.iter().flat_map(at)),
            domain,
            side,
        }
    }

    /// Whether a triangle of T3 shares ground with one of the reference that is not `known`.
    pub(super) fn are_others(
        &self,
        overlay: &Overlay<'_>,
        gained: &GridTriangle,
        known: impl Fn(u32) -> bool,
    ) -> bool {
        let is_other =
            |&t: &u32| overlay.sense[t as usize] != 0 && !known(t) && meet(overlay, gained, t);
        let mut found = false;
        let corners = gained.map(|p| p.map(f64::from));
        self.domain.pieces(&corners, |piece| {
            found = found
                || cells(self.side, &piece).any(|cell| self.cells.get(cell).iter().any(is_other));
        });
        found
    }
}

/// How many cells a side has: about one for two triangles, and fewer where these are long.
fn side(domain: &Domain, pieces: &[(Piece, u32)], triangles: usize) -> usize {
    let extent = |piece: &Piece, k: usize| piece.high[k].min(1.0) - piece.low[k].max(0.0);
    let area = |(piece, _): &(Piece, u32)| extent(piece, 0).max(0.0) * extent(piece, 1).max(0.0);
    let area: f64 = pieces.iter().map(area).sum();
    let mut side = (triangles as f64 / (2 * domain.sheets()) as f64).sqrt();
    while side > 1.0 && area * side * side > CELLS * triangles as f64 {
        side /= 2.0;
    }
    side.max(1.0) as usize
}

/// The cells that a piece may touch.
fn cells(side: usize, piece: &Piece) -> impl Iterator<Item = u32> + Clone + use<> {
    let span = |k: usize| -> RangeInclusive<usize> {
        let cell = |x: f64| ((x * side as f64) as usize).min(side - 1);
        cell(piece.low[k])..=cell(piece.high[k])
    };
    let (columns, first) = (span(0), piece.sheet * side * side);
    span(1).flat_map(move |row| {
        let start = first + row * side;
        columns.clone().map(move |column| (start + column) as u32)
    })
}

/// Whether a triangle shares more than an edge with triangle `t` of the reference.
fn meet(overlay: &Overlay<'_>, a: &GridTriangle, t: u32) -> bool {
    let b = overlay.triangles[t as usize].map(|v| overlay.grid(v));
    match overlay.line {
        Line::Cylinder => radial::overlap(a, &b),
        line => !is_beside(line, a, &b) && !is_beside(line, &b, a),
    }
}

/// Whether an edge of `a` has `a` on one side and all of `b` on the other: edges' images are straight.
fn is_beside(line: Line, a: &GridTriangle, b: &GridTriangle) -> bool {
    let sense = orientation(line, a);
    (0..3).any(|k| {
        let edge = [a[k], a[(k + 1) % 3]];
        let side = |&p: &[i32; 3]| orientation(line, &[edge[0], edge[1], p]) * sense;
        b.iter().all(|p| side(p) <= 0)
    })
}
