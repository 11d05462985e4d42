//! Morph targets of a primitive.
//!
//! In: the accessors of each target. Out: [`MorphTarget`]s, whose arrays are as long as the primitive's positions or empty.
//! Where the file has no normals and ours are made, the normals of its targets are made alike.

use super::accessor::Reader;
use super::json::MeshJson;
use super::node;
use crate::mesh::{Mesh, MorphTarget, smooth_normals};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Reads the targets of the primitive at `element`, which has `vertices` vertices.
pub(super) fn read_targets(
    reader: &Reader,
    element: &str,
    targets: &[BTreeMap<String, usize>],
    vertices: usize,
) -> Result<Vec<MorphTarget>> {
    let target = |(k, attributes): (usize, &BTreeMap<String, usize>)| {
        let array = |name: &str| -> Result<Vec<[f32; 3]>> {
            let Some(&accessor) = attributes.get(name) else {
                return Ok(Vec::new());
            };
            let place = || format!("{element}.targets[{k}].{name}");
            let values = reader.floats::<3>(accessor, place)?;
            if values.len() == vertices {
                return Ok(values);
            }
            let reason = format!("has {} elements, POSITION has {vertices}", values.len());
            Err(Error::input(reader.file, place(), reason))
        };
        Ok(MorphTarget {
            positions: array("POSITION")?,
            normals: array("NORMAL")?,
            tangents: array("TANGENT")?,
        })
    };
    targets.iter().enumerate().map(target).collect()
}

/// The targets of all blocks of a mesh as targets of the mesh; a block without some array adds nothing there. `blocks`
/// holds each block's targets and its number of vertices.
pub(super) fn join(
    reader: &Reader,
    element: &str,
    blocks: &[(&[MorphTarget], usize)],
    warnings: &mut Vec<String>,
) -> Result<Vec<MorphTarget>> {
    let count = blocks.iter().map(|(t, _)| t.len()).max().unwrap_or(0);
    if blocks.iter().any(|(targets, _)| targets.len() != count) {
        warnings.push(format!(
            "{element}: its primitives have different numbers of morph targets; those that lack some do not move by them"
        ));
    }
    let vertices: usize = blocks.iter().map(|(_, vertices)| vertices).sum();
    let array = |k: usize, get: fn(&MorphTarget) -> &Vec<[f32; 3]>| -> Result<Vec<[f32; 3]>> {
        let of = |targets: &[MorphTarget]| targets.get(k).map_or(0, |t| get(t).len());
        if blocks.iter().all(|(targets, _)| of(targets) == 0) {
            return Ok(Vec::new());
        }
        reader.charge(vertices, 12, || element.into())?;
        let mut out = Vec::with_capacity(vertices);
        for &(targets, vertices) in blocks {
            match targets.get(k).map(get).filter(|values| !values.is_empty()) {
                Some(values) => out.extend_from_slice(values),
                None => out.resize(out.len() + vertices, [0.0; 3]),
            }
        }
        Ok(out)
    };
    let target = |k: usize| {
        Ok(MorphTarget {
            positions: array(k, |t| &t.positions)?,
            normals: array(k, |t| &t.normals)?,
            tangents: array(k, |t| &t.tangents)?,
        })
    };
    (0..count).map(target).collect()
}

/// Weights at rest: as many as there are targets.
pub(super) fn rest_weights(
    file: &str,
    element: &str,
    json: &MeshJson,
    targets: usize,
    warnings: &mut Vec<String>,
) -> Result<Vec<f32>> {
    let mut weights = node::weights(file, &json.weights, || format!("{element}.weights"))?;
    if !weights.is_empty() && weights.len() != targets {
        warnings.push(format!(
            "{element}: {} weights for {targets} morph targets",
            weights.len()
        ));
    }
    weights.resize(targets, 0.0);
    Ok(weights)
}

/// Gives targets normals where the mesh's own were made, for the vertices in `made`: from the morphed shape.
pub(super) fn add_normals(
    reader: &Reader,
    element: &str,
    mesh: &mut Mesh,
    made: &[bool],
) -> Result<()> {
    if !made.contains(&true) {
        return Ok(());
    }
    let base = smooth_normals(&mesh.positions, &mesh.triangles);
    for target in mesh.targets.iter_mut().filter(|t| !t.positions.is_empty()) {
        reader.charge(base.len(), 64, || element.into())?;
        let add = |(p, d): (&[f32; 3], &[f32; 3])| std::array::from_fn(|k| p[k] + d[k]);
        let moved: Vec<[f32; 3]> = mesh
            .positions
            .iter()
            .zip(&target.positions)
            .map(add)
            .collect();
        let normals = smooth_normals(&moved, &mesh.triangles);
        target.normals.resize(base.len(), [0.0; 3]);
        for v in (0..base.len()).filter(|&v| made[v]) {
            let way: [f32; 3] = std::array::from_fn(|k| normals[v][k] - base[v][k]);
            // A shape beyond the range of floats has none.
            if way.iter().all(|c| c.is_finite()) {
                target.normals[v] = way;
            }
        }
    }
    Ok(())
}
