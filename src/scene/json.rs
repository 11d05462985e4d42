//! The parts of a glTF document that are read, as serde structures: nothing is checked here but types.
//!
//! In: the JSON value. Out: [`Root`]. An element of the wrong type is an error that names it. Every index in here is
//! still only a claim; it is checked where it is used ([`at`]).
//!
//! Source: glTF 2.0 specification, section 5. Why not `gltf-json`: it rejects valid files (scenes without nodes, animation
//! channels without a node), leaves animation targets unchecked and refuses KHR_mesh_quantization.

use crate::{Error, Result};
use serde::Deserialize;
use serde::de::{DeserializeOwned, IgnoredAny};
use serde_json::Value;
use std::collections::BTreeMap;

/// All arrays of a document that the loader reads.
#[derive(Default)]
pub(super) struct Root {
    pub(super) scene: Option<usize>,
    pub(super) scenes: Vec<SceneJson>,
    pub(super) nodes: Vec<NodeJson>,
    pub(super) meshes: Vec<MeshJson>,
    pub(super) accessors: Vec<Accessor>,
    pub(super) buffer_views: Vec<BufferView>,
    pub(super) buffers: Vec<Buffer>,
    pub(super) materials: Vec<MaterialJson>,
    pub(super) textures: Vec<TextureJson>,
    pub(super) images: Vec<ImageJson>,
    pub(super) samplers: Vec<SamplerJson>,
    pub(super) skins: Vec<SkinJson>,
    pub(super) animations: Vec<AnimationJson>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct SceneJson {
    pub(super) nodes: Vec<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct NodeJson {
    pub(super) name: Option<String>,
    pub(super) children: Vec<usize>,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    pub(super) weights: Vec<f64>,
    #[serde(rename = "extensions")]
    _extensions: BTreeMap<String, IgnoredAny>,
}

#[derive(Deserialize)]
pub(super) struct MeshJson {
    pub(super) name: Option<String>,
    pub(super) primitives: Vec<Primitive>,
    /// Of the morph targets.
    #[serde(default)]
    pub(super) weights: Vec<f64>,
    #[serde(default, rename = "extensions")]
    _extensions: BTreeMap<String, IgnoredAny>,
}

#[derive(Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: BTreeMap<String, usize>,
    pub(super) indices: Option<usize>,
    pub(super) material: Option<usize>,
    #[serde(default = "triangles")]
    pub(super) mode: u32,
    #[serde(default)]
    pub(super) targets: Vec<BTreeMap<String, usize>>,
}

fn triangles() -> u32 {
    4
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    pub(super) byte_offset: Option<u64>,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: u64,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: SparsePart,
    pub(super) values: SparsePart,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparsePart {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    /// Of the indices; absent for the values.
    pub(super) component_type: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: u64,
}

#[derive(Deserialize, Default)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct MaterialJson {
    pub(super) name: Option<String>,
    pub(super) pbr_metallic_roughness: PbrJson,
    pub(super) normal_texture: Option<TextureInfo>,
    pub(super) occlusion_texture: Option<TextureInfo>,
    pub(super) emissive_texture: Option<TextureInfo>,
    pub(super) emissive_factor: [f64; 3],
    pub(super) alpha_mode: Option<String>,
    pub(super) alpha_cutoff: Option<f64>,
    pub(super) double_sided: bool,
    pub(super) extensions: BTreeMap<String, Value>,
}

#[derive(Deserialize, Default)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct PbrJson {
    pub(super) base_color_factor: Option<[f64; 4]>,
    pub(super) base_color_texture: Option<TextureInfo>,
    pub(super) metallic_factor: Option<f64>,
    pub(super) roughness_factor: Option<f64>,
    pub(super) metallic_roughness_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub(super) index: usize,
    #[serde(default)]
    pub(super) tex_coord: usize,
    /// Of a normal texture.
    pub(super) scale: Option<f64>,
    /// Of an occlusion texture.
    pub(super) strength: Option<f64>,
    #[serde(default)]
    pub(super) extensions: BTreeMap<String, Value>,
}

#[derive(Deserialize, Default)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct TransformJson {
    pub(super) offset: [f64; 2],
    pub(super) rotation: f64,
    pub(super) scale: Option<[f64; 2]>,
    pub(super) tex_coord: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct TextureJson {
    pub(super) source: Option<usize>,
    pub(super) sampler: Option<usize>,
    pub(super) extensions: BTreeMap<String, Value>,
}

#[derive(Deserialize, Default)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct ImageJson {
    pub(super) name: Option<String>,
    pub(super) uri: Option<String>,
    pub(super) buffer_view: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct SamplerJson {
    pub(super) mag_filter: Option<u32>,
    pub(super) min_filter: Option<u32>,
    pub(super) wrap_s: Option<u32>,
    pub(super) wrap_t: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SkinJson {
    pub(super) name: Option<String>,
    pub(super) joints: Vec<usize>,
    pub(super) inverse_bind_matrices: Option<usize>,
    pub(super) skeleton: Option<usize>,
}

#[derive(Deserialize)]
pub(super) struct AnimationJson {
    pub(super) name: Option<String>,
    pub(super) channels: Vec<ChannelJson>,
    pub(super) samplers: Vec<AnimationSamplerJson>,
}

#[derive(Deserialize)]
pub(super) struct ChannelJson {
    pub(super) sampler: usize,
    pub(super) target: TargetJson,
}

#[derive(Deserialize)]
pub(super) struct TargetJson {
    pub(super) node: Option<usize>,
    pub(super) path: String,
}

#[derive(Deserialize)]
pub(super) struct AnimationSamplerJson {
    pub(super) input: usize,
    pub(super) output: usize,
    pub(super) interpolation: Option<String>,
}

/// Reads the arrays of a document.
///
/// # Errors
/// [`Error::Input`] naming the element that is not what glTF says.
pub(super) fn parse(file: &str, json: &Value) -> Result<Root> {
    let scene = match json.get("scene") {
        None => None,
        Some(index) => {
            let index = index
                .as_u64()
                .ok_or_else(|| Error::input(file, "scene", "is not an index"))?;
            Some(index as usize)
        }
    };
    if json.get("extensions").is_some_and(|e| !e.is_object()) {
        return Err(Error::input(file, "extensions", "is not an object"));
    }
    for key in ["extensionsUsed", "extensionsRequired"] {
        if json.get(key).is_some_and(|e| !e.is_array()) {
            return Err(Error::input(file, key, "is not an array"));
        }
    }
    Ok(Root {
        scene,
        scenes: list(file, json, "scenes")?,
        nodes: list(file, json, "nodes")?,
        meshes: list(file, json, "meshes")?,
        accessors: list(file, json, "accessors")?,
        buffer_views: list(file, json, "bufferViews")?,
        buffers: list(file, json, "buffers")?,
        materials: list(file, json, "materials")?,
        textures: list(file, json, "textures")?,
        images: list(file, json, "images")?,
        samplers: list(file, json, "samplers")?,
        skins: list(file, json, "skins")?,
        animations: list(file, json, "animations")?,
    })
}

/// The array `key` of the document, each element as a `T`; an absent array is empty.
fn list<T: DeserializeOwned>(file: &str, json: &Value, key: &str) -> Result<Vec<T>> {
    let Some(value) = json.get(key) else {
        return Ok(Vec::new());
    };
    let array = value
        .as_array()
        .ok_or_else(|| Error::input(file, key, "is not an array"))?;
    let element = |(i, value)| {
        if !Value::is_object(value) {
            return Err(Error::input(
                file,
                format!("{key}[{i}]"),
                "is not an object",
            ));
        }
        T::deserialize(value).map_err(|e| Error::input(file, format!("{key}[{i}]"), e.to_string()))
    };
    array.iter().enumerate().map(element).collect()
}

/// Element `index` of an array, or an error that says where the index stands.
pub(super) fn at<'a, T>(
    file: &str,
    array: &'a [T],
    what: &str,
    index: usize,
    element: impl FnOnce() -> String,
) -> Result<&'a T> {
    array.get(index).ok_or_else(|| {
        let reason = format!(
            "names {what}[{index}], which does not exist (there are {})",
            array.len()
        );
        Error::input(file, element(), reason)
    })
}
