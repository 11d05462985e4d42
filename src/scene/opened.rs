//! A document on its way to a [`Scene`]: checked in order, nothing read before what it stands on.
//!
//! In: bytes or a JSON value. Out: [`Opened`], from which accessors can be read, and then the scene.

use super::accessor::Reader;
use super::document::Document;
use super::image::Image;
use super::material::Material;
use super::{
    Scene, animation, container, document, json, material, node, primitive, resource, texture,
};
use crate::{Error, Result};
use std::path::Path;
use std::sync::Arc;

/// Extensions that a file may require.
const SUPPORTED: [&str; 4] = [
    "KHR_texture_transform",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "EXT_texture_webp",
];

/// A document whose JSON, buffers and views have been checked, and whose accessors can be read.
pub(crate) struct Opened {
    name: String,
    root: json::Root,
    views: Vec<document::View>,
    /// The document, self-contained.
    pub(crate) document: Document,
    /// Size of the file: what memory may grow with.
    size: u64,
}

impl Opened {
    /// Opens a file, as [`Scene::from_bytes`].
    pub(crate) fn new(name: &str, bytes: &[u8], folder: Option<&Path>) -> Result<Opened> {
        let container = container::open(name, bytes)?;
        Opened::from_json(
            name,
            container.json,
            container.bin,
            folder,
            bytes.len() as u64,
        )
    }

    /// Opens a document; `size` is that of the file it came from.
    pub(crate) fn from_json(
        name: &str,
        json: serde_json::Value,
        bin: Option<&[u8]>,
        folder: Option<&Path>,
        size: u64,
    ) -> Result<Opened> {
        check_asset(name, &json)?;
        let root = json::parse(name, &json)?;
        let mut resolver = resource::Resolver::new(name, folder);
        let (document, views) = document::gather(name, json, &root, bin, &mut resolver)?;
        let size = size.max(document.binary.len() as u64);
        Ok(Opened {
            name: name.into(),
            root,
            views,
            document,
            size,
        })
    }

    /// Reads its accessors, within a budget of memory of its own.
    pub(crate) fn reader(&self) -> Reader<'_> {
        Reader::new(
            &self.name,
            &self.root.accessors,
            &self.views,
            &self.document.binary,
            self.size,
        )
    }

    /// Bytes of a buffer view that `element` names.
    pub(crate) fn view(&self, index: usize, element: &str) -> Result<&[u8]> {
        let view = json::at(&self.name, &self.views, "bufferViews", index, || {
            element.into()
        })?;
        Ok(&self.document.binary[view.start..view.start + view.length])
    }

    /// Reads everything else.
    pub(crate) fn into_scene(self) -> Result<Scene> {
        let Opened {
            name,
            root,
            views,
            document,
            size,
        } = self;
        let binary = Arc::clone(&document.binary);
        let reader = Reader::new(&name, &root.accessors, &views, &binary, size);
        reader.check_all()?;
        let mut warnings = Vec::new();
        let mut materials = material::materials(&name, &root)?;
        let (nodes, roots) = node::nodes(&name, &root, &mut warnings)?;
        let mut reading = primitive::Meshes {
            reader: &reader,
            root: &root,
            materials: &materials,
            warnings: &mut warnings,
            default_material_used: false,
        };
        let meshes = reading.all()?;
        if reading.default_material_used {
            materials.push(Material::default());
        }
        let scene = Scene {
            textures: texture::textures(&name, &root, &mut warnings)?,
            images: images(&name, &root, &views, &document, &mut warnings)?,
            samplers: texture::samplers(&name, &root)?,
            skins: animation::skins(&reader, &root)?,
            animations: animation::animations(&reader, &root)?,
            world: node::world_matrices(&name, &nodes, |i| nodes[i].transform.matrix())?,
            name,
            meshes,
            materials,
            nodes,
            roots,
            warnings,
            document,
        };
        scene.check_joints()?;
        Ok(scene)
    }
}

/// glTF 2, and no required extension that is not known.
fn check_asset(file: &str, json: &serde_json::Value) -> Result<()> {
    let version = json
        .get("asset")
        .and_then(|a| a.get("version"))
        .and_then(|v| v.as_str());
    match version {
        Some(version) if version.starts_with("2.") => {}
        Some(version) => {
            let shown: String = version.chars().take(20).collect();
            return Err(Error::input(
                file,
                "asset.version",
                format!("{shown:?} is not supported (2.0 is)"),
            ));
        }
        None => {
            return Err(Error::input(
                file,
                "asset.version",
                "is missing: this is not glTF 2.0",
            ));
        }
    }
    let Some(required) = json.get("extensionsRequired") else {
        return Ok(());
    };
    let Some(required) = required.as_array() else {
        return Err(Error::input(file, "extensionsRequired", "is not an array"));
    };
    for (i, extension) in required.iter().enumerate() {
        let known = extension
            .as_str()
            .is_some_and(|name| SUPPORTED.contains(&name));
        if !known {
            let shown: String = extension.to_string().chars().take(80).collect();
            let reason = format!("{shown} is needed to read this file and is not supported");
            return Err(Error::input(
                file,
                format!("extensionsRequired[{i}]"),
                reason,
            ));
        }
    }
    Ok(())
}

/// All images, with a warning for each whose header is broken.
fn images(
    file: &str,
    root: &json::Root,
    views: &[document::View],
    document: &Document,
    warnings: &mut Vec<String>,
) -> Result<Vec<Image>> {
    let mut out = Vec::with_capacity(root.images.len());
    for (i, json) in root.images.iter().enumerate() {
        // Images that came by URI have been given a view behind those of the file.
        let view = document.json["images"][i]["bufferView"]
            .as_u64()
            .map(|v| v as usize);
        let range = match view.or(json.buffer_view) {
            Some(view) => {
                let view = json::at(file, views, "bufferViews", view, || {
                    format!("images[{i}].bufferView")
                })?;
                view.start..view.start + view.length
            }
            None => 0..0,
        };
        let name = json.name.clone().unwrap_or_else(|| format!("image_{i}"));
        let image = Image::new(name, Arc::clone(&document.binary), range);
        if let Err(error) = image.size() {
            warnings.push(format!("images[{i}]: a neutral texture stands in: {error}"));
        }
        out.push(image);
    }
    Ok(out)
}
