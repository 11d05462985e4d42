//! What `render` says of its images.

use invertex::render::Rendered;
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::print::{Table, thousands};
use super::render_stages::{CutReport, Drawn};

#[derive(Serialize)]
pub(super) struct Report {
    pub(super) file: String,
    pub(super) device: String,
    /// Name of the animation.
    pub(super) animation: Option<String>,
    /// What is shown in place of base colour.
    pub(super) attribute: Option<String>,
    pub(super) images: Vec<ImageReport>,
    pub(super) warnings: Vec<String>,
}

#[derive(Serialize)]
pub(super) struct ImageReport {
    path: String,
    /// Seconds into the animation.
    time: Option<f64>,
    width: u32,
    height: u32,
    lod: usize,
    /// The level that is left.
    #[serde(skip_serializing_if = "Option::is_none")]
    leaving: Option<Leaving>,
    /// Limits and cost of a cut, where one was drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    cut: Option<CutReport>,
    triangles: u32,
    covered_pixels: u64,
    mean_fetches: f64,
    /// Shown without a lookup, where that may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    prefiltered_pixels: Option<u64>,
    sha256: String,
    passes: Vec<Pass>,
}

/// A level that gives way to another.
#[derive(Serialize)]
struct Leaving {
    lod: usize,
    /// How much of the image is the other one's.
    share: f32,
}

#[derive(Serialize)]
struct Pass {
    name: String,
    nanoseconds: u64,
}

impl ImageReport {
    /// Of an image written as `bytes` to `path`.
    pub(super) fn new(
        path: String,
        bytes: &[u8],
        drawn: Drawn,
        time: Option<f64>,
        shader_lod: bool,
    ) -> Self {
        let pass = |(name, nanoseconds)| Pass { name, nanoseconds };
        let digest = Sha256::digest(bytes);
        let image = drawn.image;
        ImageReport {
            path,
            time,
            width: image.width,
            height: image.height,
            lod: drawn.level,
            leaving: drawn.leaving.map(|(lod, share)| Leaving { lod, share }),
            cut: drawn.cut,
            triangles: drawn.triangles,
            covered_pixels: image.covered_pixels,
            mean_fetches: image.mean_fetches,
            prefiltered_pixels: shader_lod.then(|| prefiltered(&image)),
            sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(),
            passes: image.passes.into_iter().map(pass).collect(),
        }
    }
}

/// Pixels that show something and stand for no point of the reference: one fetch each.
fn prefiltered(image: &Rendered) -> u64 {
    let pixels = image.triangle.iter().zip(&image.draw).zip(&image.fetches);
    let alone = |&((&triangle, &draw), &fetches): &((&u32, &u32), &u32)| {
        draw != u32::MAX && triangle == u32::MAX && fetches == 1
    };
    pixels.filter(alone).count() as u64
}

impl Report {
    pub(super) fn table(&self) -> Table {
        let moving = self.animation.is_some();
        let mut columns = vec![
            "image",
            "size",
            "LoD",
            "triangles",
            "covered pixels",
            "fetches",
        ];
        columns.extend(moving.then_some("time"));
        columns.push("sha256");
        let mut table = Table::new(&columns);
        for image in &self.images {
            let mut row = vec![
                image.path.clone(),
                format!("{}x{}", image.width, image.height),
                image.lod.to_string(),
                thousands(image.triangles.into()),
                thousands(image.covered_pixels),
                format!("{:.2}", image.mean_fetches),
            ];
            row.extend(moving.then(|| format!("{:.3} s", image.time.unwrap_or(0.0))));
            row.push(image.sha256[..16].to_owned());
            table.row(row);
        }
        table
    }
}
