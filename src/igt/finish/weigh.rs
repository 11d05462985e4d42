//! How much of a texel a triangle covers: what decides the order of packed lists.
//!
//! In: a texel and a triangle of its list. Out: the covered share of the texel, 0 to 1.
//!
//! The sides of a triangle's edges are worked out at the texel's four corners; between them they are linear in a chart and
//! inside an octant, and nearly so elsewhere, where the share is an estimate. Nothing but the order of lists, and with it
//! the number of tests, depends on it. f64 in a fixed order, on the host: the same bits everywhere.

use crate::param::grid::VERTEX_BITS;
use crate::param::projection::{GridTriangle, Line};

/// The corners of a texel: in a chart points (x, y), on a cylinder (direction, height), on a sphere directions. Exact.
pub(super) type Corners = [[f64; 3]; 4];

/// The sides of a triangle's three edges at the four corners of a texel: of one sign where the corner is inside.
pub(super) type Sides = [[f64; 4]; 3];

/// Sides smaller than this may have the wrong sign. Charts: none, they are exact below 2^53. Others: three products of up to
/// 2^70 each, rounded.
const DOUBT: f64 = (1u64 << 22) as f64;

/// The corners of the texel (x, y) in a table of `2^bits` squared texels.
pub(super) fn corners(line: Line, bits: u32, x: u32, y: u32) -> Corners {
    [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| corner(line, bits, x + i, y + j))
}

fn corner(line: Line, bits: u32, x: u32, y: u32) -> [f64; 3] {
    let linear = |t: u32| f64::from((t << (VERTEX_BITS - bits)) as i32 - (1 << (VERTEX_BITS - 1)));
    match line {
        Line::Parallel => [linear(x), linear(y), 0.0],
        Line::Cylinder => {
            let [dx, dy] = diamond(bits, x);
            [dx, dy, linear(y)]
        }
        Line::Sphere => octahedral(bits, x, y),
    }
}

/// The direction of the border left of a column, of L1 length 2^(bits - 2).
fn diamond(bits: u32, column: u32) -> [f64; 2] {
    let quarter = 1 << (bits - 2);
    let along = f64::from(column & (quarter - 1));
    let rest = f64::from(quarter) - along;
    match column >> (bits - 2) & 3 {
        0 => [rest, along],
        1 => [-along, rest],
        2 => [-rest, -along],
        _ => [along, -rest],
    }
}

/// The direction at a corner of the octahedral map, of L1 length 2^bits.
fn octahedral(bits: u32, x: u32, y: u32) -> [f64; 3] {
    let width = f64::from(1 << bits);
    let (u, v) = (2.0 * f64::from(x) - width, 2.0 * f64::from(y) - width);
    let z = width - u.abs() - v.abs();
    if z >= 0.0 {
        [u, v, z]
    } else {
        [
            (width - v.abs()).copysign(u),
            (width - u.abs()).copysign(v),
            z,
        ]
    }
}

/// The sides of a triangle at the corners of a cylinder's texel.
pub(super) fn bent_sides(corners: &Corners, triangle: &GridTriangle) -> Sides {
    let t = triangle.map(|v| v.map(f64::from));
    std::array::from_fn(|i| {
        let (a, b) = (t[(i + 1) % 3], t[(i + 2) % 3]);
        corners.map(|c| {
            let turn = |p: [f64; 3]| p[0] * c[1] - p[1] * c[0];
            turn(b) * (a[2] - c[2]) - turn(a) * (b[2] - c[2])
        })
    })
}

/// Whether the triangle may own a query point in the texel: `false` is certain.
pub(super) fn touches(line: Line, sides: &Sides) -> bool {
    let doubt = if line == Line::Parallel { 0.0 } else { DOUBT };
    let front = sides.iter().all(|s| s.iter().any(|x| *x >= -doubt));
    let back = sides.iter().all(|s| s.iter().any(|x| *x <= doubt));
    front || back
}

/// The sense of a triangle about an axis, as the sides at a texel have it.
pub(super) fn sense_of(sides: &Sides) -> f64 {
    let total: f64 = sides.iter().flatten().sum();
    if total < 0.0 { -1.0 } else { 1.0 }
}

/// The share of the texel that a triangle of the given sense, 1 or -1, covers.
pub(super) fn coverage(sides: &Sides, sign: f64) -> f64 {
    let mut polygon = Polygon::square();
    for [a, b, c, d] in sides {
        let (at, right, up, far) = (a * sign, b * sign, c * sign, d * sign);
        if at < 0.0 && right < 0.0 && up < 0.0 && far < 0.0 {
            return 0.0;
        }
        if at < 0.0 || right < 0.0 || up < 0.0 || far < 0.0 {
            polygon.clip(at, right - at, up - at);
        }
    }
    polygon.area()
}

/// A convex polygon in the unit square; three cuts leave at most seven corners.
struct Polygon {
    points: [[f64; 2]; 8],
    count: usize,
}

impl Polygon {
    fn square() -> Self {
        let mut points = [[0.0; 2]; 8];
        points[..4].copy_from_slice(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        Polygon { points, count: 4 }
    }

    /// Keeps where `at + right x + up y` is not negative (Sutherland, Hodgman 1974).
    fn clip(&mut self, at: f64, right: f64, up: f64) {
        if self.count == 0 {
            return;
        }
        let side = |p: [f64; 2]| at + right * p[0] + up * p[1];
        let (old, count) = (self.points, self.count);
        self.count = 0;
        let mut p = old[count - 1];
        let mut a = side(p);
        for q in &old[..count] {
            let b = side(*q);
            if (a < 0.0) != (b < 0.0) {
                let t = a / (a - b);
                self.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
            }
            if b >= 0.0 {
                self.push(*q);
            }
            (p, a) = (*q, b);
        }
    }

    fn push(&mut self, p: [f64; 2]) {
        // Rounding could cut a convex polygon oftener than three lines can; what is lost then is a sliver.
        if self.count < self.points.len() {
            self.points[self.count] = p;
            self.count += 1;
        }
    }

    fn area(&self) -> f64 {
        let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
        let corners = &self.points[..self.count];
        let mut twice = 0.0;
        let mut before = corners.last().copied().unwrap_or_default();
        for p in corners {
            twice += cross(before, *p);
            before = *p;
        }
        (0.5f64 * twice).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sides::Piece;
    use super::*;

    #[test]
    fn half_a_texel_is_half_a_texel() {
        let texel = corners(Line::Parallel, 4, 8, 8);
        let width = 1 << (VERTEX_BITS - 4);
        for (triangle, share) in [
            ([[0, 0, 0], [width, 0, 0], [0, width, 0]], 0.5),
            ([[0, 0, 0], [0, width, 0], [width, 0, 0]], 0.5),
            ([[0, 0, 0], [2 * width, 0, 0], [0, 2 * width, 0]], 1.0),
            ([[0, 0, 0], [width / 2, 0, 0], [0, width / 2, 0]], 0.125),
            ([[-9, 0, 0], [-9, width, 0], [-99, 0, 0]], 0.0),
        ] {
            let piece = Piece::new(Line::Parallel, [0, 1, 2], triangle);
            assert!((piece.share(&texel) - share).abs() < 1e-12, "{triangle:?}");
            let sides = piece.at_corners(&texel);
            assert_eq!(touches(Line::Parallel, &sides), share > 0.0);
        }
    }

    /// All three corners in one place: every side is zero, and nothing is covered.
    #[test]
    fn a_point_covers_nothing() {
        for line in [Line::Parallel, Line::Sphere] {
            let piece = Piece::new(line, [0, 1, 2], [[9, 9, 9]; 3]);
            assert_eq!(piece.share(&corners(line, 4, 8, 8)), 0.0);
        }
    }

    #[test]
    fn corners_lie_in_their_texels() {
        for line in [Line::Parallel, Line::Cylinder, Line::Sphere] {
            let bits = 5;
            for texel in 0..1u32 << (2 * bits) {
                let (x, y) = (texel & 31, texel >> bits);
                let c = corners(line, bits, x, y);
                // The middle of the corners belongs to the texel, or, where it lies on an octant's border, next to it.
                let middle: [i32; 3] = std::array::from_fn(|k| {
                    let sum: f64 = c.iter().map(|p| p[k]).sum();
                    let scale = match line {
                        Line::Parallel => 16.0,
                        _ if k == 2 && line == Line::Cylinder => 16.0,
                        _ => 1_048_576.0,
                    };
                    (sum * scale) as i32
                });
                let [i, j] = line.texel(bits, middle);
                assert!(
                    i.abs_diff(x) <= 1 && j.abs_diff(y) <= 1,
                    "{line:?} {x} {y}: {i} {j}"
                );
            }
        }
    }
}
