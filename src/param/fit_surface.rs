//! How each triangle lies to its projection lines: the raw material of a fit.
//!
//! In: a mesh, a kind of primary, its origin. Out: [`Surface`]: T3 corners, surface areas, and for each triangle the
//! *facing*: the cosine between its normal and its projection line, signed; negative means turned (the line meets
//! the back), 0 means that the triangle's image has no area.

use super::fit_centre::{HalfSpace, cross, dot, sub};
use super::projection::Line;
use super::weld::by_place;
use super::{Frame, Primary, PrimaryKind};
use crate::mesh::{Components, Mesh, Weld, components};

/// A triangle whose normal is closer to the cylinder's axis than acos of this faces an end: the side projection says
/// nothing about it, and it is left out of the share that is turned.
const END_FACING: f64 = 0.9;
/// Cosines below this are rounding: the triangle's image is a line.
const EDGE_ON: f64 = 1e-7;

/// A mesh seen through one kind of primary.
pub(crate) struct Surface {
    /// What kind.
    pub(crate) kind: PrimaryKind,
    /// The origin, in T3 coordinates.
    pub(crate) origin: [f64; 3],
    /// T3 coordinates of every vertex, relative to the origin.
    pub(crate) points: Vec<[f64; 3]>,
    /// Area in object space per triangle; 0 for degenerate ones.
    pub(crate) areas: Vec<f64>,
    /// Sum of `areas`.
    pub(crate) area: f64,
    /// Signed facing per triangle; 0 where the image has no area.
    pub(crate) facing: Vec<f64>,
    /// Per triangle: false for those that face an end of the cylinder.
    pub(crate) counted: Vec<bool>,
    /// Connected part per triangle: charts for uv sets, welded components otherwise.
    pub(crate) part: Vec<u32>,
    /// Number of parts.
    pub(crate) parts: usize,
}

/// T3 coordinates of all vertices.
pub(crate) fn t3_points(mesh: &Mesh, kind: PrimaryKind) -> Vec<[f64; 3]> {
    let identity = Primary {
        kind,
        frame: Frame {
            origin: [0.0; 3],
            scale: 1.0,
        },
    };
    (0..mesh.positions.len())
        .map(|v| identity.t3_of(mesh, v))
        .collect()
}

/// Vertices that are one under a kind of primary: by position and uv for a uv set, by place otherwise.
pub(crate) fn weld(mesh: &Mesh, kind: PrimaryKind) -> Weld {
    match kind {
        PrimaryKind::UvSet(set) => Weld::by_position_and_uv(mesh, set as usize),
        PrimaryKind::Computed(_) => {
            let place = by_place(&mesh.positions, &mesh.triangles);
            let t3 = &mesh.embedding.t3;
            Weld::by_key(
                place
                    .of
                    .iter()
                    .zip(t3)
                    .map(|(p, t3)| (*p, t3.map(f32::to_bits))),
            )
        }
        _ => by_place(&mesh.positions, &mesh.triangles),
    }
}

/// Parts of a mesh under a kind of primary: triangles that share a welded vertex.
pub(crate) fn parts_of(mesh: &Mesh, kind: PrimaryKind) -> Components {
    components(
        &weld(mesh, kind).triangles(&mesh.triangles),
        mesh.positions.len(),
    )
}

impl Surface {
    /// Measures `mesh` with the origin at zero; `parts` are those of [`parts_of`].
    pub(crate) fn new(mesh: &Mesh, kind: PrimaryKind, parts: Components) -> Self {
        let areas: Vec<f64> = (0..mesh.triangles.len())
            .map(|t| 0.5 * length(normal_of(mesh, t)))
            .collect();
        let mut surface = Surface {
            kind,
            origin: [0.0; 3],
            points: t3_points(mesh, kind),
            area: areas.iter().sum(),
            facing: vec![0.0; areas.len()],
            counted: vec![true; areas.len()],
            areas,
            part: parts.of,
            parts: parts.count,
        };
        surface.face(mesh);
        surface
    }

    /// Moves the origin to `origin` (T3) and measures the facings again.
    pub(crate) fn set_origin(&mut self, mesh: &Mesh, origin: [f64; 3]) {
        self.points = t3_points(mesh, self.kind)
            .into_iter()
            .map(|p| sub(p, origin))
            .collect();
        self.origin = origin;
        self.face(mesh);
    }

    /// T3 corners of triangle `t`, relative to the origin.
    pub(crate) fn corners(&self, mesh: &Mesh, t: usize) -> [[f64; 3]; 3] {
        mesh.triangles[t].map(|v| self.points[v as usize])
    }

    fn face(&mut self, mesh: &Mesh) {
        let facings: Vec<(f64, bool)> = (0..mesh.triangles.len())
            .map(|t| {
                let corners = self.corners(mesh, t);
                let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
                facing(self.kind, normal, &corners)
            })
            .collect();
        (self.facing, self.counted) = facings.into_iter().unzip();
        if self.kind.has_charts() {
            self.face_by_chart(mesh);
        } else if self.sum(|t| self.facing[t]) < 0.0 {
            // Which way is out is the majority's choice: a mesh may be wound inside out.
            self.facing.iter_mut().for_each(|f| *f = -*f);
        }
    }

    /// Each chart has its own way round: mirrored charts are as good as others.
    fn face_by_chart(&mut self, mesh: &Mesh) {
        let mut sums = vec![0.0; self.parts];
        for t in 0..self.facing.len() {
            sums[self.part[t] as usize] += self.uv_area(mesh, t);
        }
        for t in 0..self.facing.len() {
            if sums[self.part[t] as usize] < 0.0 {
                self.facing[t] = -self.facing[t];
            }
        }
    }

    /// Signed uv area of a triangle.
    pub(crate) fn uv_area(&self, mesh: &Mesh, t: usize) -> f64 {
        let [a, b, c] = self.corners(mesh, t);
        0.5 * cross(sub(b, a), sub(c, a))[2]
    }

    /// Area-weighted sum over the triangles.
    pub(crate) fn sum(&self, value: impl Fn(usize) -> f64) -> f64 {
        self.areas
            .iter()
            .enumerate()
            .map(|(t, area)| area * value(t))
            .sum()
    }

    /// The half-spaces from which each counted triangle is seen from inside, for the search of a centre or an axis.
    /// Facings must have been measured from a point inside, so that "out" is known.
    pub(crate) fn half_spaces(&self, mesh: &Mesh) -> Vec<HalfSpace> {
        let mut spaces = Vec::with_capacity(self.areas.len());
        let mut balance = 0.0;
        for (t, &area) in self
            .areas
            .iter()
            .enumerate()
            .filter(|&(t, &area)| area > 0.0 && self.counted[t])
        {
            let corners = self.corners(mesh, t);
            let mut normal = unit(cross(
                sub(corners[1], corners[0]),
                sub(corners[2], corners[0]),
            ));
            if self.kind.line() == Line::Cylinder {
                normal[2] = 0.0;
            }
            let middle: [f64; 3] =
                std::array::from_fn(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0);
            let offset = dot(normal, middle);
            balance += area * offset;
            spaces.push(HalfSpace {
                normal,
                offset,
                weight: area / self.area,
            });
        }
        if balance < 0.0 {
            for s in &mut spaces {
                (s.normal, s.offset) = (s.normal.map(|x| -x), -s.offset);
            }
        }
        spaces
    }

    /// Area-weighted mean of the surface, in T3 relative to the origin.
    pub(crate) fn centroid(&self, mesh: &Mesh) -> [f64; 3] {
        if self.area <= 0.0 {
            return [0.0; 3];
        }
        std::array::from_fn(|k| {
            self.sum(|t| self.corners(mesh, t).iter().map(|p| p[k]).sum::<f64>() / 3.0) / self.area
        })
    }
}

/// Signed facing of a triangle given in T3 relative to the origin (0 where it faces an end of the cylinder), and the same
/// times twice its area in T3: the sum of these over a mesh says which way is out.
pub(crate) fn t3_facing(kind: PrimaryKind, corners: &[[f64; 3]; 3]) -> (f64, f64) {
    let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
    let (cosine, counted) = facing(kind, normal, corners);
    (if counted { cosine } else { 0.0 }, cosine * length(normal))
}

/// Signed facing (see the file's head), and whether the triangle counts as turned or not.
fn facing(kind: PrimaryKind, normal: [f64; 3], corners: &[[f64; 3]; 3]) -> (f64, bool) {
    let n = length(normal);
    if n == 0.0 || !n.is_finite() {
        return (0.0, true);
    }
    let middle: [f64; 3] = std::array::from_fn(|k| corners[0][k] + corners[1][k] + corners[2][k]);
    let (line, counted) = match kind.line() {
        Line::Parallel => ([0.0, 0.0, 1.0], true),
        Line::Cylinder => (
            [middle[0], middle[1], 0.0],
            normal[2].abs() <= END_FACING * n,
        ),
        Line::Sphere => (middle, true),
    };
    let l = length(line);
    let cosine = if l > 0.0 {
        dot(normal, line) / (n * l)
    } else {
        0.0
    };
    (if cosine.abs() < EDGE_ON { 0.0 } else { cosine }, counted)
}

/// Twice the area vector of a triangle in object space.
fn normal_of(mesh: &Mesh, t: usize) -> [f64; 3] {
    let [a, b, c] = mesh.corners(t).map(|p| p.map(f64::from));
    cross(sub(b, a), sub(c, a))
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let l = length(a);
    a.map(|x| x / l)
}
