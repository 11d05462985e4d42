//! Memory of inverse textures, table by table: the paper's Table 1.
//!
//! In: a built model. Out: a [`MemoryRow`] for each of its meshes.

use crate::asset::{Built, TableBytes};
use crate::igt::Layout;
use serde::Serialize;

/// What the tables of one mesh take.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MemoryRow {
    /// The built file.
    pub file: String,
    /// The mesh.
    pub mesh: String,
    /// Triangles of the reference.
    pub triangles: usize,
    /// The primary parameterization.
    pub primary: String,
    /// The layout.
    pub layout: Layout,
    /// Side of the hash texture, texels.
    pub hash: u32,
    /// Mean list length over texels that have one.
    pub mean_list: f64,
    /// Bytes of each table.
    pub bytes: TableBytes,
    /// Bytes for each triangle of the reference.
    pub bytes_per_triangle: f64,
}

/// The rows of `built`, which `file` is the name of.
pub fn memory(file: &str, built: &Built) -> Vec<MemoryRow> {
    let row = |mesh: &crate::asset::BuiltMesh| {
        let (reference, tables) = (&built.scene.meshes[mesh.mesh], &mesh.tables);
        let [hash, list, triangle] = tables.bytes();
        let total = hash + list + triangle;
        let triangles = reference.triangles.len();
        MemoryRow {
            file: file.to_owned(),
            mesh: reference.name.clone(),
            triangles,
            primary: tables.primary.kind.to_string(),
            layout: tables.layout,
            hash: tables.hash_size[0],
            mean_list: tables.stats.mean_list,
            bytes: TableBytes {
                hash,
                list,
                triangle,
                attribute: 0,
                total,
            },
            bytes_per_triangle: total as f64 / triangles.max(1) as f64,
        }
    };
    built.meshes.iter().map(row).collect()
}
