//! A picture in memory, as a viewer shows it.
//!
//! In: a PNG, JPEG, WebP or EXR file. Out: [`Picture`], 8-bit sRGB RGBA, alpha = coverage, not premultiplied. EXR is
//! linear and is encoded to sRGB, clamped to 0..1.

use std::io::Cursor;
use std::path::Path;

use crate::{Error, Result};

/// Sides beyond this are refused before anything is allocated.
const LARGEST_SIDE: u32 = 16_384;

/// An 8-bit sRGB RGBA picture, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` pixels.
    pub rgba: Vec<[u8; 4]>,
    /// Whether the file had an alpha channel; without one every alpha is 255.
    pub has_alpha: bool,
}

impl Picture {
    /// Reads a file; the format is told by its content.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be read, [`Error::Input`] when it is no picture or larger than 16384 a side.
    pub fn load(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|source| Error::io(path, source))?;
        Self::decode(&bytes, &path.display().to_string())
    }

    /// Decodes `bytes`; `name` stands for them in errors.
    ///
    /// # Errors
    /// [`Error::Input`] when they are no picture that can be read.
    pub fn decode(bytes: &[u8], name: &str) -> Result<Self> {
        const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
        if bytes.starts_with(&EXR_MAGIC) {
            decode_exr(bytes, name)
        } else {
            decode_image(bytes, name)
        }
    }

    /// The pixels as bytes, four each.
    pub fn bytes(&self) -> &[u8] {
        self.rgba.as_flattened()
    }
}

fn decode_image(bytes: &[u8], name: &str) -> Result<Picture> {
    let fail = |error: &dyn std::fmt::Display| Error::input(name, "picture", error.to_string());
    let mut reader = image::ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|e| fail(&e))?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    reader.limits(limits);
    let image = reader.decode().map_err(|e| fail(&e))?;
    let has_alpha = image.color().has_alpha();
    let image = image.into_rgba8();
    let rgba = image.pixels().map(|pixel| pixel.0).collect();
    Ok(Picture {
        width: image.width(),
        height: image.height(),
        rgba,
        has_alpha,
    })
}

fn decode_exr(bytes: &[u8], name: &str) -> Result<Picture> {
    use exr::prelude::{MetaData, ReadChannels, ReadLayers, read};
    let fail = |error: exr::error::Error| Error::input(name, "EXR", error.to_string());
    // The header first: the reader below would allocate by what it says.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(fail)?;
    for header in &meta.headers {
        let size = header.layer_size;
        if size.0.max(size.1) > LARGEST_SIDE as usize {
            let reason = format!(
                "{} x {} pixels; at most {LARGEST_SIDE} a side",
                size.0, size.1
            );
            return Err(Error::input(name, "EXR", reason));
        }
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (size.0, vec![[0u8; 4]; size.0 * size.1]),
            |(width, pixels): &mut (usize, Vec<[u8; 4]>),
             at,
             (r, g, b, a): (f32, f32, f32, f32)| {
                pixels[at.1 * *width + at.0] = [encode(r), encode(g), encode(b), quantise(a)];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(fail)?;
    let size = image.layer_data.size;
    let (_, rgba) = image.layer_data.channel_data.pixels;
    Ok(Picture {
        width: size.0 as u32,
        height: size.1 as u32,
        rgba,
        has_alpha: true,
    })
}

/// Linear to sRGB (IEC 61966-2-1), 8 bits.
fn encode(linear: f32) -> u8 {
    let x = linear.clamp(0.0, 1.0);
    quantise(if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    })
}

fn quantise(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8 // a NaN becomes 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rubbish_and_truncated_pictures_are_errors() {
        assert!(Picture::decode(b"", "x").is_err());
        assert!(Picture::decode(b"not a picture", "x").is_err());
        let png = {
            let image = image::RgbaImage::from_pixel(9, 9, image::Rgba([1, 2, 3, 255]));
            let mut bytes = Vec::new();
            image
                .write_to(&mut Cursor::new(&mut bytes), image::ImageFormat::Png)
                .unwrap();
            bytes
        };
        assert_eq!(Picture::decode(&png, "x").unwrap().rgba[80], [1, 2, 3, 255]);
        assert!(Picture::decode(&png[..png.len() / 2], "x").is_err());
        assert!(Picture::decode(&[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0], "x").is_err());
    }

    #[test]
    fn srgb_ends_and_middle() {
        assert_eq!(
            (encode(0.0), encode(1.0), encode(7.0), encode(f32::NAN)),
            (0, 255, 255, 0)
        );
        assert_eq!(encode(0.214_041_14), 128); // the linear value of mid grey, IEC 61966-2-1
    }
}
