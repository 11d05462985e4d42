//! Exact texture filtering: the twin of `glsl/common/texture.glsl`.
//!
//! In: a [`TextureSet`], a texture's id, uv and the change of uv to the next pixel in x and in y. Out: RGBA in linear
//! light. Bilinear inside a level, linear between two; the level is log2 of the longer of the two gradients in texels
//! (isotropic, as Vulkan's section on scale factors has it for one sample). Uv far outside [0, 1] wrap exactly.

use super::arithmetic::log2;
use super::texture::{FLAG_NEAREST, FLAG_NO_MIPS, FLAG_SRGB, LEVELS_AT, TEXTURE_WORDS, TextureSet};

/// Uv and its change to the next pixel in x and in y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct UvGradient {
    pub uv: [f32; 2],
    pub dx: [f32; 2],
    pub dy: [f32; 2],
}

impl TextureSet {
    /// RGBA of texture `id` at `at`, filtered; `decode` is the sRGB table.
    pub(crate) fn sample(&self, decode: &[f32], id: u32, at: &UvGradient) -> [f32; 4] {
        let record = &self.records[id as usize * TEXTURE_WORDS..][..TEXTURE_WORDS];
        let top = record[3] as i32 - 1;
        let lambda = level_of(record, at);
        if lambda <= 0.0 || top == 0 || record[5] & FLAG_NO_MIPS != 0 {
            return self.level(decode, record, 0, at.uv);
        }
        let lambda = lambda.min(top as f32);
        let low = lambda.floor();
        let f = lambda - low;
        let level = low as i32;
        let a = self.level(decode, record, level, at.uv);
        if f == 0.0 {
            return a;
        }
        let b = self.level(decode, record, level + 1, at.uv);
        blend(a, b, f)
    }

    /// [`sample`](Self::sample) over a footprint that is up to `most` times as long as wide: the mean of samples along the
    /// longer gradient, each of its share of it.
    pub(crate) fn sample_along(
        &self,
        decode: &[f32],
        id: u32,
        at: &UvGradient,
        most: u32,
    ) -> [f32; 4] {
        let record = &self.records[id as usize * TEXTURE_WORDS..][..TEXTURE_WORDS];
        let [x, y] = [at.dx, at.dy].map(|d| squared_texels(record, d));
        let (longer, shorter) = (x.max(y), x.min(y).max(1.0));
        let reached = |k: &u32| longer > shorter * (k * k) as i32 as f32;
        let count = (1..most).rfind(reached).unwrap_or(0) + 1;
        let n = count as i32 as f32;
        let along = if x >= y { at.dx } else { at.dy }.map(|c| c / n);
        let (dx, dy) = if x >= y {
            (along, at.dy)
        } else {
            (at.dx, along)
        };
        let mut sum = [0.0; 4];
        for k in 0..count {
            let t = (2 * k + 1) as i32 as f32 * 0.5 - n * 0.5;
            let uv = [0, 1].map(|i| at.uv[i] + along[i] * t);
            let one = self.sample(decode, id, &UvGradient { uv, dx, dy });
            sum = [0, 1, 2, 3].map(|i| sum[i] + one[i]);
        }
        sum.map(|c| c / n)
    }

    /// One level, bilinear or nearest.
    fn level(&self, decode: &[f32], record: &[u32], level: i32, uv: [f32; 2]) -> [f32; 4] {
        let w = (record[1] >> level).max(1) as i32;
        let h = (record[2] >> level).max(1) as i32;
        let (wrap_u, wrap_v) = (record[4] & 3, (record[4] >> 2) & 3);
        let x = wrap_coordinate(uv[0], wrap_u) * w as f32;
        let y = wrap_coordinate(uv[1], wrap_v) * h as f32;
        let base = record[0].wrapping_add(record[LEVELS_AT + level as usize]);
        let texel = |x: i32, y: i32| {
            let (x, y) = (wrap_index(x, w, wrap_u), wrap_index(y, h, wrap_v));
            unpack(
                self.texels[(base as i32 + y * w + x) as usize],
                decode,
                record[5] & FLAG_SRGB != 0,
            )
        };
        if record[5] & FLAG_NEAREST != 0 {
            return texel(x.floor() as i32, y.floor() as i32);
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let (x0, y0) = (x0 as i32, y0 as i32);
        let upper = blend(texel(x0, y0), texel(x0 + 1, y0), fx);
        let lower = blend(texel(x0, y0 + 1), texel(x0 + 1, y0 + 1), fx);
        blend(upper, lower, fy)
    }
}

/// log2 of the longer gradient in texels of level 0.
fn level_of(record: &[u32], at: &UvGradient) -> f32 {
    let longer = squared_texels(record, at.dx).max(squared_texels(record, at.dy));
    0.5 * log2(longer.clamp(1e-20, 1e20))
}

/// The square of a gradient's length in texels of level 0.
fn squared_texels(record: &[u32], d: [f32; 2]) -> f32 {
    let (x, y) = (
        d[0] * record[1] as i32 as f32,
        d[1] * record[2] as i32 as f32,
    );
    x * x + y * y
}

/// `a * (1 - f) + b * f`.
fn blend(a: [f32; 4], b: [f32; 4], f: f32) -> [f32; 4] {
    let g = 1.0 - f;
    [0, 1, 2, 3].map(|i| a[i] * g + b[i] * f)
}

/// Brings a coordinate near [0, 1] so that texel indices stay small: repeat [0, 1], mirror [0, 2], clamp [-1, 2].
fn wrap_coordinate(u: f32, mode: u32) -> f32 {
    match mode {
        0 => u - u.floor(),
        1 => u - 2.0 * (u * 0.5).floor(),
        _ => u.clamp(-1.0, 2.0),
    }
}

/// The texel an index just outside stands for.
fn wrap_index(i: i32, n: i32, mode: u32) -> i32 {
    let mut i = i;
    match mode {
        0 => {
            if i < 0 {
                i += n;
            }
            if i >= n {
                i -= n;
            }
        }
        1 => {
            if i < 0 {
                i = -1 - i;
            }
            if i >= 2 * n {
                i -= 2 * n;
            }
            if i >= n {
                i = 2 * n - 1 - i;
            }
        }
        _ => {}
    }
    i.clamp(0, n - 1)
}

fn unpack(word: u32, decode: &[f32], srgb: bool) -> [f32; 4] {
    let byte = |shift: u32| (word >> shift) & 0xff;
    let channel = |shift: u32| byte(shift) as i32 as f32 / 255.0;
    if srgb {
        let colour = |shift: u32| decode[byte(shift) as usize];
        [colour(0), colour(8), colour(16), channel(24)]
    } else {
        [channel(0), channel(8), channel(16), channel(24)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::arithmetic::srgb_decode_table;
    use super::super::texture::{Pixels, Sampler, Wrap};
    use super::*;

    const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];

    /// glTF's wrap modes by definition: a texel's index in an endless row of copies.
    fn endless(i: i64, n: i64, wrap: Wrap) -> i64 {
        match wrap {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Mirror => {
                let j = i.rem_euclid(2 * n);
                if j < n { j } else { 2 * n - 1 - j }
            }
            Wrap::Clamp => i.clamp(0, n - 1),
        }
    }

    fn brute(rgba: &[u8], w: i64, h: i64, wrap: [Wrap; 2], uv: [f64; 2], channel: usize) -> f64 {
        let (x, y) = (uv[0] * w as f64 - 0.5, uv[1] * h as f64 - 0.5);
        let mut sum = 0.0;
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (ix, iy) = (x.floor() as i64 + dx, y.floor() as i64 + dy);
            let weight = (1.0 - (x - ix as f64).abs()) * (1.0 - (y - iy as f64).abs());
            let at = endless(iy, h, wrap[1]) * w + endless(ix, w, wrap[0]);
            sum += weight * f64::from(rgba[at as usize * 4 + channel]) / 255.0;
        }
        sum
    }

    #[test]
    fn bilinear_agrees_with_the_definition_in_every_wrap_mode() {
        let decode = srgb_decode_table();
        for (w, h) in [(1, 1), (2, 1), (5, 3), (8, 8)] {
            let rgba: Vec<u8> = (0..w * h * 4).map(|i| (i * 97 + 13) as u8).collect();
            for wrap_u in WRAPS {
                for wrap_v in WRAPS {
                    let mut set = TextureSet::default();
                    let sampler = Sampler {
                        wrap_u,
                        wrap_v,
                        ..Sampler::default()
                    };
                    let pixels = Pixels {
                        width: w as u32,
                        height: h as u32,
                        rgba: &rgba,
                    };
                    let id = set.add(0, false, sampler, || Ok(pixels)).unwrap();
                    for i in -40..40 {
                        let uv = [i as f32 * 0.093_75, 0.7 - i as f32 * 0.062_5];
                        let got = set.sample(
                            &decode,
                            id,
                            &UvGradient {
                                uv,
                                ..UvGradient::default()
                            },
                        );
                        for channel in 0..4 {
                            let want =
                                brute(&rgba, w, h, [wrap_u, wrap_v], uv.map(f64::from), channel);
                            let error = (f64::from(got[channel]) - want).abs();
                            assert!(
                                error < 1e-5,
                                "{w}x{h} {wrap_u:?} {wrap_v:?} {uv:?}: {error}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn any_float_is_a_coordinate() {
        let rgba = [255u8; 3 * 2 * 4];
        for wrap in WRAPS {
            let mut set = TextureSet::default();
            let sampler = Sampler {
                wrap_u: wrap,
                wrap_v: wrap,
                ..Sampler::default()
            };
            let id = set
                .add(0, false, sampler, || {
                    Ok(Pixels {
                        width: 3,
                        height: 2,
                        rgba: &rgba,
                    })
                })
                .unwrap();
            for u in [
                0.0,
                -0.0,
                1.0,
                -1e-9,
                0.999_999_94,
                1e9,
                -1e9,
                3e38,
                -3e38,
                1e-40,
            ] {
                for v in [0.5, -1e-9, 3e38] {
                    let at = UvGradient {
                        uv: [u, v],
                        dx: [3e38, 0.0],
                        dy: [0.0, 1e-30],
                    };
                    let got = set.sample(&srgb_decode_table(), id, &at);
                    assert!(
                        got.iter().all(|c| (c - 1.0).abs() < 1e-6),
                        "{u} {v} {got:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_level_grows_by_one_with_each_doubling_of_the_gradient() {
        let rgba: Vec<u8> = (0..16 * 16 * 4)
            .map(|i| if (i / 4 + i / 64) % 2 == 0 { 255 } else { 0 })
            .collect();
        let mut set = TextureSet::default();
        let id = set
            .add(0, false, Sampler::default(), || {
                Ok(Pixels {
                    width: 16,
                    height: 16,
                    rgba: &rgba,
                })
            })
            .unwrap();
        let record = &set.records[..TEXTURE_WORDS];
        for k in 0..5 {
            let dx = [(1 << k) as f32 / 16.0, 0.0];
            let lambda = level_of(
                record,
                &UvGradient {
                    uv: [0.0; 2],
                    dx,
                    dy: [0.0; 2],
                },
            );
            assert!((lambda - k as f32).abs() < 1e-5);
        }
        // A checkerboard seen from one level up is grey.
        let at = UvGradient {
            uv: [0.3, 0.6],
            dx: [2.0 / 16.0, 0.0],
            dy: [0.0; 2],
        };
        let grey = set.sample(&srgb_decode_table(), id, &at);
        assert!((grey[0] - 0.5).abs() < 0.01, "{grey:?}");
    }
}
