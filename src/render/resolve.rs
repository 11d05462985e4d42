//! Supersampling: several samples of a finer image become one pixel.
//!
//! In: an image `factor` times as wide and high. Out: the mean of each block's covered samples in linear light, alpha
//! the covered share; AOVs of the first covered sample. On the host, so that it is the same for every processor.

use super::camera::Camera;
use super::constants::{THRESHOLDS_AT, constants};
use super::shade::{EMPTY, Pixel};
use crate::attribute::arithmetic::{srgb_encode, unit_encode};
use crate::{Error, Result};

/// Samples along each side of a pixel.
pub(crate) fn factor(samples: u32) -> Result<u32> {
    match samples {
        1 => Ok(1),
        4 => Ok(2),
        16 => Ok(4),
        64 => Ok(8),
        other => Err(Error::Option {
            option: "--samples",
            reason: format!("{other} is not 1, 4, 16 or 64 samples a pixel"),
        }),
    }
}

/// One image of `camera`'s size from one `factor` times as fine. `coded`: values are coded already (normals, false
/// colours), not linear light.
pub(crate) fn average(fine: &[Pixel], camera: &Camera, factor: u32, coded: bool) -> Vec<Pixel> {
    let constants = constants();
    let thresholds = &constants[THRESHOLDS_AT..THRESHOLDS_AT + 256];
    let encode = |c: f32| {
        if coded {
            unit_encode(c)
        } else {
            srgb_encode(thresholds, c)
        }
    };
    let (width, height, f) = (
        camera.width as usize,
        camera.height as usize,
        factor as usize,
    );
    let mut out = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let samples = (0..f * f).map(|i| &fine[(y * f + i / f) * width * f + x * f + i % f]);
            out.push(mean(samples, encode));
        }
    }
    out
}

fn mean<'a>(samples: impl Iterator<Item = &'a Pixel>, encode: impl Fn(f32) -> u32) -> Pixel {
    let (mut sum, mut alpha, mut count) = ([0f32; 3], 0f32, 0f32);
    let mut first = None;
    for sample in samples {
        let a = sample.linear[3];
        (0..3).for_each(|i| sum[i] += sample.linear[i] * a);
        alpha += a;
        count += 1.0;
        if first.is_none() && sample.rgba8 != 0 {
            first = Some(*sample);
        }
    }
    let Some(first) = first.filter(|_| alpha > 0.0) else {
        return EMPTY;
    };
    let [r, g, b] = sum.map(|c| c / alpha);
    let codes = [r, g, b].map(encode);
    let coverage = alpha / count;
    let rgba8 = codes[0] | (codes[1] << 8) | (codes[2] << 16) | (unit_encode(coverage) << 24);
    Pixel {
        linear: [r, g, b, coverage],
        rgba8,
        aov: first.aov,
    }
}
