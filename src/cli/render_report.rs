//! What `render` says of its images.

use invertex::render::Rendered;
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::print::{Table, thousands};

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
    triangles: u32,
    covered_pixels: u64,
    mean_fetches: f64,
    sha256: String,
    passes: Vec<Pass>,
}

#[derive(Serialize)]
struct Pass {
    name: String,
    nanoseconds: u64,
}

impl ImageReport {
    /// Of an image of `triangles` triangles at level `lod`, written as `bytes` to `path`.
    pub(super) fn new(
        path: String,
        bytes: &[u8],
        image: Rendered,
        (lod, triangles): (usize, u32),
        time: Option<f64>,
    ) -> Self {
        let pass = |(name, nanoseconds)| Pass { name, nanoseconds };
        let digest = Sha256::digest(bytes);
        ImageReport {
            path,
            time,
            width: image.width,
            height: image.height,
            lod,
            triangles,
            covered_pixels: image.covered_pixels,
            mean_fetches: image.mean_fetches,
            sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(),
            passes: image.passes.into_iter().map(pass).collect(),
        }
    }
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
