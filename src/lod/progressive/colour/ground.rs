//! The reference as colours are looked for on it, and a simplified triangle's plane.
//!
//! Coordinates of a simplified triangle ([`Plane`]) are homogeneous barycentric: of a point of T3 where its projection line
//! meets the triangle's plane, of a point in space its foot on that plane. In them what a triangle of the reference shows is a
//! linear function ([`Rows`]), whatever the lines, but for a cylinder's.

use super::super::overlay::Overlay;
use super::beyond::clamped;
use crate::lod::LodInput;
use crate::mesh::{Adjacency, NONE};
use crate::param::fit_surface::weld;
use crate::param::projection::{Line, orientation};
use crate::param::weld::by_place;
use glam::{DMat3, DVec3};

/// The reference.
pub(super) struct Ground<'a> {
    pub(super) line: Line,
    pub(super) t3: Vec<DVec3>,
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) sense: Vec<i8>,
    /// Across each edge (from corner k to corner k + 1), in T3: none at rims, at seams, and where the surface turns over.
    pub(super) across: Vec<[u32; 3]>,
    /// The same in space, over seams and folds.
    pub(super) beside: Vec<[u32; 3]>,
    /// For each vertex of the surface whether it lies on a rim or seam.
    pub(super) on_rim: Vec<bool>,
}

/// A simplified triangle's plane.
pub(super) struct Plane {
    image: DMat3,
    shift: DVec3,
    foot: DMat3,
    from: DVec3,
}

/// Homogeneous barycentric coordinates in a triangle of the reference: linear in those of a [`Plane`].
pub(super) struct Rows(pub(super) [DVec3; 3]);

/// Where a walk over the reference ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum Walk {
    /// In this triangle.
    Arrived(u32),
    /// At the rim of this triangle, in which what counts has these barycentric coordinates.
    Left(u32, DVec3),
}

/// Steps after which a walk has lost its way among slivers.
const FAR: usize = 20_000;

impl<'a> Ground<'a> {
    pub(super) fn new(input: &LodInput<'a>) -> Self {
        let overlay = Overlay::new(input.mesh, input.primary);
        let (t3, positions, line) = (overlay.t3, overlay.positions, overlay.line);
        let mesh = input.mesh;
        let sense: Vec<i8> = mesh
            .triangles
            .iter()
            .map(|t| orientation(line, &t.map(|v| t3[v as usize].as_ivec3().to_array())) as i8)
            .collect();
        let welded = weld(mesh, input.primary.kind).triangles(&mesh.triangles);
        let mut across = Adjacency::new(&welded).across;
        let mut on_rim = vec![false; t3.len()];
        for (t, across) in across.iter_mut().enumerate() {
            for other in across {
                if *other != NONE && sense[*other as usize] != sense[t] {
                    *other = NONE;
                }
            }
        }
        for (corners, across) in welded.iter().zip(&across) {
            for k in (0..3).filter(|&k| across[k] == NONE) {
                on_rim[corners[k] as usize] = true;
                on_rim[corners[(k + 1) % 3] as usize] = true;
            }
        }
        let places = by_place(&mesh.positions, &mesh.triangles);
        Ground {
            line,
            t3,
            positions,
            triangles: &mesh.triangles,
            sense,
            across,
            on_rim,
            beside: Adjacency::new(&places.triangles(&mesh.triangles)).across,
        }
    }

    pub(super) fn positions(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|v| self.positions[v as usize])
    }

    pub(super) fn t3(&self, t: u32) -> [DVec3; 3] {
        self.triangles[t as usize].map(|v| self.t3[v as usize])
    }

    /// What lies across the edge opposite of corner `j`.
    pub(super) fn opposite(&self, t: u32, j: usize) -> u32 {
        self.across[t as usize][(j + 1) % 3]
    }

    pub(super) fn images(&self, plane: &Plane, t: u32) -> [DVec3; 3] {
        self.t3(t).map(|p| plane.image(p))
    }

    /// Walks from a point of triangle `start` straight to another point of the plane.
    pub(super) fn walk(&self, plane: &Plane, start: u32, from: DVec3, to: DVec3) -> Walk {
        let (mut at, mut before) = (start, NONE);
        for _ in 0..FAR {
            let Some(rows) = Rows::of(self.images(plane, at)) else {
                return Walk::Arrived(at);
            };
            let (begin, end) = (rows.at(from), rows.at(to));
            // The first edge that the way crosses outwards.
            let crossing = |j: usize| {
                let behind = before != NONE && self.opposite(at, j) == before;
                (end[j] < 0.0 && !behind).then(|| (begin[j] / (begin[j] - end[j]), j))
            };
            let first = (0..3)
                .filter_map(crossing)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, j)) = first else {
                return Walk::Arrived(at);
            };
            let next = self.opposite(at, j);
            if next == NONE {
                return Walk::Left(at, clamped(end));
            }
            (before, at) = (at, next);
        }
        Walk::Arrived(at)
    }
}

impl Plane {
    /// None for a triangle without area in space or in T3.
    pub(super) fn new(line: Line, t3: [DVec3; 3], corners: [DVec3; 3]) -> Option<Plane> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let edges = [(b, c), (c, a), (a, b)];
        let share = |(p, q): (DVec3, DVec3)| normal.cross(q - p) / normal.length_squared();
        let rows = edges.map(share);
        let from = DVec3::from([0, 1, 2].map(|k| -rows[k].dot(edges[k].0)));
        let (image, shift) = match line {
            Line::Parallel => {
                let flat = t3.map(|p| p.with_z(1.0));
                let inverse = DMat3::from_cols_array_2d(&flat.map(|p| p.to_array())).inverse();
                (
                    DMat3::from_cols(inverse.x_axis, inverse.y_axis, DVec3::ZERO),
                    inverse.z_axis,
                )
            }
            // Not linear: see `round`.
            Line::Cylinder => (DMat3::IDENTITY, DVec3::ZERO),
            Line::Sphere => (
                DMat3::from_cols_array_2d(&t3.map(|p| p.to_array())).inverse(),
                DVec3::ZERO,
            ),
        };
        let plane = Plane {
            image,
            shift,
            foot: DMat3::from_cols_array_2d(&rows.map(|r| r.to_array())).transpose(),
            from,
        };
        let finite = plane.image.is_finite() && shift.is_finite() && plane.foot.is_finite();
        finite.then_some(plane)
    }

    /// Of a point of T3.
    pub(super) fn image(&self, p: DVec3) -> DVec3 {
        self.image * p + self.shift
    }

    /// Of a point in space; they sum to one.
    pub(super) fn foot(&self, p: DVec3) -> DVec3 {
        self.foot * p + self.from
    }
}

impl Rows {
    /// None for a triangle whose image has no area.
    pub(super) fn of([a, b, c]: [DVec3; 3]) -> Option<Rows> {
        let rows = [b.cross(c), c.cross(a), a.cross(b)];
        let volume = rows[0].dot(a);
        let size = rows[0].length() * a.length();
        (volume > size * 1e-14).then(|| Rows(rows.map(|r| r / volume)))
    }

    pub(super) fn at(&self, p: DVec3) -> DVec3 {
        DVec3::from(self.0.map(|r| r.dot(p)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_of_a_triangle_are_its_own() {
        let corners = [
            DVec3::new(1.0, 0.2, 0.1),
            DVec3::new(0.1, 1.3, 0.0),
            DVec3::new(0.3, -0.1, 1.1),
        ];
        let t3 = corners.map(|p| p * 3.0);
        for line in [Line::Parallel, Line::Sphere] {
            let plane = Plane::new(line, t3, corners).unwrap();
            for k in 0..3 {
                assert!((plane.image(t3[k]) - DVec3::AXES[k]).length() < 1e-12);
                assert!((plane.foot(corners[k]) - DVec3::AXES[k]).length() < 1e-12);
            }
            // Along the normal the foot stays.
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let lifted = plane.foot(corners[0] + normal * 0.7);
            assert!((lifted - DVec3::X).length() < 1e-12);
        }
    }
}
