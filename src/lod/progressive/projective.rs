//! Cells of an overlay along parallel lines and those of a sphere, where edges' images are straight.
//!
//! In: a simplified triangle, and vertices of the reference. Out: where these lie in the triangle's image, and the corners of what
//! it shares with the image of a triangle of the reference.

use super::overlay::Asked;
use crate::param::projection::Line;
use glam::DVec3;

/// Homogeneous barycentric coordinates in a triangle's image as linear functions of T3: `h_i(p) = n_i . p + c_i`. Their sum is
/// the weight of p: 1 for parallel lines, for the sphere the factor by which the line's point on the triangle's plane is nearer
/// to the centre than p.
pub(super) struct Shares {
    n: [DVec3; 3],
    c: DVec3,
}

/// On which sides of the triangle's edges a point lies: bit i for coordinate i, where it is negative, and where it is not positive.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sides {
    pub(super) beyond: u8,
    pub(super) beside: u8,
}

/// A corner of a cell: homogeneous coordinates in the simplified triangle, and the reference's point.
type Corner = (DVec3, DVec3);

/// Corners of a cell, in order: a triangle cut by three lines has six at most.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell {
    corners: [Corner; 9],
    count: usize,
}

impl Shares {
    /// None for lines for which they are not linear.
    pub(super) fn new(line: Line, asked: &Asked) -> Option<Self> {
        let [a, b, c] = asked.t3;
        let edges = [(b, c), (c, a), (a, b)];
        match line {
            Line::Cylinder => None,
            Line::Parallel => {
                let area = (b - a).cross(c - a).z;
                let n = edges.map(|(p, q)| DVec3::new(p.y - q.y, q.x - p.x, 0.0) / area);
                Some(Shares {
                    n,
                    c: DVec3::from(edges.map(|(p, q)| (p.x * q.y - p.y * q.x) / area)),
                })
            }
            Line::Sphere => {
                let volume = a.cross(b).dot(c);
                Some(Shares {
                    n: edges.map(|(p, q)| p.cross(q) / volume),
                    c: DVec3::ZERO,
                })
            }
        }
    }

    pub(super) fn of(&self, p: DVec3) -> DVec3 {
        let [a, b, c] = self.n;
        DVec3::new(a.dot(p), b.dot(p), c.dot(p)) + self.c
    }
}

impl Sides {
    pub(super) fn of(h: DVec3) -> Self {
        Sides {
            beyond: h.cmplt(DVec3::ZERO).bitmask() as u8,
            beside: h.cmple(DVec3::ZERO).bitmask() as u8,
        }
    }
}

impl Cell {
    /// What the triangle's image shares with that of a reference triangle, whose corners lie beyond the edges of `beyond`.
    pub(super) fn new(h: [DVec3; 3], positions: [DVec3; 3], beyond: u8) -> Self {
        let mut cell = Cell::default();
        (0..3).for_each(|k| cell.push((h[k], positions[k])));
        for i in (0..3).filter(|i| beyond & (1 << i) != 0) {
            cell = cell.cut(i);
        }
        cell
    }

    pub(super) fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    fn push(&mut self, corner: Corner) {
        // Rounding could make a cut polygon less than convex, by a hair: no corner is lost that is not beside another.
        if self.count < self.corners.len() {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// What lies where coordinate `i` is not negative. Source: Sutherland and Hodgman 1974, Reentrant polygon clipping.
    fn cut(&self, i: usize) -> Cell {
        let mut kept = Cell::default();
        let corners = self.corners();
        let Some(&(mut before, mut from)) = corners.last() else {
            return kept;
        };
        for &(h, p) in corners {
            if (h[i] < 0.0) != (before[i] < 0.0) {
                let s = before[i] / (before[i] - h[i]);
                kept.push((before.lerp(h, s), from.lerp(p, s)));
            }
            if h[i] >= 0.0 {
                kept.push((h, p));
            }
            (before, from) = (h, p);
        }
        kept
    }
}
