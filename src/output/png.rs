//! PNG: sRGB RGBA of 8 or 16 bits a channel, alpha = coverage, colour not premultiplied.
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
    encode(width, height, rgba, ExtendedColorType::Rgba8)
}

/// Encodes `rgba` (four numbers a pixel, rows from the top) as PNG of 16 bits a channel.
///
/// # Errors
/// As [`encode_png`].
pub fn encode_png16(width: u32, height: u32, rgba: &[u16]) -> Result<Vec<u8>> {
    let bytes = bytemuck::cast_slice(rgba);
    encode(width, height, bytes, ExtendedColorType::Rgba16)
}

fn encode(width: u32, height: u32, rgba: &[u8], kind: ExtendedColorType) -> Result<Vec<u8>> {
    let pixel = u64::from(kind.bits_per_pixel() / 8);
    let need = u64::from(width) * u64::from(height) * pixel;
    if need == 0 || need != rgba.len() as u64 {
        return Err(Error::Capacity {
            what: format!("bytes of a {width} x {height} picture"),
            need,
            have: rgba.len() as u64,
        });
    }
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(rgba, width, height, kind)
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
    fn sixteen_bits_come_back() {
        let rgba: Vec<u16> = (0..5 * 3 * 4).map(|i| (i * 4099 % 65536) as u16).collect();
        let back = image::load_from_memory(&encode_png16(5, 3, &rgba).unwrap()).unwrap();
        assert_eq!(back.color(), image::ColorType::Rgba16);
        assert_eq!(back.into_rgba16().into_raw(), rgba);
        assert!(encode_png16(5, 3, &rgba[1..]).is_err());
    }

    #[test]
    fn sizes_that_do_not_fit_are_refused() {
        assert!(encode_png(2, 2, &[0; 15]).is_err());
        assert!(encode_png(0, 2, &[]).is_err());
    }
}
