//! A triangle mesh as flat arrays: what every later stage reads.
//!
//! In: nothing but numbers. Out: [`Mesh`], whose invariants ([`Mesh::validate`]) every stage may rely on: indices in
//! range, arrays of equal length or empty, floats finite.

pub(crate) mod bvh;
mod curvature;
mod embedding;
mod normal;
pub mod shapes;
mod tangent;
mod topology;

pub use curvature::mean_curvature;
pub use embedding::Embedding;
pub(crate) use normal::double_area_vector;
pub use normal::smooth_normals;
pub use tangent::{CornerTangents, tangents};
pub(crate) use topology::Union;
pub use topology::{Adjacency, Components, NONE, Weld, components};

use crate::{Error, Result};

/// One reference mesh: all primitives of a glTF mesh, concatenated in file order.
///
/// Triangle `t` of the mesh is the `t`-th triangle of the file (degenerate ones included), so ids mean the same
/// outside. Per-vertex arrays have one element per vertex or are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The mesh's name in the file, or `mesh_N`.
    pub name: String,
    /// Object-space positions, in the file's unit.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals; always present (computed by area weights where the file has none).
    pub normals: Vec<[f32; 3]>,
    /// Unit tangent and handedness (+1 or -1); empty where there is no uv set.
    pub tangents: Vec<[f32; 4]>,
    /// Artist uv sets TEXCOORD_0.., each with one element per vertex (a primitive that lacks a set gets zeros).
    pub uv_sets: Vec<Vec<[f32; 2]>>,
    /// Linear RGBA COLOR_0; empty where no primitive has one (white where only some have).
    pub colors: Vec<[f32; 4]>,
    /// Skin joints (indices into the skin's joint list); empty for unskinned meshes.
    pub joints: Vec<[u16; 4]>,
    /// Skin weights; empty for unskinned meshes.
    pub weights: Vec<[f32; 4]>,
    /// Vertex indices, three per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle its material (index into the scene's materials).
    pub triangle_material: Vec<u32>,
    /// Shapes to morph towards.
    pub targets: Vec<MorphTarget>,
    /// How far, at rest, one for each of `targets` (0: not at all, 1: all the way).
    pub target_weights: Vec<f32>,
    /// What else the file says of its vertices, by name.
    pub custom: Vec<CustomAttribute>,
    /// Places in T3, where a primary parameterization computed them; the mesh is cut open for it.
    pub embedding: Embedding,
}

/// A vertex attribute that means something to its author alone: one of glTF's names that begin with an underscore.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CustomAttribute {
    /// Its name in the file, with the underscore.
    pub name: String,
    /// Numbers of a vertex, 1 to 4.
    pub width: usize,
    /// `width` numbers for each vertex; integers as they are, or in 0..1 where the file says that they are normalized.
    pub values: Vec<f32>,
}

/// A shape that a mesh can morph towards: what to add to each vertex at weight 1. Arrays have one element per vertex or
/// are empty (nothing is added).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// To positions.
    pub positions: Vec<[f32; 3]>,
    /// To normals.
    pub normals: Vec<[f32; 3]>,
    /// To the directions of tangents.
    pub tangents: Vec<[f32; 3]>,
}

impl MorphTarget {
    /// The arrays and their names.
    pub(crate) fn arrays(&self) -> [(&'static str, &Vec<[f32; 3]>); 3] {
        [
            ("positions", &self.positions),
            ("normals", &self.normals),
            ("tangents", &self.tangents),
        ]
    }
}

impl Mesh {
    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Positions of the three corners of triangle `t`.
    pub fn corners(&self, t: usize) -> [[f32; 3]; 3] {
        self.triangles[t].map(|v| self.positions[v as usize])
    }

    /// Smallest and largest coordinates of all vertices; `None` for an empty mesh.
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        let first = *self.positions.first()?;
        Some(
            self.positions
                .iter()
                .fold((first, first), |(low, high), p| {
                    (
                        std::array::from_fn(|k| low[k].min(p[k])),
                        std::array::from_fn(|k| high[k].max(p[k])),
                    )
                }),
        )
    }

    /// Checks every invariant that later stages rely on.
    ///
    /// # Errors
    /// [`Error::Input`] naming the mesh, the array and the element: an array whose length is not the number of
    /// vertices (or of triangles), an index past the vertices, a float that is not finite.
    pub fn validate(&self) -> Result<()> {
        let vertices = self.positions.len();
        self.length("normals", self.normals.len(), vertices, false)?;
        self.length("tangents", self.tangents.len(), vertices, true)?;
        self.length("colors", self.colors.len(), vertices, true)?;
        self.length("joints", self.joints.len(), vertices, true)?;
        self.length("weights", self.weights.len(), vertices, true)?;
        self.length(
            "triangle_material",
            self.triangle_material.len(),
            self.triangles.len(),
            false,
        )?;
        if self.joints.len() != self.weights.len() {
            return Err(self.fault("joints".into(), "joints and weights come together".into()));
        }
        self.length(
            "target_weights",
            self.target_weights.len(),
            self.targets.len(),
            false,
        )?;
        for (k, target) in self.targets.iter().enumerate() {
            for (what, values) in target.arrays() {
                let name = format!("targets[{k}].{what}");
                self.length(&name, values.len(), vertices, true)?;
                self.finite(&name, values)?;
            }
        }
        for custom in &self.custom {
            let want = vertices * custom.width;
            self.length(&custom.name, custom.values.len(), want, false)?;
            self.finite(&custom.name, custom.values.as_chunks::<1>().0)?;
        }
        self.finite("positions", &self.positions)?;
        self.finite("normals", &self.normals)?;
        self.finite("tangents", &self.tangents)?;
        self.finite("colors", &self.colors)?;
        self.finite("weights", &self.weights)?;
        for (set, uv) in self.uv_sets.iter().enumerate() {
            let name = format!("uv_sets[{set}]");
            self.length(&name, uv.len(), vertices, false)?;
            self.finite(&name, uv)?;
        }
        for (t, triangle) in self.triangles.iter().enumerate() {
            if let Some(v) = triangle.iter().find(|&&v| v as usize >= vertices) {
                let reason = format!("vertex {v} does not exist ({vertices} vertices)");
                return Err(self.fault(format!("triangles[{t}]"), reason));
            }
        }
        Ok(())
    }

    fn fault(&self, element: String, reason: String) -> Error {
        Error::input(format!("mesh \"{}\"", self.name), element, reason)
    }

    fn length(&self, what: &str, have: usize, want: usize, may_be_empty: bool) -> Result<()> {
        if have == want || (may_be_empty && have == 0) {
            return Ok(());
        }
        Err(self.fault(
            what.into(),
            format!("{have} elements where {want} are needed"),
        ))
    }

    fn finite<const N: usize>(&self, what: &str, values: &[[f32; N]]) -> Result<()> {
        match values.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
            Some(i) => Err(self.fault(format!("{what}[{i}]"), "is not finite".into())),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_is_valid() {
        for mesh in shapes::all() {
            mesh.validate().unwrap();
            assert_eq!(mesh.uv_sets.len(), 1, "{}", mesh.name);
        }
    }

    #[test]
    fn an_empty_mesh_is_valid_and_has_no_bounds() {
        Mesh::default().validate().unwrap();
        assert!(Mesh::default().bounds().is_none());
    }

    /// Each fault alone must be found, with the element in the message.
    #[test]
    fn every_fault_is_named() {
        type Spoil = fn(&mut Mesh);
        let faults: [(Spoil, &str); 10] = [
            (|m| m.triangles[1][2] = 4, "triangles[1]"),
            (|m| m.positions[3][1] = f32::NAN, "positions[3]"),
            (|m| m.uv_sets[0][2][0] = f32::INFINITY, "uv_sets[0][2]"),
            (|m| m.normals.truncate(3), "normals"),
            (|m| m.colors = vec![[1.0; 4]; 3], "colors"),
            (|m| m.joints = vec![[0; 4]; 4], "joints"),
            (|m| m.triangle_material.clear(), "triangle_material"),
            (|m| m.target_weights.push(1.0), "target_weights"),
            (
                |m| {
                    m.custom.push(CustomAttribute {
                        name: "_HEAT".into(),
                        width: 2,
                        values: vec![0.5; 7],
                    });
                },
                "_HEAT",
            ),
            (
                |m| {
                    m.target_weights.push(1.0);
                    m.targets.push(MorphTarget {
                        normals: vec![[0.0; 3]; 5],
                        ..MorphTarget::default()
                    });
                },
                "targets[0].normals",
            ),
        ];
        for (spoil, element) in faults {
            let mut mesh = shapes::tetrahedron();
            spoil(&mut mesh);
            let message = mesh.validate().unwrap_err().to_string();
            assert!(message.contains(element), "{message}");
        }
    }
}
