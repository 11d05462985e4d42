//! The brute force made fast, without the lookup's code: most triangles are rejected by cells of the query space in plain
//! integers, and the exact question is asked on the lattice of the vertices, where it needs no common divisors.
//!
//! A cell is a square of the plane (parallel lines), or a closed wedge or pyramid of directions, cut from the faces of a
//! cube. It keeps every triangle but those that lie strictly beyond one of its planes: such a triangle has no point in
//! the cell, so no line within the cell meets it. The test `the_index_changes_no_answer` compares both with all.

use super::exact::{cross, dot, minus};
use invertex::igt::Reference;
use invertex::param::grid::{QUERY_BITS, QUERY_SHIFT};
use invertex::param::projection::Line;

/// Cells along each side of a square, a wedge's face or a cube's face.
const SIDE: i64 = 48;
/// Vertices lie on multiples of 2^LATTICE query steps ([`super::cases`]).
const LATTICE: u32 = 11 + QUERY_SHIFT;

/// The triangles of a reference, by cell.
pub(crate) struct Index {
    line: Line,
    pub(crate) cells: Vec<Vec<u32>>,
    all: Vec<u32>,
    triangles: Vec<Closed>,
}

impl Index {
    pub(crate) fn new(line: Line, reference: &Reference) -> Index {
        let count = reference.triangles.len();
        let corners: Vec<[[i32; 3]; 3]> = (0..count).map(|t| reference.corners(t)).collect();
        let keeps = |cell: usize| {
            let planes = planes(line, cell as i64);
            let beyond = |v: &[i32; 3], plane: &[i64; 4]| {
                let side = (0..3)
                    .map(|k| plane[k] * (i64::from(v[k]) << QUERY_SHIFT))
                    .sum::<i64>();
                side + plane[3] < 0
            };
            let keep = |t: &u32| {
                !planes
                    .iter()
                    .any(|p| corners[*t as usize].iter().all(|v| beyond(v, p)))
            };
            (0..count as u32).filter(keep).collect()
        };
        Index {
            line,
            cells: (0..cell_count(line)).map(keeps).collect(),
            all: (0..count as u32).collect(),
            triangles: corners.iter().map(|c| Closed::new(line, c)).collect(),
        }
    }

    /// Every triangle that the line through `q` may meet.
    pub(crate) fn near(&self, q: [i32; 3]) -> &[u32] {
        cell(self.line, q.map(i64::from)).map_or(&self.all, |cell| &self.cells[cell as usize])
    }

    /// Whether the line through `q` meets the closed triangle `t`.
    pub(crate) fn contains(&self, t: u32, q: [i32; 3]) -> bool {
        self.triangles[t as usize].contains(self.line, q.map(i128::from))
    }

    /// Whether it meets any.
    pub(crate) fn covered(&self, q: [i32; 3]) -> bool {
        self.near(q).iter().any(|t| self.contains(*t, q))
    }
}

/// Axes whose faces directions are sorted by: none for parallel lines.
fn faces(line: Line) -> i64 {
    match line {
        Line::Parallel => 0,
        Line::Cylinder => 2,
        Line::Sphere => 3,
    }
}

fn cell_count(line: Line) -> usize {
    (SIDE * SIDE * (2 * faces(line)).max(1)) as usize
}

/// The cell that holds `q`; none on the axis and in the centre, where directions end.
fn cell(line: Line, q: [i64; 3]) -> Option<i64> {
    let row = |x: i64| ((x + (1 << (QUERY_BITS - 1))) * SIDE) >> QUERY_BITS;
    let axes = faces(line);
    let Some(axis) = (0..axes as usize).max_by_key(|k| q[*k].abs()) else {
        return Some(row(q[1]) * SIDE + row(q[0]));
    };
    let w = q[axis].abs();
    if w == 0 {
        return None;
    }
    let along = |k: usize| ((q[k] + w) * SIDE / (2 * w)).min(SIDE - 1);
    let (first, second) = others(line, axis);
    let i = along(first);
    let j = if line == Line::Sphere {
        along(second)
    } else {
        row(q[2])
    };
    let face = 2 * axis as i64 + i64::from(q[axis] < 0);
    Some((face * SIDE + j) * SIDE + i)
}

/// The coordinates that divide a face.
fn others(line: Line, axis: usize) -> (usize, usize) {
    match line {
        Line::Cylinder => (1 - axis, 2),
        _ => ((axis + 1) % 3, (axis + 2) % 3),
    }
}

/// The planes a x + b y + c z + d >= 0 that bound a closed cell, in query steps.
fn planes(line: Line, cell: i64) -> Vec<[i64; 4]> {
    let (i, j) = (cell % SIDE, cell / SIDE % SIDE);
    let mut out = Vec::new();
    // Rows: SIDE (x + half) from 2 half i to 2 half (i + 1).
    let mut between = |k: usize, i: i64| {
        let half = 1i64 << (QUERY_BITS - 1);
        for (sign, border) in [(1, i), (-1, i + 1)] {
            let mut plane = [0, 0, 0, sign * (SIDE - 2 * border) * half];
            plane[k] = sign * SIDE;
            out.push(plane);
        }
    };
    if line == Line::Parallel {
        between(0, i);
        between(1, j);
        return out;
    }
    if line == Line::Cylinder {
        between(2, j);
    }
    let face = cell / (SIDE * SIDE);
    let (axis, sign) = ((face / 2) as usize, 1 - 2 * (face % 2));
    let (first, second) = others(line, axis);
    // Across the face: SIDE x from (2 i - SIDE) w to (2 i + 2 - SIDE) w, with w = |q[axis]|.
    let mut fan = |k: usize, i: i64| {
        for (side, border) in [(1, 2 * i - SIDE), (-1, 2 * i + 2 - SIDE)] {
            let mut plane = [0; 4];
            plane[k] = side * SIDE;
            plane[axis] = -side * border * sign;
            out.push(plane);
        }
    };
    fan(first, i);
    if line == Line::Sphere {
        fan(second, j);
    }
    let mut ahead = [0; 4];
    ahead[axis] = sign;
    out.push(ahead);
    out
}

/// A closed triangle on the lattice: plane normal, and for each edge a normal within the plane that points inward.
struct Closed {
    corners: [[i128; 3]; 3],
    normal: [i128; 3],
    inward: [[i128; 3]; 3],
}

impl Closed {
    fn new(line: Line, corners: &[[i32; 3]; 3]) -> Closed {
        let lattice = corners.map(|v| {
            v.map(|x| {
                let wide = i128::from(x) << QUERY_SHIFT;
                // Bounds that keep all products below within 127 bits.
                assert!(
                    wide % (1 << LATTICE) == 0 && wide >> LATTICE <= 1 << 11,
                    "{v:?} is off the lattice"
                );
                wide >> LATTICE
            })
        });
        // For parallel lines the third coordinate is free.
        let flat = line == Line::Parallel;
        let corners = lattice.map(|v| [v[0], v[1], if flat { 0 } else { v[2] }]);
        let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
        let inward = [0, 1, 2].map(|i| cross(normal, minus(corners[(i + 1) % 3], corners[i])));
        Closed {
            corners,
            normal,
            inward,
        }
    }

    /// The line start + t d meets the plane at t = far / along; that point must be inside of each edge.
    fn contains(&self, line: Line, q: [i128; 3]) -> bool {
        let (start, d) = match line {
            Line::Parallel => ([q[0], q[1], 0], [0, 0, 1]),
            Line::Cylinder => ([0, 0, q[2]], [q[0], q[1], 0]),
            Line::Sphere => ([0, 0, 0], q),
        };
        let corner = |i: usize| self.corners[i].map(|x| x << LATTICE);
        let along = dot(self.normal, d);
        if along == 0 {
            return false;
        }
        let far = dot(self.normal, minus(corner(0), start));
        let behind = far.signum() * along.signum() < 0 || far == 0 && line == Line::Sphere;
        if line != Line::Parallel && behind {
            return false;
        }
        (0..3).all(|i| {
            let inward = self.inward[i];
            let (from, step) = (dot(inward, minus(start, corner(i))), dot(inward, d));
            (from * along + step * far).signum() * along.signum() >= 0
        })
    }
}
