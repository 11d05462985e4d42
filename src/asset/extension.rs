//! The JSON of the vendor extension, as `schema/` documents it.

use super::embedding::EmbeddingExtension;
use super::hierarchy::HierarchyExtension;
use crate::attribute::Scope;
use crate::igt::{Format, Layout, Stats, Window};
use crate::param::Primary;
use serde::{Deserialize, Serialize};

/// Name of the vendor extension, on the root and on each reference mesh.
pub const EXTENSION: &str = "INVERTEX_inverse_geometric_texture";

/// Name of the extension that tells other viewers of LoDs.
pub(super) const MSFT_LOD: &str = "MSFT_lod";

/// Version of the extension that is written and read.
pub(super) const VERSION: u32 = 3;

/// On the root: what of the document is the original's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RootExtension {
    pub(super) version: u32,
    pub(super) original: Counts,
}

/// Lengths of the original's arrays, `None` where it has no such array. What comes after was appended.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct Counts {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) accessors: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) buffer_views: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) meshes: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) nodes: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) extensions_used: Option<usize>,
    /// Bytes of the only buffer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) byte_length: Option<usize>,
}

/// On a mesh: its tables and LoDs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct MeshExtension {
    pub(super) primary: Primary,
    /// Places in T3, for a primary that is computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) embedding: Option<EmbeddingExtension>,
    pub(super) layout: Layout,
    pub(super) format: Format,
    /// Width and height of the hash texture, in texels.
    pub(super) hash_size: [u32; 2],
    /// Those of them that are stored.
    pub(super) window: Window,
    /// Buffer views of little-endian 32-bit words; `None` for a table without any.
    pub(super) hash: Option<usize>,
    pub(super) list: Option<usize>,
    pub(super) triangle: Option<usize>,
    /// Buffer view of one byte per triangle of the mesh.
    pub(super) layer: usize,
    /// Of the three tables, as [`crate::igt::Tables::sha256`].
    pub(super) tables_sha256: String,
    /// Of the mesh as the tables see it.
    pub(super) reference_sha256: String,
    pub(super) stats: Stats,
    pub(super) lods: Vec<LodExtension>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) prefiltered: Option<PrefilteredExtension>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) hierarchy: Option<HierarchyExtension>,
    #[serde(default)]
    pub(super) report: serde_json::Value,
}

/// What was filtered beforehand over the primary parameterization.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PrefilteredExtension {
    /// Texels along each side of the first level.
    pub(super) size: u32,
    pub(super) scope: Scope,
    /// Buffer views of PNG.
    pub(super) images: [usize; 4],
}

/// One LoD of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LodExtension {
    /// The glTF mesh, which has one primitive.
    pub(super) mesh: usize,
    /// Buffer view of one byte per triangle of the LoD.
    pub(super) layer: usize,
    /// In object units.
    pub(super) error: f32,
    /// Whether the error is a bound along projection lines.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(super) bounded: bool,
    pub(super) turned: u32,
    pub(super) reached: bool,
}
