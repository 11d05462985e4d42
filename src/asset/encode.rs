//! Writes a [`Built`] model as a GLB.
//!
//! In: a built model. Out: bytes; the same model gives the same bytes. Nothing of the original is changed but its
//! `extensionsUsed`, the length of its buffer, and `extensions` of the meshes and nodes that have LoDs.

use super::extension::{
    EXTENSION, LodExtension, MSFT_LOD, MeshExtension, PrefilteredExtension, RootExtension, VERSION,
};
use super::{Built, BuiltMesh, embedding, hierarchy, morph, original};
use crate::attribute::Prefiltered;
use crate::lod::Lod;
use crate::mesh::Mesh;
use crate::scene::{Document, array};
use crate::{Error, Result};
use bytemuck::Pod;
use serde_json::{Value, json};
use std::sync::Arc;

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;

/// The bytes of a built model.
///
/// # Errors
/// [`Error::Input`] where the parts do not fit each other (a mesh that does not exist, arrays of different lengths, an empty
/// LoD, a document that has inverse textures already); [`Error::Capacity`] past the 4 GiB of a GLB.
pub fn to_bytes(built: &Built) -> Result<Vec<u8>> {
    let document = &built.scene.document;
    let mut writer = Writer {
        name: &built.scene.name,
        counts_nodes: document.json["nodes"].as_array().map_or(0, Vec::len),
        json: document.json.clone(),
        binary: document.binary.to_vec(),
    };
    if !document.json["extensions"][EXTENSION].is_null() {
        return Err(writer.fault(
            "extensions".into(),
            "this model has inverse textures already; build from the original",
        ));
    }
    if let Some(pair) = built
        .meshes
        .windows(2)
        .find(|pair| pair[0].mesh >= pair[1].mesh)
    {
        return Err(writer.fault(
            format!("meshes[{}]", pair[1].mesh),
            "built meshes are not in growing order",
        ));
    }
    let root = RootExtension {
        version: VERSION,
        original: original::count(&document.json, document.binary.len()),
    };
    for mesh in &built.meshes {
        writer.mesh(built, mesh)?;
    }
    writer.json["extensions"][EXTENSION] = to_value(&root)?;
    writer.use_extensions();
    writer.finish()
}

fn to_value(value: &impl serde::Serialize) -> Result<Value> {
    serde_json::to_value(value).map_err(|e| Error::input("built model", EXTENSION, e.to_string()))
}

/// A document that grows.
struct Writer<'a> {
    name: &'a str,
    /// Nodes of the original.
    counts_nodes: usize,
    json: Value,
    binary: Vec<u8>,
}

impl Writer<'_> {
    fn fault(&self, element: String, reason: impl Into<String>) -> Error {
        Error::input(self.name, element, reason)
    }

    fn mesh(&mut self, built: &Built, mesh: &BuiltMesh) -> Result<()> {
        let element = format!("meshes[{}]", mesh.mesh);
        let Some(reference) = built.scene.meshes.get(mesh.mesh) else {
            return Err(self.fault(element, "does not exist"));
        };
        let reference_sha256 =
            super::reference_sha256(reference, &mesh.tables, &mesh.triangle_layer)?;
        let tables = &mesh.tables;
        let [hash, list, triangle] =
            [&tables.hash, &tables.list, &tables.triangle].map(|words| self.words(words));
        let layer = self.view(&mesh.triangle_layer, None);
        let embedding = embedding::write(&reference.embedding, |words| self.words(words));
        let mut lods = Vec::with_capacity(mesh.lods.len());
        for (k, lod) in mesh.lods.iter().enumerate() {
            self.check_lod(
                &format!("{element}.lods[{k}]"),
                lod,
                reference.targets.len(),
            )?;
            lods.push(self.lod(&format!("{} LoD {}", reference.name, k + 1), lod, reference));
        }
        self.nodes(mesh.mesh, &lods);
        let prefiltered = mesh.prefiltered.as_ref().map(|p| self.prefiltered(p));
        let hierarchy = mesh.hierarchy.as_ref().map(|h| {
            hierarchy::write(h, |bytes| {
                (!bytes.is_empty()).then(|| self.view(bytes, None))
            })
        });
        let extension = MeshExtension {
            primary: tables.primary,
            embedding,
            layout: tables.layout,
            format: tables.format,
            hash_size: tables.hash_size,
            window: tables.window,
            hash,
            list,
            triangle,
            layer,
            tables_sha256: tables.sha256(),
            reference_sha256,
            stats: tables.stats,
            lods,
            prefiltered: prefiltered.transpose()?,
            hierarchy,
            report: mesh.report.clone(),
        };
        self.json["meshes"][mesh.mesh]["extensions"][EXTENSION] = to_value(&extension)?;
        Ok(())
    }

    fn prefiltered(&mut self, prefiltered: &Prefiltered) -> Result<PrefilteredExtension> {
        let images = super::prefiltered::encode(prefiltered)
            .map_err(|reason| self.fault("prefiltered".into(), reason))?;
        Ok(PrefilteredExtension {
            size: prefiltered.size(),
            scope: prefiltered.scope(),
            images: images.map(|png| self.view(&png, None)),
        })
    }

    /// What reading would refuse is not written.
    fn check_lod(&self, element: &str, lod: &Lod, targets: usize) -> Result<()> {
        let vertices = lod.positions.len();
        let skinned = lod.joints.len() == vertices || lod.joints.is_empty();
        let lengths = [lod.normals.len(), lod.t3.len()] == [vertices; 2]
            && skinned
            && lod.joints.len() == lod.weights.len()
            && lod.triangle_layer.len() == lod.triangles.len();
        let finite = lod
            .positions
            .iter()
            .chain(&lod.normals)
            .flatten()
            .all(|c| c.is_finite());
        let inside = lod
            .triangles
            .iter()
            .flatten()
            .all(|&v| (v as usize) < vertices);
        let reason = match () {
            () if lod.triangles.is_empty() => "has no triangles",
            () if !lengths => "has arrays of different lengths",
            () if !finite || !lod.error.is_finite() => "has a number that is not finite",
            () if !morph::fit(&lod.targets, targets, vertices) => "has other morph targets",
            () if !inside => "has a triangle with a vertex that does not exist",
            () => return Ok(()),
        };
        Err(self.fault(element.into(), reason))
    }

    /// Appends a LoD as a mesh of one primitive, without a material.
    fn lod(&mut self, name: &str, lod: &Lod, reference: &Mesh) -> LodExtension {
        // Integers of 24 bits are exact in a float.
        let t3: Vec<[f32; 3]> = lod.t3.iter().map(|p| p.map(|c| c as f32)).collect();
        let mut attributes = json!({
            "POSITION": self.accessor(&lod.positions, FLOAT, "VEC3", ARRAY_BUFFER, Some(bounds(&lod.positions))),
            "NORMAL": self.accessor(&lod.normals, FLOAT, "VEC3", ARRAY_BUFFER, None),
            "_IGT_T3": self.accessor(&t3, FLOAT, "VEC3", ARRAY_BUFFER, None),
        });
        if !lod.joints.is_empty() {
            attributes["JOINTS_0"] = self
                .accessor(&lod.joints, UNSIGNED_SHORT, "VEC4", ARRAY_BUFFER, None)
                .into();
            attributes["WEIGHTS_0"] = self
                .accessor(&lod.weights, FLOAT, "VEC4", ARRAY_BUFFER, None)
                .into();
        }
        let corners = lod.triangles.as_flattened();
        let indices = self.accessor(corners, UNSIGNED_INT, "SCALAR", ELEMENT_ARRAY_BUFFER, None);
        let layer = self.view(&lod.triangle_layer, None);
        let mut mesh = json!({ "name": name, "primitives": [{ "attributes": attributes, "indices": indices }] });
        if !lod.targets.is_empty() {
            let targets = morph::write(&lod.targets, |values, positions| {
                let bounds = positions.then(|| bounds(values));
                self.accessor(values, FLOAT, "VEC3", ARRAY_BUFFER, bounds)
            });
            mesh["primitives"][0]["targets"] = targets;
            mesh["weights"] = json!(reference.target_weights);
        }
        let meshes = array(&mut self.json, "meshes");
        meshes.push(mesh);
        LodExtension {
            mesh: meshes.len() - 1,
            layer,
            error: lod.error,
            bounded: lod.bounded,
            turned: lod.turned,
            reached: lod.reached,
        }
    }

    /// Gives every node of the mesh nodes for its LoDs (MSFT_lod). A viewer that follows them shows a LoD node in place of
    /// the node and all below it, so nodes with children are left alone, as are nodes that name LoDs already.
    fn nodes(&mut self, mesh: usize, lods: &[LodExtension]) {
        for n in (0..self.counts_nodes).filter(|_| !lods.is_empty()) {
            let node = &self.json["nodes"][n];
            let leaf = node["children"].as_array().is_none_or(Vec::is_empty);
            if node["mesh"].as_u64() != Some(mesh as u64)
                || !leaf
                || !node["extensions"][MSFT_LOD].is_null()
            {
                continue;
            }
            let mut copy = json!({});
            for key in [
                "matrix",
                "translation",
                "rotation",
                "scale",
                "skin",
                "weights",
            ] {
                if let Some(value) = node.get(key) {
                    copy[key] = value.clone();
                }
            }
            let nodes = array(&mut self.json, "nodes");
            let first = nodes.len();
            for lod in lods {
                copy["mesh"] = lod.mesh.into();
                nodes.push(copy.clone());
            }
            let ids: Vec<usize> = (first..nodes.len()).collect();
            nodes[n]["extensions"][MSFT_LOD] = json!({ "ids": ids });
            self.move_alike(n, &ids);
        }
    }

    /// Whatever moves node `n` moves `others` too.
    fn move_alike(&mut self, n: usize, others: &[usize]) {
        let animations = self
            .json
            .get_mut("animations")
            .and_then(Value::as_array_mut);
        for animation in animations.into_iter().flatten() {
            let channels = animation.get_mut("channels").and_then(Value::as_array_mut);
            let Some(channels) = channels else { continue };
            let moving = |channel: &&Value| channel["target"]["node"].as_u64() == Some(n as u64);
            for mut channel in channels.iter().filter(moving).cloned().collect::<Vec<_>>() {
                for &other in others {
                    channel["target"]["node"] = other.into();
                    channels.push(channel.clone());
                }
            }
        }
    }

    /// Appends bytes as a buffer view at a multiple of 16; returns its index.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.binary
            .resize(self.binary.len().next_multiple_of(16), 0);
        let mut view =
            json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.binary.extend(bytes);
        let views = array(&mut self.json, "bufferViews");
        views.push(view);
        views.len() - 1
    }

    /// Appends words; a view cannot be empty, so none stands for none.
    fn words(&mut self, words: &[u32]) -> Option<usize> {
        let little: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
        (!words.is_empty()).then(|| self.view(&little, None))
    }

    /// Appends an array as an accessor; returns its index.
    fn accessor<T: Pod>(
        &mut self,
        values: &[T],
        component: u32,
        kind: &str,
        target: u32,
        bounds: Option<Value>,
    ) -> usize {
        // Written as they lie in memory: little-endian hosts only, which the crate's GPU side needs anyway.
        const { assert!(cfg!(target_endian = "little")) };
        let view = self.view(bytemuck::cast_slice(values), Some(target));
        let mut accessor = json!({ "bufferView": view, "componentType": component, "count": values.len(), "type": kind });
        if let Some(bounds) = bounds {
            accessor["min"] = bounds["min"].clone();
            accessor["max"] = bounds["max"].clone();
        }
        let accessors = array(&mut self.json, "accessors");
        accessors.push(accessor);
        accessors.len() - 1
    }

    fn use_extensions(&mut self) {
        let lods = array(&mut self.json, "nodes")
            .iter()
            .any(|node| !node["extensions"][MSFT_LOD].is_null());
        let used = array(&mut self.json, "extensionsUsed");
        for name in [EXTENSION, MSFT_LOD] {
            let wanted = name == EXTENSION || lods;
            if wanted && !used.iter().any(|u| u == name) {
                used.push(name.into());
            }
        }
    }

    fn finish(mut self) -> Result<Vec<u8>> {
        // Arrays that were only looked into are not left behind empty.
        if let Some(object) = self.json.as_object_mut() {
            object.retain(|key, value| {
                key != "nodes" || value.as_array().is_none_or(|a| !a.is_empty())
            });
        }
        if !self.binary.is_empty() {
            array(&mut self.json, "buffers");
            if self.json["buffers"][0].is_null() {
                self.json["buffers"] = json!([{}]);
            }
            self.json["buffers"][0]["byteLength"] = self.binary.len().into();
        }
        Document {
            json: self.json,
            binary: Arc::new(self.binary),
        }
        .to_glb()
    }
}

fn bounds(positions: &[[f32; 3]]) -> Value {
    let start = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    let (min, max) = positions.iter().fold(start, |(min, max), p| {
        let pick = |f: fn(f32, f32) -> f32, a: [f32; 3]| {
            std::array::from_fn::<f32, 3, _>(|k| f(a[k], p[k]))
        };
        (pick(f32::min, min), pick(f32::max, max))
    });
    json!({ "min": min, "max": max })
}
