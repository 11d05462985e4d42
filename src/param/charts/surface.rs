//! A mesh as charts see it: welded, measured, with what lies across each edge.
//!
//! In: a mesh. Out: [`Surface`], in a unit where the bounding box's diagonal is 1. Two triangles are neighbours where they
//! are the only two at an edge and are wound alike; everything else (three at an edge, a fold that turns the winding over) is
//! a border, so that whatever comes later deals with oriented manifolds only.

use crate::mesh::{Mesh, NONE};
use crate::param::weld::by_place;
use glam::DVec3;

/// Triangles lower than this share of their longest edge have no direction: rounding of positions decided it.
const SLIVER: f64 = 1e-6;

/// A welded mesh. Half-edge `3 t + k` runs from corner k of triangle t to corner k + 1.
pub(crate) struct Surface {
    /// Where vertices lie; numbers are those of the mesh, welded ones name the first of their class.
    pub(crate) places: Vec<DVec3>,
    /// Welded vertices of each triangle.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// For each half-edge the one across, or [`NONE`].
    pub(crate) across: Vec<u32>,
    /// Area of each triangle; 0 for those that cannot be laid flat.
    pub(crate) areas: Vec<f64>,
    /// Unit normals; 0 for those.
    pub(crate) normals: Vec<DVec3>,
}

impl Surface {
    /// Measures a mesh.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let weld = by_place(&mesh.positions, &mesh.triangles);
        let triangles = weld.triangles(&mesh.triangles);
        let places = unit_places(mesh);
        let corner = |v: u32| places[v as usize];
        let (areas, normals): (Vec<f64>, Vec<DVec3>) =
            triangles.iter().map(|t| measured(t.map(corner))).unzip();
        let across = across(&triangles, &areas);
        Surface {
            places,
            triangles,
            across,
            areas,
            normals,
        }
    }

    /// The triangle across a half-edge.
    pub(crate) fn neighbour(&self, half_edge: usize) -> Option<usize> {
        let other = self.across[half_edge];
        (other != NONE).then_some(other as usize / 3)
    }

    /// Whether a triangle can be laid flat.
    pub(crate) fn usable(&self, t: usize) -> bool {
        self.areas[t] > 0.0
    }

    /// Length of a half-edge.
    pub(crate) fn length(&self, half_edge: usize) -> f64 {
        let t = &self.triangles[half_edge / 3];
        let (a, b) = (t[half_edge % 3], t[(half_edge % 3 + 1) % 3]);
        self.places[a as usize].distance(self.places[b as usize])
    }

    /// Corners of a triangle.
    pub(crate) fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|v| self.places[v as usize])
    }
}

/// Positions about the middle of the box, whose diagonal becomes 1: no product of them leaves the range of numbers.
fn unit_places(mesh: &Mesh) -> Vec<DVec3> {
    let (low, high) = mesh.bounds().unwrap_or_default();
    let [low, high] = [low, high].map(|p| DVec3::from(p.map(f64::from)));
    let diagonal = (high - low).length();
    let scale = if diagonal > 0.0 { 1.0 / diagonal } else { 1.0 };
    let middle = (low + high) * 0.5;
    let place = |p: &[f32; 3]| (DVec3::from(p.map(f64::from)) - middle) * scale;
    mesh.positions.iter().map(place).collect()
}

/// Area and unit normal.
fn measured([a, b, c]: [DVec3; 3]) -> (f64, DVec3) {
    let double = (b - a).cross(c - a);
    let length = double.length();
    let longest = (b - a)
        .length_squared()
        .max((c - b).length_squared())
        .max((a - c).length_squared());
    if length > SLIVER * longest {
        (0.5 * length, double / length)
    } else {
        (0.0, DVec3::ZERO)
    }
}

fn across(triangles: &[[u32; 3]], areas: &[f64]) -> Vec<u32> {
    let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(triangles.len() * 3);
    for (t, corners) in triangles
        .iter()
        .enumerate()
        .filter(|&(t, _)| areas[t] > 0.0)
    {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), (3 * t + k) as u32));
        }
    }
    edges.sort_unstable();
    let mut across = vec![NONE; triangles.len() * 3];
    let start = |half_edge: u32| triangles[half_edge as usize / 3][half_edge as usize % 3];
    for same in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        // Wound alike, the two run along their edge in opposite directions.
        if let [x, y] = same
            && start(x.2) != start(y.2)
        {
            across[x.2 as usize] = y.2;
            across[y.2 as usize] = x.2;
        }
    }
    across
}
