//! The reference mesh on the integer grid of T3, as the build reads it.

use super::Layout;
use super::layout::{self, Format, Record};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::param::Primary;
use crate::param::projection::GridTriangle;
use rayon::prelude::*;

/// The reference mesh in T3: vertices rounded once, to what the layout can hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The primary parameterization.
    pub primary: Primary,
    /// The layout the vertices were rounded for.
    pub layout: Layout,
    /// The format that layout takes for this mesh.
    pub format: Format,
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
        let mut t3: Vec<[i32; 3]> = (0..mesh.positions.len())
            .into_par_iter()
            .map(|v| primary.to_grid(primary.t3_of(mesh, v)))
            .collect();
        let flat = layout::is_flat(primary);
        let record = match layout {
            Layout::Classic => Record::Rgb9e5,
            Layout::Packed if flat => Record::Chart,
            Layout::Packed => Record::for_mesh(mesh.triangles.len(), |t| {
                mesh.triangles[t].map(|v| t3[v as usize])
            }),
        };
        let top_layer = layer.iter().copied().max().unwrap_or(0);
        let format = Format::new(layout, record, mesh.triangles.len(), top_layer)?;
        t3.par_iter_mut().for_each(|v| *v = record.round(*v, flat));
        Ok(Reference {
            primary: *primary,
            layout,
            format,
            t3,
            triangles: mesh.triangles.clone(),
            layer: layer.to_vec(),
        })
    }

    /// The grid coordinates of a triangle's vertices.
    pub fn corners(&self, triangle: usize) -> GridTriangle {
        let [a, b, c] = self.triangles[triangle];
        [
            self.t3[a as usize],
            self.t3[b as usize],
            self.t3[c as usize],
        ]
    }
}
