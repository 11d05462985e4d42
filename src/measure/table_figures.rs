//! What a profile's row says of the tables that are looked up in.
//!
//! In: a built model and what is drawn of it. Out: layout, resolution, mean list and bytes, over all of its meshes.

use super::plan::Variant;
use crate::asset::Built;
use crate::igt::Layout;

/// The figures; none where nothing is looked up.
#[derive(Default)]
pub(super) struct TableFigures {
    pub(super) layout: Option<Layout>,
    pub(super) hash: Option<u32>,
    pub(super) mean_list: Option<f64>,
    pub(super) bytes: u64,
}

impl TableFigures {
    pub(super) fn of(built: &Built, variant: Variant) -> Self {
        let tables = || built.meshes.iter().map(|mesh| &mesh.tables);
        let Some(first) = tables().next().filter(|_| variant == Variant::Inverse) else {
            return TableFigures::default();
        };
        // Texels with a list, from what a build keeps: entries and their mean.
        let entries: u64 = tables().map(|t| t.stats.entries).sum();
        let filled = |mean: f64, entries: u64| {
            if mean > 0.0 {
                entries as f64 / mean
            } else {
                0.0
            }
        };
        let texels: f64 = tables()
            .map(|t| filled(t.stats.mean_list, t.stats.entries))
            .sum();
        let alike = tables().all(|t| t.hash_size == first.hash_size);
        TableFigures {
            layout: Some(first.layout),
            hash: alike.then_some(first.hash_size[0]),
            mean_list: (texels > 0.0).then(|| entries as f64 / texels),
            bytes: tables().flat_map(|t| t.bytes()).sum(),
        }
    }
}
