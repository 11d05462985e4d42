//! PNG: sRGB RGBA of 8 or 16 bits a channel, alpha = coverage, colour not premultiplied.
//!
//! In: `width * height` pixels, top row first. Out: the file's bytes, the same for the same pixels. Pictures are packed as small
//! as is usual; textures, which are many and large, by an encoder that is made for speed ([`encode_texture`]): of a normal map
//! of 2048 x 2048 texels in a thirtieth of the time, a fifth larger.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::{Error, Result};

/// Encodes `rgba` (four bytes a pixel, rows from the top) as PNG.
///
/// # Errors
/// [`Error::Capacity`] when `rgba` is not `width * height * 4` bytes or a side is zero.
pub fn encode_png(width: u32, height: u32, rgba: &[u8]) -> Result<Vec<u8>> {
    let small = (CompressionType::Default, FilterType::Adaptive);
    encode((width, height), rgba, ExtendedColorType::Rgba8, small)
}

/// What encoders that are made for speed do best with.
const QUICK: (CompressionType, FilterType) = (CompressionType::Fast, FilterType::Paeth);

/// [`encode_png`], quickly.
///
/// # Errors
/// As [`encode_png`].
pub fn encode_texture(width: u32, height: u32, rgba: &[u8]) -> Result<Vec<u8>> {
    encode((width, height), rgba, ExtendedColorType::Rgba8, QUICK)
}

/// Encodes `rgba` (four numbers a pixel, rows from the top) as PNG of 16 bits a channel, quickly.
///
/// # Errors
/// As [`encode_png`].
pub fn encode_texture16(width: u32, height: u32, rgba: &[u16]) -> Result<Vec<u8>> {
    let bytes = bytemuck::cast_slice(rgba);
    encode((width, height), bytes, ExtendedColorType::Rgba16, QUICK)
}

/// Encodes shades of grey (a byte a pixel, rows from the top), quickly.
///
/// # Errors
/// As [`encode_png`].
pub fn encode_grey(width: u32, height: u32, grey: &[u8]) -> Result<Vec<u8>> {
    encode((width, height), grey, ExtendedColorType::L8, QUICK)
}

fn encode(
    (width, height): (u32, u32),
    rgba: &[u8],
    kind: ExtendedColorType,
    (packing, filter): (CompressionType, FilterType),
) -> Result<Vec<u8>> {
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
    PngEncoder::new_with_quality(&mut bytes, packing, filter)
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
        let back = image::load_from_memory(&encode_texture16(5, 3, &rgba).unwrap()).unwrap();
        assert_eq!(back.color(), image::ColorType::Rgba16);
        assert_eq!(back.into_rgba16().into_raw(), rgba);
        assert!(encode_texture16(5, 3, &rgba[1..]).is_err());
    }

    #[test]
    fn quick_encoders_keep_every_pixel() {
        let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 23) as u8;
        let rgba: Vec<u8> = (0..64 * 64 * 4).map(noise).collect();
        let back = image::load_from_memory(&encode_texture(64, 64, &rgba).unwrap()).unwrap();
        assert_eq!(back.into_rgba8().into_raw(), rgba);
        let back = image::load_from_memory(&encode_grey(128, 128, &rgba).unwrap()).unwrap();
        assert_eq!(back.color(), image::ColorType::L8);
        assert_eq!(back.into_luma8().into_raw(), rgba);
        assert!(encode_grey(64, 64, &rgba).is_err());
    }

    #[test]
    fn sizes_that_do_not_fit_are_refused() {
        assert!(encode_png(2, 2, &[0; 15]).is_err());
        assert!(encode_png(0, 2, &[]).is_err());
    }
}
