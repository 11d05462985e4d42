//! Nodes, their world transforms, and the meshes they place.
//!
//! In: the JSON structures. Out: a forest (each node has at most one parent and is not its own ancestor), walked without
//! recursion: chains of any depth are fine. Matrices are double precision.

use super::json::{NodeJson, Root, at};
use crate::{Error, Result};
use glam::{DMat4, DQuat, DVec3};

/// A node of the scene graph.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Its name in the file, or `node_N`.
    pub name: String,
    /// The node above, if any.
    pub parent: Option<usize>,
    /// The nodes below.
    pub children: Vec<usize>,
    /// Relative to the parent.
    pub transform: Transform,
    /// Index into the scene's meshes.
    pub mesh: Option<usize>,
    /// Index into the scene's skins.
    pub skin: Option<usize>,
    /// At rest, one for each morph target of its mesh; empty: the mesh's own.
    pub weights: Vec<f32>,
}

/// A node's transform as the file gives it (animations need the parts).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform {
    /// Column-major.
    Matrix(DMat4),
    /// Scale first, then rotation, then translation.
    Parts {
        /// In units.
        translation: DVec3,
        /// Of unit length.
        rotation: DQuat,
        /// Per axis.
        scale: DVec3,
    },
}

impl Transform {
    /// As one matrix.
    pub fn matrix(&self) -> DMat4 {
        match *self {
            Transform::Matrix(matrix) => matrix,
            Transform::Parts {
                translation,
                rotation,
                scale,
            } => DMat4::from_scale_rotation_translation(scale, rotation, translation),
        }
    }
}

/// A mesh as it stands in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The node that places it.
    pub node: usize,
    /// Index into the scene's meshes.
    pub mesh: usize,
    /// Index into the scene's skins. A skinned mesh is placed by its joints, not by `world` (glTF 3.7.3.3).
    pub skin: Option<usize>,
    /// Object to world.
    pub world: DMat4,
}

impl Instance {
    /// `world` as floats, column-major: `world[column][row]`.
    pub fn world_columns(&self) -> [[f32; 4]; 4] {
        self.world.as_mat4().to_cols_array_2d()
    }
}

/// All nodes of a document, and the roots of its default scene.
pub(super) fn nodes(
    file: &str,
    root: &Root,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Node>, Vec<usize>)> {
    let mut nodes = Vec::with_capacity(root.nodes.len());
    for (i, json) in root.nodes.iter().enumerate() {
        nodes.push(node(file, root, i, json, warnings)?);
    }
    link(file, root, &mut nodes)?;
    let roots = roots(file, root, &nodes)?;
    Ok((nodes, roots))
}

fn node(
    file: &str,
    root: &Root,
    i: usize,
    json: &NodeJson,
    warnings: &mut Vec<String>,
) -> Result<Node> {
    if let Some(mesh) = json.mesh {
        at(file, &root.meshes, "meshes", mesh, || {
            format!("nodes[{i}].mesh")
        })?;
    }
    if let Some(skin) = json.skin {
        at(file, &root.skins, "skins", skin, || {
            format!("nodes[{i}].skin")
        })?;
    }
    Ok(Node {
        name: json.name.clone().unwrap_or_else(|| format!("node_{i}")),
        parent: None,
        children: json.children.clone(),
        transform: transform(file, i, json, warnings)?,
        mesh: json.mesh,
        skin: json.skin,
        weights: weights(file, &json.weights, || format!("nodes[{i}].weights"))?,
    })
}

/// Weights of morph targets, as floats of bounded size.
pub(super) fn weights(
    file: &str,
    weights: &[f64],
    element: impl Fn() -> String,
) -> Result<Vec<f32>> {
    match weights.iter().position(|w| w.abs() > MAX_TRANSFORM) {
        Some(k) => Err(Error::input(
            file,
            element(),
            format!("number {k} is beyond 1e15"),
        )),
        None => Ok(weights.iter().map(|&w| w as f32).collect()),
    }
}

/// Largest number in a transform: far inside of what floats hold, so that products stay finite.
const MAX_TRANSFORM: f64 = 1e15;

fn transform(
    file: &str,
    i: usize,
    json: &NodeJson,
    warnings: &mut Vec<String>,
) -> Result<Transform> {
    let bad = |what: &str, reason: &str| Error::input(file, format!("nodes[{i}].{what}"), reason);
    let fits = |values: &[f64]| values.iter().all(|v| v.abs() <= MAX_TRANSFORM);
    if let Some(matrix) = json.matrix {
        if !fits(&matrix) {
            return Err(bad("matrix", "has a number beyond 1e15"));
        }
        let matrix = DMat4::from_cols_array(&matrix);
        if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
            return Err(bad("matrix", "has a last row that is not 0, 0, 0, 1"));
        }
        let [x, y, z] = [0, 1, 2].map(|k| matrix.col(k).truncate().normalize_or_zero());
        if x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs()) > 1e-3 {
            warnings.push(format!(
                "nodes[{i}].matrix shears, which glTF does not allow: it is used as it is"
            ));
        }
        return Ok(Transform::Matrix(matrix));
    }
    let translation = json.translation.unwrap_or([0.0; 3]);
    let scale = json.scale.unwrap_or([1.0; 3]);
    let rotation = json.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    if !fits(&translation) || !fits(&scale) || !fits(&rotation) {
        return Err(bad("transform", "has a number beyond 1e15"));
    }
    let rotation = DQuat::from_array(rotation);
    if rotation.length_squared() < 1e-12 {
        return Err(bad("rotation", "is zero"));
    }
    Ok(Transform::Parts {
        translation: translation.into(),
        rotation: rotation.normalize(),
        scale: scale.into(),
    })
}

/// Fills in the parents; refuses children that do not exist, second parents and loops.
fn link(file: &str, root: &Root, nodes: &mut [Node]) -> Result<()> {
    for parent in 0..nodes.len() {
        for (k, &child) in root.nodes[parent].children.iter().enumerate() {
            let element = || format!("nodes[{parent}].children[{k}]");
            at(file, &root.nodes, "nodes", child, element)?;
            if nodes[child].parent.is_some() || child == parent {
                let reason = format!("nodes[{child}] has a parent already, or is its own");
                return Err(Error::input(file, element(), reason));
            }
            nodes[child].parent = Some(parent);
        }
    }
    // With one parent each, whatever a walk from the parentless nodes does not reach lies on a loop.
    let reached = order(nodes);
    if reached.len() == nodes.len() {
        return Ok(());
    }
    let mut seen = vec![false; nodes.len()];
    reached.iter().for_each(|&i| seen[i] = true);
    let lost = seen.iter().position(|s| !s).unwrap_or(0);
    Err(Error::input(
        file,
        format!("nodes[{lost}]"),
        "is its own ancestor",
    ))
}

/// Every node after its parent.
pub(super) fn order(nodes: &[Node]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..nodes.len())
        .filter(|&i| nodes[i].parent.is_none())
        .collect();
    let mut next = 0;
    while next < order.len() {
        let node = order[next];
        order.extend(&nodes[node].children);
        next += 1;
    }
    order
}

/// Roots of the default scene; of the first where none is named; all parentless nodes where there is no scene.
fn roots(file: &str, root: &Root, nodes: &[Node]) -> Result<Vec<usize>> {
    if let Some(scene) = root.scene {
        at(file, &root.scenes, "scenes", scene, || "scene".into())?;
    }
    for (s, scene) in root.scenes.iter().enumerate() {
        let mut seen = std::collections::HashSet::new();
        for (k, &node) in scene.nodes.iter().enumerate() {
            let element = || format!("scenes[{s}].nodes[{k}]");
            at(file, &root.nodes, "nodes", node, element)?;
            if nodes[node].parent.is_some() || !seen.insert(node) {
                let reason = format!("nodes[{node}] is not a root, or is named twice");
                return Err(Error::input(file, element(), reason));
            }
        }
    }
    Ok(match root.scenes.get(root.scene.unwrap_or(0)) {
        Some(scene) => scene.nodes.clone(),
        None => (0..nodes.len())
            .filter(|&i| nodes[i].parent.is_none())
            .collect(),
    })
}

/// Object-to-world matrix of every node, each of which `local` places under its parent.
///
/// # Errors
/// [`Error::Input`] where the product of a chain leaves the range of floats.
pub(super) fn world_matrices(
    file: &str,
    nodes: &[Node],
    local: impl Fn(usize) -> DMat4,
) -> Result<Vec<DMat4>> {
    let mut world = vec![DMat4::IDENTITY; nodes.len()];
    for i in order(nodes) {
        let above = nodes[i]
            .parent
            .map_or(DMat4::IDENTITY, |parent| world[parent]);
        world[i] = above * local(i);
        if !world[i]
            .to_cols_array()
            .iter()
            .all(|v| v.abs() <= MAX_TRANSFORM)
        {
            return Err(Error::input(
                file,
                format!("nodes[{i}]"),
                "its world transform has a number beyond 1e15",
            ));
        }
    }
    Ok(world)
}
