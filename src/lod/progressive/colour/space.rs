//! Colour spaces in which deviations are measured, and their places of colours.
//!
//! In: linear RGBA. Out: a point of four coordinates, whose Euclidean distances are what [`Distance`] says. The fourth is
//! opacity, for materials where it matters: all of it counts as much as black against white.
//!
//! Sources: CIE 15:2004 (CIELAB, the 1976 distance), IEC 61966-2-1 (sRGB and its white, D65).

use glam::{DVec3, Vec4};

/// How colours are compared.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Distance {
    /// Distance in CIELAB under D65 (Delta E of 1976): 1 is about what is just noticed, 100 is black against white.
    #[default]
    Lab,
    /// Distance of sRGB codes, 0 to 255 for each of red, green and blue.
    Rgb,
}

/// CIE XYZ of linear sRGB, over the white's (columns).
const XYZ: [DVec3; 3] = [
    DVec3::new(0.412_390_8 / WHITE[0], 0.212_639_0, 0.019_330_8 / WHITE[2]),
    DVec3::new(0.357_584_3 / WHITE[0], 0.715_168_7, 0.119_194_8 / WHITE[2]),
    DVec3::new(0.180_480_8 / WHITE[0], 0.072_192_3, 0.950_532_2 / WHITE[2]),
];
/// D65 as the sum of the three: white has no hue.
const WHITE: [f64; 3] = [0.950_455_9, 1.0, 1.089_057_8];

impl Distance {
    /// Where a colour lies: linear RGB, and opacity where it `matters`.
    pub fn place(self, rgba: [f64; 4], matters: bool) -> [f64; 4] {
        let opacity = if matters { rgba[3] } else { 0.0 };
        let rgb = [rgba[0], rgba[1], rgba[2]].map(|c| c.clamp(0.0, 1.0));
        match self {
            Distance::Lab => {
                let f = (XYZ[0] * rgb[0] + XYZ[1] * rgb[1] + XYZ[2] * rgb[2])
                    .to_array()
                    .map(lightness);
                [
                    116.0 * f[1] - 16.0,
                    500.0 * (f[0] - f[1]),
                    200.0 * (f[1] - f[2]),
                    100.0 * opacity,
                ]
            }
            Distance::Rgb => {
                let [r, g, b] = rgb.map(|c| 255.0 * to_srgb(c));
                [r, g, b, 255.0 * opacity]
            }
        }
    }

    /// Steps a unit in which places of texels are kept: they fit 16 bits.
    pub(super) fn steps(self) -> f32 {
        match self {
            Distance::Lab => 256.0,
            Distance::Rgb => 128.0,
        }
    }

    /// Below this nobody asks how large a deviation is.
    pub(super) fn floor(self) -> f32 {
        match self {
            Distance::Lab => 0.1,
            Distance::Rgb => 0.25,
        }
    }
}

/// CIELAB's f: a cube root, straight near black.
fn lightness(t: f64) -> f64 {
    const EDGE: f64 = 6.0 / 29.0;
    if t > EDGE * EDGE * EDGE {
        t.cbrt()
    } else {
        t / (3.0 * EDGE * EDGE) + 4.0 / 29.0
    }
}

fn to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The linear value of an sRGB code.
pub(super) fn from_srgb(code: u8) -> f64 {
    let c = f64::from(code) / 255.0;
    if c <= 0.040_45 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

/// As the vectors that are computed with.
pub(super) fn vector(place: [f64; 4]) -> Vec4 {
    Vec4::from_array(place.map(|x| x as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lab(code: [u8; 3]) -> [f64; 4] {
        let [r, g, b] = code.map(from_srgb);
        Distance::Lab.place([r, g, b, 1.0], false)
    }

    /// Values of the primaries that every table of CIELAB under D65 has.
    #[test]
    fn known_colours() {
        let known = [
            ([255, 255, 255], [100.0, 0.0, 0.0]),
            ([0, 0, 0], [0.0, 0.0, 0.0]),
            ([255, 0, 0], [53.24, 80.09, 67.20]),
            ([0, 255, 0], [87.73, -86.18, 83.18]),
            ([0, 0, 255], [32.30, 79.19, -107.86]),
        ];
        for (code, expected) in known {
            let found = lab(code);
            for k in 0..3 {
                assert!((found[k] - expected[k]).abs() < 0.03, "{code:?}: {found:?}");
            }
        }
        let codes = Distance::Rgb.place([from_srgb(7), from_srgb(200), 1.0, 0.5], true);
        let expected = [7.0, 200.0, 255.0, 127.5];
        assert!(
            (0..4).all(|k| (codes[k] - expected[k]).abs() < 1e-3),
            "{codes:?}"
        );
    }
}
