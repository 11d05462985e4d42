//! A row of a profile: what was drawn, what its pixels took, how long its frames took.

use super::fetches::FetchCounts;
use super::plan::{Sweep, Variant};
use super::timing::PassStatistics;
use crate::igt::Layout;
use crate::render::{Clock, Filter, FrameTime, Picture, Rendered};
use serde::Serialize;

/// One row of a profile.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// The built file.
    pub file: String,
    /// The mesh, or [`WHOLE`](super::WHOLE).
    pub mesh: String,
    /// What was drawn.
    pub variant: Variant,
    /// The sweep the row belongs to, if any.
    pub sweep: Option<Sweep>,
    /// How a pixel gathers the reference; uv loads are counted for its middle alone.
    pub filter: Filter,
    /// The level of detail.
    pub lod: usize,
    /// Distance, in units of the one at which the model fills the view.
    pub distance: f64,
    /// The layout of the tables, where there are any.
    pub layout: Option<Layout>,
    /// Side of the hash textures, texels; none where there are none or they differ.
    pub hash: Option<u32>,
    /// Triangles drawn, all instances counted.
    pub triangles: u32,
    /// Mean list length over texels that have one.
    pub mean_list: Option<f64>,
    /// Mean fetches of the correspondence over covered pixels.
    pub mean_fetches: f64,
    /// With those of the artist uv.
    pub mean_fetches_with_uv: f64,
    /// 99 % of the covered pixels took at most this.
    pub p99_fetches: u32,
    /// The most a pixel took.
    pub max_fetches: u32,
    /// Mean textures read over covered pixels.
    pub mean_texture_fetches: f64,
    /// Bytes of the tables.
    pub tables_bytes: u64,
    /// Bytes of the textures with their mip levels.
    pub texture_bytes: u64,
    /// Pixels that something covers.
    pub covered_pixels: u64,
    /// Of them, those that the tables know no point for.
    pub unmapped_pixels: u64,
    /// Half of the frames took at most this, nanoseconds.
    pub frame_ns_median: u64,
    /// 95 % of the frames.
    pub frame_ns_p95: u64,
    /// 99 % of the frames.
    pub frame_ns_p99: u64,
    /// Half of the repetitions of all covered pixels' lookups alone, in one pass, took at most this, nanoseconds; none
    /// where nothing is looked up, or in the tables of several meshes.
    pub lookup_ns_median: Option<u64>,
    /// 95 % of the repetitions.
    pub lookup_ns_p95: Option<u64>,
    /// Frames timed.
    pub frames: usize,
    /// What they were timed with.
    pub clock: Clock,
    /// The passes of a frame.
    pub passes: Vec<PassStatistics>,
    /// For each number of fetches from 0 on the covered pixels that took it.
    pub histogram: Vec<u64>,
    /// For each number of triangles from 0 on the covered pixels whose lookup tested so many; empty where nothing is looked
    /// up, or in the tables of several meshes.
    pub tests_histogram: Vec<u64>,
    /// Mean triangles tested, from it.
    pub mean_tests: Option<f64>,
    /// Every frame, for a trace.
    #[serde(skip)]
    pub times: Vec<FrameTime>,
    /// Fetches of each pixel, where any were counted at distance 1; none where nothing is.
    #[serde(skip)]
    pub fetches: Vec<Option<u32>>,
}

impl Run {
    /// The row with the counters of `image`.
    pub(super) fn counted(self, image: &Rendered, picture: &Picture) -> Run {
        let counts = FetchCounts::of(image, picture);
        let pixels = image.draw.iter().zip(&image.fetches);
        let fetches = pixels.map(|(&draw, &f)| (draw != u32::MAX).then_some(f));
        let shown = counts.max > 0 && self.distance == 1.0;
        Run {
            mean_fetches: counts.mean,
            mean_fetches_with_uv: counts.mean_with_uv,
            p99_fetches: counts.p99,
            max_fetches: counts.max,
            mean_texture_fetches: counts.mean_textures,
            covered_pixels: counts.covered_pixels,
            unmapped_pixels: counts.unmapped_pixels,
            histogram: counts.histogram,
            fetches: if shown { fetches.collect() } else { Vec::new() },
            ..self
        }
    }

    /// The row with the tests of its lookups.
    pub(super) fn tested(self, histogram: Vec<u64>) -> Run {
        let weighted = |(n, &count): (usize, &u64)| n as u64 * count;
        let tests: u64 = histogram.iter().enumerate().map(weighted).sum();
        let pixels: u64 = histogram.iter().sum();
        Run {
            mean_tests: (pixels > 0).then(|| tests as f64 / pixels as f64),
            tests_histogram: histogram,
            ..self
        }
    }
}
