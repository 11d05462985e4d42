//! The built GLB: the original model, its LoDs and its inverse geometric textures in one file.
//!
//! In: a [`Built`] model. Out: a GLB that any other viewer shows as the original, and from which [`read`] gives back the same
//! [`Built`], bit by bit. What comes from a file is untrusted: everything is checked before a lookup or a shader sees it.
//!
//! ```text
//! original document            appended
//! JSON  accessors, views, ...  accessors and views of LoDs and tables; LoD meshes; LoD nodes; extension objects
//! BIN   its bytes, untouched   hash, list and triangle words; layers; LoD attributes
//! ```
//!
//! LoDs are plain meshes named by MSFT_lod on the nodes; the tables stand in the vendor extension
//! `INVERTEX_inverse_geometric_texture` (schema in `schema/`), used but never required. Both directions are exact:
//! `read(to_bytes(b)) == b` and `to_bytes(read(x)) == x` for every `x` that [`to_bytes`] made. Tables alone are opened where
//! they lie, without reading the rest ([`open_tables`]).

mod build;
mod colours;
mod decode;
mod decode_lod;
mod embedding;
mod encode;
mod extension;
mod hierarchy;
mod morph;
mod motion;
mod original;
mod prefiltered;
mod rebuild;
mod report;
mod settings;
mod tables;
mod work;

pub use build::{BuildOutcome, build};
pub use colours::colours_of;
pub use decode::{is_built, read};
pub use encode::to_bytes;
pub use extension::EXTENSION;
pub use report::{HierarchyReport, LodReport, MeshReport, NAMED, TableBytes};
pub use settings::{BuildSettings, Multiresolution, Processor, Progress, hash_for};
pub use tables::{MeshTables, TableFile, open_tables};

use crate::attribute::Prefiltered;
use crate::igt::{Reference, Tables};
use crate::lod::Lod;
use crate::lod::multiresolution::Hierarchy;
use crate::mesh::Mesh;
use crate::scene::Scene;
use crate::{Error, Result};
use sha2::{Digest, Sha256};
use std::io::Write;
use std::path::Path;

/// A model with inverse geometric textures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Built {
    /// The original model.
    pub scene: Scene,
    /// What was built, in growing order of the mesh; meshes without an entry have no inverse texture.
    pub meshes: Vec<BuiltMesh>,
}

/// The inverse geometric texture of one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct BuiltMesh {
    /// Index into the scene's meshes: the reference.
    pub mesh: usize,
    /// For each triangle of the reference the layer of its part.
    pub triangle_layer: Vec<u8>,
    /// The tables.
    pub tables: Tables,
    /// Levels of detail, finest first. None of them is empty.
    pub lods: Vec<Lod>,
    /// What was filtered beforehand over the primary parameterization, for the shader LoD.
    pub prefiltered: Option<Prefiltered>,
    /// Triangles of every age, of which any view takes a cut.
    pub hierarchy: Option<Hierarchy>,
    /// Whatever else the build reports; kept, not interpreted.
    pub report: serde_json::Value,
}

impl Built {
    /// What was built for mesh `mesh` of the scene.
    pub fn of_mesh(&self, mesh: usize) -> Option<&BuiltMesh> {
        self.meshes.iter().find(|built| built.mesh == mesh)
    }
}

/// A file that may have inverse textures or not.
#[derive(Clone, Debug)]
pub enum Model {
    /// Any glTF file.
    Plain(Box<Scene>),
    /// One that [`to_bytes`] made.
    Built(Box<Built>),
}

impl Model {
    /// Reads either kind; resources of a plain file may lie beside it or below.
    ///
    /// # Errors
    /// As [`Scene::load`] and [`read`].
    pub fn load(path: &Path) -> Result<Model> {
        let bytes = crate::scene::read_file(path)?;
        let name = path.display().to_string();
        Ok(match is_built(&bytes) {
            true => Model::Built(Box::new(read(&name, &bytes)?)),
            false => Model::Plain(Box::new(Scene::from_bytes(&name, &bytes, path.parent())?)),
        })
    }

    /// The model without what was built.
    pub fn scene(&self) -> &Scene {
        match self {
            Model::Plain(scene) => scene,
            Model::Built(built) => &built.scene,
        }
    }
}

/// Writes a built model to `path`: the whole file or none. Bytes go to a temporary file beside it, which then takes the
/// name; whatever fails on the way, the temporary file is removed and an existing file stays as it was.
///
/// # Errors
/// Those of [`to_bytes`]; [`Error::Io`] where the folder is missing, not writable or full.
pub fn write(built: &Built, path: &Path) -> Result<()> {
    let bytes = to_bytes(built)?;
    let io = |source| Error::io(path, source);
    // A pipe or device is written to, never replaced by a file.
    if std::fs::metadata(path).is_ok_and(|meta| !meta.is_file() && !meta.is_dir()) {
        return std::fs::write(path, &bytes).map_err(io);
    }
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file, less the umask; a temporary file would be private.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder
        .prefix(".invertex-")
        .tempfile_in(folder)
        .map_err(io)?;
    file.write_all(&bytes).map_err(io)?;
    file.as_file().sync_all().map_err(io)?;
    file.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

/// SHA-256 of the reference as the tables see it (grid coordinates, triangles, layers): ties tables to their mesh.
fn reference_sha256(mesh: &Mesh, tables: &Tables, triangle_layer: &[u8]) -> Result<String> {
    let reference = Reference::new(mesh, &tables.primary, triangle_layer, tables.layout)?;
    let mut hasher = Sha256::new();
    reference
        .t3
        .iter()
        .for_each(|p| hasher.update(bytemuck::bytes_of(&p.map(i32::to_le))));
    reference
        .triangles
        .iter()
        .for_each(|t| hasher.update(bytemuck::bytes_of(&t.map(u32::to_le))));
    hasher.update(&reference.layer);
    Ok(hasher
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect())
}
