//! The reference of a recovery: all triangles of a scene in the world, and the tree over them.

use super::partner::belongs;
use super::standing::{Standing, standing};
use crate::attribute::arithmetic::weighted;
use crate::mesh::Mesh;
use crate::mesh::bvh::Bvh;
use crate::scene::Scene;
use crate::{Error, Result};

/// The reference: meshes of a scene as they stand, their triangles numbered in one run.
pub(crate) struct High {
    pub(super) meshes: Vec<Standing>,
    /// Number of each mesh's first triangle.
    first: Vec<u32>,
    /// Corners of all triangles.
    pub(crate) corners: Vec<[[f32; 3]; 3]>,
    pub(crate) tree: Bvh,
}

impl High {
    /// The meshes of `scene` that belong to one called `name`, or all.
    ///
    /// # Errors
    /// [`Error::Input`] where there is none with a triangle.
    pub(crate) fn new(scene: &Scene, name: Option<&str>) -> Result<High> {
        let mut meshes = standing(scene)?;
        meshes.retain(|m| name.is_none_or(|name| belongs(&m.mesh.name, name)));
        let (mut corners, mut first) = (Vec::new(), Vec::new());
        for Standing { mesh, .. } in &meshes {
            first.push(corners.len() as u32);
            corners.extend((0..mesh.triangles.len()).map(|t| mesh.corners(t)));
        }
        if corners.is_empty() {
            let (element, reason) = match name {
                Some(name) => (
                    format!("mesh \"{name}\""),
                    "there is no such mesh with a triangle, nor one of that name with _high for _low",
                ),
                None => ("scene".to_owned(), "the reference has no triangles"),
            };
            return Err(Error::input(&scene.name, element, reason));
        }
        let tree = Bvh::new(&corners);
        Ok(High {
            meshes,
            first,
            corners,
            tree,
        })
    }

    /// The mesh that a triangle of the run belongs to, and its number there.
    pub(super) fn mesh_of(&self, triangle: u32) -> (&Mesh, u32) {
        let k = self.first.partition_point(|&f| f <= triangle) - 1;
        (&self.meshes[k].mesh, triangle - self.first[k])
    }

    /// A point of the run's triangle.
    pub(crate) fn point(&self, triangle: u32, b: [f32; 3]) -> [f32; 3] {
        weighted(&self.corners[triangle as usize], b)
    }
}
