//! Mip chains by box filter in linear light.
//!
//! In: an RGBA image of 8 bits. Out: its levels, each half as large (rounded down, at least 1), down to one texel. A
//! texel of a level is the mean of the area it covers of the level above; at odd sizes that area cuts texels and they
//! count by the share covered, so every level keeps the mean of the first. Colour of sRGB images is averaged in linear
//! light; alpha and linear images as they are. Rows are filtered on all cores, with no sum that depends on the split.

use super::arithmetic::{srgb_decode_table, srgb_encode, srgb_encode_thresholds, unit_encode};
use super::texture::{Pixels, words};
use rayon::prelude::*;

/// Appends all levels of `pixels` to `texels`, a word per texel (R in the low byte); returns where each level begins,
/// counted from the first.
pub(crate) fn append_chain(texels: &mut Vec<u32>, pixels: Pixels, srgb: bool) -> Vec<u32> {
    let base = texels.len();
    texels.extend(words(pixels.rgba));
    let codec = Codec::new(srgb);
    let mut offsets = vec![0u32];
    let (mut width, mut height) = (pixels.width as usize, pixels.height as usize);
    while width > 1 || height > 1 {
        let above = base + offsets[offsets.len() - 1] as usize;
        let (w, h) = ((width / 2).max(1), (height / 2).max(1));
        let level = halve(
            &texels[above..above + width * height],
            [width, height],
            [w, h],
            &codec,
        );
        offsets.push((texels.len() - base) as u32);
        texels.extend_from_slice(&level);
        (width, height) = (w, h);
    }
    offsets
}

/// One level from the one above it.
fn halve(above: &[u32], size: [usize; 2], target: [usize; 2], codec: &Codec) -> Vec<u32> {
    let columns = spans(size[0], target[0]);
    let rows = spans(size[1], target[1]);
    let mut out = vec![0u32; target[0] * target[1]];
    out.par_chunks_mut(target[0])
        .zip(&rows)
        .for_each(|(line, row)| {
            for (texel, column) in line.iter_mut().zip(&columns) {
                let mut sum = [0f32; 4];
                for &(y, wy) in row {
                    for &(x, wx) in column {
                        let value = codec.decode(above[y * size[0] + x]);
                        for channel in 0..4 {
                            sum[channel] += value[channel] * (wx * wy);
                        }
                    }
                }
                *texel = codec.encode(sum);
            }
        });
    out
}

/// For each of `target` cells the texels of `size` it covers, with weights that sum to one.
fn spans(size: usize, target: usize) -> Vec<Vec<(usize, f32)>> {
    (0..target)
        .map(|cell| {
            // In units of 1/target of a texel: the cell is [cell * size, (cell + 1) * size), texel x is [x, x + 1) * target.
            let (begin, end) = (cell * size, (cell + 1) * size);
            (begin / target..end.div_ceil(target))
                .map(|x| {
                    let covered = ((x + 1) * target).min(end) - (x * target).max(begin);
                    (x, covered as f32 / size as f32)
                })
                .collect()
        })
        .collect()
}

/// Texel words to linear values and back.
struct Codec {
    srgb: bool,
    decode: [f32; 256],
    thresholds: [f32; 256],
}

impl Codec {
    fn new(srgb: bool) -> Self {
        Codec {
            srgb,
            decode: srgb_decode_table(),
            thresholds: srgb_encode_thresholds(),
        }
    }

    fn decode(&self, word: u32) -> [f32; 4] {
        let bytes = word.to_le_bytes();
        let linear = bytes.map(|b| f32::from(b) / 255.0);
        if self.srgb {
            let [r, g, b] = [0, 1, 2].map(|i| self.decode[usize::from(bytes[i])]);
            [r, g, b, linear[3]]
        } else {
            linear
        }
    }

    fn encode(&self, value: [f32; 4]) -> u32 {
        let code = |i: usize| {
            if self.srgb && i < 3 {
                srgb_encode(&self.thresholds, value[i])
            } else {
                unit_encode(value[i])
            }
        };
        code(0) | (code(1) << 8) | (code(2) << 16) | (code(3) << 24)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_cover_every_texel_alike() {
        for size in 1..40usize {
            let target = (size / 2).max(1);
            let mut cover = vec![0f64; size];
            for span in spans(size, target) {
                let total: f64 = span.iter().map(|s| f64::from(s.1)).sum();
                assert!((total - 1.0).abs() < 1e-6);
                span.iter().for_each(|s| cover[s.0] += f64::from(s.1));
            }
            let mean = target as f64 / size as f64;
            assert!(
                cover.iter().all(|c| (c - mean).abs() < 1e-6),
                "{size}: {cover:?}"
            );
        }
    }

    #[test]
    fn every_level_keeps_the_mean_in_linear_light() {
        for (width, height, srgb) in [
            (16, 16, true),
            (16, 16, false),
            (7, 13, true),
            (1, 9, false),
            (33, 2, true),
        ] {
            let rgba: Vec<u8> = (0..width * height * 4)
                .map(|i| ((i * 2_654_435_761usize) >> 7) as u8)
                .collect();
            let mut texels = vec![9u32; 3];
            let pixels = Pixels {
                width: width as u32,
                height: height as u32,
                rgba: &rgba,
            };
            let offsets = append_chain(&mut texels, pixels, srgb);
            let codec = Codec::new(srgb);
            let mean = |level: &[u32], channel: usize| {
                level
                    .iter()
                    .map(|&t| f64::from(codec.decode(t)[channel]))
                    .sum::<f64>()
                    / level.len() as f64
            };
            let first = &texels[3..3 + width * height];
            let last = &texels[texels.len() - 1..];
            assert_eq!(texels.len() - 3, offsets[offsets.len() - 1] as usize + 1);
            for channel in 0..4 {
                let drift = (mean(first, channel) - mean(last, channel)).abs();
                assert!(
                    drift < 0.5 * (offsets.len() as f64) / 100.0,
                    "{width}x{height} {channel}: {drift}"
                );
            }
        }
    }

    #[test]
    fn black_and_white_average_to_half_the_light_not_half_the_code() {
        let rgba = [0, 0, 0, 255, 255, 255, 255, 255];
        let half = |srgb| {
            let mut texels = Vec::new();
            append_chain(
                &mut texels,
                Pixels {
                    width: 2,
                    height: 1,
                    rgba: &rgba,
                },
                srgb,
            );
            texels[2] & 0xff
        };
        assert_eq!((half(true), half(false)), (188, 128));
    }
}
