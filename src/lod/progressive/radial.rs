//! Cells of an overlay along a cylinder's lines, where edges' images are curves.
//!
//! In: two triangles in T3. Out: the corners of what their images share, and a bound of the distance between the two along the
//! lines.
//!
//! On a line, at height z and in direction d, a triangle's plane lies at a radius that is a quotient of linear functions of
//! points of the other's plane; so is the ratio of both radii, along edges too. Such a quotient has no extremum between the
//! corners of a cell, and radii themselves are convex: `max |1 - ratio| * max radius` over the corners is a bound.

use super::overlay::Asked;
use glam::DVec3;
use smallvec::SmallVec;

/// A corner of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// The reference's point, object space.
    pub(super) reference: DVec3,
    /// The simplified triangle's point.
    pub(super) simplified: DVec3,
    /// Radii of both on the line, in T3.
    radii: [f64; 2],
}

/// What two triangles' images share: its corners, in no order.
#[derive(Clone, Debug, Default)]
pub(super) struct Cell {
    pub(super) corners: SmallVec<[Corner; 12]>,
}

impl Cell {
    /// No point of the cell deviates farther, in units of T3.
    pub(super) fn bound(&self) -> f64 {
        let over = |value: fn(&Corner) -> f64| self.corners.iter().map(value).fold(0.0, f64::max);
        let difference = over(|c| (1.0 - c.radii[1] / c.radii[0]).abs());
        let reference = over(|c| c.radii[0]);
        let along_edges = over(|c| c.radii[1]) * over(|c| c.radii[0] / c.radii[1]);
        difference * reference.max(along_edges)
    }
}

/// The cell of the asked triangle and a reference triangle; none where they share nothing.
pub(super) fn cell(asked: &Asked, t3: [DVec3; 3], positions: [DVec3; 3]) -> Option<Cell> {
    let height = |corners: &[DVec3; 3]| {
        let z = corners.map(|p| p.z);
        (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]))
    };
    let (a, b) = (height(&asked.t3), height(&t3));
    if a.0 > b.1 || b.0 > a.1 {
        return None;
    }
    let mut cell = Cell::default();
    let mut add = |p: DVec3| {
        let Some((alpha, beta)) = shares(p, &asked.t3).zip(shares(p, &t3)) else {
            return;
        };
        let radius = |corners: &[DVec3; 3], b: [f64; 3]| blend(corners, b).truncate().length();
        cell.corners.push(Corner {
            reference: blend(&positions, beta),
            simplified: blend(&asked.corners, alpha),
            radii: [radius(&t3, beta), radius(&asked.t3, alpha)],
        });
    };
    t3.iter().chain(&asked.t3).for_each(|&p| add(p));
    for k in 0..3 {
        let (from, to) = (t3[k], t3[(k + 1) % 3]);
        for i in 0..3 {
            let edge = [asked.t3[i], asked.t3[(i + 1) % 3]];
            crossings(from, to, edge).for_each(|s| add(from.lerp(to, s)));
        }
    }
    (!cell.corners.is_empty()).then_some(cell)
}

/// How far outside of a triangle a crossing of its edge may seem to lie, by rounding.
const ROUNDING: f64 = 1e-9;

/// Barycentric coordinates of the point where the line through `p` meets a triangle; none where it does not.
fn shares(p: DVec3, corners: &[DVec3; 3]) -> Option<[f64; 3]> {
    let side = |a: DVec3, b: DVec3| side(p, a, b);
    let [a, b, c] = *corners;
    let values = [side(b, c), side(c, a), side(a, b)];
    let sum: f64 = values.iter().sum();
    let shares = values.map(|v| v / sum);
    let met = shares.iter().all(|&s| s >= -ROUNDING);
    // Ahead on the half-line, not behind the axis.
    (met && blend(corners, shares).truncate().dot(p.truncate()) > 0.0).then_some(shares)
}

/// On which side of the edge from `a` to `b` the line through `p` passes: `det(d, a - p, b - p)`.
fn side(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let turn = |q: DVec3| p.x * q.y - p.y * q.x;
    turn(b) * (a.z - p.z) - turn(a) * (b.z - p.z)
}

/// Where between `from` and `to` the line passes through an edge: roots of a quadratic.
fn crossings(from: DVec3, to: DVec3, [a, b]: [DVec3; 2]) -> impl Iterator<Item = f64> {
    let at = |s: f64| side(from.lerp(to, s), a, b);
    let (start, middle, end) = (at(0.0), at(0.5), at(1.0));
    let c = start;
    let a = 2.0 * (start + end) - 4.0 * middle;
    let b = end - start - a;
    let root = (b * b - 4.0 * a * c).sqrt();
    let q = -0.5 * (b + root.copysign(b));
    [q / a, c / q]
        .into_iter()
        .filter(|s| (0.0..=1.0).contains(s))
}

fn blend(corners: &[DVec3; 3], b: [f64; 3]) -> DVec3 {
    corners[0] * b[0] + corners[1] * b[1] + corners[2] * b[2]
}
