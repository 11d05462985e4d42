//! Morph targets of LoDs in the built GLB: plain targets of the LoD's primitive, so that other viewers morph it too.

use crate::Result;
use crate::mesh::MorphTarget;
use serde_json::{Value, json};

/// The `targets` of a primitive, each array by `accessor`, which is told whether the array holds positions.
pub(super) fn write(
    targets: &[MorphTarget],
    mut accessor: impl FnMut(&[[f32; 3]], bool) -> usize,
) -> Value {
    let target = |target: &MorphTarget| {
        let mut out = json!({});
        if !target.positions.is_empty() {
            out["POSITION"] = accessor(&target.positions, true).into();
        }
        if !target.normals.is_empty() {
            out["NORMAL"] = accessor(&target.normals, false).into();
        }
        out
    };
    targets.iter().map(target).collect()
}

/// The `targets` of a primitive, each accessor read by `floats`.
pub(super) fn read(
    primitive: &Value,
    floats: impl Fn(usize) -> Result<Vec<[f32; 3]>>,
) -> Result<Vec<MorphTarget>> {
    let array = |target: &Value, name: &str| match target[name].as_u64() {
        Some(index) => floats(index as usize),
        None => Ok(Vec::new()),
    };
    let target = |target: &Value| {
        Ok(MorphTarget {
            positions: array(target, "POSITION")?,
            normals: array(target, "NORMAL")?,
            tangents: Vec::new(),
        })
    };
    let targets = primitive["targets"].as_array();
    targets.into_iter().flatten().map(target).collect()
}

/// Whether a LoD of `vertices` vertices has `count` targets whose arrays are as long, or empty, and finite.
pub(super) fn fit(targets: &[MorphTarget], count: usize, vertices: usize) -> bool {
    let arrays = || targets.iter().flat_map(|target| target.arrays());
    targets.len() == count
        && targets.iter().all(|target| target.tangents.is_empty())
        && arrays().all(|(_, values)| values.is_empty() || values.len() == vertices)
        && arrays().all(|(_, values)| values.iter().flatten().all(|c| c.is_finite()))
}
