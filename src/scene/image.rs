//! Images of a document: encoded bytes, decoded on demand under limits.
//!
//! In: a range of the document's binary. Out: 8-bit RGBA, or an error that says what is broken; or a neutral stand-in. The
//! header's size is compared with the limits before anything is decoded or allocated.

use crate::{Error, Result};
use image::{ImageFormat, ImageReader, Limits, RgbaImage};
use std::io::Cursor;
use std::ops::Range;
use std::sync::Arc;

/// Longest side of an image that is decoded, in texels.
pub const MAX_SIDE: u32 = 16_384;
/// Most bytes that decoding one image may allocate.
pub const MAX_ALLOCATION: u64 = 512 << 20;

/// Most texels that a byte of PNG or JPEG can stand for: deflate expands at most 1032-fold, to texels of at least one bit;
/// a JPEG spends at least one bit on a block of 64 samples, each of at most 4 x 4 texels.
const MAX_TEXELS_PER_BYTE: u64 = 8256;

/// One image of a document, still encoded.
#[derive(Clone, Debug)]
pub struct Image {
    /// Its name in the file, or `image_N`.
    pub name: String,
    binary: Arc<Vec<u8>>,
    range: Range<usize>,
}

impl PartialEq for Image {
    fn eq(&self, other: &Image) -> bool {
        self.name == other.name && self.bytes() == other.bytes()
    }
}

/// What a texture is for: decides what stands in for a broken one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureUse {
    /// Factors multiply it: base colour, metallic-roughness, occlusion, emissive. Stand-in: white.
    Factor,
    /// A tangent-space normal map. Stand-in: the flat normal (128, 128, 255).
    Normal,
}

impl Image {
    pub(super) fn new(name: String, binary: Arc<Vec<u8>>, range: Range<usize>) -> Image {
        Image {
            name,
            binary,
            range,
        }
    }

    /// The encoded file (PNG, JPEG or WebP); empty when it could not be found.
    pub fn bytes(&self) -> &[u8] {
        &self.binary[self.range.clone()]
    }

    /// Width and height by the header, without decoding.
    ///
    /// # Errors
    /// [`Error::Input`] where the bytes are no image that is read, or it is larger than [`MAX_SIDE`] or
    /// [`MAX_ALLOCATION`].
    pub fn size(&self) -> Result<[u32; 2]> {
        let (width, height) = self
            .reader()?
            .into_dimensions()
            .map_err(|e| self.fault(e.to_string()))?;
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(self.fault(format!(
                "{width} x {height} texels; up to {MAX_SIDE} a side are read"
            )));
        }
        let texels = u64::from(width) * u64::from(height);
        // The WebP decoder holds an opaque image twice, and no limit of its own keeps it from asking: a few bytes of
        // WebP may stand for any size.
        let copies = 1 + u64::from(self.format() == Some(ImageFormat::WebP));
        if texels * 4 * copies > MAX_ALLOCATION {
            return Err(self.fault(format!(
                "{width} x {height} texels need more than {MAX_ALLOCATION} bytes"
            )));
        }
        if self.format() != Some(ImageFormat::WebP)
            && texels > MAX_TEXELS_PER_BYTE * self.bytes().len() as u64
        {
            let reason = format!(
                "{width} x {height} texels cannot come from {} bytes",
                self.bytes().len()
            );
            return Err(self.fault(reason));
        }
        Ok([width, height])
    }

    /// Decodes to 8-bit RGBA (16-bit images are rounded, grey is repeated, alpha is 255 where there is none).
    ///
    /// # Errors
    /// [`Error::Input`] as for [`Image::size`], or where the data are broken.
    pub fn decode(&self) -> Result<RgbaImage> {
        self.size()?;
        let image = self
            .reader()?
            .decode()
            .map_err(|e| self.fault(e.to_string()))?;
        Ok(image.into_rgba8())
    }

    /// Decodes, or makes one texel of the neutral value for this use and returns the error as a warning.
    pub fn decode_or_neutral(&self, texture_use: TextureUse) -> (RgbaImage, Option<Error>) {
        match self.decode() {
            Ok(image) => (image, None),
            Err(error) => {
                let texel = match texture_use {
                    TextureUse::Factor => [255, 255, 255, 255],
                    TextureUse::Normal => [128, 128, 255, 255],
                };
                (RgbaImage::from_pixel(1, 1, image::Rgba(texel)), Some(error))
            }
        }
    }

    fn reader(&self) -> Result<ImageReader<Cursor<&[u8]>>> {
        let format = self
            .format()
            .ok_or_else(|| self.fault("is neither PNG, JPEG nor WebP".into()))?;
        // The decoder fills in grey for what is missing; a JPEG without its end marker is cut off.
        if format == ImageFormat::Jpeg
            && !self
                .bytes()
                .array_windows()
                .any(|pair| *pair == [0xff, 0xd9])
        {
            return Err(self.fault("is a JPEG that is cut off (no end marker)".into()));
        }
        let mut reader = ImageReader::with_format(Cursor::new(self.bytes()), format);
        let mut limits = Limits::no_limits();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        limits.max_alloc = Some(MAX_ALLOCATION);
        reader.limits(limits);
        Ok(reader)
    }

    fn format(&self) -> Option<ImageFormat> {
        format(self.bytes())
    }

    fn fault(&self, reason: String) -> Error {
        Error::input("glTF image", format!("\"{}\"", self.name), reason)
    }
}

/// The format by the first bytes (a file's claimed type is not believed).
fn format(bytes: &[u8]) -> Option<ImageFormat> {
    match image::guess_format(bytes).ok()? {
        format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP) => Some(format),
        _ => None,
    }
}

/// The media type by the first bytes.
pub(super) fn mime(bytes: &[u8]) -> Option<&'static str> {
    format(bytes).map(|f| f.to_mime_type())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(bytes: Vec<u8>) -> Image {
        let range = 0..bytes.len();
        Image::new("test".into(), Arc::new(bytes), range)
    }

    fn png(width: u32, height: u32) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        RgbaImage::from_fn(width, height, |x, y| {
            image::Rgba([x as u8, y as u8, 7, 200])
        })
        .write_to(&mut out, ImageFormat::Png)
        .unwrap();
        out.into_inner()
    }

    /// A lossless WebP whose header claims a size: after RIFF, VP8L and one byte come 14 bits of each side less one.
    fn webp_claiming(width: u32, height: u32) -> Image {
        let mut out = Cursor::new(Vec::new());
        let small = image::RgbImage::from_pixel(16, 12, image::Rgb([1, 2, 3]));
        small.write_to(&mut out, ImageFormat::WebP).unwrap();
        let mut bytes = out.into_inner();
        assert_eq!(&bytes[12..16], b"VP8L");
        let rest = u32::from_le_bytes(bytes[21..25].try_into().unwrap()) & 0xf000_0000;
        let word = rest | (width - 1) | ((height - 1) << 14);
        bytes[21..25].copy_from_slice(&word.to_le_bytes());
        image(bytes)
    }

    #[test]
    fn a_webp_that_would_be_held_twice_over_the_limit_is_refused() {
        assert_eq!(
            webp_claiming(16, 12).decode().unwrap().dimensions(),
            (16, 12)
        );
        assert_eq!(webp_claiming(8192, 8192).size().unwrap(), [8192, 8192]);
        // Found by mutation: 488 MiB asked for at once, beside as much again for the answer.
        let fault = webp_claiming(16_000, 7_999).decode().unwrap_err();
        assert!(fault.to_string().contains("need more than"), "{fault}");
    }

    #[test]
    fn a_good_image_decodes_and_a_cut_one_is_an_error() {
        let bytes = png(9, 5);
        assert_eq!(image(bytes.clone()).size().unwrap(), [9, 5]);
        assert_eq!(
            image(bytes.clone()).decode().unwrap().get_pixel(8, 4).0,
            [8, 4, 7, 200]
        );
        assert!(image(bytes[..bytes.len() / 2].to_vec()).decode().is_err());
        let (neutral, warning) = image(Vec::new()).decode_or_neutral(TextureUse::Normal);
        assert_eq!(
            (neutral.get_pixel(0, 0).0, warning.is_some()),
            ([128, 128, 255, 255], true)
        );
    }

    /// The header is changed to claim 60000 x 60000 (with its checksum made right): refused by the claim alone.
    #[test]
    fn a_claim_beyond_the_limit_is_refused() {
        let mut bytes = png(8, 8);
        bytes[16..20].copy_from_slice(&60_000u32.to_be_bytes());
        bytes[20..24].copy_from_slice(&60_000u32.to_be_bytes());
        assert!(image(bytes).decode().is_err());
    }
}
