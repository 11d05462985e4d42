//! The simplifier: edge collapses in the order of their quadric error, over the whole joint mesh.
//!
//! In: the joint mesh and a fraction of its triangles. Out: [`Simplified`], whose vertices may have moved. Sequential inside,
//! so the same input gives the same bytes.

use super::joint::Joint;
use meshopt::SimplifyOptions;

/// A joint mesh with fewer triangles; vertices keep the joint mesh's numbers.
pub(super) struct Simplified {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) attributes: Vec<f32>,
    pub(super) indices: Vec<u32>,
    /// Largest error of a collapse, in world units.
    pub(super) error: f32,
    /// Whether the triangle count asked for was reached.
    pub(super) reached: bool,
}

/// The joint mesh at `fraction` of the references' triangles.
pub(super) fn simplify(joint: &Joint, fraction: f32) -> Simplified {
    let target =
        ((joint.reference_triangles as f64 * f64::from(fraction)).round() as usize).max(1) * 3;
    let mut result = untouched(joint);
    if target < joint.indices.len() {
        // An attribute without weight costs nothing: models without charts that do not move are simplified by position
        // alone.
        let weights = vec![
            1.0;
            if joint.has_attributes {
                joint.stride
            } else {
                0
            }
        ];
        let count = meshopt::simplify_with_update(
            &mut result.indices,
            &mut result.positions,
            &mut result.attributes,
            &weights,
            joint.stride * size_of::<f32>(),
            None,
            target,
            f32::MAX.sqrt() * 0.5,
            SimplifyOptions::ErrorAbsolute,
            Some(&mut result.error),
        );
        result.indices.truncate(count);
    }
    result.reached = result.indices.len() <= target;
    result
}

/// The joint mesh as it is.
pub(super) fn untouched(joint: &Joint) -> Simplified {
    Simplified {
        positions: joint.positions.clone(),
        attributes: joint.attributes.clone(),
        indices: joint.indices.clone(),
        error: 0.0,
        reached: false,
    }
}
