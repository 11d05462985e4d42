//! Boxes: the texels that a triangle may touch, from its corners alone. Twin of `glsl/common/igt_boxes.glsl`.
//!
//! In: a triangle on the vertex grid. Out: one box, or one for each octant that the triangle reaches into; each box cut
//! into tiles, the unit of work of the build.

use crate::param::grid::QUERY_SHIFT;
use crate::param::projection::{GridTriangle, Line, diamond_column, octahedral_texel, row};

/// Texels that a triangle may touch: `width` columns from `column` on (modulo the table's width) times `height` rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TexelBox {
    /// First column.
    pub column: u32,
    /// First row.
    pub row: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Sphere: the octant (bit k set: coordinate k negative), plus [`SEVERAL_OCTANTS`].
    pub octant: u32,
}

/// Flag of a box whose triangle reaches into several octants.
pub const SEVERAL_OCTANTS: u32 = 8;
/// The most boxes a triangle can have.
pub const MAX_BOXES: usize = 8;
/// The most texels of a tile: the bits of a mask.
pub const TILE: u32 = 32;

impl TexelBox {
    /// The number of texels.
    pub fn area(&self) -> u32 {
        self.width * self.height
    }

    /// Columns and rows of the tiles the box is cut into: at most [`TILE`] texels, all of them where the box is long enough.
    fn tile_size(&self) -> [u32; 2] {
        let (width, height) = (self.width, self.height);
        if width * height <= TILE {
            [width, height]
        } else if height < 4 {
            [TILE / height, height]
        } else if width < 8 {
            [width, TILE / width]
        } else {
            [8, 4]
        }
    }

    /// The number of tiles.
    pub fn tiles(&self) -> u32 {
        let size = self.tile_size();
        self.width.div_ceil(size[0]) * self.height.div_ceil(size[1])
    }

    /// The `i`-th tile: a box of at most [`TILE`] texels. Its columns are not yet taken modulo the table's width.
    pub fn tile(&self, i: u32) -> TexelBox {
        let size = self.tile_size();
        let across = self.width.div_ceil(size[0]);
        let at = [i % across * size[0], i / across * size[1]];
        TexelBox {
            column: self.column + at[0],
            row: self.row + at[1],
            width: size[0].min(self.width - at[0]),
            height: size[1].min(self.height - at[1]),
            octant: self.octant,
        }
    }

    /// The `i`-th texel, row by row: its index in a table of `2^bits` squared texels.
    pub fn texel(&self, bits: u32, i: u32) -> u32 {
        let column = (self.column + i % self.width) & ((1 << bits) - 1);
        (self.row + i / self.width) << bits | column
    }

    fn from_texels(a: [u32; 2], b: [u32; 2], octant: u32) -> Self {
        TexelBox {
            column: a[0],
            row: a[1],
            width: b[0] - a[0] + 1,
            height: b[1] - a[1] + 1,
            octant,
        }
    }
}

/// The boxes of a triangle, in a fixed array and their number.
pub fn boxes(line: Line, bits: u32, t: &GridTriangle) -> ([TexelBox; MAX_BOXES], usize) {
    let mut out = [TexelBox::default(); MAX_BOXES];
    let mut count = 0;
    match line {
        Line::Parallel => {
            out[0] = parallel_box(bits, t);
            count = 1;
        }
        Line::Cylinder => {
            out[0] = cylinder_box(bits, t);
            count = 1;
        }
        Line::Sphere if t.contains(&[0, 0, 0]) => {}
        Line::Sphere => match common_octant(t) {
            Some(octant) => {
                out[0] = octant_box(bits, t, octant, 0);
                count = 1;
            }
            None => {
                for octant in 0..8 {
                    if let Some(one) = clipped_box(bits, t, octant) {
                        out[count] = one;
                        count += 1;
                    }
                }
            }
        },
    }
    (out, count)
}

fn rows(bits: u32, values: [i32; 3]) -> [u32; 2] {
    let low = values[0].min(values[1]).min(values[2]);
    let high = values[0].max(values[1]).max(values[2]);
    [
        row(bits, low << QUERY_SHIFT),
        row(bits, high << QUERY_SHIFT),
    ]
}

fn parallel_box(bits: u32, t: &GridTriangle) -> TexelBox {
    let [x0, x1] = rows(bits, [t[0][0], t[1][0], t[2][0]]);
    let [y0, y1] = rows(bits, [t[0][1], t[1][1], t[2][1]]);
    TexelBox::from_texels([x0, y0], [x1, y1], 0)
}

/// Turn from a to b about the axis (twice the signed area).
fn turn(a: [i32; 3], b: [i32; 3]) -> i64 {
    a[0] as i64 * b[1] as i64 - a[1] as i64 * b[0] as i64
}

fn cylinder_box(bits: u32, t: &GridTriangle) -> TexelBox {
    let [y0, y1] = rows(bits, t.map(|v| v[2]));
    let around = TexelBox {
        column: 0,
        row: y0,
        width: 1 << bits,
        height: y1 - y0 + 1,
        octant: 0,
    };
    let on_axis = t.map(|v| v[0] == 0 && v[1] == 0);
    let turns = [turn(t[0], t[1]), turn(t[1], t[2]), turn(t[2], t[0])];
    if turns.iter().all(|x| *x > 0) || turns.iter().all(|x| *x < 0) {
        return around;
    }
    // The axis is outside: some vertex has all others within half a turn to its left, another to its right.
    let extreme = |sign: i64| {
        (0..3).find(|&i| !on_axis[i] && (0..3).all(|j| on_axis[j] || sign * turn(t[i], t[j]) >= 0))
    };
    let (Some(first), Some(last)) = (extreme(1), extreme(-1)) else {
        return around;
    };
    let column = |i: usize| diamond_column(bits, t[i]);
    // Opposite vertices that are all of one line through the axis leave the side open.
    if turns == [0, 0, 0]
        && column(first) == column(last)
        && t.iter()
            .any(|v| v[0] as i64 * t[first][0] as i64 + v[1] as i64 * (t[first][1] as i64) < 0)
    {
        return around;
    }
    let (a, b) = (column(first), column(last));
    let width = ((b + (1 << bits) - a) & ((1 << bits) - 1)) + 1;
    TexelBox {
        column: a,
        width,
        ..around
    }
}

/// The octant that holds all three vertices, zero counted with either side.
fn common_octant(t: &GridTriangle) -> Option<u32> {
    let mut octant = 0;
    for k in 0..3 {
        if t.iter().all(|v| v[k] >= 0) {
            continue;
        }
        if t.iter().any(|v| v[k] > 0) {
            return None;
        }
        octant |= 1 << k;
    }
    Some(octant)
}

pub(super) fn negatives(octant: u32) -> [bool; 3] {
    [octant & 1 != 0, octant & 2 != 0, octant & 4 != 0]
}

fn octant_box(bits: u32, points: &[[i32; 3]], octant: u32, margin: u32) -> TexelBox {
    let most = (1 << bits) - 1;
    let (mut low, mut high) = ([most; 2], [0; 2]);
    for p in points {
        let texel = octahedral_texel(bits, *p, negatives(octant));
        for k in 0..2 {
            low[k] = low[k].min(texel[k]);
            high[k] = high[k].max(texel[k]);
        }
    }
    let low = low.map(|x: u32| x.saturating_sub(margin));
    let high = high.map(|x| (x + margin).min(most));
    TexelBox::from_texels(low, high, octant)
}

/// The box of the part of a triangle inside an octant: the corners of the clipped polygon are its vertices in the octant, its
/// edges' crossings with the coordinate planes, and the axes inside it. Crossings are rounded, hence a margin of one.
fn clipped_box(bits: u32, t: &GridTriangle, octant: u32) -> Option<TexelBox> {
    let negative = negatives(octant);
    let inside = |p: [i64; 3]| (0..3).all(|k| if negative[k] { p[k] <= 0 } else { p[k] >= 0 });
    let mut points = [[0i32; 3]; 15];
    let mut count = 0;
    let mut keep = |p: [i32; 3]| {
        points[count] = p;
        count += 1;
    };
    for i in 0..3 {
        let (a, b) = (t[i], t[(i + 1) % 3]);
        if inside(a.map(i64::from)) {
            keep(a);
        }
        for k in 0..3 {
            if (a[k] < 0 && b[k] > 0) || (a[k] > 0 && b[k] < 0) {
                let (alpha, beta) = (b[k].unsigned_abs() as i64, a[k].unsigned_abs() as i64);
                let p = [0, 1, 2].map(|c| a[c] as i64 * alpha + b[c] as i64 * beta);
                if p != [0, 0, 0] && inside(p) {
                    keep(shorten(p));
                }
            }
        }
    }
    let n = face_normals(t);
    for k in 0..3 {
        let sign = if negative[k] { -1 } else { 1 };
        let s = [0, 1, 2].map(|i| n[i][k] * sign);
        if s.iter().all(|x| *x >= 0) || s.iter().all(|x| *x <= 0) {
            let mut axis = [0; 3];
            axis[k] = sign as i32;
            keep(axis);
        }
    }
    (count > 0).then(|| octant_box(bits, &points[..count], octant | SEVERAL_OCTANTS, 1))
}

/// A parallel vector that fits the query grid's range.
fn shorten(p: [i64; 3]) -> [i32; 3] {
    let largest = p[0].unsigned_abs() | p[1].unsigned_abs() | p[2].unsigned_abs();
    let shift = (64 - largest.leading_zeros()).saturating_sub(29);
    p.map(|x| {
        let size = (x.unsigned_abs() >> shift) as i32;
        if x < 0 { -size } else { size }
    })
}

pub(super) fn cross(a: [i32; 3], b: [i32; 3]) -> [i64; 3] {
    let (a, b) = (a.map(i64::from), b.map(i64::from));
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The planes through the centre and an edge: `v_j x v_k`.
pub(super) fn face_normals(t: &GridTriangle) -> [[i64; 3]; 3] {
    [cross(t[1], t[2]), cross(t[2], t[0]), cross(t[0], t[1])]
}
