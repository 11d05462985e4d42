//! Skins and animations: read, checked, kept. Nothing here moves anything.

use super::accessor::Reader;
use super::json::{AnimationJson, Root, SkinJson, at};
use crate::{Error, Result};

/// The joints that move a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Its name in the file, or `skin_N`.
    pub name: String,
    /// Nodes, in the order that a mesh's joint indices count them.
    pub joints: Vec<usize>,
    /// Mesh space to joint space at rest, column-major; one per joint.
    pub inverse_bind: Vec<[f32; 16]>,
    /// The common root, if named.
    pub skeleton: Option<usize>,
}

/// Keyframes that move nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// Its name in the file, or `animation_N`.
    pub name: String,
    /// What moves, and by which track.
    pub channels: Vec<Channel>,
    /// Tracks of keyframes.
    pub tracks: Vec<Track>,
}

/// One moved property of one node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The node; `None` where an extension names the target.
    pub node: Option<usize>,
    /// The property.
    pub property: Property,
    /// Index into the animation's tracks.
    pub track: usize,
}

/// What a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// 3 numbers.
    Translation,
    /// 4 numbers, a quaternion.
    Rotation,
    /// 3 numbers.
    Scale,
    /// One number per morph target.
    Weights,
    /// Of an extension.
    Other,
}

/// Keyframes.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Seconds, growing.
    pub times: Vec<f32>,
    /// Numbers per keyframe times keyframes (three groups per keyframe for [`Interpolation::Cubic`]: in-tangent, value,
    /// out-tangent).
    pub values: Vec<f32>,
    /// Between keyframes.
    pub interpolation: Interpolation,
}

/// How to go from keyframe to keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// In a straight line (rotations: along the arc).
    Linear,
    /// Not at all.
    Step,
    /// By a cubic Hermite spline.
    Cubic,
}

/// All skins of a document.
pub(super) fn skins(reader: &Reader, root: &Root) -> Result<Vec<Skin>> {
    root.skins
        .iter()
        .enumerate()
        .map(|(i, json)| skin(reader, root, i, json))
        .collect()
}

fn skin(reader: &Reader, root: &Root, i: usize, json: &SkinJson) -> Result<Skin> {
    let bad = |reason: String| Error::input(reader.file, format!("skins[{i}]"), reason);
    if json.joints.is_empty() {
        return Err(bad("has no joints".into()));
    }
    for (k, &joint) in json.joints.iter().enumerate() {
        at(reader.file, &root.nodes, "nodes", joint, || {
            format!("skins[{i}].joints[{k}]")
        })?;
    }
    if let Some(node) = json.skeleton {
        at(reader.file, &root.nodes, "nodes", node, || {
            format!("skins[{i}].skeleton")
        })?;
    }
    let inverse_bind = match json.inverse_bind_matrices {
        Some(accessor) => {
            reader.floats::<16>(accessor, || format!("skins[{i}].inverseBindMatrices"))?
        }
        None => vec![glam::Mat4::IDENTITY.to_cols_array(); json.joints.len()],
    };
    if inverse_bind.len() < json.joints.len() {
        let reason = format!(
            "{} inverse bind matrices for {} joints",
            inverse_bind.len(),
            json.joints.len()
        );
        return Err(bad(reason));
    }
    Ok(Skin {
        name: json.name.clone().unwrap_or_else(|| format!("skin_{i}")),
        joints: json.joints.clone(),
        inverse_bind: inverse_bind[..json.joints.len()].to_vec(),
        skeleton: json.skeleton,
    })
}

/// All animations of a document.
pub(super) fn animations(reader: &Reader, root: &Root) -> Result<Vec<Animation>> {
    root.animations
        .iter()
        .enumerate()
        .map(|(i, json)| animation(reader, root, i, json))
        .collect()
}

fn animation(reader: &Reader, root: &Root, i: usize, json: &AnimationJson) -> Result<Animation> {
    let mut tracks = Vec::with_capacity(json.samplers.len());
    for (k, sampler) in json.samplers.iter().enumerate() {
        let element = || format!("animations[{i}].samplers[{k}]");
        let interpolation = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::Cubic,
            Some(_) => {
                return Err(Error::input(
                    reader.file,
                    element(),
                    "interpolation is not LINEAR, STEP or CUBICSPLINE",
                ));
            }
        };
        let times = reader.floats::<1>(sampler.input, element)?.into_flattened();
        if times[0] < 0.0 || times.windows(2).any(|w| w[0] > w[1]) {
            return Err(Error::input(
                reader.file,
                element(),
                "times of the keyframes do not grow from 0",
            ));
        }
        let values = numbers(reader, sampler.output, element)?;
        tracks.push(Track {
            times,
            values,
            interpolation,
        });
    }
    let mut channels = Vec::with_capacity(json.channels.len());
    for (k, channel) in json.channels.iter().enumerate() {
        let element = || format!("animations[{i}].channels[{k}]");
        let track = at(reader.file, &tracks, "samplers", channel.sampler, element)?;
        if let Some(node) = channel.target.node {
            at(reader.file, &root.nodes, "nodes", node, || {
                format!("{}.target.node", element())
            })?;
        }
        let (property, width) = match channel.target.path.as_str() {
            "translation" => (Property::Translation, Some(3)),
            "rotation" => (Property::Rotation, Some(4)),
            "scale" => (Property::Scale, Some(3)),
            "weights" => (Property::Weights, None),
            _ => (Property::Other, None),
        };
        let groups = track.times.len()
            * if track.interpolation == Interpolation::Cubic {
                3
            } else {
                1
            };
        let fits = match width {
            Some(width) => groups * width == track.values.len(),
            None => track.values.len().is_multiple_of(groups),
        };
        if !fits {
            let reason = format!(
                "{} numbers for {} keyframes",
                track.values.len(),
                track.times.len()
            );
            return Err(Error::input(reader.file, element(), reason));
        }
        channels.push(Channel {
            node: channel.target.node,
            property,
            track: channel.sampler,
        });
    }
    Ok(Animation {
        name: json
            .name
            .clone()
            .unwrap_or_else(|| format!("animation_{i}")),
        channels,
        tracks,
    })
}

/// All numbers of an accessor of scalars or vectors, in order.
fn numbers(reader: &Reader, index: usize, element: impl Fn() -> String) -> Result<Vec<f32>> {
    match reader.check(index, &element)?.components {
        1 => Ok(reader.floats::<1>(index, element)?.into_flattened()),
        2 => Ok(reader.floats::<2>(index, element)?.into_flattened()),
        3 => Ok(reader.floats::<3>(index, element)?.into_flattened()),
        4 => Ok(reader.floats::<4>(index, element)?.into_flattened()),
        n => Err(reader.fault(index, format!("{n} components cannot be animated"))),
    }
}
