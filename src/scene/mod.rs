//! glTF in, hardened: any bytes give a [`Scene`] or an error that names the element and the reason.
//!
//! In: a `.gltf` or `.glb`, and the folder its resources may come from. Out: meshes as flat arrays, materials, textures,
//! encoded images, nodes, skins, animations, what was repaired on the way (`warnings`), and the original document, made
//! self-contained, to be written back.
//!
//! ```text
//! bytes -> container -> json -> document (resource) -> accessor -> primitive, vertex -> Mesh
//!          GLB, JSON    types    one binary, views      numbers     nodes, skins, materials -> Scene
//! ```
//!
//! `gltf::import` is not used: it reads absolute paths and `..`, panics on some inputs and drops bad accessors silently.

mod accessor;
mod animation;
mod container;
mod document;
mod image;
mod json;
mod material;
mod node;
mod primitive;
mod resource;
mod vertex;

pub(crate) use accessor::Reader;
pub use animation::{Animation, Channel, Interpolation, Property, Skin, Track};
pub use document::Document;
pub(crate) use document::array;
pub use image::{Image, MAX_ALLOCATION, MAX_SIDE, TextureUse};
pub use material::{AlphaMode, Material, Mipmap, Sampler, Texture, TextureRef, UvTransform, Wrap};
pub use node::{Instance, Node, Transform};

use crate::mesh::Mesh;
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

/// A glTF model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Name of the file.
    pub name: String,
    /// One for each glTF mesh, with the same index; empty where it has no triangles.
    pub meshes: Vec<Mesh>,
    /// The file's materials, then, if a primitive has none, glTF's default one.
    pub materials: Vec<Material>,
    /// The file's textures.
    pub textures: Vec<Texture>,
    /// The file's images.
    pub images: Vec<Image>,
    /// The file's samplers.
    pub samplers: Vec<Sampler>,
    /// The file's nodes.
    pub nodes: Vec<Node>,
    /// Root nodes of the default scene.
    pub roots: Vec<usize>,
    /// The file's skins.
    pub skins: Vec<Skin>,
    /// The file's animations.
    pub animations: Vec<Animation>,
    /// What was repaired, skipped or replaced.
    pub warnings: Vec<String>,
    /// The model as it came, self-contained.
    pub document: Document,
    /// Object-to-world matrix of every node.
    world: Vec<glam::DMat4>,
}

impl Scene {
    /// Reads a file; its resources may lie beside it or below.
    ///
    /// # Errors
    /// [`Error::Io`] where the file cannot be read, else as [`Scene::from_bytes`].
    pub fn load(path: &Path) -> Result<Scene> {
        let bytes = read_file(path)?;
        Scene::from_bytes(&path.display().to_string(), &bytes, path.parent())
    }

    /// Reads a model from memory; `name` is what errors call it, `root` the folder that its resources may come from
    /// (`None`: only `data:` URIs).
    ///
    /// # Errors
    /// [`Error::Input`] naming the element and the reason.
    pub fn from_bytes(name: &str, bytes: &[u8], root: Option<&Path>) -> Result<Scene> {
        Opened::new(name, bytes, root)?.into_scene()
    }

    /// Every mesh of the default scene as it stands in the world, in depth-first order of the nodes. Meshes without
    /// triangles are left out.
    pub fn instances(&self) -> Vec<Instance> {
        let mut out = Vec::new();
        let mut stack: Vec<usize> = self.roots.iter().rev().copied().collect();
        while let Some(i) = stack.pop() {
            let node = &self.nodes[i];
            if let Some(mesh) = node.mesh.filter(|&m| !self.meshes[m].triangles.is_empty()) {
                out.push(Instance {
                    node: i,
                    mesh,
                    skin: node.skin,
                    world: self.world[i],
                });
            }
            stack.extend(node.children.iter().rev());
        }
        out
    }

    /// Object-to-world matrix of every node, at rest.
    pub fn world_matrices(&self) -> &[glam::DMat4] {
        &self.world
    }

    /// How a texture is sampled.
    pub fn sampler_of(&self, texture: &Texture) -> Sampler {
        texture
            .sampler
            .map_or_else(Sampler::default, |s| self.samplers[s])
    }

    /// Joint indices of skinned meshes exist in the skins that nodes pair them with.
    fn check_joints(&self) -> Result<()> {
        let largest: Vec<Option<u16>> = self
            .meshes
            .iter()
            .map(|mesh| {
                let used = |(joints, weights): (&[u16; 4], &[f32; 4])| {
                    (0..4)
                        .filter(|&k| weights[k] > 0.0)
                        .map(|k| joints[k])
                        .max()
                };
                mesh.joints.iter().zip(&mesh.weights).filter_map(used).max()
            })
            .collect();
        for (i, node) in self.nodes.iter().enumerate() {
            if let (Some(mesh), Some(skin)) = (node.mesh, node.skin)
                && let Some(joint) = largest[mesh]
                && usize::from(joint) >= self.skins[skin].joints.len()
            {
                let have = self.skins[skin].joints.len();
                let reason =
                    format!("meshes[{mesh}] names joint {joint}, skins[{skin}] has {have}");
                return Err(Error::input(&self.name, format!("nodes[{i}]"), reason));
            }
        }
        Ok(())
    }
}

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
            textures: material::textures(&name, &root, &mut warnings)?,
            images: images(&name, &root, &views, &document, &mut warnings)?,
            samplers: material::samplers(&name, &root)?,
            skins: animation::skins(&reader, &root)?,
            animations: animation::animations(&reader, &root)?,
            world: node::world_matrices(&name, &nodes)?,
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

/// All bytes of a plain file.
///
/// # Errors
/// [`Error::Io`] where it cannot be read or is not a plain file.
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    let io = |e| Error::io(path, e);
    // Looked at first: opening a pipe would wait for its other end, a device might never end.
    if !std::fs::metadata(path).map_err(io)?.is_file() {
        return Err(io(std::io::Error::new(
            std::io::ErrorKind::InvalidInput,
            "is not a plain file",
        )));
    }
    std::fs::read(path).map_err(io)
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
