//! Projection lines, exactly: does the line through a query point meet a triangle, and where.
//!
//! In: a query point nu (query grid) and a triangle (vertex grid). Out: hit or not, with barycentric coordinates.
//!
//! Every family of lines is written as the line through nu with direction d(nu):
//!
//! | family | d | hash address (M) |
//! |---|---|---|
//! | parallel (uv charts, planes) | (0, 0, 1) | the first two coordinates |
//! | cylinder | (x, y, 0), a half-line from the axis | diamond angle, height |
//! | sphere | (x, y, z), a half-line from the centre | octahedral map |
//!
//! With w_i = vertex_i - nu the numbers `D_i = det(d, w_j, w_k)` (i, j, k cyclic) have one sign iff the line meets the
//! triangle, and `D / (D_0 + D_1 + D_2)` are the barycentric coordinates (design: "two planes"; Plücker's side products).
//! All of it is integer arithmetic within 96 bits, so the answer is the same on every processor.
//!
//! **Exactly one owner.** Where some `D_i` is zero the query lies on an edge. Then the sign is taken as if the query were
//! moved by an infinitesimal step, the same one for every triangle (`tie`); what holds for generic points (a one-to-one
//! surface has one owner) then holds for all of them: edges, vertices, seams, poles and the axis.

use super::grid::{QUERY_BITS, QUERY_SHIFT};

/// A family of projection lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Line {
    /// Lines along the third coordinate.
    #[default]
    Parallel = 0,
    /// Half-lines from the third axis, perpendicular to it.
    Cylinder = 1,
    /// Half-lines from the origin.
    Sphere = 2,
}

/// Three points of the vertex grid.
pub type GridTriangle = [[i32; 3]; 3];

impl Line {
    /// The direction of the line through `q`. On the axis (or at the centre) it is the first axis: the limit of the
    /// infinitesimal step that decides ties.
    pub fn direction(self, q: [i32; 3]) -> [i32; 3] {
        match self {
            Line::Parallel => [0, 0, 1],
            Line::Cylinder if q[0] == 0 && q[1] == 0 => [1, 0, 0],
            Line::Cylinder => [q[0], q[1], 0],
            Line::Sphere if q == [0, 0, 0] => [1, 0, 0],
            Line::Sphere => q,
        }
    }

    /// The hash texel (column, row) of a query point in a table of `2^bits` squared texels.
    pub fn texel(self, bits: u32, q: [i32; 3]) -> [u32; 2] {
        match self {
            Line::Parallel => [row(bits, q[0]), row(bits, q[1])],
            Line::Cylinder => [diamond_column(bits, self.direction(q)), row(bits, q[2])],
            Line::Sphere => {
                let d = self.direction(q);
                octahedral_texel(bits, d, d.map(|x| x < 0))
            }
        }
    }
}

/// The texel of a linear coordinate of the query grid.
pub fn row(bits: u32, q: i32) -> u32 {
    ((q + (1 << (QUERY_BITS - 1))) as u32) >> (QUERY_BITS - bits)
}

/// floor(2^bits * numerator / denominator), at most 2^bits - 1; for numerator <= denominator < 2^31, without division.
pub fn fraction(bits: u32, numerator: u32, denominator: u32) -> u32 {
    let (mut rest, mut quotient) = (numerator, 0);
    for _ in 0..bits {
        rest <<= 1;
        quotient <<= 1;
        if rest >= denominator {
            rest -= denominator;
            quotient |= 1;
        }
    }
    quotient
}

/// The quadrant (0..4, counter-clockwise from +x) of a direction: half-open, so that each has exactly one.
pub fn quadrant(d: [i32; 3]) -> u32 {
    match (d[0], d[1]) {
        (x, y) if x > 0 && y >= 0 => 0,
        (x, y) if x <= 0 && y > 0 => 1,
        (x, y) if x < 0 && y <= 0 => 2,
        _ => 3,
    }
}

/// The column of a direction about the axis: quadrants are cut at integer directions, so that no trigonometry is needed.
pub fn diamond_column(bits: u32, d: [i32; 3]) -> u32 {
    let (x, y) = (d[0].unsigned_abs(), d[1].unsigned_abs());
    let quadrant = quadrant(d);
    let along = if quadrant & 1 == 0 { y } else { x };
    (quadrant << (bits - 2)) + fraction(bits - 2, along, x + y)
}

/// The texel of a direction in the octahedral map, seen as a point of the octant with the given `negative` signs (a point
/// on an octant's border belongs to several; queries use their own signs, with zero counted as positive).
pub fn octahedral_texel(bits: u32, d: [i32; 3], negative: [bool; 3]) -> [u32; 2] {
    let a = d.map(i32::unsigned_abs);
    let length = a[0] + a[1] + a[2];
    // Distance from the map's middle line, in units of `length`; the lower half is folded outwards.
    let u = if negative[2] { length - a[1] } else { a[0] };
    let v = if negative[2] { length - a[0] } else { a[1] };
    [
        half(bits, u, length, negative[0]),
        half(bits, v, length, negative[1]),
    ]
}

fn half(bits: u32, u: u32, length: u32, negative: bool) -> u32 {
    // floor of W/2 (length +- u) / length, at most W - 1. The shader finds it digit by digit. Here numerator and denominator
    // (below 2^45 and 2^32) are exact in an f64, and so is the floor: a quotient below 2^14 that is less than a whole number
    // is so by 2^-32 at least, far more than rounding adds.
    let most = (1 << bits) - 1;
    if length == 0 {
        return most;
    }
    let numerator = (if negative { length - u } else { length + u }) as u64;
    ((((numerator << bits) as f64) * 0.5 / length as f64) as u32).min(most)
}

/// Where a line meets a triangle: the three side products, all of one sign (or zero where an edge is touched).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hit {
    /// `D_i`: proportional to the barycentric coordinates.
    pub sides: [i128; 3],
    /// 1 or -1: their sign, the sense in which the line meets the triangle.
    pub sense: i32,
}

/// On which sides of a triangle's edges a query lies, ties broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sides {
    /// `D_i`.
    pub values: [i128; 3],
    /// Their signs after the infinitesimal step; 0 for an edge that no step can separate.
    pub signs: [i32; 3],
}

impl Sides {
    /// The sides of a query point.
    pub fn of(line: Line, q: [i32; 3], triangle: &GridTriangle) -> Self {
        let d = line.direction(q);
        let w = triangle.map(|v| offset(v, q));
        let others = [[1, 2], [2, 0], [0, 1]];
        let values = others.map(|[j, k]| side(line, d, w[j], w[k]));
        let signs = [0, 1, 2].map(|i| match values[i].signum() as i32 {
            0 => tie(line, d, q, triangle[others[i][0]], triangle[others[i][1]]),
            s => s,
        });
        Sides { values, signs }
    }

    /// Which of the six regions around the triangle the line passes through, 1 to 6: bit `i` where side `i` is positive. 0
    /// where all signs are equal, or one is missing.
    pub fn region(&self) -> u32 {
        let bit = |i: usize| u32::from(self.signs[i] > 0) << i;
        match bit(0) | bit(1) | bit(2) {
            7 => 0,
            _ if self.signs.contains(&0) => 0,
            region => region,
        }
    }

    /// The hit, if all signs are equal and it lies on the half-line.
    pub fn hit(&self, line: Line, q: [i32; 3], triangle: &GridTriangle) -> Option<Hit> {
        let [sign, b, c] = self.signs;
        if sign == 0 || b != sign || c != sign {
            return None;
        }
        facing(line, q, triangle, sign).then_some(Hit {
            sides: self.values,
            sense: sign,
        })
    }
}

/// Whether the projection line through `q` meets `triangle`, with ties broken so that a one-to-one surface has exactly
/// one owner for every query point.
pub fn hit(line: Line, q: [i32; 3], triangle: &GridTriangle) -> Option<Hit> {
    Sides::of(line, q, triangle).hit(line, q, triangle)
}

/// vertex - query, on the query grid: below 2^30 in size.
pub fn offset(v: [i32; 3], q: [i32; 3]) -> [i32; 3] {
    [0, 1, 2].map(|k| (v[k] << QUERY_SHIFT) - q[k])
}

/// `det(d, a, b)`.
fn side(line: Line, d: [i32; 3], a: [i32; 3], b: [i32; 3]) -> i128 {
    let cross = |x: usize, y: usize| a[x] as i64 * b[y] as i64 - a[y] as i64 * b[x] as i64;
    match line {
        Line::Parallel => cross(0, 1) as i128,
        _ => {
            d[0] as i128 * cross(1, 2) as i128
                + d[1] as i128 * cross(2, 0) as i128
                + d[2] as i128 * cross(0, 1) as i128
        }
    }
}

/// The sign of `D` for the edge (a, b) after the infinitesimal step, where `D` itself is zero; 0 for edges that no step
/// can separate (degenerate in the projection).
///
/// The steps: parallel x + e, y + e^2; sphere d + (e, e^2, e^3); cylinder height + e, d + (e^2, e^4). The signs below are
/// those of the coefficients of rising powers of e.
fn tie(line: Line, d: [i32; 3], q: [i32; 3], a: [i32; 3], b: [i32; 3]) -> i32 {
    let wide = |p: [i32; 3]| p.map(|x| x as i64);
    let (a, b) = (wide(a), wide(b));
    let first = |terms: &[i64]| {
        terms
            .iter()
            .find(|t| **t != 0)
            .map_or(0, |t| t.signum() as i32)
    };
    match line {
        Line::Parallel => first(&[a[1] - b[1], b[0] - a[0]]),
        Line::Sphere => first(&[
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]),
        Line::Cylinder => {
            let (dx, dy) = (d[0] as i64, d[1] as i64);
            let turn = |p: [i64; 3]| p[0] * dy - p[1] * dx;
            let above = |p: [i64; 3]| (p[2] << QUERY_SHIFT) - q[2] as i64;
            let (above_a, above_b) = (above(a), above(b));
            first(&[
                turn(a) - turn(b),
                a[1] * above_b - b[1] * above_a,
                b[1] - a[1],
                b[0] * above_a - a[0] * above_b,
                a[0] - b[0],
            ])
        }
    }
}

/// Whether a triangle whose sides all have `sign` lies on the half-line (always, for parallel lines).
///
/// For W = the vertices seen from the line's start, sum(D_i W_i) = det(W) d: the hit lies ahead iff det(W) has D's sign.
fn facing(line: Line, q: [i32; 3], triangle: &GridTriangle, sign: i32) -> bool {
    let start = match line {
        Line::Parallel => return true,
        Line::Cylinder => [0, 0, q[2]],
        Line::Sphere => [0, 0, 0],
    };
    let w = triangle.map(|v| offset(v, start));
    let volume = side(Line::Sphere, w[0], w[1], w[2]);
    if volume != 0 {
        return volume.signum() as i32 == sign;
    }
    // The triangle's plane passes through the line's start: the step in height decides, if anything does.
    let [a, b, c] = triangle.map(|p| p.map(|x| x as i64));
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    line == Line::Cylinder && area != 0 && -area.signum() as i32 == sign
}

/// The sense in which projection lines meet `triangle`: that of [`Hit::sense`] (for the cylinder: at the height of the
/// centroid); 0 for a triangle that they run along.
pub fn orientation(line: Line, triangle: &GridTriangle) -> i32 {
    let [a, b, c] = triangle.map(|p| p.map(i128::from));
    let across = |a: [i128; 3], b: [i128; 3]| a[0] * b[1] - a[1] * b[0];
    let value = match line {
        Line::Parallel => {
            let from = |p: [i128; 3]| [p[0] - a[0], p[1] - a[1], 0];
            across(from(b), from(c))
        }
        Line::Cylinder => {
            // Heights over the centroid's, times three.
            let sum = a[2] + b[2] + c[2];
            let over = |p: [i128; 3]| 3 * p[2] - sum;
            over(a) * across(b, c) + over(b) * across(c, a) + over(c) * across(a, b)
        }
        Line::Sphere => a[2] * across(b, c) + b[2] * across(c, a) + c[2] * across(a, b),
    };
    value.signum() as i32
}

/// The sine of the angle under which lines graze a triangle: beyond it a deviation is at most five times as long when
/// measured along the line.
const GRAZING: f64 = 0.2;

/// Whether projection lines run along `triangle`, all but: seen at its centroid, at less than a fifth (sine).
pub fn is_grazed(line: Line, triangle: &GridTriangle) -> bool {
    let [a, b, c] = triangle.map(|p| glam::DVec3::from(p.map(f64::from)));
    let (normal, middle) = ((b - a).cross(c - a), (a + b + c) / 3.0);
    let direction = match line {
        Line::Parallel => glam::DVec3::Z,
        Line::Cylinder => middle.with_z(0.0),
        Line::Sphere => middle,
    };
    normal.dot(direction).abs() < GRAZING * normal.length() * direction.length()
}

impl Hit {
    /// The barycentric coordinates, each within 2^-21 of the exact value: the side products are brought to 22 bits, so
    /// that every step but the last division is exact.
    pub fn barycentric(&self) -> [f32; 3] {
        let size = self.sides.map(i128::unsigned_abs);
        let largest = size[0].max(size[1]).max(size[2]);
        if largest == 0 {
            // Seen edge-on: the whole intersection has one address, and any point of it is the answer.
            return [1.0 / 3.0; 3];
        }
        let shift = (128 - largest.leading_zeros()).saturating_sub(22);
        let n = size.map(|s| (s >> shift) as u32);
        let sum = (n[0] + n[1] + n[2]) as f32;
        n.map(|x| x as f32 / sum)
    }
}

/// The point of a triangle nearest to the origin (the query), given the vertices' offsets from it, as barycentric
/// coordinates and squared distance. Source: Ericson, Real-Time Collision Detection, section 5.1.5 (Voronoi regions).
///
/// f32 in a fixed order: both processors give the same bits.
pub fn nearest(w: [[f32; 3]; 3]) -> ([f32; 3], f32) {
    let b = nearest_barycentric(w);
    (b, squared_length(combine(b, w)))
}

/// `sum(b_i w_i)` in a fixed order.
pub fn combine(b: [f32; 3], w: [[f32; 3]; 3]) -> [f32; 3] {
    [0, 1, 2].map(|k| b[0] * w[0][k] + b[1] * w[1][k] + b[2] * w[2][k])
}

/// Squared length in a fixed order.
pub fn squared_length(p: [f32; 3]) -> f32 {
    dot(p, p)
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn nearest_barycentric(w: [[f32; 3]; 3]) -> [f32; 3] {
    let minus = |a: [f32; 3], b: [f32; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let ratio = |a: f32, b: f32| if b == 0.0 { 0.0 } else { a / b };
    let (ab, ac) = (minus(w[1], w[0]), minus(w[2], w[0]));
    let (d1, d2) = (-dot(ab, w[0]), -dot(ac, w[0]));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (d3, d4) = (-dot(ab, w[1]), -dot(ac, w[1]));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = ratio(d1, d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let (d5, d6) = (-dot(ab, w[2]), -dot(ac, w[2]));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let v = ratio(d2, d2 - d6);
        return [1.0 - v, 0.0, v];
    }
    let va = d3 * d6 - d5 * d4;
    let (e1, e2) = (d4 - d3, d5 - d6);
    if va <= 0.0 && e1 >= 0.0 && e2 >= 0.0 {
        let v = ratio(e1, e1 + e2);
        return [0.0, 1.0 - v, v];
    }
    let sum = va + vb + vc;
    let (v, t) = (ratio(vb, sum), ratio(vc, sum));
    [1.0 - v - t, v, t]
}

#[cfg(test)]
mod tests;
