//! What a build says of each mesh.
//!
//! In: a mesh, its tables and LoDs. Out: [`MeshReport`], which is kept in the built file and printed by `build --json`.
//! It holds no times and no device, so that it does not depend on where the build ran.

use super::BuiltMesh;
use super::build::Prepared;
use crate::igt::{Ambiguous, Layout, Tables};
use crate::lod::Simplifier;
use crate::lod::deviation::Deviation;
use crate::lod::multiresolution::Hierarchy;
use crate::lod::progressive::colour::Distance;
use crate::mesh::Mesh;
use crate::param::{self, Quality, Weighed};
use serde::{Deserialize, Serialize};

/// Ambiguous triangles that a report names.
pub const NAMED: usize = 64;

/// Everything a build says of one mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeshReport {
    /// Its name.
    pub name: String,
    /// Triangles of the reference.
    pub triangles: usize,
    /// Connected parts of the reference in T3.
    pub parts: usize,
    /// The primary parameterization, as `--primary` spells it.
    pub primary: String,
    /// Why that one.
    pub why: String,
    /// What `auto` weighed against each other; empty where nothing had to be.
    #[serde(default)]
    pub weighed: Vec<Weighed>,
    /// What a computed map does to lengths and angles, its charts and seams; null for others.
    #[serde(default)]
    pub map: Option<Quality>,
    /// Texels of the hash texture: width and height.
    pub hash: [u32; 2],
    /// The layout of the tables.
    pub layout: Layout,
    /// List entries, gutter included.
    pub entries: u64,
    /// Mean list length over texels that have one.
    pub mean_list: f64,
    /// The longest list.
    pub max_list: u32,
    /// Entries that only serve points outside the reference's charts.
    pub gutter_entries: u64,
    /// How far the gutter had to reach, in texels.
    pub gutter_width: u32,
    /// Texels that a LoD touches and that no gutter reaches.
    pub unreached_texels: u64,
    /// Reference triangles that the grid collapsed: nothing maps to them.
    pub collapsed_triangles: u64,
    /// Share of the covered domain that is covered more than once within one part, where nothing tells the answers apart.
    pub ambiguous_fraction: f64,
    /// Triangles that share a place with another of their layer, exactly: see [`Ambiguous`].
    pub ambiguous_triangles: usize,
    /// Their share of the surface area: at most so much of it is ambiguous.
    pub ambiguous_area_fraction: f64,
    /// The first of them, up to 64.
    pub ambiguous_first: Vec<u32>,
    /// Share of the covered domain that is covered more than once at all.
    pub overlap_fraction: f64,
    /// Share of the surface that is turned away from its projection lines.
    pub turned_fraction: f64,
    /// Bytes of each table.
    pub bytes: TableBytes,
    /// SHA-256 of the tables.
    pub tables_sha256: String,
    /// The LoDs, finest first.
    pub lods: Vec<LodReport>,
    /// Of which views take cuts; null without `--mrm`.
    #[serde(default)]
    pub multiresolution: Option<HierarchyReport>,
}

/// What a build says of a multiresolution model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HierarchyReport {
    /// Steps of the simplification.
    pub collapses: usize,
    /// Triangles of all ages.
    pub triangles: usize,
    /// Triangles of the coarsest cut.
    pub coarsest: usize,
    /// Footprints that colours are measured at; 0 where only geometry counts.
    pub colour_levels: usize,
    /// What colours are measured by; null where only geometry counts.
    pub colour_distance: Option<Distance>,
}

impl HierarchyReport {
    fn of(hierarchy: &Hierarchy) -> Self {
        let history = &hierarchy.history;
        let colours = hierarchy.colours.as_ref();
        HierarchyReport {
            collapses: history.collapses.len(),
            triangles: history.triangles.len(),
            coarsest: history.after(history.collapses.len()).count(),
            colour_levels: colours.map_or(0, |c| c.levels),
            colour_distance: colours.map(|c| c.distance),
        }
    }
}

/// Bytes of each table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableBytes {
    /// The hash texture.
    pub hash: u64,
    /// The lists.
    pub list: u64,
    /// The triangles' T3 coordinates.
    pub triangle: u64,
    /// Attributes beyond those of the original model, which serve as they are: none.
    pub attribute: u64,
    /// All of them.
    pub total: u64,
}

/// What a build says of one LoD.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LodReport {
    /// Its triangles.
    pub triangles: usize,
    /// Its vertices.
    pub vertices: usize,
    /// Largest distance from the reference, object units (see [`crate::lod::deviation`]).
    pub deviation_max: f32,
    /// Root mean square of it.
    pub deviation_rms: f32,
    /// Bound of how far any point of the LoD lies from the point of the reference that it stands for, object units; null
    /// where the simplifier knows none.
    #[serde(default)]
    pub deviation_bound: Option<f32>,
    /// Triangles that lie the other way round in T3.
    pub turned: u32,
    /// False where the simplifier could not come down to the triangles asked for.
    pub reached: bool,
}

impl MeshReport {
    /// As the file keeps it.
    pub(super) fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(self).unwrap_or_default()
    }
}

impl BuiltMesh {
    /// Largest distance of LoD `lod` (0 is the finest LoD) from the reference, in object units: the simplifier's bound where
    /// it has one, else as the build measured it, or, where the file does not say so credibly, the simplifier's figure.
    pub fn deviation_max(&self, lod: usize) -> f32 {
        let said = |what: &str| {
            let said = self.report["lods"][lod][what].as_f64().map(|d| d as f32);
            said.filter(|d| d.is_finite() && *d >= 0.0)
        };
        said("deviation_bound")
            .or_else(|| said("deviation_max"))
            .unwrap_or_else(|| self.lods.get(lod).map_or(0.0, |lod| lod.error))
    }
}

pub(super) fn of(
    mesh: &Mesh,
    prepared: &Prepared,
    tables: &Tables,
    ambiguous: &Ambiguous,
    (far, simplifier): (&[Deviation], Simplifier),
) -> MeshReport {
    let primary = &prepared.primary;
    let fit = param::fit(mesh, primary.kind, Some(primary.frame.origin));
    let of_fit = |value: fn(&param::Fit) -> f64| fit.as_ref().map_or(0.0, value);
    let [hash, list, triangle] = tables.bytes();
    let stats = &tables.stats;
    let lod = |(lod, far): (&crate::lod::Lod, &Deviation)| LodReport {
        triangles: lod.triangles.len(),
        vertices: lod.positions.len(),
        deviation_max: far.max,
        deviation_rms: far.rms,
        deviation_bound: (simplifier != Simplifier::Meshopt).then_some(lod.error),
        turned: lod.turned,
        reached: lod.reached,
    };
    MeshReport {
        name: mesh.name.clone(),
        triangles: mesh.triangles.len(),
        parts: prepared.parts.part_count,
        primary: primary.kind.to_string(),
        why: prepared.why.clone(),
        weighed: prepared.weighed.clone(),
        map: prepared.quality.clone(),
        hash: tables.hash_size,
        layout: tables.layout,
        entries: stats.entries,
        mean_list: stats.mean_list,
        max_list: stats.max_list,
        gutter_entries: stats.gutter_entries,
        gutter_width: stats.gutter_width,
        unreached_texels: stats.unreached_texels,
        collapsed_triangles: stats.collapsed_triangles,
        ambiguous_fraction: of_fit(|f| f.overlap_within_parts),
        ambiguous_triangles: ambiguous.triangles.len(),
        ambiguous_area_fraction: ambiguous.area_fraction,
        ambiguous_first: ambiguous.triangles.iter().copied().take(NAMED).collect(),
        overlap_fraction: of_fit(|f| f.overlap_fraction),
        turned_fraction: of_fit(|f| f.turned_fraction),
        bytes: TableBytes {
            hash,
            list,
            triangle,
            attribute: 0,
            total: hash + list + triangle,
        },
        tables_sha256: tables.sha256(),
        lods: prepared.lods.iter().zip(far).map(lod).collect(),
        multiresolution: prepared.hierarchy.as_ref().map(HierarchyReport::of),
    }
}
