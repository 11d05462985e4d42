//! How values of a texture become codes of 8 or 16 bits.

use super::wanted::BakeAttribute;
use crate::attribute::arithmetic::{V3, linear_to_srgb, srgb_encode, unit_encode};
use crate::render::{THRESHOLDS_AT, constants};
use rayon::prelude::*;

/// The largest number that the first component of a mapping's value holds beside others.
const LOW_BITS: u32 = 24;

/// What values are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Coding {
    /// Linear light.
    Color,
    /// -1..1.
    Direction,
    /// Places in a box with this low corner and longest side.
    Place(V3, f32),
    /// From minus this to this.
    Signed(f32),
    /// From 0 to this.
    Length(f32),
    /// Numbers of triangles.
    Number,
    /// 0..1.
    Plain,
}

impl Coding {
    /// How an attribute of a model in this box is coded, where nothing else is said of heights.
    pub(super) fn of(attribute: &BakeAttribute, (low, longest): (V3, f32), steep: f32) -> Coding {
        match attribute {
            _ if attribute.is_direction() => Coding::Direction,
            _ if attribute.is_color() => Coding::Color,
            BakeAttribute::Position => Coding::Place(low, longest),
            BakeAttribute::Height => Coding::Signed(steep),
            BakeAttribute::Mapping => Coding::Number,
            _ => Coding::Plain,
        }
    }

    /// A value as what codes hold, 0..1; colours still linear.
    fn unit(self, value: [f32; 4]) -> [f32; 4] {
        let [x, y, z, w] = value;
        let rgb = [x, y, z];
        let [x, y, z] = match self {
            Coding::Color | Coding::Plain => rgb,
            Coding::Direction => rgb.map(|c| c * 0.5 + 0.5),
            Coding::Place(low, longest) => [0, 1, 2].map(|k| (rgb[k] - low[k]) / longest),
            Coding::Signed(most) => rgb.map(|c| c / most * 0.5 + 0.5),
            Coding::Length(most) => rgb.map(|c| c / most),
            Coding::Number => number(value).map_or([0.0; 3], shade),
        };
        [x, y, z, w]
    }

    /// Four codes of 8 bits for each value.
    pub(super) fn eight(self, values: &[[f32; 4]]) -> Vec<u8> {
        let constants = constants();
        let thresholds = &constants[THRESHOLDS_AT..THRESHOLDS_AT + 256];
        let code = |c: f32| code(c, self == Coding::Color, thresholds);
        let codes = values.par_iter().map(|value| {
            let [r, g, b, a] = self.unit(*value);
            [code(r), code(g), code(b), unit_encode(a) as u8]
        });
        codes.collect::<Vec<[u8; 4]>>().into_flattened()
    }

    /// Four codes of 16 bits for each value.
    pub(super) fn sixteen(self, values: &[[f32; 4]]) -> Vec<u16> {
        let rounded = |c: f64| (c.clamp(0.0, 1.0) * 65535.0).round() as u16;
        let code = |c: f32| match self {
            Coding::Color => rounded(linear_to_srgb(f64::from(c))),
            _ => rounded(c.into()),
        };
        let codes = values.par_iter().map(|value| {
            let [r, g, b, a] = self.unit(*value);
            [code(r), code(g), code(b), rounded(a.into())]
        });
        codes.collect::<Vec<[u16; 4]>>().into_flattened()
    }
}

/// A channel in 8 bits: light as sRGB, or what it is.
pub(super) fn code(value: f32, is_color: bool, thresholds: &[f32]) -> u8 {
    match is_color {
        true => srgb_encode(thresholds, value) as u8,
        false => unit_encode(value) as u8,
    }
}

/// The value of a mapping at a point: the number's low 24 bits, which a float holds exactly, barycentrics, and 1 more than its
/// high bits.
pub(super) fn numbered(triangle: u32, b: [f32; 3]) -> [f32; 4] {
    let low = triangle & ((1 << LOW_BITS) - 1);
    [low as f32, b[1], b[2], (triangle >> LOW_BITS) as f32 + 1.0]
}

/// The number in it.
pub(super) fn number([low, _, _, high]: [f32; 4]) -> Option<u32> {
    (low >= 0.0 && high >= 1.0).then(|| low as u32 | (high as u32 - 1) << LOW_BITS)
}

/// A colour for a number, none near black.
fn shade(number: u32) -> V3 {
    let mixed = number.wrapping_add(1).wrapping_mul(0x9e37_79b9);
    let mixed = (mixed ^ mixed >> 15).wrapping_mul(0x85eb_ca6b);
    [8, 16, 24].map(|shift| 0.25 + 0.75 * (mixed >> shift & 0xff) as f32 / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_of_a_triangle_comes_back() {
        for n in [0, 1, (1 << 24) - 1, 1 << 24, (1 << 24) + 1, 0xfedc_ba98] {
            assert_eq!(number(numbered(n, [0.5, 0.25, 0.25])), Some(n));
        }
        assert_eq!(number([-1.0, 0.0, 0.0, 0.0]), None);
        // A float alone would not have done.
        assert_ne!(((1u32 << 24) + 1) as f32 as u32, (1 << 24) + 1);
    }

    #[test]
    fn ends_and_middles_have_the_codes_they_should() {
        let grey = |c: f32| [c, c, c, 1.0];
        for (coding, value, unit) in [
            (Coding::Plain, 0.25, 0.25),
            (Coding::Direction, -1.0, 0.0),
            (Coding::Signed(4.0), 2.0, 0.75),
            (Coding::Length(4.0), 1.0, 0.25),
            (Coding::Place([1.0; 3], 2.0), 2.0, 0.5),
            (Coding::Color, 0.214_041_14, 0.5),
            (Coding::Color, 9.0, 1.0),
        ] {
            let eight = coding.eight(&[grey(value)]);
            let sixteen = coding.sixteen(&[grey(value)]);
            assert_eq!(eight[3], 255);
            assert_eq!(sixteen[3], 65535);
            assert!(
                (f64::from(eight[0]) - unit * 255.0).abs() <= 0.5,
                "{coding:?}"
            );
            let deep = f64::from(sixteen[0]) - unit * 65535.0;
            assert!(deep.abs() <= 0.51, "{coding:?}");
        }
    }
}
