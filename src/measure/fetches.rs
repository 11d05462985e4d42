//! Fetches of a picture: how many loads its pixels took.
//!
//! In: a drawn image with its AOVs, and the [`render::Picture`](crate::render::Picture) it was drawn from. Out: a histogram over covered pixels, mean,
//! percentile and maximum. A fetch is one load of at most 128 bits. Counters only: nothing here takes time.

use crate::igt::Layout;
use crate::render::{self, Rendered};
use serde::Serialize;

/// Loads that the artist uv takes where a lookup in draw `draw` found `triangle`: the renderer's own with packed tables,
/// the paper's with classic ones (its attribute texture holds a uv a texel). None where nothing is looked up: the
/// rasteriser interpolates it.
pub fn fetches_of_uv(picture: &render::Picture, draw: u32, triangle: u32) -> u32 {
    match picture.layout_of(draw) {
        None => 0,
        Some(Layout::Classic) => 3,
        Some(Layout::Packed) => picture.uv_fetches_at(draw, triangle),
    }
}

/// What the pixels of an image took.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FetchCounts {
    /// Pixels that something covers.
    pub covered_pixels: u64,
    /// Of them, those for which the tables know no point of the reference.
    pub unmapped_pixels: u64,
    /// Mean fetches of the correspondence over covered pixels.
    pub mean: f64,
    /// The same with those of the artist uv.
    pub mean_with_uv: f64,
    /// 99 % of the covered pixels took at most this.
    pub p99: u32,
    /// The most any pixel took.
    pub max: u32,
    /// Mean textures read over covered pixels.
    pub mean_textures: f64,
    /// For each number of fetches from 0 on the covered pixels that took it.
    pub histogram: Vec<u64>,
}

impl FetchCounts {
    /// Counts of `image`, drawn from `picture` with one sample a pixel.
    pub fn of(image: &Rendered, picture: &render::Picture) -> Self {
        let mut counts = FetchCounts::default();
        let (mut uv, mut textures) = (0u64, 0u64);
        for (pixel, &draw) in image.draw.iter().enumerate() {
            if draw == u32::MAX {
                continue;
            }
            counts.covered_pixels += 1;
            counts.add(image.fetches[pixel]);
            match image.triangle[pixel] {
                u32::MAX => counts.unmapped_pixels += 1,
                triangle => {
                    uv += u64::from(fetches_of_uv(picture, draw, triangle));
                    textures += u64::from(picture.textures_at(draw, triangle));
                }
            }
        }
        let pixels = counts.covered_pixels.max(1) as f64;
        let weighted = |(n, &count): (usize, &u64)| n as u64 * count;
        let sum: u64 = counts.histogram.iter().enumerate().map(weighted).sum();
        counts.mean = sum as f64 / pixels;
        counts.mean_with_uv = (sum + uv) as f64 / pixels;
        counts.mean_textures = textures as f64 / pixels;
        counts.p99 = counts.percentile(99);
        counts.max = counts.histogram.len().saturating_sub(1) as u32;
        counts
    }

    fn add(&mut self, fetches: u32) {
        let at = fetches as usize;
        if self.histogram.len() <= at {
            self.histogram.resize(at + 1, 0);
        }
        self.histogram[at] += 1;
    }

    /// The least number of fetches that `percent` of the covered pixels do not exceed.
    fn percentile(&self, percent: u64) -> u32 {
        let rank = (self.covered_pixels * percent).div_ceil(100).max(1);
        let mut below = 0;
        let reaches = |&count: &u64| {
            below += count;
            below >= rank
        };
        self.histogram.iter().position(reaches).unwrap_or(0) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(histogram: &[u64]) -> FetchCounts {
        FetchCounts {
            covered_pixels: histogram.iter().sum(),
            histogram: histogram.to_vec(),
            ..FetchCounts::default()
        }
    }

    #[test]
    fn percentiles_are_values_that_occur() {
        // 99 pixels with 2 fetches and one with 5: the 99th percentile is still 2; with two of them it is 5.
        assert_eq!(counted(&[0, 0, 99, 0, 0, 1]).percentile(99), 2);
        assert_eq!(counted(&[0, 0, 98, 0, 0, 2]).percentile(99), 5);
        assert_eq!(counted(&[7]).percentile(99), 0);
        assert_eq!(counted(&[]).percentile(99), 0, "nothing was drawn");
    }
}
