//! Multiresolution models of a build, and in the file: the steps of a history, how far its triangles are displaced, their
//! colours.
//!
//! In: meshes that are built, or words from a file of any origin. Out: [`Hierarchy`]s, or what is wrong. Steps are made again on
//! reading: what does not keep the surface whole is refused there.

use crate::igt::Asking;
use crate::lod::LodInput;
use crate::lod::multiresolution::{Hierarchy, StepColours};
use crate::lod::progressive::colour::Distance;
use crate::lod::progressive::{Deviation, Progressive, Steps};
use crate::mesh::Mesh;
use crate::param::Primary;
use serde::{Deserialize, Serialize};

/// Triangles below which no history goes.
pub(super) const LEAST: usize = 4;

/// Buffer views of a history; none of them where nothing could be collapsed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HierarchyExtension {
    /// Pairs of 32-bit integers: the place that goes, the place it becomes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) steps: Option<usize>,
    /// Three floats for each triangle that a step makes: deviation, its tangential part, its normal part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) deviations: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) colours: Option<ColoursExtension>,
}

/// Colour deviations of steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ColoursExtension {
    /// Pairs of bytes, `levels` for each step: codes of the tangential deviation and of the product.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) codes: Option<usize>,
    /// Object units of a pixel at the first level.
    pub(super) footprint: f32,
    pub(super) levels: usize,
    /// What they are measured by.
    pub(super) distance: Distance,
}

/// Whether a mesh stands still: deviations are those at rest.
pub(super) fn stands_still(mesh: &Mesh) -> bool {
    mesh.joints.is_empty() && mesh.targets.is_empty()
}

/// Places in T3 and triangles of every age, for [`Asked::asking`].
pub(super) struct Asked {
    t3: Vec<[i32; 3]>,
    triangles: Vec<[u32; 3]>,
    layer: Vec<u8>,
}

impl Asked {
    pub(super) fn of(mesh: &Mesh, primary: &Primary, history: &Progressive) -> Self {
        let grid = |v: usize| primary.to_grid(primary.t3_of(mesh, v));
        let made = history.triangles.iter().filter(|t| t.made.is_some());
        Asked {
            t3: (0..mesh.positions.len()).map(grid).collect(),
            triangles: made.clone().map(|t| t.corners).collect(),
            layer: made.map(|t| t.layer).collect(),
        }
    }

    /// What any cut may ask of the tables.
    pub(super) fn asking(&self) -> Asking<'_> {
        Asking {
            t3: &self.t3,
            triangles: &self.triangles,
            layer: &self.layer,
        }
    }
}

/// The extension of `hierarchy`; `view` appends bytes and says in which view they are, none for none.
pub(super) fn write(
    hierarchy: &Hierarchy,
    mut view: impl FnMut(&[u8]) -> Option<usize>,
) -> HierarchyExtension {
    let Steps { places, deviations } = hierarchy.history.steps();
    let floats: Vec<f32> = deviations
        .iter()
        .flat_map(|d| [d.total, d.tangential, d.normal])
        .collect();
    HierarchyExtension {
        steps: view(&little(places.as_flattened())),
        deviations: view(&little(bytemuck::cast_slice(&floats))),
        colours: hierarchy.colours.as_ref().map(|colours| ColoursExtension {
            codes: view(colours.codes.as_flattened()),
            footprint: colours.footprint,
            levels: colours.levels,
            distance: colours.distance,
        }),
    }
}

fn little(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|w| w.to_le_bytes()).collect()
}

/// The hierarchy that `extension` speaks of; `words` and `bytes` read a view.
pub(super) fn read<E>(
    extension: &HierarchyExtension,
    input: &LodInput<'_>,
    words: impl Fn(Option<usize>) -> Result<Vec<u32>, E>,
    bytes: impl Fn(Option<usize>) -> Result<Vec<u8>, E>,
) -> Result<Result<Hierarchy, String>, E> {
    let (places, deviations) = (words(extension.steps)?, words(extension.deviations)?);
    let colours = match &extension.colours {
        Some(colours) => Some(StepColours {
            footprint: colours.footprint,
            levels: colours.levels,
            distance: colours.distance,
            codes: bytes(colours.codes)?.as_chunks::<2>().0.to_vec(),
        }),
        None => None,
    };
    let ((places, []), (deviations, [])) = (places.as_chunks::<2>(), deviations.as_chunks::<3>())
    else {
        return Ok(Err(
            "has steps that are no pairs, or deviations of other than three parts".into(),
        ));
    };
    let deviation = |d: &[u32; 3]| {
        let [total, tangential, normal] = d.map(f32::from_bits);
        Deviation {
            total,
            tangential,
            normal,
        }
    };
    let steps = Steps {
        places: places.to_vec(),
        deviations: deviations.iter().map(deviation).collect(),
    };
    Ok(Hierarchy::replay(input, &steps, colours))
}
