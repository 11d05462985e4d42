//! Numbers every shading pass reads: the sRGB tables and the false-colour scale, one buffer of floats.
//!
//! Words 0..256 decode sRGB, 256..512 are the encoding thresholds, then [`PALETTE_STOPS`] RGB colours of the *viridis*
//! scale (Smith and van der Walt; even steps look even, and it reads without colour vision), coded values.

use crate::attribute::arithmetic::{srgb_decode_table, srgb_encode_thresholds};

/// Where the thresholds begin.
pub(crate) const THRESHOLDS_AT: usize = 256;
/// Where the palette begins.
pub(crate) const PALETTE_AT: usize = 512;
/// Number of colours of the palette, evenly spaced over [0, 1].
pub(crate) const PALETTE_STOPS: usize = 17;

/// Viridis at 0, 1/16, ... 1, as 8-bit codes.
const VIRIDIS: [[u8; 3]; PALETTE_STOPS] = [
    [68, 1, 84],
    [72, 20, 103],
    [71, 39, 119],
    [66, 58, 130],
    [60, 77, 138],
    [51, 94, 141],
    [44, 111, 142],
    [38, 127, 142],
    [33, 144, 141],
    [31, 160, 136],
    [40, 176, 125],
    [66, 190, 113],
    [99, 203, 95],
    [137, 213, 72],
    [180, 222, 44],
    [218, 227, 25],
    [253, 231, 37],
];

/// The whole buffer.
pub(crate) fn constants() -> Vec<f32> {
    let mut out = Vec::with_capacity(PALETTE_AT + 3 * PALETTE_STOPS);
    out.extend(srgb_decode_table());
    out.extend(srgb_encode_thresholds());
    out.extend(
        VIRIDIS
            .iter()
            .flatten()
            .map(|&code| f32::from(code) / 255.0),
    );
    out
}

/// False colour (coded RGB) of `t` in [0, 1].
pub(crate) fn palette(constants: &[f32], t: f32) -> [f32; 3] {
    let x = t.clamp(0.0, 1.0) * (PALETTE_STOPS - 1) as f32;
    let low = x.floor().min((PALETTE_STOPS - 2) as f32);
    let f = x - low;
    let at = PALETTE_AT + 3 * low as i32 as usize;
    std::array::from_fn(|i| constants[at + i] * (1.0 - f) + constants[at + 3 + i] * f)
}

/// The false-colour scale as a legend: `steps` pairs of value in [0, 1] and 8-bit RGB.
pub fn legend(steps: usize) -> Vec<(f32, [u8; 3])> {
    let constants = constants();
    let last = steps.max(2) - 1;
    (0..=last)
        .map(|i| {
            let t = i as f32 / last as f32;
            (t, palette(&constants, t).map(|c| (c * 255.0).round() as u8))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_palette_gets_steadily_brighter() {
        let brightness = |c: [u8; 3]| {
            0.2126 * f32::from(c[0]) + 0.7152 * f32::from(c[1]) + 0.0722 * f32::from(c[2])
        };
        let scale = legend(100);
        assert_eq!((scale[0].1, scale[99].1), ([68, 1, 84], [253, 231, 37]));
        assert!(
            scale
                .windows(2)
                .all(|w| brightness(w[1].1) > brightness(w[0].1) - 0.6)
        );
        let constants = constants();
        assert_eq!(palette(&constants, -3.0), palette(&constants, 0.0));
        assert_eq!(palette(&constants, 3.0), palette(&constants, 1.0));
    }
}
