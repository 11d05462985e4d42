//! Reads a built GLB: untrusted input.
//!
//! In: bytes of any origin. Out: a [`Built`] model in which every index that a lookup, a shader or a draw follows exists, or
//! an error that names the element. The tables must have the checksum the file gives them, and the mesh must be the one
//! they were built for.

use super::embedding::EmbeddingExtension;
use super::extension::{EXTENSION, MeshExtension, PrefilteredExtension, RootExtension, VERSION};
use super::hierarchy::HierarchyExtension;
use super::{Built, BuiltMesh, embedding, hierarchy, original};
use crate::attribute::Prefiltered;
use crate::igt::Tables;
use crate::lod::LodInput;
use crate::lod::multiresolution::Hierarchy;
use crate::mesh::Mesh;
use crate::param::{self, Primary, PrimaryKind};
use crate::scene::{Opened, Reader, Scene};
use crate::{Error, Result};
use serde::Deserialize;
use serde_json::Value;

/// Most LoDs of one mesh.
const MAX_LODS: usize = 64;

/// Whether bytes look like a built model: a GLB whose JSON names the extension. [`read`] says whether they are one.
pub fn is_built(bytes: &[u8]) -> bool {
    let Some(head) = bytes
        .first_chunk::<20>()
        .filter(|head| head.starts_with(b"glTF"))
    else {
        return false;
    };
    let length = u32::from_le_bytes([head[12], head[13], head[14], head[15]]) as usize;
    let text = &bytes[20..bytes.len().min(20usize.saturating_add(length))];
    text.windows(EXTENSION.len())
        .any(|window| window == EXTENSION.as_bytes())
}

/// Reads a built model; `name` is what errors call it.
///
/// # Errors
/// [`Error::Input`] naming the element and the reason: whatever [`Scene::from_bytes`] refuses, and an extension whose
/// parts are missing, of the wrong length, out of range, or not those of this mesh.
pub fn read(name: &str, bytes: &[u8]) -> Result<Built> {
    let full = Opened::new(name, bytes, None)?;
    let json = &full.document.json;
    let extension = &json["extensions"][EXTENSION];
    if extension.is_null() {
        return Err(Error::input(
            name,
            "extensions",
            format!("has no {EXTENSION}: not a built model; run build first"),
        ));
    }
    let root: RootExtension = parse(name, "", extension)?;
    if root.version != VERSION {
        return Err(Error::input(
            name,
            "extensions",
            format!("{EXTENSION} version {} is not {VERSION}", root.version),
        ));
    }
    let mut scene = read_original(name, &full, &root)?;
    let reader = full.reader();
    let mut meshes = Vec::new();
    for mesh in 0..scene.meshes.len() {
        let extension = &json["meshes"][mesh]["extensions"][EXTENSION];
        if !extension.is_null() {
            let element = format!("meshes[{mesh}]");
            let extension: MeshExtension = parse(name, &format!("{element}."), extension)?;
            if let Some(embedding) = &extension.embedding {
                let reading = Reading::new((name, &full, &reader), &scene, mesh);
                scene.meshes[mesh] = reading.cut_open(embedding)?;
            }
            let reading = Reading::new((name, &full, &reader), &scene, mesh);
            meshes.push(reading.built_mesh(extension)?);
        }
    }
    Ok(Built { scene, meshes })
}

pub(super) fn parse<T: for<'de> Deserialize<'de>>(
    name: &str,
    element: &str,
    value: &Value,
) -> Result<T> {
    T::deserialize(value).map_err(|e| {
        Error::input(
            name,
            format!("{element}extensions.{EXTENSION}"),
            e.to_string(),
        )
    })
}

/// The model as it was before the build.
fn read_original(name: &str, full: &Opened, root: &RootExtension) -> Result<Scene> {
    let mut json = full.document.json.clone();
    let bad = |what: &str| {
        Error::input(
            name,
            format!("extensions.{EXTENSION}.original"),
            format!("{what} does not fit the document"),
        )
    };
    original::strip(&mut json, &root.original).map_err(bad)?;
    let length = root.original.byte_length.unwrap_or(0);
    let binary = full
        .document
        .binary
        .get(..length)
        .ok_or_else(|| bad("byteLength"))?;
    let bin = root.original.byte_length.is_some().then_some(binary);
    Opened::from_json(name, json, bin, None, length as u64)?.into_scene()
}

/// One mesh's extension being read.
pub(super) struct Reading<'a> {
    name: &'a str,
    pub(super) full: &'a Opened,
    pub(super) reader: &'a Reader<'a>,
    pub(super) scene: &'a Scene,
    pub(super) mesh: usize,
    pub(super) element: String,
}

impl<'a> Reading<'a> {
    fn new(
        (name, full, reader): (&'a str, &'a Opened, &'a Reader<'a>),
        scene: &'a Scene,
        mesh: usize,
    ) -> Self {
        Reading {
            name,
            full,
            reader,
            scene,
            mesh,
            element: format!("meshes[{mesh}]"),
        }
    }

    pub(super) fn fault(&self, what: &str, reason: impl Into<String>) -> Error {
        Error::input(self.name, format!("{}.{what}", self.element), reason)
    }

    pub(super) fn mesh(&self) -> &Mesh {
        &self.scene.meshes[self.mesh]
    }

    fn built_mesh(&self, extension: MeshExtension) -> Result<BuiltMesh> {
        if let PrimaryKind::UvSet(set) = extension.primary.kind
            && usize::from(set) >= self.mesh().uv_sets.len()
        {
            return Err(self.fault("primary", format!("the mesh has no uv set {set}")));
        }
        let computed = matches!(extension.primary.kind, PrimaryKind::Computed(_));
        if computed != extension.embedding.is_some() {
            return Err(self.fault(
                "embedding",
                "comes with a computed primary, and only with one",
            ));
        }
        let tables = Tables {
            layout: extension.layout,
            format: extension.format,
            hash_size: extension.hash_size,
            window: extension.window,
            primary: extension.primary,
            hash: self.words("hash", extension.hash)?.into(),
            list: self.words("list", extension.list)?.into(),
            triangle: self.words("triangle", extension.triangle)?.into(),
            stats: extension.stats,
        };
        let triangles = self.mesh().triangles.len();
        tables
            .validate(triangles)
            .map_err(|(element, reason)| self.fault(&element, reason))?;
        if tables.sha256() != extension.tables_sha256 {
            return Err(self.fault(
                "tablesSha256",
                "is not that of the tables: the file is damaged",
            ));
        }
        let triangle_layer = self.layers("layer", extension.layer, triangles)?;
        let reference = super::reference_sha256(self.mesh(), &tables, &triangle_layer)?;
        if reference != extension.reference_sha256 {
            return Err(self.fault(
                "referenceSha256",
                "the tables were built for another mesh; build again",
            ));
        }
        if extension.lods.len() > MAX_LODS {
            return Err(self.fault(
                "lods",
                format!(
                    "{} of them, up to {MAX_LODS} are read",
                    extension.lods.len()
                ),
            ));
        }
        let lods = extension
            .lods
            .iter()
            .enumerate()
            .map(|(k, lod)| self.lod(k, lod))
            .collect::<Result<_>>()?;
        let prefiltered = extension
            .prefiltered
            .map(|p| self.prefiltered(&p))
            .transpose()?;
        let hierarchy = extension
            .hierarchy
            .map(|h| self.hierarchy(&h, &tables.primary))
            .transpose()?;
        Ok(BuiltMesh {
            mesh: self.mesh,
            triangle_layer,
            tables,
            lods,
            prefiltered,
            hierarchy,
            report: extension.report,
        })
    }

    /// The mesh cut open for its computed map.
    fn cut_open(&self, extension: &EmbeddingExtension) -> Result<Mesh> {
        let words = |view| self.words("embedding", view);
        embedding::read(extension, self.mesh(), words)?
            .map_err(|reason| self.fault("embedding", reason))
    }

    fn prefiltered(&self, extension: &PrefilteredExtension) -> Result<Prefiltered> {
        let size = extension.size;
        Prefiltered::check(size, extension.scope)
            .map_err(|reason| self.fault("prefiltered", reason))?;
        let mut images: [Vec<u8>; 4] = Default::default();
        for (k, image) in images.iter_mut().enumerate() {
            let what = format!("prefiltered.images[{k}]");
            let element = format!("{}.{what}", self.element);
            let png = self.full.view(extension.images[k], &element)?;
            self.reader
                .charge(2 * size as usize * size as usize, 4, || element)?;
            *image = super::prefiltered::decode(size, png)
                .map_err(|reason| self.fault(&what, reason))?;
        }
        Prefiltered::new(size, extension.scope, images)
    }

    fn hierarchy(&self, extension: &HierarchyExtension, primary: &Primary) -> Result<Hierarchy> {
        let mesh = self.mesh();
        let input = LodInput {
            mesh,
            primary,
            parts: &param::parts(mesh, primary),
            world: glam::Mat4::IDENTITY.to_cols_array_2d(),
        };
        let words = |view| self.words("hierarchy", view);
        let bytes = |view: Option<usize>| match view {
            Some(view) => self.bytes("hierarchy", view),
            None => Ok(Vec::new()),
        };
        hierarchy::read(extension, &input, words, bytes)?
            .map_err(|reason| self.fault("hierarchy", reason))
    }

    fn bytes(&self, what: &str, view: usize) -> Result<Vec<u8>> {
        let bytes = self.full.view(view, &format!("{}.{what}", self.element))?;
        self.reader
            .charge(bytes.len(), 1, || self.element.clone())?;
        Ok(bytes.to_vec())
    }

    fn words(&self, what: &str, view: Option<usize>) -> Result<Vec<u32>> {
        let Some(view) = view else {
            return Ok(Vec::new());
        };
        let bytes = self.full.view(view, &format!("{}.{what}", self.element))?;
        let (words, []) = bytes.as_chunks::<4>() else {
            return Err(self.fault(what, format!("{} bytes are not whole words", bytes.len())));
        };
        self.reader
            .charge(words.len(), 4, || self.element.clone())?;
        Ok(words.iter().map(|w| u32::from_le_bytes(*w)).collect())
    }

    pub(super) fn layers(&self, what: &str, view: usize, triangles: usize) -> Result<Vec<u8>> {
        let bytes = self.bytes(what, view)?;
        if bytes.len() != triangles {
            return Err(self.fault(
                what,
                format!("{} layers for {triangles} triangles", bytes.len()),
            ));
        }
        Ok(bytes)
    }
}
