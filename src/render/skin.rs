//! Skinned meshes at rest.
//!
//! In: a mesh's joints and weights, a skin, the world matrices of the nodes. Out: positions, normals and tangents in world
//! space (glTF 3.7.3.3: the node that names the mesh has no say).

use crate::mesh::Mesh;
use crate::scene::{Scene, Skin};
use glam::{DMat3, DMat4, DVec3};

/// One matrix for each joint: mesh space at bind time to world space at rest.
pub(crate) fn palette(scene: &Scene, skin: &Skin) -> Vec<DMat4> {
    let world = scene.world_matrices();
    let joint = |(&node, bind): (&usize, &[f32; 16])| {
        world[node] * DMat4::from_cols_array(&bind.map(f64::from))
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

/// Positions as the skin places them.
pub(crate) fn positions(
    palette: &[DMat4],
    at: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
) -> Vec<[f32; 3]> {
    let moved = |(v, p): (usize, &[f32; 3])| match (joints.get(v), weights.get(v)) {
        (Some(&j), Some(&w)) => blend(palette, j, w)
            .transform_point3(DVec3::from_array(p.map(f64::from)))
            .as_vec3()
            .to_array(),
        _ => *p,
    };
    at.iter().enumerate().map(moved).collect()
}

/// The whole mesh as the skin places it.
pub(crate) fn mesh(palette: &[DMat4], mesh: &Mesh) -> Mesh {
    let mut out = mesh.clone();
    out.positions = positions(palette, &mesh.positions, &mesh.joints, &mesh.weights);
    for v in 0..mesh.positions.len() {
        let (Some(&j), Some(&w)) = (mesh.joints.get(v), mesh.weights.get(v)) else {
            continue;
        };
        let linear = DMat3::from_mat4(blend(palette, j, w));
        let turned = |m: DMat3, d: [f32; 3]| {
            (m * DVec3::from_array(d.map(f64::from)))
                .normalize_or(DVec3::Z)
                .as_vec3()
                .to_array()
        };
        let upright = if linear.determinant() == 0.0 {
            linear
        } else {
            linear.inverse().transpose()
        };
        out.normals[v] = turned(upright, mesh.normals[v]);
        if let Some(&[x, y, z, side]) = mesh.tangents.get(v) {
            let [x, y, z] = turned(linear, [x, y, z]);
            out.tangents[v] = [x, y, z, side];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_blend_matrices_and_none_leaves_the_vertex_alone() {
        let palette = [
            DMat4::from_translation(DVec3::X),
            DMat4::from_translation(DVec3::new(0.0, 4.0, 0.0)),
        ];
        let at = [[1.0, 0.0, 0.0]; 3];
        let joints = [[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0]];
        let weights = [[0.5, 0.5, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0], [0.0; 4]];
        let moved = positions(&palette, &at, &joints, &weights);
        assert_eq!(moved, [[1.5, 2.0, 0.0], [1.0, 4.0, 0.0], [1.0, 0.0, 0.0]]);
    }
}
