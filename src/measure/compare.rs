//! Two pictures of one size, compared.
//!
//! In: a reference and a candidate. Out: [`Comparison`]. Both are composited over mid grey; by default FLIP and the
//! squared error are averaged over the foreground only, the pixels that either picture covers, so that a small object
//! in a large frame is not flattered by its background.

use serde::Serialize;

use super::Picture;
use super::flip::{self, Window};
use crate::{Error, Result};

/// What transparent pixels are laid over: the middle of sRGB.
const GREY: u8 = 128;

/// Which pixels count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Region {
    /// Those that either picture covers: alpha above zero, or, in a picture without alpha, not mid grey.
    #[default]
    Foreground,
    /// All.
    Everything,
}

/// How two pictures differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Pixels that FLIP and PSNR are taken over.
    pub compared_pixels: usize,
    /// Mean FLIP, 0 (same) to 1.
    pub flip_mean: f64,
    /// Largest FLIP of a pixel.
    pub flip_max: f64,
    /// Peak signal-to-noise ratio in dB of the composited colours; `null` when they are identical.
    pub psnr_db: Option<f64>,
    /// Pixels of the whole picture whose RGBA differ in any way.
    pub differing_pixels: usize,
    /// Largest difference of one channel (RGBA) anywhere, in 8-bit steps.
    pub max_channel_difference: u8,
    /// Pixels that one picture covers and the other does not.
    pub silhouette_pixels: usize,
    /// Sum of squared channel differences (0..1 each) over the compared pixels; lets several pictures be pooled.
    #[serde(skip)]
    pub squared_error: f64,
}

/// Compares `candidate` with `reference`; `names` stand for them in errors.
///
/// # Errors
/// [`Error::Input`] when the sizes differ.
pub fn compare(
    reference: &Picture,
    candidate: &Picture,
    region: Region,
    names: [&str; 2],
) -> Result<Comparison> {
    Ok(analyse(reference, candidate, region, names)?.0)
}

/// FLIP of each pixel in FLIP's customary colours, as an opaque picture of the same size.
///
/// # Errors
/// [`Error::Input`] when the sizes differ.
pub fn difference_image(
    reference: &Picture,
    candidate: &Picture,
    region: Region,
    names: [&str; 2],
) -> Result<Picture> {
    let (_, map) = analyse(reference, candidate, region, names)?;
    let rgba = flip::magma(&map);
    Ok(Picture {
        width: reference.width,
        height: reference.height,
        rgba,
        has_alpha: false,
    })
}

/// PSNR in dB of a squared error summed over `pixels` pixels of three channels; `None` when there is none.
pub(super) fn psnr_db(squared_error: f64, pixels: usize) -> Option<f64> {
    (squared_error > 0.0).then(|| 10.0 * (pixels as f64 * 3.0 / squared_error).log10())
}

fn analyse(
    a: &Picture,
    b: &Picture,
    region: Region,
    names: [&str; 2],
) -> Result<(Comparison, Vec<f32>)> {
    if (a.width, a.height) != (b.width, b.height) {
        let reason = format!(
            "{} x {}, but {} is {} x {}",
            b.width, b.height, names[0], a.width, a.height
        );
        return Err(Error::input(names[1], "size", reason));
    }
    let (width, height) = (a.width as usize, a.height as usize);
    let (rgb_a, rgb_b) = (over_grey(a), over_grey(b));
    let (cover_a, cover_b) = (coverage(a), coverage(b));
    let mask: Vec<bool> = match region {
        Region::Everything => vec![true; a.rgba.len()],
        Region::Foreground => cover_a.iter().zip(&cover_b).map(|(x, y)| x | y).collect(),
    };
    let map = match Window::around(&mask, width, height) {
        Some(window) => flip::flip_map(&rgb_a, &rgb_b, width, window),
        None => vec![0.0; mask.len()],
    };
    let compared = || (0..mask.len()).filter(|&i| mask[i]);
    let compared_pixels = compared().count();
    let squared_error: f64 = compared()
        .map(|i| squared_difference(rgb_a[i], rgb_b[i]))
        .sum();
    let flip_sum: f64 = compared().map(|i| f64::from(map[i])).sum();
    let largest =
        |(x, y): (&[u8; 4], &[u8; 4])| (0..4).map(|k| x[k].abs_diff(y[k])).max().unwrap_or(0);
    let differences = || a.rgba.iter().zip(&b.rgba).map(largest);
    let comparison = Comparison {
        width: a.width,
        height: a.height,
        compared_pixels,
        flip_mean: flip_sum / compared_pixels.max(1) as f64,
        flip_max: compared().map(|i| f64::from(map[i])).fold(0.0, f64::max),
        psnr_db: psnr_db(squared_error, compared_pixels),
        differing_pixels: differences().filter(|&d| d > 0).count(),
        max_channel_difference: differences().max().unwrap_or(0),
        silhouette_pixels: cover_a.iter().zip(&cover_b).filter(|(x, y)| x != y).count(),
        squared_error,
    };
    Ok((comparison, map))
}

fn over_grey(picture: &Picture) -> Vec<[u8; 3]> {
    let blend = |c: u8, alpha: u8| {
        let (c, a) = (u32::from(c), u32::from(alpha));
        ((c * a + u32::from(GREY) * (255 - a) + 127) / 255) as u8
    };
    picture
        .rgba
        .iter()
        .map(|&[r, g, b, a]| [blend(r, a), blend(g, a), blend(b, a)])
        .collect()
}

/// Which pixels a picture covers. Without alpha the background is mid grey by agreement, give or take a step.
fn coverage(picture: &Picture) -> Vec<bool> {
    let grey = |p: &[u8; 4]| p[..3].iter().all(|c| c.abs_diff(GREY) <= 1);
    picture
        .rgba
        .iter()
        .map(|p| {
            if picture.has_alpha {
                p[3] > 0
            } else {
                !grey(p)
            }
        })
        .collect()
}

fn squared_difference(a: [u8; 3], b: [u8; 3]) -> f64 {
    (0..3)
        .map(|k| (f64::from(a[k]) - f64::from(b[k])).powi(2))
        .sum::<f64>()
        / (255.0 * 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> Picture {
        let rgba = (0..width * height)
            .map(|i| pixel(i % width, i / width))
            .collect();
        Picture {
            width,
            height,
            rgba,
            has_alpha: true,
        }
    }

    fn disc(radius: i32, colour: [u8; 4]) -> Picture {
        picture(96, 80, |x, y| {
            let inside = (x as i32 - 48).pow(2) + (y as i32 - 40).pow(2) < radius * radius;
            if inside { colour } else { [0; 4] }
        })
    }

    #[test]
    fn a_picture_equals_itself() {
        let a = disc(20, [200, 30, 40, 255]);
        let c = compare(&a, &a, Region::Foreground, ["a", "b"]).unwrap();
        assert_eq!(
            (c.flip_mean, c.flip_max, c.psnr_db, c.differing_pixels),
            (0.0, 0.0, None, 0)
        );
    }

    #[test]
    fn one_step_of_one_channel_has_the_textbook_psnr() {
        let (a, b) = (disc(20, [200, 30, 40, 255]), disc(20, [201, 30, 40, 255]));
        let c = compare(&a, &b, Region::Foreground, ["a", "b"]).unwrap();
        let expected = 10.0 * (3.0f64 * 255.0 * 255.0).log10(); // one of three channels is off by 1/255
        assert!((c.psnr_db.unwrap() - expected).abs() < 1e-9, "{c:?}");
        assert_eq!(
            (c.differing_pixels, c.max_channel_difference),
            (c.compared_pixels, 1)
        );
        assert!(c.flip_mean > 0.0 && c.flip_mean < 0.1, "{c:?}");
    }

    #[test]
    fn the_frame_does_not_flatter_the_object() {
        let (a, b) = (disc(20, [200, 30, 40, 255]), disc(20, [20, 230, 40, 255]));
        let foreground = compare(&a, &b, Region::Foreground, ["a", "b"]).unwrap();
        let everything = compare(&a, &b, Region::Everything, ["a", "b"]).unwrap();
        assert!(foreground.flip_mean > 2.0 * everything.flip_mean);
        assert!(foreground.compared_pixels < everything.compared_pixels);
        assert_eq!(foreground.silhouette_pixels, 0);
    }

    #[test]
    fn the_crop_gives_the_map_of_the_whole_picture() {
        let (a, b) = (disc(9, [200, 30, 40, 255]), disc(11, [20, 230, 40, 255]));
        let (_, cropped) = analyse(&a, &b, Region::Foreground, ["a", "b"]).unwrap();
        let (_, whole) = analyse(&a, &b, Region::Everything, ["a", "b"]).unwrap();
        let covered = |i: &usize| a.rgba[*i][3] > 0 || b.rgba[*i][3] > 0;
        let apart = (0..cropped.len())
            .filter(covered)
            .map(|i| (cropped[i] - whole[i]).abs())
            .fold(0.0, f32::max);
        assert!(apart < 1e-5, "{apart}");
    }

    #[test]
    fn sizes_must_agree_and_emptiness_is_equality() {
        let (a, b) = (disc(5, [1; 4]), picture(3, 3, |_, _| [0; 4]));
        assert!(
            compare(&a, &b, Region::Foreground, ["a", "b"])
                .unwrap_err()
                .to_string()
                .contains("3 x 3")
        );
        assert_eq!(
            compare(&b, &b, Region::Foreground, ["a", "b"])
                .unwrap()
                .psnr_db,
            None
        );
    }
}
