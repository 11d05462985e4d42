//! Texels of the octahedral map against their definition.

use super::half;

/// Digit by digit, as `igt_half` in `glsl/common/igt_line.glsl` has it.
fn by_digits(bits: u32, u: u32, length: u32, negative: bool) -> u32 {
    let mut rest = if negative { length - u } else { length + u };
    let mut quotient = 0;
    for _ in 0..bits {
        quotient <<= 1;
        if rest >= length {
            rest -= length;
            quotient |= 1;
        }
        rest = rest.wrapping_shl(1);
    }
    quotient
}

#[test]
fn the_octahedral_texel_is_that_of_the_digits() {
    let most = 3u32 << 29;
    let lengths = [
        0,
        1,
        2,
        3,
        7,
        8191,
        8192,
        8193,
        (1 << 24) - 1,
        1 << 29,
        most - 1,
        most,
    ];
    for bits in 2..=13u32 {
        for length in lengths {
            let border = |k: u64| ((length as u64 * k) >> (bits - 1)) as u32;
            let some = (0..=1u64 << (bits - 1)).step_by(1 << bits.saturating_sub(6));
            for at in some
                .map(border)
                .chain([0, 1, length / 2, length.saturating_sub(1), length])
            {
                for u in at.saturating_sub(1)..=at.saturating_add(1).min(length) {
                    for negative in [false, true] {
                        assert_eq!(
                            half(bits, u.min(length), length, negative),
                            by_digits(bits, u.min(length), length, negative),
                            "{bits} bits, {u} of {length}, {negative}"
                        );
                    }
                }
            }
        }
    }
}
