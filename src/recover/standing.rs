//! Meshes as they stand in the world.
//!
//! In: a scene at rest. Out: each instance's mesh with positions, normals and tangents in world space. Where a placing
//! mirrors, triangles are wound the other way, so that fronts stay fronts.

use crate::mesh::Mesh;
use crate::scene::{Deformation, Instance, Pose, Scene};
use crate::{Error, Result};
use glam::{DMat3, DMat4, DVec3};

/// A mesh of a scene where one instance puts it.
pub(crate) struct Standing {
    /// Number of the mesh in its scene.
    pub(crate) number: usize,
    /// The mesh in world space.
    pub(crate) mesh: Mesh,
    /// Object to world.
    pub(crate) world: DMat4,
}

/// All instances at rest.
///
/// # Errors
/// [`Error::Input`] where one leaves the range of floats.
pub(super) fn standing(scene: &Scene) -> Result<Vec<Standing>> {
    let pose = scene.rest();
    let instances = scene.instances_in(&pose);
    instances.iter().map(|i| stand(scene, i, &pose)).collect()
}

/// Each mesh where its first instance stands at rest.
///
/// # Errors
/// As [`standing`].
pub(super) fn standing_first(scene: &Scene) -> Result<Vec<Standing>> {
    let mut taken = vec![false; scene.meshes.len()];
    let mut all = standing(scene)?;
    all.retain(|stood| !std::mem::replace(&mut taken[stood.number], true));
    Ok(all)
}

fn stand(scene: &Scene, instance: &Instance, pose: &Pose) -> Result<Standing> {
    let rest = &scene.meshes[instance.mesh];
    let deformation = Deformation::of(scene, instance, pose);
    let posed = deformation.as_ref().map(|d| d.mesh(rest)).transpose()?;
    let world = deformation
        .as_ref()
        .map_or(instance.world, Deformation::world);
    let mesh = placed(posed.as_ref().unwrap_or(rest), world);
    if mesh.positions.iter().flatten().any(|c| !c.is_finite()) {
        let element = format!("mesh \"{}\"", mesh.name);
        let reason = "does not stand in the range of floats";
        return Err(Error::input(&scene.name, element, reason));
    }
    Ok(Standing {
        number: instance.mesh,
        mesh,
        world,
    })
}

/// `mesh` brought into the world.
pub(super) fn placed(mesh: &Mesh, world: DMat4) -> Mesh {
    let mut out = mesh.clone();
    if world == DMat4::IDENTITY {
        return out;
    }
    let linear = DMat3::from_mat4(world);
    let upright = linear.inverse().transpose();
    let wide = |v: &[f32; 3]| DVec3::from_array(v.map(f64::from));
    for p in &mut out.positions {
        *p = world.transform_point3(wide(p)).as_vec3().to_array();
    }
    for n in &mut out.normals {
        let turned = (upright * wide(n)).normalize_or(DVec3::Y);
        *n = turned.as_vec3().to_array();
    }
    let mirrors = linear.determinant() < 0.0;
    for t in &mut out.tangents {
        let [x, y, z, side] = *t;
        let [x, y, z] = (linear * wide(&[x, y, z]))
            .normalize_or_zero()
            .as_vec3()
            .to_array();
        *t = [x, y, z, if mirrors { -side } else { side }];
    }
    if mirrors {
        out.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn fronts_stay_fronts_when_a_placing_mirrors() {
        let mut ball = shapes::icosphere(1);
        ball.tangents = vec![[1.0, 0.0, 0.0, 1.0]; ball.positions.len()];
        for (scale, side) in [([2.0, 3.0, 1.0], 1.0), ([-2.0, 3.0, 1.0], -1.0)] {
            let world = DMat4::from_scale(DVec3::from_array(scale));
            let stood = placed(&ball, world);
            for t in 0..stood.triangles.len() {
                let [a, b, c] = stood
                    .corners(t)
                    .map(|p| DVec3::from_array(p.map(f64::from)));
                assert!(DVec3::from_array(stood.face_normal(t)).dot(a + b + c) > 0.0);
            }
            assert_eq!(stood.tangents[3][3], side);
            for (p, n) in stood.positions.iter().zip(&stood.normals) {
                let outwards: f32 = (0..3).map(|k| p[k] * n[k]).sum();
                assert!(outwards > 0.0);
            }
        }
    }
}
