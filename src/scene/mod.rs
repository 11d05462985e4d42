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
mod component;
mod container;
mod deform;
mod document;
mod image;
mod json;
mod mapped;
mod material;
mod morph;
mod node;
mod opened;
mod pose;
mod primitive;
mod resource;
mod sample;
mod texture;
mod vertex;

pub(crate) use accessor::Reader;
pub use animation::{Animation, Channel, Interpolation, Property, Skin, Track};
pub(crate) use container::to_glb;
#[cfg(test)]
pub(crate) use deform::samples as deform_samples;
pub(crate) use deform::{Deformation, Rest};
pub use document::Document;
pub(crate) use document::array;
pub use image::{Image, MAX_ALLOCATION, MAX_SIDE, TextureUse};
pub use mapped::Mapped;
pub use material::{AlphaMode, Material, TextureRef, UvTransform};
pub use node::{Instance, Node, Transform};
pub(crate) use opened::Opened;
pub use pose::Pose;
pub use texture::{Mipmap, Sampler, Texture, Wrap};

use crate::mesh::Mesh;
use crate::{Error, Result};
use std::path::Path;

/// The JSON of a GLB or glTF file and the range of its BIN chunk, if it has one, among the file's bytes.
pub(crate) fn json_and_binary(
    name: &str,
    bytes: &[u8],
) -> Result<(serde_json::Value, Option<std::ops::Range<usize>>)> {
    let container = container::open(name, bytes)?;
    let range = container.bin.map(|bin| {
        // A part of `bytes`: its place is how far it lies behind their beginning.
        let start = bin.as_ptr().addr() - bytes.as_ptr().addr();
        start..start + bin.len()
    });
    Ok((container.json, range))
}

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
    pub(crate) world: Vec<glam::DMat4>,
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
