//! Triangles about an axis, whose edges are bent when they are seen along half-lines from it.
//!
//! In: triangles on the vertex grid. Out: sides of edges ([`bent_side`]), the sense in which a triangle is met ([`away`]), and
//! its quarters, which are less bent. Exact.

use super::sides::cross;
use crate::param::projection::GridTriangle;

/// The sense in which half-lines from the axis meet a triangle, 0 where it is not the same everywhere: its normal's part
/// across the axis times each place's, which is linear in between.
pub(super) fn away([a, b, c]: &GridTriangle) -> i32 {
    let minus = |p: &[i32; 3]| [0, 1, 2].map(|k| p[k] - a[k]);
    let normal = cross(minus(b), minus(c)).map(i128::from);
    let side = |p: &[i32; 3]| normal[0] * i128::from(p[0]) + normal[1] * i128::from(p[1]);
    let signs = [a, b, c].map(|p| side(p).signum() as i32);
    match (signs.contains(&1), signs.contains(&-1)) {
        (true, false) => 1,
        (false, true) => -1,
        _ => 0,
    }
}

/// The polar form of the side of an edge about the axis (its diagonal is the side, times two).
pub(super) fn bent_side(edge: [[i32; 3]; 2], p: [i32; 3], q: [i32; 3]) -> i128 {
    let turn = |e: [i32; 3], p: [i32; 3]| {
        i128::from(i64::from(e[0]) * i64::from(p[1]) - i64::from(e[1]) * i64::from(p[0]))
    };
    let above = |e: [i32; 3], p: [i32; 3]| i128::from(e[2] - p[2]);
    let half = |p: [i32; 3], q: [i32; 3]| {
        turn(edge[1], p) * above(edge[0], q) - turn(edge[0], p) * above(edge[1], q)
    };
    half(p, q) + half(q, p)
}

/// Whether the side of an edge can be positive, and negative, over a triangle: it lies between its six Bernstein coefficients.
pub(super) fn reach(edge: [[i32; 3]; 2], t: &GridTriangle) -> [bool; 2] {
    let mut reach = [false; 2];
    for [j, k] in [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]] {
        let sign = bent_side(edge, t[j], t[k]).signum();
        reach[0] |= sign > 0;
        reach[1] |= sign < 0;
    }
    reach
}

/// Whether a line through a common corner has the one triangle on its one side and the other on its other: one that runs
/// half-way between a side of each, as where both go straight on past the corner their edges bend into each other.
pub(super) fn past_a_corner(a: &GridTriangle, b: &GridTriangle) -> bool {
    let between = |v: &[i32; 3], p: &[i32; 3], q: &[i32; 3]| {
        let edge = [*v, [0, 1, 2].map(|k| p[k] + q[k] - v[k])];
        // Without a side there is no line: the two go on in opposite directions.
        let sides = (reach(edge, a), reach(edge, b));
        p != v
            && q != v
            && matches!(
                sides,
                ([true, false], [false, true]) | ([false, true], [true, false])
            )
    };
    let common = a.iter().filter(|v| b.contains(v));
    common
        .into_iter()
        .any(|v| a.iter().any(|p| b.iter().any(|q| between(v, p, q))))
}

/// A triangle's quarters, on a grid twice as fine: about its corners, and the one in the middle.
pub(super) fn quarters(t: &GridTriangle) -> [GridTriangle; 4] {
    let middle = |i: usize, j: usize| [0, 1, 2].map(|k| t[i][k] + t[j][k]);
    let corner = |i: usize| t[i].map(|x| 2 * x);
    let (ab, bc, ca) = (middle(0, 1), middle(1, 2), middle(2, 0));
    [
        [corner(0), ab, ca],
        [ab, corner(1), bc],
        [ca, bc, corner(2)],
        [ab, bc, ca],
    ]
}
