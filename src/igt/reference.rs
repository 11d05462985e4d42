//! The reference mesh on the integer grid of T3, as the build reads it.

use super::Layout;
use super::layout;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::param::Primary;
use crate::param::projection::GridTriangle;

/// The largest number of triangles: ids have 31 bits in every table (24 in the classic layout).
const MAX_TRIANGLES: usize = (1 << 31) - 2;

/// The reference mesh in T3: vertices rounded once, to what the layout can hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The primary parameterization.
    pub primary: Primary,
    /// The layout the vertices were rounded for.
    pub layout: Layout,
    /// Vertex-grid coordinates, one per vertex of the mesh.
    pub t3: Vec<[i32; 3]>,
    /// Vertex indices, one triple per triangle of the mesh, degenerate ones included.
    pub triangles: Vec<[u32; 3]>,
    /// The layer of each triangle: parts of the surface that overlap or nearly touch in T3 have different ones.
    pub layer: Vec<u8>,
}

impl Reference {
    /// Brings `mesh` to the grid. `layer` has one element per triangle.
    pub fn new(mesh: &Mesh, primary: &Primary, layer: &[u8], layout: Layout) -> Result<Self> {
        let refuse = |reason: String| Error::Parameterization {
            mesh: mesh.name.clone(),
            reason,
        };
        if mesh.triangles.is_empty() {
            return Err(refuse("it has no triangles".into()));
        }
        if layer.len() != mesh.triangles.len() {
            return Err(refuse(format!(
                "{} layers for {} triangles",
                layer.len(),
                mesh.triangles.len()
            )));
        }
        let most = if layout == Layout::Classic {
            (1 << 24) - 1
        } else {
            MAX_TRIANGLES
        };
        if mesh.triangles.len() > most {
            return Err(Error::Capacity {
                what: format!("triangle ids of the {layout:?} layout").to_lowercase(),
                need: mesh.triangles.len() as u64,
                have: most as u64,
            });
        }
        let t3 = (0..mesh.positions.len())
            .map(|v| layout::round_vertex(layout, primary, primary.to_grid(primary.t3_of(mesh, v))))
            .collect();
        Ok(Reference {
            primary: *primary,
            layout,
            t3,
            triangles: mesh.triangles.clone(),
            layer: layer.to_vec(),
        })
    }

    /// The grid coordinates of a triangle's vertices.
    pub fn corners(&self, triangle: usize) -> GridTriangle {
        self.triangles[triangle].map(|v| self.t3[v as usize])
    }
}
