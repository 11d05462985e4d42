//! On which sides of a triangle's edges points and other triangles lie, seen along projection lines.
//!
//! In: triangles on the vertex grid. Out: what is certain: that no line meets two of them ([`apart`]), and through which
//! regions around the one lines to the other pass ([`regions`]); the sides of a texel's corners ([`Piece::at_corners`]).
//!
//! The side of a point p of an edge (a, b) is `det(a, b)` seen along p's projection line, as in
//! [`Sides`](crate::param::projection::Sides): linear in p in a chart and about a centre, and a quadratic polynomial about an
//! axis, whose values over a triangle lie between its six Bernstein coefficients. In a chart it is exact in f64; about a
//! centre its sign is, but near zero, where it is worked out anew in integers.

use super::bent::{self, away, bent_side, past_a_corner, quarters};
use super::weigh::{self, Corners, Sides};
use crate::param::projection::{GridTriangle, Line};

/// About a centre a side of a vertex, three products of up to 2^71, is off by less than this.
const DOUBT: f64 = (1u64 << 22) as f64;

/// The corners after corner i, and after that one.
const NEXT: [usize; 4] = [1, 2, 0, 1];

/// A triangle prepared for tests.
#[derive(Default)]
pub(super) struct Piece {
    line: Line,
    vertices: [u32; 3],
    at: GridTriangle,
    /// Chart: the coefficients of x, y and 1; sphere: of x, y, z; of the side of the edge opposite each corner.
    edges: [[f64; 3]; 3],
    /// The sign of each corner's side of the edge opposite it, 0 without a footprint; about an axis the sense in which
    /// half-lines meet it everywhere, 0 where they meet it in both.
    sense: i32,
}

impl Piece {
    /// `vertices`: numbers that tell corners of neighbours as the same.
    pub(super) fn new(line: Line, vertices: [u32; 3], at: GridTriangle) -> Self {
        let p = at.map(|v| [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])]);
        let mut edges = [[0.0; 3]; 3];
        for (i, edge) in edges.iter_mut().enumerate() {
            let (a, b) = (p[NEXT[i]], p[NEXT[i + 1]]);
            *edge = match line {
                Line::Parallel => [a[1] - b[1], b[0] - a[0], a[0] * b[1] - a[1] * b[0]],
                Line::Cylinder => [0.0; 3],
                Line::Sphere => [
                    a[1] * b[2] - a[2] * b[1],
                    a[2] * b[0] - a[0] * b[2],
                    a[0] * b[1] - a[1] * b[0],
                ],
            };
        }
        let mut piece = Piece {
            line,
            vertices,
            at,
            edges,
            sense: 0,
        };
        piece.sense = match line {
            Line::Cylinder => away(&at),
            _ => piece.sign(0, 0, &piece),
        };
        piece
    }

    /// The share of a texel that it covers.
    ///
    /// About a centre its sense is not that of the sides at the corners: lines that graze a triangle may meet its plane from
    /// the other side beyond it.
    pub(super) fn share(&self, corners: &Corners) -> f64 {
        let sides = self.at_corners(corners);
        match self.sense {
            _ if self.line == Line::Cylinder => weigh::coverage(&sides, weigh::sense_of(&sides)),
            0 => 0.0,
            sense => weigh::coverage(&sides, f64::from(sense)),
        }
    }

    /// The sides of the three edges at the corners of a texel.
    pub(super) fn at_corners(&self, corners: &Corners) -> Sides {
        if self.line == Line::Cylinder {
            return weigh::bent_sides(corners, &self.at);
        }
        // A chart's corners have 0 for a third coordinate: its edges' constant is taken once.
        let flat = self.line == Line::Parallel;
        let mut sides = [[0.0; 4]; 3];
        for (n, out) in self.edges.iter().zip(&mut sides) {
            for (c, side) in corners.iter().zip(out) {
                let third = if flat { 1.0 } else { c[2] };
                *side = n[0] * c[0] + n[1] * c[1] + n[2] * third;
            }
        }
        sides
    }

    /// The sign of the side of edge `i` on which corner `k` of `other` lies. Not about an axis.
    #[inline]
    fn sign(&self, i: usize, k: usize, other: &Piece) -> i32 {
        let (vertex, p) = (other.vertices[k], other.at[k]);
        let edge = [NEXT[i], NEXT[i + 1]];
        if vertex == self.vertices[edge[0]] || vertex == self.vertices[edge[1]] {
            return 0;
        }
        let n = self.edges[i];
        let flat = self.line == Line::Parallel;
        let third = if flat { 1.0 } else { f64::from(p[2]) };
        let side = n[0] * f64::from(p[0]) + n[1] * f64::from(p[1]) + n[2] * third;
        if flat || side.abs() > DOUBT {
            return i32::from(side > 0.0) - i32::from(side < 0.0);
        }
        self.exact_sign(edge, p)
    }

    #[cold]
    fn exact_sign(&self, edge: [usize; 2], p: [i32; 3]) -> i32 {
        let normal = cross(self.at[edge[0]], self.at[edge[1]]);
        let exact = (0..3).map(|k| i128::from(normal[k]) * i128::from(p[k]));
        exact.sum::<i128>().signum() as i32
    }

    /// Whether the two lie on either side of an edge that both have: it runs the other way in a triangle of the same sense.
    #[inline]
    fn adjoins(&self, other: &Piece) -> bool {
        let (a, b) = (self.vertices, other.vertices);
        let has = |from: u32, to: u32| {
            b[0] == from && b[1] == to || b[1] == from && b[2] == to || b[2] == from && b[0] == to
        };
        self.sense == other.sense && (has(a[1], a[0]) || has(a[2], a[1]) || has(a[0], a[2]))
    }

    /// Whether the side of edge `i` can be positive, and negative, over `other`.
    fn reach(&self, i: usize, other: &Piece) -> [bool; 2] {
        if self.line == Line::Cylinder {
            return bent::reach([self.at[NEXT[i]], self.at[NEXT[i + 1]]], &other.at);
        }
        let signs = [0, 1, 2].map(|k| self.sign(i, k, other));
        [signs.iter().any(|s| *s > 0), signs.iter().any(|s| *s < 0)]
    }

    /// Whether edge `i` has all of this triangle on one side and nothing of `other`.
    fn separated_by(&self, i: usize, other: &Piece) -> bool {
        if self.line != Line::Cylinder {
            return (0..3).all(|k| self.sign(i, k, other) != self.sense);
        }
        // Of a triangle that is met in one sense everywhere all lies where the corner does.
        let corner = bent_side(
            [self.at[NEXT[i]], self.at[NEXT[i + 1]]],
            self.at[i],
            self.at[i],
        );
        let own = match corner.signum() {
            sign if self.sense != 0 && sign != 0 => [sign > 0, sign < 0],
            _ => self.reach(i, self),
        };
        let others = self.reach(i, other);
        match own {
            [true, true] => false,
            [true, false] => !others[0],
            [false, true] => !others[1],
            [false, false] => true,
        }
    }
}

/// Whether no projection line meets the inside of both triangles: an edge of one has its third corner on one side, and
/// nothing of the other triangle. A triangle without a footprint is met by no line and is apart from everything.
pub(super) fn apart(a: &Piece, b: &Piece) -> bool {
    let flat = a.line != Line::Cylinder;
    if flat && (a.sense == 0 || b.sense == 0) || a.sense != 0 && a.adjoins(b) {
        return true;
    }
    by_an_edge(a, b) || a.line == Line::Sphere && opposite(a, b)
}

fn by_an_edge(a: &Piece, b: &Piece) -> bool {
    (0..3).any(|i| a.separated_by(i, b)) || (0..3).any(|i| b.separated_by(i, a))
}

/// Whether two triangles about an axis are apart by a line past a common corner, or all their quarters are, so many `times`:
/// quarters are less bent. An edge goes on as a curve beyond its corners, and may pass through a triangle that the other does
/// not meet.
pub(super) fn apart_in_parts(a: &Piece, b: &Piece, times: u32) -> bool {
    if a.line != Line::Cylinder {
        return false;
    }
    if past_a_corner(&a.at, &b.at) {
        return true;
    }
    let pieces =
        |of: &Piece| quarters(&of.at).map(|at| Piece::new(Line::Cylinder, of.vertices, at));
    times > 0 && {
        let (parts, others) = (pieces(a), pieces(b));
        parts.iter().all(|p| {
            let apart = |q: &Piece| by_an_edge(p, q) || apart_in_parts(p, q, times - 1);
            others.iter().all(apart)
        })
    }
}

/// About a centre: whether a plane through a corner of each has the one triangle on its one side and the other on its other.
///
/// Edges tell any two triangles apart that half a sphere holds, as they do in the plane. Two on opposite sides may look like
/// a star of David through the centre, where only such planes lie between them; the lists of texels about the six axes
/// hold such pairs, as a triangle round an axis counts for the axis' other end too.
#[cold]
fn opposite(a: &Piece, b: &Piece) -> bool {
    let side = |n: [i64; 3], p: [i32; 3]| -> i128 {
        (0..3).map(|k| i128::from(n[k]) * i128::from(p[k])).sum()
    };
    let between = |n: [i64; 3]| {
        let of = |piece: &Piece| piece.at.map(|p| side(n, p).signum() as i32);
        let (own, others) = (of(a), of(b));
        let parts = |sense: i32| {
            own.iter().all(|s| s * sense >= 0) && others.iter().all(|s| s * sense <= 0)
        };
        n != [0; 3] && (parts(1) || parts(-1))
    };
    a.at.iter()
        .any(|p| b.at.iter().any(|q| between(cross(*p, *q))))
}

/// The regions around `a` ([`Sides::region`](crate::param::projection::Sides::region)) that lines to `b` may pass
/// through: bit `r - 1` for region r.
pub(super) fn regions(a: &Piece, b: &Piece) -> u32 {
    let reach = [0, 1, 2].map(|i| a.reach(i, b));
    let passes = |region: u32| (0..3).all(|i| reach[i][usize::from(region >> i & 1 == 0)]);
    (1..=6)
        .filter(|r| passes(*r))
        .fold(0, |mask, r| mask | 1 << (r - 1))
}

pub(super) fn cross(a: [i32; 3], b: [i32; 3]) -> [i64; 3] {
    let (a, b) = (a.map(i64::from), b.map(i64::from));
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::param::projection::{Sides, hit};

    /// A piece whose corners are told from those of others.
    fn piece(line: Line, first: u32, at: GridTriangle) -> Piece {
        Piece::new(line, [first, first + 1, first + 2], at)
    }

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
                let (p, r) = (piece(line, 0, a), piece(line, 3, b));
                let is_apart = apart(&p, &r);
                assert!(!(met && is_apart), "{line:?} {a:?} {b:?}");
                for w in weights {
                    let q = middle(&b, w);
                    let region = Sides::of(line, q, &a).region();
                    if region != 0 && hit(line, q, &b).is_some() {
                        let all = regions(&p, &r);
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

    /// No half-line from the centre meets two triangles on opposite sides of it, star of David or not.
    #[test]
    fn triangles_on_opposite_sides_are_apart() {
        let mut state = 5u64;
        let mut random = |n: i32| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 33) % n as u64) as i32
        };
        let mut stars = 0;
        for _ in 0..2000 {
            let mut triangle =
                || [0; 3].map(|_| [700, 20, 500].map(|middle: i32| middle + random(400) - 200));
            let (a, b) = (triangle(), triangle());
            let here = apart(&piece(Line::Sphere, 0, a), &piece(Line::Sphere, 3, b));
            let there = piece(Line::Sphere, 3, b.map(|v| v.map(|x| -x)));
            let own = piece(Line::Sphere, 0, a);
            assert!(apart(&own, &there), "{a:?} {b:?}");
            let by_edges = (0..3).any(|i| own.separated_by(i, &there))
                || (0..3).any(|i| there.separated_by(i, &own));
            stars += i32::from(!by_edges && own.sense != 0 && there.sense != 0);
            // Negative control: on the same side those that meet are not.
            let middle = [0, 1, 2].map(|k| (a[0][k] + a[1][k] + a[2][k]) * 21);
            let met =
                hit(Line::Sphere, middle, &a).is_some() && hit(Line::Sphere, middle, &b).is_some();
            assert!(!(met && here), "{a:?} {b:?}");
        }
        assert!(stars > 20, "{stars} that edges do not tell apart");
    }

    #[test]
    fn neighbours_are_apart_and_a_fold_is_not() {
        for line in [Line::Parallel, Line::Cylinder, Line::Sphere] {
            // A neighbour lies across one edge, in half of the regions or fewer.
            let (p, q) = ([1000, -30, 500], [1000, 40, 500]);
            let (up, down, inside) = ([1000, 0, 560], [1000, 5, 420], [1010, 3, 530]);
            assert!(
                apart(&piece(line, 0, [p, q, up]), &piece(line, 3, [q, p, down])),
                "{line:?}"
            );
            assert!(
                regions(&piece(line, 0, [p, q, up]), &piece(line, 3, [q, p, down])).count_ones()
                    <= 3,
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
            assert!(
                !apart(
                    &piece(line, 0, [p, q, face]),
                    &piece(line, 3, [q, p, folded])
                ),
                "{line:?}"
            );
        }
    }
}
