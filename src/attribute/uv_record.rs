//! A triangle's artist uv in one load: three corners in 128 bits. Twin of `igt_uv_record` in `glsl/common/surface.glsl`.
//!
//! Six fields of 20 bits, in steps of 2^-19 from a whole number on (4 bits each for u and v, -8 to 6): whole numbers and all
//! borders of texels are exact, others are off by 2^-20 at most, 1/256 of a texel of 4096. A triangle that spans two whole
//! numbers or more, or lies farther out, has no record: its uv is read from its vertices.

/// Steps of a field.
const STEPS: f64 = 524_288.0;
/// The size of a step.
const STEP: f32 = 1.0 / 524_288.0;
/// Added to whole numbers.
const WHOLE_BIAS: f64 = 8.0;
/// The last word of a record that is not one.
const NONE: u32 = u32::MAX;

/// The uv of three corners.
pub(crate) type CornerUv = [[f32; 2]; 3];

/// The record of a triangle's uv, or the mark that it has none.
pub(crate) fn encode(uv: &CornerUv) -> [u32; 4] {
    let mut bits = 0u128;
    for k in 0..2 {
        let c = uv.map(|p| f64::from(p[k]));
        let whole = c[0].min(c[1]).min(c[2]).floor();
        for (i, x) in c.iter().enumerate() {
            let field = ((x - whole) * STEPS).round();
            if !((-WHOLE_BIAS..7.0).contains(&whole) && (0.0..2.0 * STEPS).contains(&field)) {
                return [0, 0, 0, NONE];
            }
            bits |= (field as u128) << (20 * (2 * i + k));
        }
        bits |= ((whole + WHOLE_BIAS) as u128) << (120 + 4 * k);
    }
    [0, 1, 2, 3].map(|i| (bits >> (32 * i)) as u32)
}

/// Whether a triangle has a record.
pub(crate) fn is_one(record: [u32; 4]) -> bool {
    record[3] != NONE
}

/// The uv of a record; none where it is not one.
pub(crate) fn decode(record: [u32; 4]) -> Option<CornerUv> {
    if !is_one(record) {
        return None;
    }
    let bits = (0..4).fold(0, |b, i| b | u128::from(record[i]) << (32 * i));
    let whole = |k: usize| ((bits >> (120 + 4 * k)) as u32 & 15) as f32 - WHOLE_BIAS as f32;
    let field = |i: usize| ((bits >> (20 * i)) as u32 & 0xf_ffff) as f32 * STEP;
    Some([0, 1, 2].map(|i| [0, 1].map(|k| field(2 * i + k) + whole(k))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_of_texels_are_exact_and_others_within_half_a_step() {
        for uv in [
            [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            [[0.25, 0.5], [17.0 / 4096.0, 1.0], [0.125, 4095.0 / 4096.0]],
            [[-0.05, -0.97], [0.3, -0.03], [0.1, -0.5]],
            [[3.9, -7.5], [4.4, -6.9], [4.0, -7.0]],
        ] {
            let read = decode(encode(&uv)).unwrap();
            for (given, read) in uv.iter().flatten().zip(read.iter().flatten()) {
                let exact = given * 4096.0 == (given * 4096.0).round();
                let off = (given - read).abs();
                assert!(
                    if exact {
                        off == 0.0
                    } else {
                        off <= STEP * 0.75
                    },
                    "{given} {read}"
                );
            }
        }
    }

    #[test]
    fn what_does_not_fit_has_no_record() {
        for uv in [
            [[0.0, 0.0], [2.5, 0.0], [0.0, 1.0]],
            [[9.0, 0.0], [9.5, 0.0], [9.0, 1.0]],
            [[-8.5, 0.0], [-8.2, 0.0], [-8.4, 1.0]],
            [[f32::NAN, 0.0], [0.5, 0.0], [0.0, 1.0]],
        ] {
            assert_eq!(decode(encode(&uv)), None, "{uv:?}");
        }
    }
}
