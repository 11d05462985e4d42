//! What was filtered beforehand, as images of the built GLB.
//!
//! In: [`Prefiltered`]. Out: four PNG, each `size` wide and `2 size - 1` high: the levels from the top down, at the left; and
//! back, from untrusted bytes.

use crate::attribute::Prefiltered;
use crate::attribute::prefiltered::{levels, texels};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// The images of all levels.
pub(super) fn encode(prefiltered: &Prefiltered) -> Result<[Vec<u8>; 4], String> {
    let size = prefiltered.size();
    let mut out: [Vec<u8>; 4] = Default::default();
    for (png, rgba) in out.iter_mut().zip(prefiltered.images()) {
        let rows = rows(size, rgba);
        PngEncoder::new_with_quality(&mut *png, CompressionType::Default, FilterType::Adaptive)
            .write_image(&rows, size, 2 * size - 1, ExtendedColorType::Rgba8)
            .map_err(|e| e.to_string())?;
    }
    Ok(out)
}

/// All levels of an image of [`encode`]'s; the reason where it is none.
pub(super) fn decode(size: u32, png: &[u8]) -> Result<Vec<u8>, String> {
    let mut reader = ImageReader::with_format(Cursor::new(png), ImageFormat::Png);
    let mut limits = Limits::default();
    limits.max_image_width = Some(size);
    limits.max_image_height = Some(2 * size);
    // The image, and what its decoder needs beside it.
    limits.max_alloc = Some(32 * u64::from(size) * u64::from(size) + (1 << 20));
    reader.limits(limits);
    let rgba = reader.decode().map_err(|e| e.to_string())?.into_rgba8();
    let (width, height) = rgba.dimensions();
    if (width, height) != (size, 2 * size - 1) {
        return Err(format!("{width}x{height} is not {size}x{}", 2 * size - 1));
    }
    let mut out = Vec::with_capacity(4 * texels(size));
    let mut row = 0;
    for (_, side) in levels(size) {
        for line in rgba.rows().skip(row).take(side) {
            out.extend(line.take(side).flat_map(|texel| texel.0));
        }
        row += side;
    }
    Ok(out)
}

/// The levels below each other, with nothing at their right.
fn rows(size: u32, rgba: &[u8]) -> Vec<u8> {
    let width = 4 * size as usize;
    let mut out = Vec::with_capacity(width * (2 * size as usize - 1));
    for (at, side) in levels(size) {
        for line in rgba[4 * at..4 * (at + side * side)].chunks_exact(4 * side) {
            out.extend(line);
            out.resize(out.len() + width - line.len(), 0);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attribute::Scope;

    fn some(size: u32) -> Prefiltered {
        let image = |role: usize| {
            let byte = |k: usize| ((k * 2_654_435_761 + role) >> 9) as u8;
            (0..4 * texels(size)).map(byte).collect()
        };
        Prefiltered::new(size, Scope::default(), std::array::from_fn(image)).unwrap()
    }

    #[test]
    fn images_come_back_byte_for_byte() {
        let before = some(64);
        let png = encode(&before).unwrap();
        let back = png.each_ref().map(|png| decode(64, png).unwrap());
        assert_eq!(&back, before.images());
    }

    #[test]
    fn others_are_refused() {
        let png = &encode(&some(64)).unwrap()[0];
        for size in [32, 128] {
            assert!(decode(size, png).is_err(), "of another size");
        }
        assert!(decode(64, &png[..png.len() / 2]).is_err(), "cut");
        assert!(decode(64, b"no image").is_err());
    }
}
