//! The share of a texel that a triangle covers, estimated: close enough to order most lists, in a tenth of the time.
//!
//! In: a texel of a chart, or one inside an octant, and a triangle of the same. Out: the share within [`CLOSE`], so that
//! [`Piece::share`](super::sides::Piece::share) need be asked only where two shares, or a share and a bound, lie closer.
//!
//! By Green's theorem the share is the sum over the triangle's edges of the integral of `x dy`, with x and y kept within
//! the texel: no clipping, no branch that depends on where the edges run.

use super::weigh::{self, Corners};
use crate::param::grid::VERTEX_BITS;
use crate::param::projection::{GridTriangle, Line};

/// An estimate differs from the share by less than this, several times over: the tests measure it.
pub(super) const CLOSE: f64 = 4e-8;
/// An edge whose x changes by less than this within the texel counts as upright.
const UPRIGHT: f64 = 3e-8;
/// A point of the octahedral map is rounded by 2^-51.4 of half its width; a determinant has eight such errors.
const ROUNDING: f64 = 1e-14;

/// How points of T3 lie in one texel.
pub(super) enum Frame {
    /// Column and row of the texel's first corner on the vertex grid, texels a step.
    Chart([f64; 2], f64),
    /// An octant of the octahedral map: the signs of its coordinates, its texels along half a side, column and row of the
    /// texel from the map's middle.
    Octant([f64; 3], f64, [f64; 2]),
    /// A texel of a cylinder, or on the border of octants: no estimate.
    Bent,
}

impl Frame {
    /// The frame of texel (x, y) in a table of `2^bits` squared ones.
    #[inline]
    pub(super) fn new(line: Line, bits: u32, x: u32, y: u32) -> Self {
        match line {
            Line::Parallel => {
                let step = f64::from(1 << bits) / f64::from(1 << VERTEX_BITS);
                let half = f64::from(1 << (VERTEX_BITS - 1));
                let at = |t: u32| f64::from(t) / step - half;
                Frame::Chart([at(x), at(y)], step)
            }
            Line::Cylinder => Frame::Bent,
            Line::Sphere => {
                let half = f64::from(1 << (bits - 1));
                let at = [f64::from(x) - half, f64::from(y) - half];
                octant(&weigh::corners(line, bits, x, y))
                    .map_or(Frame::Bent, |signs| Frame::Octant(signs, half, at))
            }
        }
    }

    /// A triangle's corners in texels from the texel's first corner; none where the frame does not hold all of it.
    #[inline]
    pub(super) fn points(&self, triangle: &GridTriangle) -> Option<[[f64; 2]; 3]> {
        let mut points = [[0.0; 2]; 3];
        match self {
            Frame::Bent => return None,
            Frame::Chart(at, step) => {
                for (v, point) in triangle.iter().zip(&mut points) {
                    point[0] = (f64::from(v[0]) - at[0]) * step;
                    point[1] = (f64::from(v[1]) - at[1]) * step;
                }
            }
            Frame::Octant(signs, half, at) => {
                for (v, point) in triangle.iter().zip(&mut points) {
                    *point = folded(*v, signs, *half, at)?;
                }
            }
        }
        Some(points)
    }

    /// Determinants of points one texel apart that are not larger may have the wrong sign: those of charts are exact.
    pub(super) fn doubt(&self) -> f64 {
        match self {
            Frame::Octant(_, half, _) => half * ROUNDING,
            _ => 0.0,
        }
    }
}

/// The share of the texel that a triangle covers, within [`CLOSE`].
#[inline]
pub(super) fn share(at: &[[f64; 2]; 3]) -> f64 {
    let [a, b, c] = *at;
    (below(a, b) + below(b, c) + below(c, a)).abs()
}

/// The signs of the octant that holds all corners; none on the border of several.
fn octant(corners: &Corners) -> Option<[f64; 3]> {
    let mut signs = [1.0; 3];
    for (k, sign) in signs.iter_mut().enumerate() {
        let negative = corners.iter().any(|c| c[k] < 0.0);
        if negative && corners.iter().any(|c| c[k] > 0.0) {
            return None;
        }
        *sign = if negative { -1.0 } else { 1.0 };
    }
    Some(signs)
}

/// Where a vertex of an octant lies in the octahedral map, in texels; none outside of the octant, and at the centre.
#[inline]
fn folded(v: [i32; 3], signs: &[f64; 3], half: f64, at: &[f64; 2]) -> Option<[f64; 2]> {
    let (a, b, c) = (
        f64::from(v[0]) * signs[0],
        f64::from(v[1]) * signs[1],
        f64::from(v[2]) * signs[2],
    );
    let length = a + b + c;
    if a < 0.0 || b < 0.0 || c < 0.0 || length == 0.0 {
        return None;
    }
    let scale = half / length;
    let (u, v) = if signs[2] < 0.0 {
        (length - b, length - a)
    } else {
        (a, b)
    };
    Some([u * scale * signs[0] - at[0], v * scale * signs[1] - at[1]])
}

#[inline]
fn within(x: f64) -> f64 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}

/// The integral of `x dy` along an edge, x and y kept within 0 and 1.
#[inline]
fn below(p: [f64; 2], q: [f64; 2]) -> f64 {
    let (low, high) = (within(p[1]), within(q[1]));
    let run = q[1] - p[1];
    let slope = (q[0] - p[0]) / if run == 0.0 { 1.0 } else { run };
    let (from, to) = (p[0] + (low - p[1]) * slope, p[0] + (high - p[1]) * slope);
    let (a, b) = (within(from), within(to));
    let beyond = |x: f64| if x > 1.0 { x } else { 1.0 };
    let across = to - from;
    let upright = across.abs() < UPRIGHT;
    let swept = (b - a) * (a + b) * 0.5 + (beyond(to) - beyond(from));
    let mean = if upright {
        (a + b) * 0.5
    } else {
        swept / across
    };
    (high - low) * mean
}

#[cfg(test)]
mod tests {
    use super::super::flat::Flat;
    use super::super::sides::Piece;
    use super::super::weigh::corners;
    use super::*;

    /// Over triangles of all sizes and shapes near a texel, of all octants.
    #[test]
    fn estimates_are_close_to_the_share() {
        let mut state = 4_321u64;
        let mut random = |n: i64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as i64 % n
        };
        for line in [Line::Parallel, Line::Sphere] {
            for bits in [2, 6, 10, 13, 19] {
                let (mut partial, mut worst) = (0, 0f64);
                for _ in 0..20_000 {
                    let [x, y] = [0; 2].map(|_| random(1 << bits) as u32);
                    let corners = corners(line, bits, x, y);
                    let middle: [f64; 3] = std::array::from_fn(|k| {
                        let sum: f64 = corners.iter().map(|c| c[k]).sum();
                        let far = if line == Line::Sphere {
                            f64::from(1 << (VERTEX_BITS - 2 - bits.min(20)))
                        } else {
                            1.0
                        };
                        sum * 0.25 * far
                    });
                    let size =
                        (1i64 << (VERTEX_BITS - bits)) << random(i64::from(bits)) >> random(6);
                    let thin = [1, 1, 1 + random(40)][random(3) as usize];
                    let most = (1 << (VERTEX_BITS - 1)) - 1;
                    let triangle: GridTriangle = [0; 3].map(|_| {
                        std::array::from_fn(|k| {
                            let width = if k == 1 { size / thin } else { size }.max(1);
                            let off = (random(2 * width + 1) - width) as f64;
                            ((middle[k] + off) as i32).clamp(-most, most)
                        })
                    });
                    let frame = Frame::new(line, bits, x, y);
                    // Without a footprint there is nothing to estimate.
                    let Some(flat) = Flat::new(&frame, [0, 1, 2], &triangle) else {
                        continue;
                    };
                    let share = flat.share();
                    let exact = Piece::new(line, [0, 1, 2], triangle).share(&corners);
                    partial += i32::from(exact > 0.0 && exact < 1.0);
                    worst = worst.max((share - exact).abs());
                }
                assert!(worst < CLOSE / 4.0, "{line:?} {bits}: off by {worst:e}");
                assert!(partial > 400, "{line:?} {bits}: {partial} of use");
            }
        }
    }

    #[test]
    fn there_is_no_estimate_across_octants() {
        let frame = Frame::new(Line::Sphere, 4, 9, 9);
        assert!(
            frame
                .points(&[[9, 9, 90], [9, 8, 90], [8, 9, 90]])
                .is_some()
        );
        assert!(
            frame
                .points(&[[9, -1, 90], [9, 8, 90], [8, 9, 90]])
                .is_none()
        );
        assert!(matches!(Frame::new(Line::Sphere, 4, 11, 12), Frame::Bent));
    }
}
