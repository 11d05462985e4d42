//! Where a model's meshes stand, and the poses that its LoDs are made for.
//!
//! In: a scene. Out: the place of each mesh in the world; for a mesh its shapes in poses spread over all of the file's animations; where the file has none, with
//! every joint turned a little about each axis, and with each morph target.

use crate::lod::{MOST_POSES, Shape};
use crate::scene::{Animation, Deformation, Pose, Rest, Scene};
use glam::DVec3;

/// Joints turn by this much where no animation says how, in radians.
const FLEX: f64 = 0.6;

/// Where each mesh first stands in the world, as four columns: what one error budget over all meshes is measured in.
pub(super) fn places(scene: &Scene) -> Vec<[[f32; 4]; 4]> {
    let mut places = vec![glam::Mat4::IDENTITY.to_cols_array_2d(); scene.meshes.len()];
    // A skinned mesh is placed by its joints, not by its node, so it keeps the identity.
    let standing: Vec<_> = scene
        .instances()
        .into_iter()
        .filter(|instance| instance.skin.is_none())
        .collect();
    for instance in standing.into_iter().rev() {
        places[instance.mesh] = instance.world.as_mat4().to_cols_array_2d();
    }
    places
}

/// Positions of a mesh's vertices in up to [`MOST_POSES`] poses; none for a mesh that nothing deforms.
pub(super) fn shapes(scene: &Scene, mesh: usize) -> Vec<Shape> {
    let instances = scene.instances();
    let Some(instance) = instances.iter().find(|instance| instance.mesh == mesh) else {
        return Vec::new();
    };
    if Deformation::of(scene, instance, &scene.rest()).is_none() {
        return Vec::new();
    }
    let shape = |pose: &Pose| {
        let moving = Deformation::of(scene, instance, pose)?;
        let mesh = &scene.meshes[mesh];
        moving.positions(&mesh.name, Rest::from(mesh)).ok()
    };
    poses(scene, instance.node)
        .iter()
        .filter_map(shape)
        .collect()
}

/// A pose that cannot be had (an animation with a fault) is left out: it will be told when it is asked for.
fn poses(scene: &Scene, node: usize) -> Vec<Pose> {
    let moving: Vec<usize> = (0..scene.animations.len())
        .filter(|&a| moves(&scene.animations[a]))
        .collect();
    if moving.is_empty() {
        return flexed(scene, node);
    }
    // Of many animations some, each at its middle; of few each at several moments.
    let taken = moving.len().min(MOST_POSES);
    let pose = |k: usize| {
        let (a, moment) = (k % taken, k / taken);
        let moments = (MOST_POSES - a).div_ceil(taken);
        let animation = moving[a * moving.len() / taken];
        let share = (moment as f64 + 0.5) / moments as f64;
        let time = share * scene.animations[animation].duration();
        scene.pose(animation, time).ok()
    };
    (0..MOST_POSES).filter_map(pose).collect()
}

fn moves(animation: &Animation) -> bool {
    !animation.channels.is_empty()
}

fn flexed(scene: &Scene, node: usize) -> Vec<Pose> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let turned = axes.iter().filter(|_| scene.nodes[node].skin.is_some());
    let mut poses: Vec<Pose> = turned
        .filter_map(|axis| scene.flexed(*axis, FLEX).ok())
        .collect();
    let targets = scene.rest().weights()[node].len();
    for target in 0..targets.min(MOST_POSES - poses.len()) {
        let mut pose = scene.rest();
        pose.weights[node] = vec![0.0; targets];
        pose.weights[node][target] = 1.0;
        poses.push(pose);
    }
    poses
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MorphTarget, shapes as made};
    use crate::scene::{Node, Transform};
    use glam::DMat4;

    #[test]
    fn a_mesh_that_nothing_deforms_has_no_shapes_and_targets_are_each_one() {
        let mut mesh = made::tetrahedron();
        let node = Node {
            name: "n".into(),
            parent: None,
            children: vec![],
            transform: Transform::Matrix(DMat4::IDENTITY),
            mesh: Some(0),
            skin: None,
            weights: vec![],
        };
        let scene = |mesh: &crate::mesh::Mesh| Scene {
            meshes: vec![mesh.clone()],
            nodes: vec![node.clone()],
            roots: vec![0],
            world: vec![DMat4::IDENTITY],
            ..Scene::default()
        };
        assert!(shapes(&scene(&mesh), 0).is_empty());
        mesh.targets = vec![MorphTarget::default(); 2];
        mesh.targets[1].positions = vec![[0.0, 5.0, 0.0]; 4];
        mesh.target_weights = vec![0.5; 2];
        let found = shapes(&scene(&mesh), 0);
        assert_eq!((found.len(), &found[0]), (2, &mesh.positions));
        assert_eq!(found[1][2][1], mesh.positions[2][1] + 5.0);
    }
}
