//! From an address of a primary parameterization back to T3: a point on the projection line that has this address; and what
//! the tables answer there.
//!
//! In: (s, t) in the unit square. Out: a point on the vertex grid. Inverse of `texel` in `param/projection.rs`. Of all points
//! of a line the one farthest out is taken, so that outer layers are met before inner ones.

use crate::attribute::surface::SurfacePoint;
use crate::igt::{Asker, Tables, layout};
use crate::param::grid::VERTEX_BITS;
use crate::param::projection::Line;
use crate::render::{Drawn, inverse_at};

/// The largest coordinate of the vertex grid.
const MOST: f64 = ((1u32 << (VERTEX_BITS - 1)) - 1) as f64;

/// A point with the address (s, t). `is_flat`: T3 has two dimensions.
pub(super) fn point(line: Line, is_flat: bool, [s, t]: [f64; 2]) -> [i32; 3] {
    let along = |x: f64| (x * 2.0 - 1.0) * (MOST + 1.0);
    let p = match line {
        Line::Parallel => [along(s), along(t), if is_flat { 0.0 } else { MOST }],
        Line::Cylinder => {
            let [x, y] = outward2(diamond(s));
            [x, y, along(t)]
        }
        Line::Sphere => outward3(octahedral([s, t])),
    };
    p.map(|c| c.round().clamp(-MOST, MOST) as i32)
}

/// What tables answer at an address, with the gradients of steps along both axes.
pub(super) fn asked(
    tables: &Tables,
    st: [f64; 2],
    step: f64,
    asker: Asker,
) -> Option<SurfacePoint> {
    let line = tables.primary.line();
    let is_flat = layout::is_flat(&tables.primary);
    let t3 = [[0.0, 0.0], [step, 0.0], [0.0, step]].map(|by| {
        let [x, y, z] = point(line, is_flat, [st[0] + by[0], st[1] + by[1]]);
        [x, y, z, 0]
    });
    let drawn = Drawn {
        b: [1.0, 0.0, 0.0],
        bx: Some([0.0, 1.0, 0.0]),
        by: Some([0.0, 0.0, 1.0]),
        local: 0,
        vertex: [0; 3],
        asker: asker.word(),
    };
    inverse_at(tables, 0, &t3, &drawn).point
}

/// The direction at `s` of a turn: around the square |x| + |y| = 1.
fn diamond(s: f64) -> [f64; 2] {
    let turn = s.rem_euclid(1.0) * 4.0;
    let f = turn.fract();
    match turn as u32 {
        0 => [1.0 - f, f],
        1 => [-f, 1.0 - f],
        2 => [f - 1.0, -f],
        _ => [f, f - 1.0],
    }
}

/// The direction at (s, t) of the unfolded octahedron |x| + |y| + |z| = 1.
fn octahedral(st: [f64; 2]) -> [f64; 3] {
    let [a, b] = st.map(|c| c.clamp(0.0, 1.0) * 2.0 - 1.0);
    let z = 1.0 - a.abs() - b.abs();
    if z >= 0.0 {
        return [a, b, z];
    }
    [(1.0 - b.abs()).copysign(a), (1.0 - a.abs()).copysign(b), z]
}

fn outward2(d: [f64; 2]) -> [f64; 2] {
    let longest = d[0].abs().max(d[1].abs());
    d.map(|c| c / longest * MOST)
}

fn outward3(d: [f64; 3]) -> [f64; 3] {
    let longest = d.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    d.map(|c| c / longest * MOST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::param::grid::QUERY_SHIFT;

    #[test]
    fn a_point_lies_in_the_texel_whose_middle_it_is_made_from() {
        let bits = 6;
        for line in [Line::Parallel, Line::Cylinder, Line::Sphere] {
            for row in 0..64u32 {
                for column in 0..64u32 {
                    let st = [column, row].map(|c| (f64::from(c) + 0.5) / 64.0);
                    let query = point(line, false, st).map(|c| c << QUERY_SHIFT);
                    assert_eq!(line.texel(bits, query), [column, row], "{line:?}");
                }
            }
        }
    }
}
