//! Touches: which texels of a tile a triangle may own a query point in. Twin of `glsl/common/igt_touches.glsl`.
//!
//! In: a triangle and a tile of one of its boxes. Out: a mask, bit `i` for the tile's `i`-th texel.
//!
//! A texel is missed only where some edge has all of the texel's corners strictly on its far side. An edge's side is an
//! exact integer, linear over the texel grid (charts, planes, the octahedral map inside an octant): it is worked out once
//! at the tile's first corner and then stepped. Which side is the far one depends on the triangle's orientation, which is
//! not asked for: both are tried, so a triangle without area is found wherever it lies.

use super::boxes::{SEVERAL_OCTANTS, TexelBox, cross, face_normals, negatives};
use crate::param::grid::VERTEX_BITS;
use crate::param::projection::{GridTriangle, Line};

/// A triangle prepared for tests against many texels.
pub struct Toucher<'a> {
    line: Line,
    bits: u32,
    triangle: &'a GridTriangle,
    normals: [[i64; 3]; 3],
}

/// Beyond this a side in a chart keeps its sign over a whole tile: a tile has at most 33 columns and rows together, a step
/// is at most 2^24, and 33 * 2^24 < 2^30. Clamped to it a side and its steps fit 32 bits.
const FAR: i64 = 1 << 30;

impl<'a> Toucher<'a> {
    /// Prepares `triangle` for tables of `2^bits` squared texels.
    pub fn new(line: Line, bits: u32, triangle: &'a GridTriangle) -> Self {
        let normals = if line == Line::Sphere {
            face_normals(triangle)
        } else {
            [[0; 3]; 3]
        };
        Toucher {
            line,
            bits,
            triangle,
            normals,
        }
    }

    /// The texels of `tile`, a tile of one of the triangle's boxes, in which the triangle may own a query point.
    pub fn touched(&self, tile: &TexelBox) -> u32 {
        match self.line {
            Line::Parallel => self.touched_squares(tile),
            Line::Cylinder => self.one_by_one(tile),
            Line::Sphere if tile.octant & SEVERAL_OCTANTS == 0 && interior(self.bits, tile) => {
                self.touched_cones(tile)
            }
            Line::Sphere => self.one_by_one(tile),
        }
    }

    /// A side and its steps are counted in units of 2^shift, the width of a texel: the steps are whole numbers of them, and
    /// rounding the side down changes no answer to "is it at least zero".
    fn touched_squares(&self, tile: &TexelBox) -> u32 {
        let shift = VERTEX_BITS - self.bits;
        let low = [tile.column, tile.row].map(|x| ((x << shift) as i32) - (1 << (VERTEX_BITS - 1)));
        let t = self.triangle.map(|v| [v[0] - low[0], v[1] - low[1]]);
        let last = tile.width as i32 - 1;
        let (mut front, mut back) = ([0; 3], [0; 3]);
        let (mut right, mut wrap) = ([0; 3], [0; 3]);
        for i in 0..3 {
            let (a, b) = (t[(i + 1) % 3], t[(i + 2) % 3]);
            let side = a[0] as i64 * b[1] as i64 - a[1] as i64 * b[0] as i64;
            let up = b[0] - a[0];
            right[i] = a[1] - b[1];
            wrap[i] = up - last * right[i];
            front[i] = largest(side >> shift, right[i], up);
            back[i] = largest(-side >> shift, -right[i], -up);
        }
        let (mut mask, mut column) = (0, 0);
        for i in 0..tile.area() {
            let missed = (front[0] | front[1] | front[2]) & (back[0] | back[1] | back[2]);
            mask |= u32::from(missed >= 0) << i;
            let ends = column == last;
            column = if ends { 0 } else { column + 1 };
            for k in 0..3 {
                let step = if ends { wrap[k] } else { right[k] };
                front[k] += step;
                back[k] -= step;
            }
        }
        mask
    }

    /// For a tile inside its octant, of a triangle in no other.
    ///
    /// The corner (u, v) from the middle lines has the direction (u, v, W - u - v), on the folded side (W - v, W - u,
    /// u + v - W), up to signs: linear, so that a side is `su u + sv v + s W`. Within 64 bits: normals are at most 2^47 and
    /// W is at most 2^13, so the first two terms are at most 2^61 each, the third 3 * 2^60, and the steps 2^49.
    fn touched_cones(&self, tile: &TexelBox) -> u32 {
        let negative = negatives(tile.octant);
        let width = 1i64 << self.bits;
        let low = [tile.column, tile.row].map(|x| 2 * x as i64 - width);
        let last = tile.width as i64 - 1;
        let (mut front, mut span) = ([0; 3], [0; 3]);
        let (mut right, mut wrap) = ([0; 3], [0; 3]);
        for i in 0..3 {
            let n = [0, 1, 2].map(|k| flip(negative[k], self.normals[i][k]));
            let (su, sv, s) = if negative[2] {
                (n[2] - n[1], n[2] - n[0], n[0] + n[1] - n[2])
            } else {
                (n[0] - n[2], n[1] - n[2], n[2])
            };
            let (su, sv) = (flip(negative[0], su), flip(negative[1], sv));
            let up = 2 * sv;
            right[i] = 2 * su;
            wrap[i] = up - last * right[i];
            front[i] = su * low[0] + sv * low[1] + s * width + right[i].max(0) + up.max(0);
            // The largest side of the edge turned round is the span less the largest side of the edge.
            span[i] = right[i].abs() + up.abs();
        }
        let (mut mask, mut column) = (0, 0);
        for i in 0..tile.area() {
            let back = [0, 1, 2].map(|k| span[k] - front[k]);
            let missed = (front[0] | front[1] | front[2]) & (back[0] | back[1] | back[2]);
            mask |= u32::from(missed >= 0) << i;
            let ends = column == last;
            column = if ends { 0 } else { column + 1 };
            for k in 0..3 {
                front[k] += if ends { wrap[k] } else { right[k] };
            }
        }
        mask
    }

    /// The texels of a tile, one by one, where sides are not linear: a cylinder's, and an octant's borders.
    fn one_by_one(&self, tile: &TexelBox) -> u32 {
        let touches = |i: &u32| {
            let texel = tile.texel(self.bits, *i);
            let texel = [texel & ((1 << self.bits) - 1), texel >> self.bits];
            match self.line {
                Line::Cylinder => self.touches_wedge(texel),
                _ => self.touches_cone(texel, tile.octant),
            }
        };
        (0..tile.area())
            .filter(touches)
            .fold(0, |mask, i| mask | 1 << i)
    }

    /// One texel of the octahedral map: on an octant's border, or of a triangle in several octants.
    fn touches_cone(&self, texel: [u32; 2], octant: u32) -> bool {
        let (corners, count) = cone_corners(self.bits, texel, octant & 7);
        if count == 0 || !one_side(|i, c| dot(self.normals[i], corners[c]), count) {
            return false;
        }
        if octant & SEVERAL_OCTANTS == 0 {
            return true;
        }
        // Several octants: the box alone does not bound the triangle, so the cone's own faces are tested too.
        let middle = [0, 1, 2].map(|k| corners[..count].iter().map(|c| c[k]).sum::<i32>());
        (0..count).all(|c| {
            let plane = cross(corners[c], corners[(c + 1) % count]);
            let sign = dot(plane, middle).signum();
            self.triangle.iter().any(|v| sign * dot(plane, *v) >= 0)
        })
    }

    /// One texel of a cylinder.
    fn touches_wedge(&self, texel: [u32; 2]) -> bool {
        let t = self.triangle;
        let directions = [
            wedge_direction(self.bits, texel[0]),
            wedge_direction(self.bits, texel[0] + 1),
        ];
        // The wedge is convex: vertices all strictly beyond one of its half-planes (or behind the axis) miss it.
        let beyond = |d: [i64; 2], sign: i64| {
            t.iter()
                .all(|v| sign * (d[0] * v[1] as i64 - d[1] * v[0] as i64) < 0)
        };
        if beyond(directions[0], 1) || beyond(directions[1], -1) {
            return false;
        }
        let shift = VERTEX_BITS - self.bits;
        let bottom = ((texel[1] << shift) as i64) - (1 << (VERTEX_BITS - 1));
        let heights = [bottom, bottom + (1 << shift)];
        one_side(
            |i, c| {
                let (a, b) = (t[(i + 1) % 3], t[(i + 2) % 3]);
                let (d, z) = (directions[c & 1], heights[c >> 1]);
                let turn = |p: [i32; 3]| p[0] as i64 * d[1] - p[1] as i64 * d[0];
                turn(b) * (a[2] as i64 - z) - turn(a) * (b[2] as i64 - z)
            },
            4,
        )
    }
}

/// Whether all texels of a tile lie inside its octant.
fn interior(bits: u32, tile: &TexelBox) -> bool {
    let negative = negatives(tile.octant);
    let half = 1 << (bits - 1);
    let u = away(
        negative[0],
        half,
        tile.column as i32,
        (tile.column + tile.width) as i32 - 1,
    );
    let v = away(
        negative[1],
        half,
        tile.row as i32,
        (tile.row + tile.height) as i32 - 1,
    );
    let inside = if negative[2] {
        u[0] + v[0] >= half
    } else {
        u[1] + v[1] + 2 <= half
    };
    u[0] >= 0 && v[0] >= 0 && inside
}

/// Columns (or rows) a to b from the middle line, the nearest first; negative on the other side of the octant's quadrant.
fn away(negative: bool, half: i32, a: i32, b: i32) -> [i32; 2] {
    if negative {
        [half - 1 - b, half - 1 - a]
    } else {
        [a - half, b - half]
    }
}

/// The largest side among a texel's corners, given the one at its first.
fn largest(side: i64, right: i32, up: i32) -> i32 {
    side.clamp(-FAR, FAR) as i32 + right.max(0) + up.max(0)
}

fn flip(negative: bool, x: i64) -> i64 {
    if negative { -x } else { x }
}

fn dot(a: [i64; 3], b: [i32; 3]) -> i64 {
    a[0] * b[0] as i64 + a[1] * b[1] as i64 + a[2] * b[2] as i64
}

/// Whether no edge has all corners strictly on its far side, for one of the two orientations of the triangle.
fn one_side(side: impl Fn(usize, usize) -> i64, corners: usize) -> bool {
    let (mut front, mut back) = (true, true);
    for i in 0..3 {
        let (mut any_front, mut any_back) = (false, false);
        for c in 0..corners {
            let s = side(i, c);
            any_front |= s >= 0;
            any_back |= s <= 0;
        }
        front &= any_front;
        back &= any_back;
    }
    front || back
}

/// The direction of the border left of a column (integer, L1 length W/4).
fn wedge_direction(bits: u32, column: u32) -> [i64; 2] {
    let quarter = 1i64 << (bits - 2);
    let along = column as i64 & (quarter - 1);
    let (x, y) = (quarter - along, along);
    match column >> (bits - 2) & 3 {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}

/// The corners of a texel's part inside an octant, as directions of L1 length W: four, three on the fold; two or one
/// where it only touches the octant, since a query point on that border may have been assigned to the texel; or none.
fn cone_corners(bits: u32, texel: [u32; 2], octant: u32) -> ([[i32; 3]; 4], usize) {
    let width = 1i32 << bits;
    let negative = negatives(octant);
    let mut corners = [[0; 3]; 4];
    let mut count = 0;
    for step in [[0, 0], [1, 0], [1, 1], [0, 1]] {
        let signed = [0, 1].map(|k| 2 * (texel[k] as i32 + step[k]) - width);
        // Distance from the middle lines, negative on the other side of the octant's quadrant.
        let u = if negative[0] { -signed[0] } else { signed[0] };
        let v = if negative[1] { -signed[1] } else { signed[1] };
        let outside = u < 0
            || v < 0
            || if negative[2] {
                u + v < width
            } else {
                u + v > width
            };
        if outside {
            continue;
        }
        let folded = if negative[2] {
            [width - v, width - u, u + v - width]
        } else {
            [u, v, width - u - v]
        };
        corners[count] = [0, 1, 2].map(|k| if negative[k] { -folded[k] } else { folded[k] });
        count += 1;
    }
    (corners, count)
}

#[cfg(test)]
mod tests;
