//! How far a triangle of a simplified surface lies from the reference, point by point of T3: a bound, not a sample.
//!
//! In: a triangle, and the triangles of the reference that its image may meet. Out: [`Deviation`], and which of them it meets.
//!
//! Both triangulations are overlaid along the projection lines. In a cell of the overlay, the part of T3 that one triangle of
//! either shares, each surface is one formula:
//!
//! | lines | reference P, simplified Q over the cell | largest distance |
//! |---|---|---|
//! | parallel | both affine | at a corner of the cell |
//! | sphere | P affine, Q projective: the corners' weights w are rescaled | at a corner, but for what the weights move |
//! | cylinder | on each line, radii r_P and r_Q at one height | at a corner, but for how the radii vary |
//!
//! Corners of cells are vertices of either triangulation inside the other and crossings of edges. What is added to the largest
//! distance there makes it a bound: for the sphere, weights that differ by a factor k move a mean of points no farther than
//! their radius times (k - 1) / 2. Cells are small, and it is of a higher order.
//!
//! Source: Schilling and Klein, Texture-dependent refinement of multiresolution meshes, section 3.2 (and 4.2 for the parts).

use super::near::Near;
use super::projective::{Shares, Sweep};
use super::radial;
use crate::mesh::Mesh;
use crate::param::Primary;
use crate::param::projection::{Line, orientation};
use glam::DVec3;

/// Largest distances between points of a simplified triangle and the points of the reference that they stand for, in
/// object units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Of the whole deviation vector.
    pub total: f32,
    /// Of its part in the plane of the simplified triangle.
    pub tangential: f32,
    /// Of its part along that triangle's normal.
    pub normal: f32,
}

/// The reference as overlays see it.
pub(super) struct Overlay<'a> {
    pub(super) line: Line,
    /// Grid coordinates of its vertices, exact in f64.
    pub(super) t3: Vec<DVec3>,
    pub(super) positions: Vec<DVec3>,
    triangles: &'a [[u32; 3]],
    /// The sense in which lines meet each triangle.
    pub(super) sense: Vec<i8>,
    /// Object units per step of the grid; what is from position only.
    unit: f64,
}

/// A triangle whose deviation is asked: its corners in T3 (grid) and in space, and its sense.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    pub(super) t3: [DVec3; 3],
    pub(super) corners: [DVec3; 3],
    pub(super) sense: i32,
}

/// The largest of what is added up over the cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Largest {
    pub(super) total: f64,
    tangential: f64,
    normal: f64,
}

impl<'a> Overlay<'a> {
    pub(super) fn new(mesh: &'a Mesh, primary: &Primary) -> Self {
        let grid: Vec<[i32; 3]> = (0..mesh.positions.len())
            .map(|v| primary.to_grid(primary.t3_of(mesh, v)))
            .collect();
        let line = primary.line();
        let sense = |t: &[u32; 3]| orientation(line, &t.map(|v| grid[v as usize])) as i8;
        Overlay {
            line,
            sense: mesh.triangles.iter().map(sense).collect(),
            t3: grid.iter().map(|p| DVec3::from(p.map(f64::from))).collect(),
            positions: mesh
                .positions
                .iter()
                .map(|p| DVec3::from(p.map(f64::from)))
                .collect(),
            triangles: &mesh.triangles,
            unit: 1.0 / primary.frame.scale,
        }
    }

    /// Gathers what `covers` name, for [`Overlay::deviation`].
    pub(super) fn gather<'c>(
        &self,
        scratch: &mut Scratch,
        covers: impl Iterator<Item = &'c [u32]> + Clone,
    ) {
        scratch.near.gather(self.triangles, covers);
    }

    /// The deviation of `asked` from what was gathered, which must hold all triangles that its image meets; those that it does
    /// meet are appended to `covers`. Where it is more than `limit`, what is returned is so too, and no more is known.
    pub(super) fn deviation(
        &self,
        asked: &Asked,
        limit: f64,
        Scratch { near, sweep }: &mut Scratch,
        covers: &mut Vec<u32>,
    ) -> Deviation {
        let normal = normal_of(asked.corners);
        sweep
            .largest((self, near), (asked, normal), limit, covers)
            .unwrap_or_else(|| self.round_the_axis(asked, normal, near, covers))
            .rounded_up()
    }

    /// How far a triangle lies from a vertex of the reference, if its image holds that vertex.
    pub(super) fn displaced(&self, v: u32, asked: &Asked) -> Option<f64> {
        let shares = Shares::new(self.line, asked)?;
        let h = shares.of(self.t3[v as usize]);
        let [a, b, c] = asked.corners;
        let there = (a * h.x + b * h.y + c * h.z) / h.element_sum();
        let distance = there.distance(self.positions[v as usize]);
        (h.min_element() >= 0.0).then_some(distance)
    }

    /// Triangles of the reference that lie the other way round are never looked up from here, nor from what comes of it.
    pub(super) fn faces(&self, t: u32, asked: &Asked) -> bool {
        i32::from(self.sense[t as usize]) == asked.sense
    }

    /// For the lines of a cylinder.
    fn round_the_axis(
        &self,
        asked: &Asked,
        normal: DVec3,
        near: &Near,
        covers: &mut Vec<u32>,
    ) -> Largest {
        let mut largest = Largest::default();
        for &t in near.triangles.iter().filter(|&&t| self.faces(t, asked)) {
            let corners = self.triangles[t as usize];
            let t3 = corners.map(|v| self.t3[v as usize]);
            let positions = corners.map(|v| self.positions[v as usize]);
            if let Some(cell) = radial::cell(asked, t3, positions) {
                largest.add_radial(&cell, self.unit, normal);
                covers.push(t);
            }
        }
        largest
    }
}

/// Room for what is found on the way: one for each thread.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    near: Near,
    sweep: Sweep,
}

/// The unit normal of a triangle in space; zero for one without area.
fn normal_of([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

impl Deviation {
    /// Takes one more deviation vector into account, of a triangle with these corners.
    pub(super) fn include(&mut self, vector: DVec3, corners: [DVec3; 3]) {
        let mut one = Largest::default();
        one.join(&Squares::of(vector, normal_of(corners)), 0.0);
        let one = one.rounded_up();
        self.total = self.total.max(one.total);
        self.tangential = self.tangential.max(one.tangential);
        self.normal = self.normal.max(one.normal);
    }
}

impl Largest {
    fn add_radial(&mut self, cell: &radial::Cell, unit: f64, normal: DVec3) {
        let mut at_corners = Squares::default();
        for corner in &cell.corners {
            at_corners.raise(&Squares::of(corner.reference - corner.simplified, normal));
        }
        let bound = cell.bound() * unit;
        self.join(&at_corners, (bound - at_corners.total.sqrt()).max(0.0));
    }

    /// A cell's: what was found at its corners, and how much more may lie between them.
    pub(super) fn join(&mut self, corners: &Squares, more: f64) {
        // Few cells have more than others had: roots are taken of those alone.
        let join = |largest: &mut f64, square: f64| {
            let left = *largest - more;
            if left < 0.0 || square > left * left {
                *largest = largest.max(square.sqrt() + more);
            }
        };
        join(&mut self.total, corners.total);
        join(&mut self.tangential, corners.tangential);
        join(&mut self.normal, corners.normal);
    }

    /// The next floats that are not smaller.
    fn rounded_up(&self) -> Deviation {
        let up = |x: f64| {
            let near = x as f32;
            if f64::from(near) < x {
                near.next_up()
            } else {
                near
            }
        };
        Deviation {
            total: up(self.total),
            tangential: up(self.tangential),
            normal: up(self.normal),
        }
    }
}

/// The largest squares of deviation vectors and of their parts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Squares {
    total: f64,
    tangential: f64,
    normal: f64,
}

impl Squares {
    /// Of one deviation vector, split by the simplified triangle's normal.
    pub(super) fn of(vector: DVec3, normal: DVec3) -> Self {
        let upright = vector.dot(normal);
        Squares {
            total: vector.length_squared(),
            tangential: (vector - normal * upright).length_squared(),
            normal: upright * upright,
        }
    }

    pub(super) fn raise(&mut self, other: &Squares) {
        self.total = self.total.max(other.total);
        self.tangential = self.tangential.max(other.tangential);
        self.normal = self.normal.max(other.normal);
    }
}
