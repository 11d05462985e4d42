//! Two folders of pictures, compared by name.
//!
//! In: a folder of references and one of candidates. Out: [`FolderComparison`]: each pair, the figures pooled, and
//! the names that have no partner.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Serialize;

use super::compare::{Comparison, Region, compare, psnr_db};
use super::picture::Picture;
use crate::{Error, Result};

/// One pair of pictures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairComparison {
    /// The file name both have.
    pub name: String,
    /// How they differ.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// All pairs of two folders.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FolderComparison {
    /// Mean over the pictures of their mean FLIP.
    pub flip_mean: f64,
    /// Largest FLIP of a pixel of any picture.
    pub flip_max: f64,
    /// PSNR in dB of the error pooled over all compared pixels; `null` when identical.
    pub psnr_db: Option<f64>,
    /// Sum over the pictures.
    pub differing_pixels: usize,
    /// Largest difference of one channel, in 8-bit steps.
    pub max_channel_difference: u8,
    /// Names in the first folder that the second lacks.
    pub only_in_first: Vec<String>,
    /// Names in the second folder that the first lacks.
    pub only_in_second: Vec<String>,
    /// Each pair, by name.
    pub images: Vec<PairComparison>,
}

/// Compares the pictures (`.png .exr .jpg .jpeg .webp`) of two folders by name.
///
/// # Errors
/// [`Error::Io`] for a folder or picture that cannot be read, [`Error::Input`] when no name is in both, or for a pair
/// that cannot be compared.
pub fn compare_folders(first: &Path, second: &Path, region: Region) -> Result<FolderComparison> {
    let (a, b) = (pictures_in(first)?, pictures_in(second)?);
    let pair = |name: &String| -> Result<PairComparison> {
        let paths = [first.join(name), second.join(name)];
        let [reference, candidate] = [Picture::load(&paths[0])?, Picture::load(&paths[1])?];
        let shown = paths.map(|path| path.display().to_string());
        let comparison = compare(&reference, &candidate, region, [&shown[0], &shown[1]])?;
        Ok(PairComparison {
            name: name.clone(),
            comparison,
        })
    };
    let images = a.intersection(&b).map(pair).collect::<Result<Vec<_>>>()?;
    if images.is_empty() {
        let reason = format!(
            "no picture has the same name as one in {}",
            second.display()
        );
        return Err(Error::input(
            first.display().to_string(),
            "pictures",
            reason,
        ));
    }
    let all = || images.iter().map(|image| &image.comparison);
    Ok(FolderComparison {
        flip_mean: all().map(|c| c.flip_mean).sum::<f64>() / images.len() as f64,
        flip_max: all().map(|c| c.flip_max).fold(0.0, f64::max),
        psnr_db: psnr_db(
            all().map(|c| c.squared_error).sum(),
            all().map(|c| c.compared_pixels).sum(),
        ),
        differing_pixels: all().map(|c| c.differing_pixels).sum(),
        max_channel_difference: all().map(|c| c.max_channel_difference).max().unwrap_or(0),
        only_in_first: a.difference(&b).cloned().collect(),
        only_in_second: b.difference(&a).cloned().collect(),
        images,
    })
}

fn pictures_in(folder: &Path) -> Result<BTreeSet<String>> {
    let fail = |source| Error::io(folder, source);
    let mut names = BTreeSet::new();
    for entry in std::fs::read_dir(folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        let extension = path
            .extension()
            .map(|e| e.to_string_lossy().to_ascii_lowercase());
        let known =
            extension.is_some_and(|e| ["png", "exr", "jpg", "jpeg", "webp"].contains(&e.as_str()));
        if let (true, true, Some(name)) = (known, path.is_file(), path.file_name()) {
            names.insert(name.to_string_lossy().into_owned());
        }
    }
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_found_by_name_and_the_rest_is_listed() {
        let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let save = |folder: &Path, name: &str, value: u8| {
            image::RgbaImage::from_pixel(40, 40, image::Rgba([value, 9, 9, 255]))
                .save(folder.join(name))
                .unwrap();
        };
        save(a.path(), "same.png", 10);
        save(b.path(), "same.png", 10);
        save(a.path(), "other.png", 10);
        save(b.path(), "other.png", 90);
        save(a.path(), "lonely.png", 1);
        std::fs::write(b.path().join("notes.txt"), "no picture").unwrap();
        let c = compare_folders(a.path(), b.path(), Region::Foreground).unwrap();
        assert_eq!(
            (c.images.len(), c.differing_pixels, c.max_channel_difference),
            (2, 1600, 80)
        );
        assert_eq!(c.only_in_first, ["lonely.png"]);
        assert!(c.only_in_second.is_empty());
        assert_eq!(c.flip_mean, c.images[0].comparison.flip_mean / 2.0);
    }

    #[test]
    fn no_common_name_and_no_folder_are_errors() {
        let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        assert!(compare_folders(a.path(), b.path(), Region::Foreground).is_err());
        assert!(compare_folders(&a.path().join("missing"), b.path(), Region::Foreground).is_err());
    }
}
