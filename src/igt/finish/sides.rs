//! On which sides of a triangle's edges another one lies, seen along projection lines.
//!
//! In: two triangles on the vertex grid. Out: what is certain, from exact integers: that no line meets both
//! ([`apart`]), and through which regions around the one lines to the other pass ([`regions`]).
//!
//! The side of a point p of an edge (a, b) is `det(a, b)` seen along p's projection line, as in
//! [`Sides`](crate::param::projection::Sides): linear in p in a chart and about a centre, and a quadratic polynomial about an
//! axis, whose values over a triangle lie between its six Bernstein coefficients.

use crate::param::projection::{GridTriangle, Line};

/// Whether no projection line meets the inside of both triangles: an edge of one has its third corner on one side, and
/// nothing of the other triangle. A triangle without a footprint is met by no line and is apart from everything.
pub(super) fn apart(line: Line, a: &GridTriangle, b: &GridTriangle) -> bool {
    let separated = |a: &GridTriangle, b: &GridTriangle| {
        (0..3).any(|i| {
            let (own, other) = (Reach::of(line, a, i, a), Reach::of(line, a, i, b));
            !(own.positive && (own.negative || other.positive) || own.negative && other.negative)
        })
    };
    separated(a, b) || separated(b, a)
}

/// The regions around `a` ([`Sides::region`](crate::param::projection::Sides::region)) that lines to `b` may pass
/// through: bit `r - 1` for region r.
pub(super) fn regions(line: Line, a: &GridTriangle, b: &GridTriangle) -> u32 {
    let reach = [0, 1, 2].map(|i| Reach::of(line, a, i, b));
    let passes = |region: u32| {
        let at = |i: usize| {
            if region >> i & 1 != 0 {
                reach[i].positive
            } else {
                reach[i].negative
            }
        };
        (0..3).all(at)
    };
    (1..=6)
        .filter(|r| passes(*r))
        .fold(0, |mask, r| mask | 1 << (r - 1))
}

/// Whether the side of an edge can be positive, and negative, over a triangle.
#[derive(Clone, Copy, Debug)]
struct Reach {
    positive: bool,
    negative: bool,
}

impl Reach {
    /// Over `b`, of edge `i` of `a` (opposite its corner `i`).
    fn of(line: Line, a: &GridTriangle, i: usize, b: &GridTriangle) -> Self {
        let edge = [a[(i + 1) % 3], a[(i + 2) % 3]];
        let mut reach = Reach {
            positive: false,
            negative: false,
        };
        let mut see = |side: i128| {
            reach.positive |= side > 0;
            reach.negative |= side < 0;
        };
        match line {
            Line::Parallel => b.iter().for_each(|p| {
                let [u, v] = edge.map(|e| [e[0] - p[0], e[1] - p[1]].map(i64::from));
                see(i128::from(u[0] * v[1] - u[1] * v[0]));
            }),
            Line::Sphere => {
                let n = cross(edge[0], edge[1]);
                b.iter().for_each(|p| {
                    see((0..3).map(|k| i128::from(n[k]) * i128::from(p[k])).sum());
                });
            }
            Line::Cylinder => {
                for [j, k] in [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]] {
                    see(bent_side(edge, b[j], b[k]));
                }
            }
        }
        reach
    }
}

fn cross(a: [i32; 3], b: [i32; 3]) -> [i64; 3] {
    let (a, b) = (a.map(i64::from), b.map(i64::from));
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The polar form of the side of an edge about the axis (its diagonal is the side, times two).
fn bent_side(edge: [[i32; 3]; 2], p: [i32; 3], q: [i32; 3]) -> i128 {
    let turn = |e: [i32; 3], p: [i32; 3]| {
        i128::from(i64::from(e[0]) * i64::from(p[1]) - i64::from(e[1]) * i64::from(p[0]))
    };
    let above = |e: [i32; 3], p: [i32; 3]| i128::from(e[2] - p[2]);
    let half = |p: [i32; 3], q: [i32; 3]| {
        turn(edge[1], p) * above(edge[0], q) - turn(edge[0], p) * above(edge[1], q)
    };
    half(p, q) + half(q, p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::param::projection::{Sides, hit};

    /// For pairs of small triangles near one place: whatever is called apart has no line in common.
    #[test]
    fn no_line_meets_triangles_that_are_apart() {
        let mut state = 99u64;
        let mut random = |n: i32| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 33) % n as u64) as i32
        };
        for line in [Line::Parallel, Line::Cylinder, Line::Sphere] {
            let (mut called_apart, mut shared) = (0, 0);
            for _ in 0..4000 {
                let mut triangle =
                    || [0; 3].map(|_| [700 + random(40), 20 + random(40), 500 + random(40)]);
                let (a, b) = (triangle(), triangle());
                let middle = |t: &GridTriangle, w: [i32; 3]| -> [i32; 3] {
                    std::array::from_fn(|k| (0..3).map(|i| t[i][k] * w[i]).sum::<i32>() * 8)
                };
                let weights = [
                    [3, 3, 2],
                    [6, 1, 1],
                    [1, 6, 1],
                    [1, 1, 6],
                    [4, 3, 1],
                    [1, 3, 4],
                ];
                let met = [a, b].iter().any(|t| {
                    weights.iter().any(|w| {
                        let q = middle(t, *w);
                        hit(line, q, &a).is_some() && hit(line, q, &b).is_some()
                    })
                });
                let is_apart = apart(line, &a, &b);
                assert!(!(met && is_apart), "{line:?} {a:?} {b:?}");
                for w in weights {
                    let q = middle(&b, w);
                    let region = Sides::of(line, q, &a).region();
                    if region != 0 && hit(line, q, &b).is_some() {
                        let all = regions(line, &a, &b);
                        assert!(
                            all >> (region - 1) & 1 != 0,
                            "{line:?} {a:?} {b:?} {region}"
                        );
                    }
                }
                called_apart += i32::from(is_apart);
                shared += i32::from(met);
            }
            assert!(
                called_apart > 500 && shared > 500,
                "{line:?}: {called_apart}, {shared}"
            );
        }
    }

    #[test]
    fn neighbours_are_apart_and_a_fold_is_not() {
        for line in [Line::Parallel, Line::Cylinder, Line::Sphere] {
            // A neighbour lies across one edge, in half of the regions or fewer.
            let (p, q) = ([1000, -30, 500], [1000, 40, 500]);
            let (up, down, inside) = ([1000, 0, 560], [1000, 5, 420], [1010, 3, 530]);
            assert!(apart(line, &[p, q, up], &[q, p, down]), "{line:?}");
            assert!(
                regions(line, &[p, q, up], &[q, p, down]).count_ones() <= 3,
                "{line:?}"
            );
            let folded = if line == Line::Parallel {
                [950, 0, 0]
            } else {
                inside
            };
            let face = if line == Line::Parallel {
                [900, 2, 0]
            } else {
                up
            };
            assert!(!apart(line, &[p, q, face], &[q, p, folded]), "{line:?}");
        }
    }
}
