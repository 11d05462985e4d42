//! PNG: 8-bit sRGB RGBA, alpha = coverage, colour not premultiplied.
//!
//! In: `width * height` pixels, top row first. Out: the file's bytes, the same for the same pixels.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::{Error, Result};

/// Encodes `rgba` (four bytes a pixel, rows from the top) as PNG.
///
/// # Errors
/// [`Error::Capacity`] when `rgba` is not `width * height * 4` bytes or a side is zero.
pub fn encode_png(width: u32, height: u32, rgba: &[u8]) -> Result<Vec<u8>> {
    let need = u64::from(width) * u64::from(height) * 4;
    if need == 0 || need != rgba.len() as u64 {
        return Err(Error::Capacity {
            what: format!("bytes of a {width} x {height} picture"),
            need,
            have: rgba.len() as u64,
        });
    }
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(rgba, width, height, ExtendedColorType::Rgba8)
        .map_err(|error| Error::input("png", format!("{width} x {height}"), error.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_back_and_bytes_repeat() {
        let rgba: Vec<u8> = (0..5 * 3 * 4).map(|i| (i * 37 % 256) as u8).collect();
        let bytes = encode_png(5, 3, &rgba).unwrap();
        assert_eq!(bytes, encode_png(5, 3, &rgba).unwrap());
        let back = image::load_from_memory(&bytes).unwrap();
        assert_eq!((back.width(), back.height()), (5, 3));
        assert_eq!(back.into_rgba8().into_raw(), rgba);
    }

    #[test]
    fn sizes_that_do_not_fit_are_refused() {
        assert!(encode_png(2, 2, &[0; 15]).is_err());
        assert!(encode_png(0, 2, &[]).is_err());
    }
}
