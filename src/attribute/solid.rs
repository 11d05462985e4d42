//! Solid textures: colours of space itself, so that the surface cut out of it is coloured without any uv. Twin of
//! `glsl/common/solid.glsl`.
//!
//! In: a point of the reference at rest, in units of the model's size; seconds. Out: linear RGB. A point has one colour
//! whatever level of detail it is found through, and every processor finds the same bits: coordinates are brought to a grid
//! of 2^20 steps a unit at once, noise is hashed from integers, and floats are `+ - * /`, square roots and floors of numbers
//! that stay away from the subnormal range (fractions of a cell have 16 bits for that).
//!
//! Every solid moves and begins again after four seconds. References: Perlin, *Improving noise* (2002), with cubic ease;
//! Worley, *A cellular texture basis function* (1996).

use super::arithmetic::{V3, dot3};

const UNIT_BITS: i32 = 20;
/// Steps of time, 2^-16 seconds each, after which a solid begins again.
const PERIOD: i32 = 1 << 18;

/// A built-in solid texture. The model's longest side is one unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solid {
    /// A board's rings around an upright trunk; they grow.
    Wood,
    /// Veins; they drift.
    Marble,
    /// Cells of one colour each between dark walls, eight to a unit; they wander.
    Cellular,
    /// Cubes of two colours, eight to a unit; they rise.
    Checker,
}

/// The colour of `solid` at `p` units.
pub(crate) fn color(solid: u32, p: V3, time: f32) -> V3 {
    let q = steps(p);
    let phase = phase(time);
    match solid {
        0 => wood(q, phase),
        1 => marble(q, phase),
        2 => cellular(q, phase),
        _ => checker(q, phase),
    }
}

/// Steps of a point given in units.
pub(super) fn steps(p: V3) -> [i32; 3] {
    p.map(|x| (x.clamp(-2000.0, 2000.0) * 1_048_576.0 + 0.5).floor() as i32)
}

fn phase(time: f32) -> i32 {
    (time.clamp(-16000.0, 16000.0) * 65_536.0 + 0.5).floor() as i32 & (PERIOD - 1)
}

fn units(steps: i32) -> f32 {
    steps as f32 * (1.0 / 1_048_576.0)
}

fn cell_hash([x, y, z]: [i32; 3], seed: u32) -> u32 {
    let h = (x as u32)
        .wrapping_mul(0x8da6_b343)
        .wrapping_add((y as u32).wrapping_mul(0xd816_3841))
        .wrapping_add((z as u32).wrapping_mul(0xcb1a_b31f))
        .wrapping_add(seed.wrapping_mul(0x9e37_79b9));
    let h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    let h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// How far into its cell of 2^bits steps a coordinate is, in 65536ths at most.
fn cell_fraction(q: i32, bits: i32) -> f32 {
    let kept = bits.min(16);
    ((q & ((1 << bits) - 1)) >> (bits - kept)) as f32 / (1 << kept) as f32
}

fn ease(t: f32) -> f32 {
    t * t * (3.0 - 2.0 * t)
}

pub(super) fn between(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

fn between3(a: V3, b: V3, t: f32) -> V3 {
    [0, 1, 2].map(|k| between(a[k], b[k], t))
}

/// One of twelve directions, dotted with `d`.
fn slope(h: u32, [x, y, z]: V3) -> f32 {
    let g = h & 15;
    let u = if g < 8 { x } else { y };
    let v = match g {
        0..4 => y,
        12 | 14 => x,
        _ => z,
    };
    (if g & 1 == 0 { u } else { -u }) + (if g & 2 == 0 { v } else { -v })
}

/// Gradient noise, about -1..1, with 2^octave cells to a unit.
fn noise(q: [i32; 3], octave: i32, seed: u32) -> f32 {
    let bits = UNIT_BITS - octave;
    let c = q.map(|q| q >> bits);
    let f = q.map(|q| cell_fraction(q, bits));
    let t = f.map(ease);
    let corner = |k: i32| {
        let corner = [k & 1, (k >> 1) & 1, k >> 2];
        let d = [0, 1, 2].map(|i| f[i] - corner[i] as f32);
        let cell = [0, 1, 2].map(|i| c[i].wrapping_add(corner[i]));
        slope(cell_hash(cell, seed), d)
    };
    let along_x = |k: i32| between(corner(k), corner(k + 1), t[0]);
    let along_y = |k: i32| between(along_x(k), along_x(k + 2), t[1]);
    between(along_y(0), along_y(4), t[2])
}

/// Sizes of four octaves of noise, each half as large as the one before.
fn turbulence(q: [i32; 3], octave: i32, seed: u32) -> f32 {
    let (mut sum, mut size) = (0.0, 1.0);
    for k in 0..4 {
        sum += noise(q, octave + k, seed + k as u32).abs() * size;
        size *= 0.5;
    }
    sum
}

fn fraction_of(x: f32) -> f32 {
    x - x.floor()
}

/// A phase as a part of its period.
fn turn(phase: i32) -> f32 {
    phase as f32 / 262_144.0
}

fn wood(q: [i32; 3], phase: i32) -> V3 {
    let (x, z) = (units(q[0]) + 0.55, units(q[2]) + 0.2);
    let radius = (x * x + z * z).sqrt() + 0.05 * noise(q, 1, 11) + 0.008 * noise(q, 4, 12);
    let ring = radius * 16.0 - turn(phase);
    let late = ease(fraction_of(ring));
    let dark = late * late;
    let fibre = 1.0 + 0.22 * noise([q[0], q[1] >> 4, q[2]], 6, 13);
    between3([0.60, 0.34, 0.15], [0.25, 0.10, 0.035], dark).map(|c| c * fibre)
}

fn marble(q: [i32; 3], phase: i32) -> V3 {
    let along = units(q[0]) * 5.0 + units(q[1]) * 3.0 + 2.2 * turbulence(q, 2, 21) + turn(phase);
    let wave = (fraction_of(along) - 0.5).abs() * 2.0;
    let eased = ease(wave);
    let vein = eased * eased * eased;
    between3([0.86, 0.84, 0.80], [0.10, 0.13, 0.17], vein)
}

/// Where in its cell a point of the pattern is along one axis: it goes to and fro in four seconds.
fn wander(h: u32, phase: i32) -> f32 {
    let at = ((h & 1023) as i32 * 256 + phase) & (PERIOD - 1);
    let wave = (turn(at) - 0.5).abs() * 2.0;
    0.1 + 0.8 * wave
}

fn cellular(q: [i32; 3], phase: i32) -> V3 {
    let bits = UNIT_BITS - 3;
    let c = q.map(|q| q >> bits);
    let f = q.map(|q| cell_fraction(q, bits));
    let (mut nearest, mut second, mut owner) = (1e9f32, 1e9f32, 0);
    for k in 0..27 {
        let step = [k % 3 - 1, (k / 3) % 3 - 1, k / 9 - 1];
        let h = cell_hash([0, 1, 2].map(|i| c[i].wrapping_add(step[i])), 31);
        let at = [h, h >> 10, h >> 20].map(|h| wander(h, phase));
        let d = [0, 1, 2].map(|i| step[i] as f32 + at[i] - f[i]);
        let squared = dot3(d, d);
        if squared < nearest {
            (second, nearest, owner) = (nearest, squared, h);
        } else {
            second = second.min(squared);
        }
    }
    let wall = (second.sqrt() - nearest.sqrt()) * 7.0;
    let inside = ease(wall.min(1.0));
    between3([0.02, 0.02, 0.03], id_color(owner), inside)
}

fn checker(q: [i32; 3], phase: i32) -> V3 {
    let c = [q[0], q[1].wrapping_sub(phase), q[2]].map(|q| q >> (UNIT_BITS - 3));
    if c[0].wrapping_add(c[1]).wrapping_add(c[2]) & 1 == 0 {
        [0.8, 0.8, 0.78]
    } else {
        [0.05, 0.05, 0.06]
    }
}

/// A colour for a number, linear: hues a golden section apart, so that neighbours differ, in four shades.
pub(crate) fn id_color(id: u32) -> V3 {
    let turned = id.wrapping_mul(0x9e37_79b9);
    let hue = (turned >> 16) as i32 as f32 * (6.0 / 65536.0);
    let shade = (id.wrapping_mul(0x85eb_ca6b) >> 30) as i32 as f32;
    let light = 0.9 - 0.17 * shade;
    let ramp = [
        (hue - 3.0).abs() - 1.0,
        2.0 - (hue - 2.0).abs(),
        2.0 - (hue - 4.0).abs(),
    ];
    ramp.map(|x| (0.12 + 0.88 * x.clamp(0.0, 1.0)) * light)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(a: V3, b: V3) -> f32 {
        (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max)
    }

    fn points() -> impl Iterator<Item = V3> {
        (0..4000).map(|i| {
            let t = i as f32;
            [0.731f32, 0.377, 0.913].map(|k| (t * k).fract() * 3.0 - 1.5)
        })
    }

    #[test]
    fn colours_of_numbers_are_in_range_and_neighbours_differ() {
        for id in 0..5000u32 {
            let here = id_color(id);
            assert!(
                here.iter().all(|c| (0.0..=1.0).contains(c)),
                "{id}: {here:?}"
            );
            for near in 1..4 {
                assert!(
                    apart(here, id_color(id + near)) > 0.12,
                    "{id} and {near} more"
                );
            }
        }
    }

    #[test]
    fn solids_are_colours_that_vary_in_space_and_begin_again_after_four_seconds() {
        for solid in 0..4 {
            let (mut low, mut high, mut moved) = (1f32, 0f32, 0);
            for p in points() {
                let now = color(solid, p, 0.0);
                assert!(
                    now.iter().all(|c| (0.0..=1.0).contains(c)),
                    "{solid} {p:?}: {now:?}"
                );
                (low, high) = (low.min(now[1]), high.max(now[1]));
                assert_eq!(now, color(solid, p, 4.0));
                moved += u32::from(now != color(solid, p, 1.0));
            }
            assert!(high - low > 0.1, "{solid} does not vary: {low} {high}");
            assert!(moved > 400, "{solid} does not move");
        }
        for p in [[f32::MAX; 3], [f32::MIN; 3]] {
            assert!(color(0, p, f32::MAX).iter().all(|c| c.is_finite()));
        }
    }

    #[test]
    fn noise_is_zero_at_corners_continuous_and_has_no_mean() {
        let (mut sum, mut most) = (0f64, 0f32);
        for p in points() {
            let q = steps(p);
            let here = noise(q, 3, 5);
            sum += f64::from(here);
            most = most.max(here.abs());
            let beside = noise([q[0] + 8, q[1], q[2]], 3, 5);
            assert!((here - beside).abs() < 1e-3, "{p:?}");
            let corner = q.map(|q| q & !((1 << 17) - 1));
            assert_eq!(noise(corner, 3, 5), 0.0);
        }
        assert!(
            (sum / 4000.0).abs() < 0.03 && (0.6..=1.1).contains(&most),
            "{sum} {most}"
        );
    }

    #[test]
    fn cubes_of_the_checker_are_an_eighth_of_a_unit() {
        let at = |x: f32| checker(steps([x, 0.01, 0.01]), 0);
        assert_eq!(at(0.001), at(0.124));
        assert_ne!(at(0.124), at(0.126));
        assert_ne!(at(-0.001), at(0.001));
        assert_eq!(at(0.01), at(0.26));
    }
}
