//! Lists seen flat: their triangles in the plane of the texel.
//!
//! In: a texel of a chart, or one inside an octant, and triangles of the same. Out: corners in texels, from them the share
//! of the texel that each triangle covers, whether two triangles are apart ([`apart`](super::sides::apart)), and the
//! regions around the first in which another lies ([`regions`](super::sides::regions)).
//!
//! A chart's corners are exact here, and so are their determinants. Those of the octahedral map are rounded, which leaves
//! some signs in doubt: the answer is then none, and integers are asked. Corners are told by their numbers, so neighbours
//! never are in doubt.

use super::estimate::{self, Frame};
use crate::param::projection::GridTriangle;

/// The corners after corner i, and after that one.
const NEXT: [usize; 4] = [1, 2, 0, 1];

/// Two common corners, bit 3 i + j where i here is j there, that follow each other one way here and the other way there.
const RUN_BACK: [u32; 9] = {
    let mut all = [0; 9];
    let mut i = 0;
    while i < 9 {
        let (here, there) = (i / 3, i % 3);
        all[i] = 1 << (3 * here + NEXT[there]) | 1 << (3 * NEXT[here] + there);
        i += 1;
    }
    all
};

/// A triangle in texels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flat {
    ids: [u32; 3],
    at: [[f64; 2]; 3],
    /// Lowest x and y, highest x and y.
    reach: [f64; 4],
    /// Twice the signed area; not zero.
    area: f64,
    /// A determinant of its corners and a neighbour's that is not larger may have the wrong sign.
    doubt: f64,
}

/// Twice the signed area of a triangle.
#[inline]
fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[inline]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline]
fn most(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl Flat {
    /// A triangle with corners of the given numbers; none where the frame does not hold all
    /// of it, or it may be without a footprint.
    #[inline]
    pub(super) fn new(frame: &Frame, ids: [u32; 3], triangle: &GridTriangle) -> Option<Self> {
        let at = frame.points(triangle)?;
        let [a, b, c] = at;
        let reach = [
            least(least(a[0], b[0]), c[0]),
            least(least(a[1], b[1]), c[1]),
            most(most(a[0], b[0]), c[0]),
            most(most(a[1], b[1]), c[1]),
        ];
        let size = most(reach[2] - reach[0], reach[3] - reach[1]);
        let flat = Flat {
            ids,
            at,
            reach,
            area: area(a, b, c),
            doubt: frame.doubt() * (1.0 + size),
        };
        (flat.area.abs() > flat.doubt).then_some(flat)
    }

    /// The columns and rows that it may reach of the texel cut into `width` x `width` parts, first and last.
    pub(super) fn parts(&self, width: u32) -> [[u32; 2]; 2] {
        // Points of charts are exact; others are moved by far less than this. Borders belong to both sides.
        let slack = if self.doubt > 0.0 { 1e-4 } else { 0.0 };
        let last = f64::from(width - 1);
        let part = |x: f64| (x * f64::from(width)).floor().clamp(0.0, last) as u32;
        [0, 1].map(|k| {
            let (low, high) = (self.reach[k] - slack, self.reach[k + 2] + slack);
            let first = part(low);
            // A triangle that begins on a border touches the part before it, too.
            let touches = f64::from(first) >= low * f64::from(width);
            [first - u32::from(touches && first > 0), part(high)]
        })
    }

    /// The share of the texel that it covers, within [`estimate::CLOSE`].
    #[inline]
    pub(super) fn share(&self) -> f64 {
        estimate::share(&self.at)
    }

    /// Its lowest y and its highest, and what may be rounded.
    #[inline]
    pub(super) fn rows(&self) -> [f64; 2] {
        [self.reach[1] - self.doubt, self.reach[3] + self.doubt]
    }

    /// Whether it is certain that no line meets the inside of both: by their extents, or by a corner or an edge that they
    /// share.
    #[inline]
    pub(super) fn surely_apart(&self, other: &Flat) -> bool {
        let (a, b) = (&self.reach, &other.reach);
        let doubt = most(self.doubt, other.doubt);
        let beside = |k: usize| a[k] > b[k + 2] + doubt || b[k] > a[k + 2] + doubt;
        if beside(0) || beside(1) {
            return true;
        }
        if self.area * other.area < 0.0 {
            return false;
        }
        // Bit 3 i + j: corner i here is corner j there. Without branches, which would go either way.
        let mut common = 0;
        for i in 0..3 {
            for j in 0..3 {
                common |= u32::from(self.ids[i] == other.ids[j]) << (3 * i + j);
            }
        }
        if common == 0 {
            return false;
        }
        if common & (common - 1) != 0 {
            // Along a common edge they run the other way round.
            return RUN_BACK.contains(&common);
        }
        let at = common.trailing_zeros() as usize;
        self.beside_at(at / 3, other, at % 3, doubt)
    }

    /// Whether an edge at the common corner, i here and j there, separates the two.
    fn beside_at(&self, i: usize, other: &Flat, j: usize, doubt: f64) -> bool {
        let v = self.at[i];
        let from = |p: [f64; 2]| [p[0] - v[0], p[1] - v[1]];
        let sense = self.area.signum();
        let (p, q) = (from(self.at[NEXT[i]]), from(self.at[NEXT[i + 1]]));
        let (r, s) = (from(other.at[NEXT[j]]), from(other.at[NEXT[j + 1]]));
        let det = |a: [f64; 2], b: [f64; 2]| sense * (a[0] * b[1] - a[1] * b[0]);
        let (pr, ps, qr, qs) = (det(p, r), det(p, s), det(q, r), det(q, s));
        let below = |x: f64, y: f64| x <= -doubt && y <= -doubt;
        let above = |x: f64, y: f64| x >= doubt && y >= doubt;
        below(pr, ps) || above(qr, qs) || above(pr, qr) || below(ps, qs)
    }

    /// The regions around this triangle in which `other` lies; none where that is in doubt.
    #[inline]
    pub(super) fn regions(&self, other: &Flat) -> Option<u32> {
        // Of all eight combinations of signs, those in which the side of edge 0, 1, 2 is positive.
        const POSITIVE: [u32; 3] = [0b1010_1010, 0b1100_1100, 0b1111_0000];
        let doubt = most(self.doubt, other.doubt);
        let mut passes = 0b0111_1110;
        for edge in 0..3 {
            let (a, b) = (NEXT[edge], NEXT[edge + 1]);
            let mut here = 0;
            for k in 0..3 {
                let id = other.ids[k];
                let own = id == self.ids[a] || id == self.ids[b];
                let side = area(self.at[a], self.at[b], other.at[k]);
                if doubt > 0.0 && !own && side.abs() <= doubt {
                    return None;
                }
                let side = if own { 0.0 } else { side };
                here |= if side > 0.0 { POSITIVE[edge] } else { 0 };
                here |= if side < 0.0 { POSITIVE[edge] ^ 255 } else { 0 };
            }
            passes &= here;
        }
        Some(passes >> 1)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sides::{self, Piece};
    use super::*;
    use crate::param::grid::VERTEX_BITS;
    use crate::param::projection::Line;

    /// Lists of triangles over few vertices near a texel, so that many touch: pairs are judged as in integers.
    #[test]
    fn pairs_are_judged_as_in_integers() {
        let mut state = 7u64;
        let mut random = |n: u32| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as u32 % n
        };
        for line in [Line::Parallel, Line::Sphere] {
            let (mut apart, mut judged, mut not) = (0, 0, 0);
            for round in 0..4_000 {
                let bits = [3, 8, 13, 19][round % 4];
                let (x, y) = (random(1 << bits), random(1 << bits));
                let corners = super::super::weigh::corners(line, bits, x, y);
                let out = if line == Line::Sphere {
                    (1 << (22 - bits)) as f64
                } else {
                    1.0
                };
                let width = (1u32 << (VERTEX_BITS - bits)).max(4) << random(3);
                let most = (1 << (VERTEX_BITS - 1)) - 1;
                let vertices: Vec<[i32; 3]> = (0..7)
                    .map(|_| {
                        std::array::from_fn(|k| {
                            let off = random(2 * width + 1) as i32 - width as i32;
                            ((corners[0][k] * out) as i32 + off).clamp(-most, most)
                        })
                    })
                    .collect();
                let frame = Frame::new(line, bits, x, y);
                let list: Vec<(Flat, Piece)> = (0..8)
                    .filter_map(|_| {
                        let ids = [0; 3].map(|_| random(7));
                        let at = ids.map(|v| vertices[v as usize]);
                        Some((Flat::new(&frame, ids, &at)?, Piece::new(line, ids, at)))
                    })
                    .collect();
                for (a, p) in &list {
                    for (b, q) in &list {
                        let truth = sides::apart(p, q);
                        assert!(truth || !a.surely_apart(b), "{line:?} {a:?} {b:?}");
                        apart += i32::from(a.surely_apart(b));
                        not += i32::from(!truth);
                        if let Some(regions) = a.regions(b) {
                            assert_eq!(regions, sides::regions(p, q), "{line:?} {a:?} {b:?}");
                            judged += 1;
                        }
                    }
                }
            }
            let counts = [apart, judged, not];
            assert!(counts.iter().all(|c| *c > 1_000), "{line:?}: {counts:?}");
        }
    }
}
