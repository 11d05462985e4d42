//! Textures as words: what the CPU and every device sample alike.
//!
//! In: decoded images, RGBA of 8 bits, row 0 on top (where glTF has v = 0). Out: [`TextureSet`]: one linear run of
//! texels (a word each, R in the low byte, all mip levels of an image after each other) and one record per texture.
//! On a device the run is split into [`SHARDS`] buffers of [`SHARD_WORDS`] words, as no storage buffer need be larger
//! than 128 MiB; a texel's address says its shard.

use super::{mips, prefiltered};
use crate::{Error, Result};
use std::collections::HashMap;

/// Words of one texture record.
pub(crate) const TEXTURE_WORDS: usize = 24;
/// Where in a record the offsets of the mip levels begin; sixteen of them.
pub(crate) const LEVELS_AT: usize = 8;
/// Most mip levels, so the longest side is 32768 texels.
const MAX_LEVELS: usize = 16;
/// Texels of one shard: 128 MiB.
pub(crate) const SHARD_WORDS: usize = 1 << 25;
/// Number of shards.
pub(crate) const SHARDS: usize = 4;

/// Bits of a record's flag word.
pub(crate) const FLAG_SRGB: u32 = 1;
/// The nearest texel instead of a bilinear blend.
pub(crate) const FLAG_NEAREST: u32 = 2;
/// Level 0 only, whatever the gradient.
pub(crate) const FLAG_NO_MIPS: u32 = 4;

/// What lies outside [0, 1] along one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// The texture again, every other time mirrored.
    Mirror,
    /// The last texel.
    Clamp,
}

/// How a texture is sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// Along u.
    pub wrap_u: Wrap,
    /// Along v.
    pub wrap_v: Wrap,
    /// The nearest texel instead of a bilinear blend.
    pub nearest: bool,
    /// Level 0 only.
    pub no_mips: bool,
}

/// A decoded image: `rgba` holds `width * height` texels of 4 bytes.
#[derive(Clone, Copy, Debug)]
pub struct Pixels<'a> {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Row after row from the top.
    pub rgba: &'a [u8],
}

/// All textures of a picture.
#[derive(Clone, Debug, Default)]
pub struct TextureSet {
    /// One record of [`TEXTURE_WORDS`] each: base address, width, height, levels, wrap modes, flags, 0, 0, offsets.
    pub(crate) records: Vec<u32>,
    /// The texels of all levels of all images.
    pub(crate) texels: Vec<u32>,
    chains: HashMap<(usize, bool), Chain>,
    known: HashMap<(usize, bool, Sampler), u32>,
}

#[derive(Clone, Debug)]
struct Chain {
    base: u32,
    width: u32,
    height: u32,
    offsets: Vec<u32>,
}

impl TextureSet {
    /// The id of a texture: image `image` (the caller's number for it) seen as sRGB or linear through a sampler.
    /// `pixels` is called only when the image's mip chain is not there yet.
    pub fn add<'a>(
        &mut self,
        image: usize,
        srgb: bool,
        sampler: Sampler,
        pixels: impl FnOnce() -> Result<Pixels<'a>>,
    ) -> Result<u32> {
        self.add_with(image, srgb, sampler, pixels, |set, pixels| {
            set.make_room(pixels, pixels.area())?;
            Ok(mips::append_chain(&mut set.texels, *pixels, srgb))
        })
    }

    /// [`add`](Self::add) for a square image that has its levels already, each half as large, down to one texel.
    pub(crate) fn add_levels<'a>(
        &mut self,
        image: usize,
        srgb: bool,
        sampler: Sampler,
        pixels: impl FnOnce() -> Result<Pixels<'a>>,
    ) -> Result<u32> {
        self.add_with(image, srgb, sampler, pixels, |set, pixels| {
            set.make_room(pixels, prefiltered::texels(pixels.width) as u64)?;
            set.texels.extend(words(pixels.rgba));
            let offsets = prefiltered::levels(pixels.width).map(|(at, _)| at as u32);
            Ok(offsets.collect())
        })
    }

    /// The id of a texture; `append` puts the levels of an image that is not there yet behind the others and says where each
    /// begins.
    fn add_with<'a>(
        &mut self,
        image: usize,
        srgb: bool,
        sampler: Sampler,
        pixels: impl FnOnce() -> Result<Pixels<'a>>,
        append: impl FnOnce(&mut Self, &Pixels<'a>) -> Result<Vec<u32>>,
    ) -> Result<u32> {
        if let Some(id) = self.find(image, srgb, sampler) {
            return Ok(id);
        }
        let pixels = pixels()?;
        let chain = Chain {
            base: self.texels.len() as u32,
            width: pixels.width,
            height: pixels.height,
            offsets: append(self, &pixels)?,
        };
        self.chains.insert((image, srgb), chain.clone());
        Ok(self.register(&chain, image, srgb, sampler))
    }

    /// The id of a texture whose image's mip chain is there already.
    pub fn find(&mut self, image: usize, srgb: bool, sampler: Sampler) -> Option<u32> {
        if let Some(&id) = self.known.get(&(image, srgb, sampler)) {
            return Some(id);
        }
        let chain = self.chains.get(&(image, srgb))?.clone();
        Some(self.register(&chain, image, srgb, sampler))
    }

    fn register(&mut self, chain: &Chain, image: usize, srgb: bool, sampler: Sampler) -> u32 {
        let id = self.len() as u32;
        self.records
            .extend_from_slice(&record(chain, srgb, sampler));
        self.known.insert((image, srgb, sampler), id);
        id
    }

    /// How many textures there are.
    pub fn len(&self) -> usize {
        self.records.len() / TEXTURE_WORDS
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Shards that texels lie in, at least one.
    #[cfg(feature = "gpu")]
    pub(crate) fn shards(&self) -> u32 {
        self.texels.len().div_ceil(SHARD_WORDS).max(1) as u32
    }

    /// The texels of shard `k`, to be uploaded as one buffer.
    #[cfg(feature = "gpu")]
    pub(crate) fn shard(&self, k: usize) -> &[u32] {
        let begin = (k * SHARD_WORDS).min(self.texels.len());
        &self.texels[begin..(begin + SHARD_WORDS).min(self.texels.len())]
    }

    /// An error where an image of `texels` texels is none, or too large for what is left.
    fn make_room(&self, pixels: &Pixels, texels: u64) -> Result<()> {
        let (width, height) = (pixels.width, pixels.height);
        let area = pixels.area();
        if area == 0
            || pixels.rgba.len() as u64 != texels * 4
            || width.max(height) >= 1 << MAX_LEVELS
        {
            let reason = format!(
                "{width}x{height} with {} bytes is not an RGBA image",
                pixels.rgba.len()
            );
            return Err(Error::input("texture", "image", reason));
        }
        let need = (self.texels.len() as u64 + area + area / 2 + 16) * 4;
        let have = (SHARDS * SHARD_WORDS * 4) as u64;
        if need > have {
            return Err(Error::Capacity {
                what: "bytes of textures with their mip levels".into(),
                need,
                have,
            });
        }
        Ok(())
    }
}

impl Pixels<'_> {
    fn area(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// RGBA as a word a texel, R in the low byte.
pub(super) fn words(rgba: &[u8]) -> impl Iterator<Item = u32> {
    rgba.chunks_exact(4)
        .map(|p| u32::from_le_bytes([p[0], p[1], p[2], p[3]]))
}

fn record(chain: &Chain, srgb: bool, sampler: Sampler) -> [u32; TEXTURE_WORDS] {
    let mut record = [0; TEXTURE_WORDS];
    let flags = u32::from(srgb) * FLAG_SRGB
        + u32::from(sampler.nearest) * FLAG_NEAREST
        + u32::from(sampler.no_mips) * FLAG_NO_MIPS;
    let wraps = sampler.wrap_u as u32 | ((sampler.wrap_v as u32) << 2);
    record[..6].copy_from_slice(&[
        chain.base,
        chain.width,
        chain.height,
        chain.offsets.len() as u32,
        wraps,
        flags,
    ]);
    record[LEVELS_AT..LEVELS_AT + chain.offsets.len()].copy_from_slice(&chain.offsets);
    record
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(width: u32, height: u32, rgba: &[u8]) -> Result<Pixels<'_>> {
        Ok(Pixels {
            width,
            height,
            rgba,
        })
    }

    #[test]
    fn an_image_is_stored_once_for_each_colour_space() {
        let rgba = [7u8; 5 * 3 * 4];
        let mut set = TextureSet::default();
        let a = set
            .add(0, true, Sampler::default(), || pixels(5, 3, &rgba))
            .unwrap();
        let clamp = Sampler {
            wrap_u: Wrap::Clamp,
            ..Sampler::default()
        };
        let b = set
            .add(0, true, clamp, || panic!("the chain is there"))
            .unwrap();
        let again = set
            .add(0, true, clamp, || panic!("the texture is there"))
            .unwrap();
        let c = set.add(0, false, clamp, || pixels(5, 3, &rgba)).unwrap();
        assert_eq!((a, b, again, c, set.len()), (0, 1, 1, 2, 3));
        // 5x3, 2x1, 1x1
        assert_eq!(set.texels.len(), 2 * (15 + 2 + 1));
        assert_eq!(set.records[3], 3);
        assert_eq!(&set.records[LEVELS_AT..LEVELS_AT + 3], &[0, 15, 17]);
        assert_eq!(set.records[2 * TEXTURE_WORDS], 18);
    }

    #[test]
    fn too_much_and_malformed_are_errors() {
        let mut set = TextureSet::default();
        assert!(
            set.add(0, true, Sampler::default(), || pixels(0, 3, &[]))
                .is_err()
        );
        assert!(
            set.add(0, true, Sampler::default(), || pixels(2, 2, &[0; 15]))
                .is_err()
        );
        assert!(set.is_empty());
    }
}
