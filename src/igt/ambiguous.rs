//! How much of a mesh is ambiguous under a primary parameterization, and which triangles.

use super::{Layout, Reference, finish};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::param::Primary;

/// Triangles that share a place of T3 with another of their layer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ambiguous {
    /// Their numbers, ascending.
    pub triangles: Vec<u32>,
    /// Their share of the mesh's surface area: at most so much of it is ambiguous.
    pub area_fraction: f64,
}

impl Ambiguous {
    /// Of `mesh` under `primary`; `layer` has one element per triangle.
    ///
    /// # Errors
    /// Those of [`Reference::new`]; [`Error::Capacity`](crate::Error::Capacity) for huge meshes of huge triangles.
    pub fn of(mesh: &Mesh, primary: &Primary, layer: &[u8]) -> Result<Self> {
        let reference = Reference::new(mesh, primary, layer, Layout::Packed)?;
        let triangles = finish::ambiguous(&reference)?;
        let area = |t: u32| {
            let [a, b, c] = mesh.triangles[t as usize]
                .map(|v| glam::Vec3::from(mesh.positions[v as usize]).as_dvec3());
            (b - a).cross(c - a).length()
        };
        let all = (0..mesh.triangles.len() as u32).fold(0.0, |sum, t| sum + area(t));
        let theirs = triangles.iter().fold(0.0, |sum, t| sum + area(*t));
        Ok(Ambiguous {
            triangles,
            area_fraction: if all > 0.0 { theirs / all } else { 0.0 },
        })
    }
}
