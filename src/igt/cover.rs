//! Which hash texels a triangle touches: conservative, exact, in integers. Twin of `glsl/common/igt_cover.glsl`.
//!
//! In: a triangle on the vertex grid. Out: boxes of texels ([`boxes`]) and, for each texel in them, whether the triangle
//! may own a query point there ([`Toucher::touches`]). A texel is missed only where a plane separates the closed triangle from the
//! closed texel, so every owner of every query point is in the list of that point's texel.
//! Source: Inverse Geometric Textures, section 2.1 ("conservative, even if the triangle slightly touches the texel").

use crate::param::grid::{QUERY_SHIFT, VERTEX_BITS};
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

impl TexelBox {
    /// The number of texels.
    pub fn area(&self) -> u32 {
        self.width * self.height
    }

    /// The `i`-th texel as column and row.
    pub fn texel(&self, bits: u32, i: u32) -> [u32; 2] {
        [
            (self.column + i % self.width) & ((1 << bits) - 1),
            self.row + i / self.width,
        ]
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
    let [x0, x1] = rows(bits, t.map(|v| v[0]));
    let [y0, y1] = rows(bits, t.map(|v| v[1]));
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

fn negatives(octant: u32) -> [bool; 3] {
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

fn cross(a: [i32; 3], b: [i32; 3]) -> [i64; 3] {
    let (a, b) = (a.map(i64::from), b.map(i64::from));
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: [i64; 3], b: [i32; 3]) -> i64 {
    a[0] * b[0] as i64 + a[1] * b[1] as i64 + a[2] * b[2] as i64
}

/// The planes through the centre and an edge: `v_j x v_k`.
fn face_normals(t: &GridTriangle) -> [[i64; 3]; 3] {
    [cross(t[1], t[2]), cross(t[2], t[0]), cross(t[0], t[1])]
}

/// A triangle prepared for tests against many texels.
pub struct Toucher<'a> {
    line: Line,
    bits: u32,
    triangle: &'a GridTriangle,
    normals: [[i64; 3]; 3],
}

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

    /// Whether the triangle may own a query point in `texel`, which lies in one of its boxes (the one of `octant`).
    pub fn touches(&self, texel: [u32; 2], octant: u32) -> bool {
        match self.line {
            Line::Parallel => self.touches_square(texel),
            Line::Cylinder => self.touches_wedge(texel),
            Line::Sphere => self.touches_cone(texel, octant),
        }
    }

    fn touches_square(&self, texel: [u32; 2]) -> bool {
        let t = self.triangle;
        let shift = VERTEX_BITS - self.bits;
        let half = 1 << (VERTEX_BITS - 1);
        let low = texel.map(|x| ((x << shift) as i32) - half);
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]]
            .map(|c: [i32; 2]| [low[0] + (c[0] << shift), low[1] + (c[1] << shift)]);
        one_side(
            |i, c| {
                let (a, b) = (t[(i + 1) % 3], t[(i + 2) % 3]);
                let p = corners[c];
                (a[0] - p[0]) as i64 * (b[1] - p[1]) as i64
                    - (a[1] - p[1]) as i64 * (b[0] - p[0]) as i64
            },
            4,
        )
    }

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
