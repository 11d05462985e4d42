//! A 3-D image as a solid texture.
//!
//! In: one picture whose square slices stand one below the other, or a folder of slices of one size. Out: [`Volume`], its
//! slices side by side in one texture, because a texture's side is limited and a stack of 256 slices would exceed it.
//!
//! Slice 0 lies where z is least; in a slice x goes to the right and y up, as it is looked at. The volume fills the cube
//! round the model's middle whose side is the model's longest, and repeats outside.

use super::arithmetic::V3;
use super::sample::UvGradient;
use super::solid::{between, steps};
use super::surface::AttributeSet;
use super::texture::{Pixels, Sampler, TEXTURE_WORDS, TextureSet};
use crate::{Error, Result};
use image::{ImageReader, Limits, RgbaImage};
use std::io::Cursor;
use std::path::Path;

/// Most slices, and the longest side of each, in texels.
const MOST: u32 = 1024;
/// Most texels.
const MOST_TEXELS: u64 = 1 << 25;
/// The number that the texture of a volume goes by: no image of a scene has it.
const NUMBER: usize = usize::MAX - 2;

/// A 3-D image, 8-bit sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Texels along x, y and z.
    size: [u32; 3],
    /// Slices side by side.
    columns: u32,
    sheet: RgbaImage,
}

impl Volume {
    /// Reads a picture of square slices one below the other, or all pictures of a folder in the order of their names.
    ///
    /// # Errors
    /// [`Error::Io`] where something cannot be read; [`Error::Input`] for what is no picture, slices that are not square or
    /// not of one size, no slice at all, more than 1024 of them, and more than 2^25 texels.
    pub fn load(path: &Path) -> Result<Volume> {
        let name = path.display().to_string();
        if !path.is_dir() {
            return Volume::of_strip(&name, &crate::scene::read_file(path)?);
        }
        let io = |e| Error::io(path, e);
        let entries = std::fs::read_dir(path).map_err(io)?;
        let mut files = entries
            .map(|entry| entry.map(|e| e.path()).map_err(io))
            .collect::<Result<Vec<_>>>()?;
        files.sort();
        if files.len() > MOST as usize {
            let reason = format!("{} files; up to {MOST} slices are read", files.len());
            return Err(Error::input(name, "slices", reason));
        }
        let mut slices = Vec::new();
        let mut texels = 0;
        for file in &files {
            let of = file.display().to_string();
            let slice = decode(&of, &crate::scene::read_file(file)?)?;
            texels += u64::from(slice.width()) * u64::from(slice.height());
            check(&name, slice.dimensions(), texels)?;
            slices.push(slice);
        }
        Volume::of_slices(&name, &slices)
    }

    /// A picture, encoded, whose height is a multiple of its width: as many square slices. `name` is what errors call it.
    ///
    /// # Errors
    /// As [`Volume::load`].
    pub fn of_strip(name: &str, bytes: &[u8]) -> Result<Volume> {
        let strip = decode(name, bytes)?;
        let (width, height) = strip.dimensions();
        if !height.is_multiple_of(width) {
            let reason = format!(
                "is {width}x{height}: not a stack of square slices, whose height is a multiple of its width"
            );
            return Err(Error::input(name, "image", reason));
        }
        check(name, (width, width), u64::from(width) * u64::from(height))?;
        let slice =
            |k: u32| image::imageops::crop_imm(&strip, 0, k * width, width, width).to_image();
        let slices: Vec<RgbaImage> = (0..(height / width).min(MOST + 1)).map(slice).collect();
        Volume::of_slices(name, &slices)
    }

    fn of_slices(name: &str, slices: &[RgbaImage]) -> Result<Volume> {
        let fault = |reason: String| Err(Error::input(name, "slices", reason));
        let Some(first) = slices.first() else {
            return fault("there are none".into());
        };
        let (width, height) = first.dimensions();
        let depth = slices.len() as u32;
        if depth > MOST {
            return fault(format!("{depth} of them; {MOST} at most"));
        }
        if let Some(k) = slices
            .iter()
            .position(|s| s.dimensions() != first.dimensions())
        {
            let (w, h) = slices[k].dimensions();
            return fault(format!("slice {k} is {w}x{h}, slice 0 is {width}x{height}"));
        }
        let columns = (1..=depth).find(|c| c * c >= depth).unwrap_or(1);
        let mut sheet = RgbaImage::new(width * columns, height * depth.div_ceil(columns));
        for (k, slice) in (0..).zip(slices) {
            let (x, y) = (k % columns * width, k / columns * height);
            image::imageops::replace(&mut sheet, slice, x.into(), y.into());
        }
        Ok(Volume {
            size: [width, height, depth],
            columns,
            sheet,
        })
    }

    /// Texels along x, y and z.
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// Adds the texture; the second word of a factor that shows it: its id, columns and slices, both less one.
    pub(super) fn add(&self, textures: &mut TextureSet) -> Result<u32> {
        let sampler = Sampler {
            nearest: true,
            no_mips: true,
            ..Sampler::default()
        };
        let (width, height) = self.sheet.dimensions();
        let id = textures.add(NUMBER, true, sampler, || {
            Ok(Pixels {
                width,
                height,
                rgba: self.sheet.as_raw(),
            })
        })?;
        if id >= 1 << 14 {
            return Err(Error::Capacity {
                what: "textures beside a 3-D image".into(),
                need: id.into(),
                have: 1 << 14,
            });
        }
        Ok(id | (self.columns - 1) << 14 | (self.size[2] - 1) << 22)
    }
}

fn decode(name: &str, bytes: &[u8]) -> Result<RgbaImage> {
    let fault = |e: &dyn std::fmt::Display| Error::input(name, "image", e.to_string());
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|e| fault(&e))?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_TEXELS * 8);
    reader.limits(limits);
    Ok(reader.decode().map_err(|e| fault(&e))?.into_rgba8())
}

fn check(name: &str, (width, height): (u32, u32), texels: u64) -> Result<()> {
    if width > MOST || height > MOST || texels > MOST_TEXELS {
        let reason = format!(
            "slices of {width}x{height}, {texels} texels in all; {MOST}x{MOST} and {MOST_TEXELS} at most"
        );
        return Err(Error::input(name, "slices", reason));
    }
    Ok(())
}

/// Sides of the volume and columns of its sheet, from the word that [`Volume::add`] made and the sheet's record.
fn shape(word: u32, record: &[u32]) -> ([i32; 3], i32) {
    let columns = (word >> 14 & 255) as i32 + 1;
    let depth = (word >> 22) as i32 + 1;
    let rows = (depth + columns - 1) / columns;
    (
        [record[1] as i32 / columns, record[2] as i32 / rows, depth],
        columns,
    )
}

impl AttributeSet {
    /// The volume of `word` at `p` units, interpolated between its eight nearest texels: twin of `igt_volume` in
    /// `glsl/common/show.glsl`.
    pub(super) fn volume(&self, decode: &[f32], word: u32, p: V3) -> V3 {
        let id = word & 0x3fff;
        let record = &self.textures.records[id as usize * TEXTURE_WORDS..][..TEXTURE_WORDS];
        let (size, columns) = shape(word, record);
        let (width, height) = (record[1] as i32 as f32, record[2] as i32 as f32);
        let mut texel = [0; 3];
        let mut f = [0.0; 3];
        for (k, q) in steps(p).into_iter().enumerate() {
            // The corner of the volume is half a unit from its middle, the first texel's centre half a texel further.
            let within = q.wrapping_add(1 << 19) & ((1 << 20) - 1);
            let along = within * size[k] - (1 << 19);
            texel[k] = along >> 20;
            f[k] = ((along >> 4) & 0xffff) as f32 / 65_536.0;
        }
        let corner = |k: i32| {
            let at = [k & 1, (k >> 1) & 1, k >> 2];
            let [x, y, z] = [0, 1, 2].map(|i| wrapped(texel[i] + at[i], size[i]));
            let column = z % columns * size[0] + x;
            let row = z / columns * size[1] + (size[1] - 1 - y);
            let uv = [(column as f32 + 0.5) / width, (row as f32 + 0.5) / height];
            let flat = UvGradient {
                uv,
                dx: [0.0; 2],
                dy: [0.0; 2],
            };
            let [r, g, b, _] = self.textures.sample(decode, id, &flat);
            [r, g, b]
        };
        let along = |a: V3, b: V3, t: f32| [0, 1, 2].map(|i| between(a[i], b[i], t));
        let along_x = |k: i32| along(corner(k), corner(k + 1), f[0]);
        let along_y = |k: i32| along(along_x(k), along_x(k + 2), f[1]);
        along(along_y(0), along_y(4), f[2])
    }
}

/// `i` of -1..=n in 0..n.
fn wrapped(i: i32, n: i32) -> i32 {
    if i < 0 {
        i + n
    } else if i >= n {
        i - n
    } else {
        i
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(width: u32, height: u32) -> Vec<u8> {
        let image = RgbaImage::from_fn(width, height, |x, y| {
            image::Rgba([
                (x * 60) as u8,
                (y % width.max(1) * 60) as u8,
                (y / width * 60) as u8,
                255,
            ])
        });
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn a_volume_is_its_texels_at_their_centres_and_repeats() {
        let volume = Volume::of_strip("v.png", &png(4, 12)).unwrap();
        assert_eq!((volume.size(), volume.columns), ([4, 4, 3], 2));
        let mut set = AttributeSet::default();
        let word = volume.add(&mut set.textures).unwrap();
        let decode = crate::attribute::arithmetic::srgb_decode_table();
        for (x, y, z) in [(0, 0, 0), (3, 1, 2), (2, 3, 1)] {
            let p = [(x, 4.0), (y, 4.0), (z, 3.0)].map(|(i, n)| (i as f32 + 0.5) / n - 0.5);
            let want = [x * 60, (3 - y) * 60, z * 60].map(|code| decode[code]);
            for shift in [0.0, 1.0, -2.0] {
                let got = set.volume(&decode, word, p.map(|c| c + shift));
                assert!(
                    (0..3).all(|k| (got[k] - want[k]).abs() < 1e-4),
                    "{got:?} {want:?}"
                );
            }
        }
        // Between the last texel and the first of the next period.
        let between = set.volume(&decode, word, [0.5, 0.125, 0.0]);
        assert!((between[0] - decode[180] / 2.0).abs() < 1e-4);
    }

    #[test]
    fn what_is_no_volume_is_refused() {
        for (bytes, word) in [
            (png(4, 10), "4x10"),
            (vec![1, 2, 3], "image"),
            (png(1, 1025), "1024 at most"),
        ] {
            let message = Volume::of_strip("v.png", &bytes).unwrap_err().to_string();
            assert!(
                message.starts_with("v.png: ") && message.contains(word),
                "{message}"
            );
        }
        let none = Volume::of_slices("folder", &[]).unwrap_err().to_string();
        let mixed = [RgbaImage::new(2, 2), RgbaImage::new(2, 3)];
        let mixed = Volume::of_slices("folder", &mixed).unwrap_err().to_string();
        assert!(
            none.contains("none") && mixed.contains("slice 1 is 2x3"),
            "{none} {mixed}"
        );
    }
}
