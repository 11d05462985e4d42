//! Float arithmetic whose every bit is ours: the twin of `glsl/common/arithmetic.glsl`.
//!
//! In and out: `f32`. Built from `+ - * /`, `sqrt`, `floor` and conversions between `i32` and `f32` alone, each
//! correctly rounded by IEEE 754 here and by every driver measured, in a fixed order and never contracted. That is
//! what makes an image the same bytes on the CPU and on each device; `dot`, `mix`, `normalize`, `inversesqrt`, `pow`
//! and `exp2` of GLSL are not (drivers choose their own formulas).

/// Three components, in the order of the axes.
pub(crate) type V3 = [f32; 3];

/// `a . b`, summed from x to z.
pub(crate) fn dot3(a: V3, b: V3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a x b`.
pub(crate) fn cross3(a: V3, b: V3) -> V3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `b[0] corners[0] + b[1] corners[1] + b[2] corners[2]`.
#[inline]
pub(crate) fn weighted([p, q, r]: &[V3; 3], b: [f32; 3]) -> V3 {
    let along = |k: usize| b[0] * p[k] + b[1] * q[k] + b[2] * r[k];
    [along(0), along(1), along(2)]
}

/// `a + b`.
pub(crate) fn add3(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
pub(crate) fn sub3(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a * s`.
pub(crate) fn scale3(a: V3, s: f32) -> V3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// `a * b`, component by component.
pub(crate) fn mul3(a: V3, b: V3) -> V3 {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

/// `v` at unit length, or `fallback` where `v` has none (squared length not above 1e-30).
pub(crate) fn unit3(v: V3, fallback: V3) -> V3 {
    let squared = dot3(v, v);
    if squared > 1e-30 {
        let length = squared.sqrt();
        [v[0] / length, v[1] / length, v[2] / length]
    } else {
        fallback
    }
}

/// `log2 x` for positive, normal, finite `x`; the error is below 2e-7 plus the rounding of the sum (the series of the
/// area tangent, cut after its seventh power).
pub(crate) fn log2(x: f32) -> f32 {
    let bits = x.to_bits() as i32;
    let mut exponent = (bits >> 23) - 127;
    let mut mantissa = f32::from_bits(((bits & 0x007f_ffff) | 0x3f80_0000) as u32);
    if mantissa > std::f32::consts::SQRT_2 {
        mantissa *= 0.5;
        exponent += 1;
    }
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let s = t * t;
    let series = 1.0 + s * (0.333_333_34 + s * (0.2 + s * 0.142_857_15));
    exponent as f32 + (t * series) * 2.885_39
}

/// The first `count` values of an sRGB decoding table: linear light of each 8-bit code (IEC 61966-2-1).
pub(crate) fn srgb_decode_table() -> [f32; 256] {
    std::array::from_fn(|code| srgb_to_linear(code as f64 / 255.0) as f32)
}

/// For each 8-bit code the least linear value that rounds to it; the first is minus infinity's stand-in.
///
/// Encoding counts how many thresholds a value reaches, so it is the exact rounding of the sRGB curve with no power
/// function in the shader.
pub(crate) fn srgb_encode_thresholds() -> [f32; 256] {
    std::array::from_fn(|code| {
        if code == 0 {
            -1.0
        } else {
            srgb_to_linear((code as f64 - 0.5) / 255.0) as f32
        }
    })
}

/// The 8-bit sRGB code of a linear value by bisection of [`srgb_encode_thresholds`].
pub(crate) fn srgb_encode(thresholds: &[f32], linear: f32) -> u32 {
    let mut code = 0u32;
    let mut step = 128u32;
    while step > 0 {
        if linear >= thresholds[(code + step) as usize] {
            code += step;
        }
        step >>= 1;
    }
    code
}

/// The 8-bit code of a value in [0, 1] that is coded already (normals, false colours).
pub(crate) fn unit_encode(value: f32) -> u32 {
    // Of a number that is not negative the conversion takes the floor, without a call where processors have none.
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as i32 as u32
}

fn srgb_to_linear(coded: f64) -> f64 {
    if coded <= 0.040_45 {
        coded / 12.92
    } else {
        ((coded + 0.055) / 1.055).powf(2.4)
    }
}

/// The sRGB curve (IEC 61966-2-1) of a linear value, 0 below 0.
pub(crate) fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear.max(0.0)
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log2_is_within_a_millionth_of_the_logarithm() {
        let mut worst = 0f64;
        let mut x = 1e-12f32;
        while x < 1e12 {
            worst = worst.max((f64::from(log2(x)) - f64::from(x).log2()).abs());
            x *= 1.000_37;
        }
        assert!(worst < 3e-6, "{worst}");
    }

    #[test]
    fn encoding_rounds_the_srgb_curve_and_undoes_decoding() {
        let (decode, thresholds) = (srgb_decode_table(), srgb_encode_thresholds());
        for code in 0..256u32 {
            assert_eq!(srgb_encode(&thresholds, decode[code as usize]), code);
        }
        for i in 0..=10_000 {
            let x = i as f32 / 10_000.0;
            let coded = if x <= 0.003_130_8 {
                x * 12.92
            } else {
                1.055 * x.powf(1.0 / 2.4) - 0.055
            };
            let nearest = (coded * 255.0).round();
            let margin = (coded * 255.0 - coded.mul_add(255.0, 0.0).floor() - 0.5).abs();
            assert!(
                margin < 1e-3 || srgb_encode(&thresholds, x) == nearest as u32,
                "{x}"
            );
        }
        assert_eq!(srgb_encode(&thresholds, 7.0), 255);
        assert_eq!(srgb_encode(&thresholds, -7.0), 0);
    }

    #[test]
    fn unit_vectors_have_unit_length_and_zero_falls_back() {
        let v = unit3([3.0, -4.0, 12.0], [0.0, 0.0, 1.0]);
        assert!((dot3(v, v) - 1.0).abs() < 1e-6);
        assert_eq!(unit3([0.0; 3], [0.0, 0.0, 1.0]), [0.0, 0.0, 1.0]);
        let normal = cross3([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        assert_eq!(normal, [0.0, 0.0, 1.0]);
    }
}
