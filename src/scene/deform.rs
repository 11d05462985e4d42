//! Meshes as a pose has them.
//!
//! In: arrays at rest, a skin's joints where they stand, weights of morph targets. Out: positions, normals and tangents.
//!
//! ```text
//! rest --morph: + weight * target--> shape --skin: blend of joint matrices (glTF 3.7.3.3)--> world
//! ```

use super::{Instance, Pose, Scene, Skin};
use crate::mesh::{Mesh, MorphTarget};
use crate::{Error, Result};
use glam::{DMat3, DMat4, DVec3};

/// What moves one instance of a mesh.
pub(crate) struct Deformation<'a> {
    /// Of a skinned mesh, one matrix for each joint: mesh space at bind time to the world.
    pub(crate) palette: Option<Vec<DMat4>>,
    /// Of the morph targets.
    pub(crate) weights: &'a [f64],
    /// Object to world of a mesh without skin.
    pub(crate) world: DMat4,
}

/// What is moved: arrays of a mesh or of a LoD.
#[derive(Clone, Copy)]
pub(crate) struct Rest<'a> {
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) normals: &'a [[f32; 3]],
    pub(crate) joints: &'a [[u16; 4]],
    pub(crate) weights: &'a [[f32; 4]],
    pub(crate) targets: &'a [MorphTarget],
}

impl<'a> From<&'a Mesh> for Rest<'a> {
    fn from(mesh: &'a Mesh) -> Self {
        Rest {
            positions: &mesh.positions,
            normals: &mesh.normals,
            joints: &mesh.joints,
            weights: &mesh.weights,
            targets: &mesh.targets,
        }
    }
}

impl Scene {
    /// The mesh of `instance` as `pose` has it, in the world for a skinned mesh and in its node's space for any other.
    ///
    /// # Errors
    /// [`Error::Input`] where the pose moves a vertex out of the range of floats.
    pub fn posed_mesh(&self, instance: &Instance, pose: &Pose) -> Result<Mesh> {
        let mesh = &self.meshes[instance.mesh];
        match Deformation::of(self, instance, pose) {
            Some(deformation) => deformation.mesh(mesh),
            None => Ok(mesh.clone()),
        }
    }
}

impl<'a> Deformation<'a> {
    /// None for a mesh that has neither skin nor morph targets: its node's transform is all that moves it.
    pub(crate) fn of(scene: &Scene, instance: &Instance, pose: &'a Pose) -> Option<Self> {
        let mesh = &scene.meshes[instance.mesh];
        let skin = instance.skin.filter(|_| !mesh.joints.is_empty());
        if skin.is_none() && mesh.targets.is_empty() {
            return None;
        }
        Some(Deformation {
            palette: skin.map(|skin| palette(&scene.skins[skin], pose)),
            weights: &pose.weights[instance.node],
            world: instance.world,
        })
    }

    /// What the deformed positions are still to be placed by: nothing, for a skinned mesh (glTF 3.7.3.3: the node that
    /// names the mesh has no say).
    pub(crate) fn world(&self) -> DMat4 {
        if self.palette.is_some() {
            DMat4::IDENTITY
        } else {
            self.world
        }
    }

    /// Deformed positions.
    ///
    /// # Errors
    /// [`Error::Input`] where one leaves the range of floats.
    pub(crate) fn positions(&self, name: &str, rest: Rest) -> Result<Vec<[f32; 3]>> {
        let moved = |v: usize| {
            let p = self.morphed(rest, v, rest.positions, |t| &t.positions);
            self.skin(rest, v).transform_point3(p).as_vec3().to_array()
        };
        let out: Vec<[f32; 3]> = (0..rest.positions.len()).map(moved).collect();
        match out.iter().flatten().all(|c| c.is_finite()) {
            true => Ok(out),
            false => {
                let reason = "its pose leaves the range of floats";
                Err(Error::input("scene", format!("mesh \"{name}\""), reason))
            }
        }
    }

    /// A whole reference, with normals and tangents turned vertex by vertex as glTF says.
    pub(crate) fn mesh(&self, mesh: &Mesh) -> Result<Mesh> {
        let rest = Rest::from(mesh);
        let mut out = mesh.clone();
        out.positions = self.positions(&mesh.name, rest)?;
        let unit = |d: DVec3| d.normalize_or(DVec3::Z).as_vec3().to_array();
        for v in 0..mesh.positions.len() {
            let linear = DMat3::from_mat4(self.skin(rest, v));
            let upright = if linear.determinant() == 0.0 {
                linear
            } else {
                linear.inverse().transpose()
            };
            out.normals[v] = unit(upright * self.normal(rest, v));
            if let Some(&[x, y, z, side]) = mesh.tangents.get(v) {
                let rest_tangent = DVec3::new(x.into(), y.into(), z.into());
                let tangent = rest_tangent + self.way(rest, v, |t| &t.tangents);
                let [x, y, z] = unit(linear * tangent);
                out.tangents[v] = [x, y, z, side];
            }
        }
        Ok(out)
    }

    /// -1 where the skin turns most of the surface inside out, else 1.
    pub(crate) fn handed(&self, rest: Rest) -> f32 {
        let side = |v: usize| self.skin(rest, v).determinant().signum();
        let sides: f64 = (0..rest.positions.len()).map(side).sum();
        if sides < 0.0 { -1.0 } else { 1.0 }
    }

    /// The blend of joint matrices that moves vertex `v`; the identity without skin and where no weight is positive.
    pub(crate) fn skin(&self, rest: Rest, v: usize) -> DMat4 {
        match (&self.palette, rest.joints.get(v), rest.weights.get(v)) {
            (Some(palette), Some(&joints), Some(&weights)) => blend(palette, joints, weights),
            _ => DMat4::IDENTITY,
        }
    }

    /// What the targets add to vertex `v`.
    pub(crate) fn way(
        &self,
        rest: Rest,
        v: usize,
        of: fn(&MorphTarget) -> &Vec<[f32; 3]>,
    ) -> DVec3 {
        let moving = rest.targets.iter().zip(self.weights);
        moving.fold(DVec3::ZERO, |sum, (target, &weight)| {
            let way = of(target).get(v).filter(|_| weight != 0.0);
            way.map_or(sum, |way| sum + DVec3::from(way.map(f64::from)) * weight)
        })
    }

    fn morphed(
        &self,
        rest: Rest,
        v: usize,
        from: &[[f32; 3]],
        of: fn(&MorphTarget) -> &Vec<[f32; 3]>,
    ) -> DVec3 {
        DVec3::from(from[v].map(f64::from)) + self.way(rest, v, of)
    }

    /// The morphed normal of vertex `v`, before the skin turns it; of unit length.
    pub(crate) fn normal(&self, rest: Rest, v: usize) -> DVec3 {
        let at_rest = DVec3::from(rest.normals[v].map(f64::from));
        let morphed = self.morphed(rest, v, rest.normals, |t| &t.normals);
        morphed.normalize_or(at_rest)
    }
}

/// One matrix for each joint: mesh space at bind time to world space.
fn palette(skin: &Skin, pose: &Pose) -> Vec<DMat4> {
    let joint = |(&node, bind): (&usize, &[f32; 16])| {
        pose.world[node] * DMat4::from_cols_array(&bind.map(f64::from))
    };
    skin.joints
        .iter()
        .zip(&skin.inverse_bind)
        .map(joint)
        .collect()
}

/// The blend of joint matrices that moves a vertex; the identity where no weight is positive.
fn blend(palette: &[DMat4], joints: [u16; 4], weights: [f32; 4]) -> DMat4 {
    let mut sum = DMat4::ZERO;
    let mut total = 0.0;
    for k in 0..4 {
        let weight = f64::from(weights[k]);
        if let Some(matrix) = palette.get(usize::from(joints[k])).filter(|_| weight > 0.0) {
            sum += *matrix * weight;
            total += weight;
        }
    }
    if total > 0.0 {
        sum * (1.0 / total)
    } else {
        DMat4::IDENTITY
    }
}

/// Small deformations for tests of this and of [`crate::render`].
#[cfg(test)]
pub(crate) mod samples {
    use super::*;

    pub(crate) fn rest<'a>(
        positions: &'a [[f32; 3]],
        joints: &'a [[u16; 4]],
        weights: &'a [[f32; 4]],
    ) -> Rest<'a> {
        Rest {
            positions,
            normals: &[[0.0, 0.0, 1.0]; 3],
            joints,
            weights,
            targets: &[],
        }
    }

    pub(crate) fn skinned(palette: Vec<DMat4>) -> Deformation<'static> {
        Deformation {
            palette: Some(palette),
            weights: &[],
            world: DMat4::from_translation(DVec3::splat(1e3)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::samples::{rest, skinned};
    use super::*;

    #[test]
    fn weights_blend_matrices_and_none_leaves_the_vertex_alone() {
        let moving = skinned(vec![
            DMat4::from_translation(DVec3::X),
            DMat4::from_translation(DVec3::new(0.0, 4.0, 0.0)),
        ]);
        let at = [[1.0, 0.0, 0.0]; 3];
        let joints = [[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0]];
        let weights = [[0.5, 0.5, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0], [0.0; 4]];
        let rest = rest(&at, &joints, &weights);
        let moved = moving.positions("m", rest).unwrap();
        assert_eq!(moved, [[1.5, 2.0, 0.0], [1.0, 4.0, 0.0], [1.0, 0.0, 0.0]]);
        assert_eq!(moving.world(), DMat4::IDENTITY, "the node has no say");
        let far = skinned(vec![DMat4::from_scale(DVec3::splat(1e39))]);
        let message = far.positions("m", rest).unwrap_err().to_string();
        assert!(message.contains("range of floats"), "{message}");
    }
}
