//! `compare`: how two pictures, or two folders of pictures, differ.

use std::path::{Path, PathBuf};

use invertex::measure::{
    Comparison, FolderComparison, Picture, Region, compare, compare_folders, difference_image,
};
use invertex::output::{check_target, encode_png, write_bytes};
use invertex::{Error, Result};
use serde::Serialize;

use super::print::{self, Table, thousands};
use super::{Common, bad_option, note};

/// Compare two pictures, or two folders of pictures by name.
///
/// FLIP and PSNR are averaged over the pixels that either picture covers (alpha above zero; without alpha, what is
/// not mid grey), both composited over mid grey. PSNR is null when nothing differs. Exit code 5 when a limit below is
/// exceeded, or when a folder lacks a picture that the other has.
#[derive(clap::Args)]
#[command(after_help = "\
JSON: flip_mean, flip_max, psnr_db (null: identical), differing_pixels, max_channel_difference, and for two pictures
width, height, compared_pixels, silhouette_pixels; for two folders only_in_first[], only_in_second[],
images[]: name and the figures of the pair.

Examples:
  invertex compare reference.png lod2.png
  invertex compare reference.png lod2.png --diff flip.png     where they differ, in FLIP's colours
  invertex compare reference/ lod2/ --json                    pairs of the same name, pooled
  invertex compare golden.png now.png --identical             exit code 5 unless every pixel agrees
  invertex compare golden.png now.png --max-flip 0.01 --min-psnr 40")]
pub(super) struct Compare {
    /// The reference: a picture (PNG, EXR, JPEG, WebP) or a folder.
    a: PathBuf,
    /// The candidate: likewise.
    b: PathBuf,
    /// Write FLIP of each pixel as a picture in FLIP's colours.
    #[arg(long, value_name = "FILE.png")]
    diff: Option<PathBuf>,
    /// Count every pixel, background included.
    #[arg(long)]
    whole: bool,
    /// Fail (exit code 5) when the mean FLIP is above this.
    #[arg(long, value_name = "FLIP", value_parser = limit)]
    max_flip: Option<f64>,
    /// Fail (exit code 5) when the PSNR is below this.
    #[arg(long, value_name = "DB", value_parser = limit)]
    min_psnr: Option<f64>,
    /// Fail (exit code 5) when a pixel differs.
    #[arg(long)]
    identical: bool,
}

#[derive(Serialize)]
struct PairReport<'a> {
    a: &'a Path,
    b: &'a Path,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

#[derive(Serialize)]
struct FolderReport<'a> {
    a: &'a Path,
    b: &'a Path,
    #[serde(flatten)]
    comparison: &'a FolderComparison,
}

impl Compare {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        if self.a.is_dir() != self.b.is_dir() && self.a.exists() && self.b.exists() {
            let (folder, file) = if self.a.is_dir() {
                (&self.a, &self.b)
            } else {
                (&self.b, &self.a)
            };
            let reason = format!(
                "is a folder, but {} is not; give two of a kind",
                file.display()
            );
            return Err(Error::input(
                folder.display().to_string(),
                "picture",
                reason,
            ));
        }
        if self.a.is_dir() {
            self.folders(common)
        } else {
            self.pictures(common)
        }
    }

    fn region(&self) -> Region {
        if self.whole {
            Region::Everything
        } else {
            Region::Foreground
        }
    }

    fn pictures(&self, common: &Common) -> Result<()> {
        if let Some(target) = &self.diff {
            check_target(target)?;
        }
        let [a, b] = [Picture::load(&self.a)?, Picture::load(&self.b)?];
        let names = [self.a.display().to_string(), self.b.display().to_string()];
        let names = [names[0].as_str(), names[1].as_str()];
        let comparison = compare(&a, &b, self.region(), names)?;
        if let Some(target) = &self.diff {
            let map = difference_image(&a, &b, self.region(), names)?;
            write_bytes(target, &encode_png(map.width, map.height, map.bytes())?)?;
            note(common, &format!("wrote {}", target.display()));
        }
        if common.json {
            print::json(&PairReport {
                a: &self.a,
                b: &self.b,
                comparison: &comparison,
            })?;
        } else {
            print::text(&pair_table(&comparison).text())?;
        }
        self.judge(
            comparison.flip_mean,
            comparison.psnr_db,
            comparison.differing_pixels,
        )
    }

    fn folders(&self, common: &Common) -> Result<()> {
        if self.diff.is_some() {
            return Err(bad_option("--diff", "needs two pictures, not two folders"));
        }
        let comparison = compare_folders(&self.a, &self.b, self.region())?;
        if common.json {
            print::json(&FolderReport {
                a: &self.a,
                b: &self.b,
                comparison: &comparison,
            })?;
        } else {
            print::text(&folder_table(&comparison).text())?;
        }
        let lonely = comparison.only_in_first.len() + comparison.only_in_second.len();
        if lonely > 0 {
            let names: Vec<&str> = comparison
                .only_in_first
                .iter()
                .chain(&comparison.only_in_second)
                .map(String::as_str)
                .take(5)
                .collect();
            let more = if lonely > names.len() { ", ..." } else { "" };
            let text = format!(
                "{lonely} pictures are in one folder only: {}{more}",
                names.join(", ")
            );
            return Err(Error::Threshold(text));
        }
        self.judge(
            comparison.flip_mean,
            comparison.psnr_db,
            comparison.differing_pixels,
        )
    }

    fn judge(&self, flip_mean: f64, psnr_db: Option<f64>, differing_pixels: usize) -> Result<()> {
        let fail = |text: String| Err(Error::Threshold(text));
        if let Some(limit) = self.max_flip.filter(|&limit| flip_mean > limit) {
            return fail(format!("mean FLIP {flip_mean:.6} is above {limit}"));
        }
        if let (Some(limit), Some(psnr)) = (self.min_psnr, psnr_db)
            && psnr < limit
        {
            return fail(format!("PSNR {psnr:.3} dB is below {limit} dB"));
        }
        if self.identical && differing_pixels > 0 {
            return fail(format!("{differing_pixels} pixels differ"));
        }
        Ok(())
    }
}

/// A number that a measure can be compared with; NaN would let everything pass.
fn limit(text: &str) -> std::result::Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if number.is_nan() {
        Err("not a number".to_owned())
    } else {
        Ok(number)
    }
}

fn psnr(value: Option<f64>) -> String {
    value.map_or("identical".to_owned(), |db| format!("{db:.2} dB"))
}

fn pair_table(c: &Comparison) -> Table {
    let mut table = Table::new(&["measure", "value"]);
    table.row(["mean FLIP".to_owned(), format!("{:.6}", c.flip_mean)]);
    table.row(["largest FLIP".to_owned(), format!("{:.6}", c.flip_max)]);
    table.row(["PSNR".to_owned(), psnr(c.psnr_db)]);
    table.row([
        "compared pixels".to_owned(),
        thousands(c.compared_pixels as u64),
    ]);
    table.row([
        "differing pixels".to_owned(),
        thousands(c.differing_pixels as u64),
    ]);
    table.row([
        "largest channel difference".to_owned(),
        c.max_channel_difference.to_string(),
    ]);
    table.row([
        "silhouette pixels".to_owned(),
        thousands(c.silhouette_pixels as u64),
    ]);
    table
}

fn folder_table(c: &FolderComparison) -> Table {
    let mut table = Table::new(&[
        "picture",
        "mean FLIP",
        "largest",
        "PSNR",
        "differing pixels",
    ]);
    let mut row = |name: &str, flip: f64, largest: f64, db: Option<f64>, pixels: usize| {
        table.row([
            name.to_owned(),
            format!("{flip:.6}"),
            format!("{largest:.6}"),
            psnr(db),
            thousands(pixels as u64),
        ]);
    };
    for image in &c.images {
        let i = &image.comparison;
        row(
            &image.name,
            i.flip_mean,
            i.flip_max,
            i.psnr_db,
            i.differing_pixels,
        );
    }
    row(
        "all",
        c.flip_mean,
        c.flip_max,
        c.psnr_db,
        c.differing_pixels,
    );
    table
}
