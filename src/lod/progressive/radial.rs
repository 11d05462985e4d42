//! Cells of an overlay along a cylinder's lines, where edges' images are curves.
//!
//! In: two triangles, in T3 and in space. Out: how far they lie apart at the corners of what their images share, and how much
//! more there may be between these.
//!
//! Over a cell let p be the reference's point in T3, height z, and w the ratio of the simplified triangle's radius on the same line
//! to p's. The simplified triangle n . q = d is met at q = (w p.x, w p.y, p.z), so
//!
//! ```text
//! w = (d - n.z p.z) / (n.x p.x + n.y p.y)
//! deviation = P(p) - S(q)     P, S: T3 to space, affine
//!           = F(p) + e(p)     F: affine, made with the ratio's tangent at the cell's middle c
//! |e| <= max |w - w(c)| (max |1 - L / L(c)| |S c| + max |S (p - c)|)     L: the denominator; S c: without heights, origin
//! ```
//!
//! `e` is of second order in the cell's size. A cell lies in the hull of its corners and, for each edge of the simplified triangle in it,
//! of one more point: in the reference's plane that edge is a rational curve of second order, of which that point is the
//! middle control point. Over the hull all maxima are at its points: the ratio is a quotient of linear functions.

use super::overlay::{Asked, Squares};
use super::refine::Known;
use crate::param::projection::GridTriangle;
use glam::{DMat3, DVec3};
use smallvec::SmallVec;

/// A point that both triangles have on a line.
#[derive(Clone, Copy, Debug)]
struct Corner {
    /// In T3, on the reference.
    p: DVec3,
    /// In space: the reference's and the simplified triangle's.
    reference: DVec3,
    simplified: DVec3,
}

/// What two triangles' images share.
#[derive(Clone, Debug, Default)]
struct Cell {
    corners: SmallVec<[Corner; 12]>,
    /// Middle control points of the simplified triangle's edges, in the reference's plane; none where there is no sure one.
    controls: Option<SmallVec<[DVec3; 3]>>,
}

/// A function that is affine on a triangle's plane, and does not change across it.
#[derive(Clone, Copy, Debug)]
struct Affine {
    at: DVec3,
    value: DVec3,
    slope: DMat3,
}

/// The simplified triangle.
pub(super) struct View {
    t3: [DVec3; 3],
    corners: [DVec3; 3],
    /// Its normal in space.
    upright: DVec3,
    map: Affine,
    /// Its plane in T3: `normal . q = offset`.
    normal: DVec3,
    offset: f64,
}

impl Affine {
    /// The function that has `values` at `corners`; not finite for corners on a line.
    fn new([a, b, c]: [DVec3; 3], values: [DVec3; 3]) -> Self {
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let per_square = 1.0 / normal.length_squared();
        let along = [ac.cross(normal), normal.cross(ab)].map(|g| g * per_square);
        let rise = [values[1] - values[0], values[2] - values[0]];
        let column = |k: usize| rise[0] * along[0][k] + rise[1] * along[1][k];
        Affine {
            at: a,
            value: values[0],
            slope: DMat3::from_cols(column(0), column(1), column(2)),
        }
    }

    fn of(&self, p: DVec3) -> DVec3 {
        self.value + self.slope * (p - self.at)
    }
}

impl View {
    pub(super) fn new(asked: &Asked, upright: DVec3) -> Self {
        let [a, b, c] = asked.t3;
        let normal = (b - a).cross(c - a);
        View {
            t3: asked.t3,
            corners: asked.corners,
            upright,
            map: Affine::new(asked.t3, asked.corners),
            normal,
            offset: normal.dot(a),
        }
    }

    /// What is known of the cell that is shared with a triangle of the reference, if there is one.
    pub(super) fn known(&self, t3: [DVec3; 3], positions: [DVec3; 3]) -> Option<Known> {
        let cell = cell((self.t3, self.corners), (t3, positions))?;
        let mut squares = Squares::default();
        for corner in &cell.corners {
            squares.raise(&Squares::of(
                corner.reference - corner.simplified,
                self.upright,
            ));
        }
        let more = self.more(&cell, &Affine::new(t3, positions), &squares);
        Some((squares, more.unwrap_or(f64::INFINITY)))
    }

    /// How much more a point of a cell may deviate than its corners, which do by `known`; none where the ratio has no bound.
    fn more(&self, cell: &Cell, reference: &Affine, known: &Squares) -> Option<f64> {
        let corners = cell.corners.iter().map(|corner| corner.p);
        let points = corners.chain(cell.controls.iter().flatten().copied());
        cell.controls.as_ref()?;
        let middle = points.clone().sum::<DVec3>() / points.clone().count() as f64;
        let above = |p: DVec3| self.offset - self.normal.z * p.z;
        let below = |p: DVec3| self.normal.truncate().dot(p.truncate());
        let (top, bottom) = (above(middle), below(middle));
        let ratio = top / bottom;
        let across = |p: DVec3| self.map.slope * p.with_z(0.0);
        let arm = across(middle);
        let (mut ratios, mut bottoms, mut wide) = (0.0f64, 0.0f64, 0.0f64);
        let mut farthest = Squares::default();
        for p in points {
            let (t, b) = (above(p), below(p));
            let one_sign = t / top > 0.0 && b / bottom > 0.0;
            if !one_sign {
                return None;
            }
            ratios = ratios.max((t / b - ratio).abs());
            bottoms = bottoms.max((1.0 - b / bottom).abs());
            wide = wide.max(across(p - middle).length());
            let met = DVec3::new(ratio * p.x, ratio * p.y, p.z);
            let turned = arm * ((t - ratio * b) / bottom);
            let vector = reference.of(p) - self.map.of(met) - turned;
            farthest.raise(&Squares::of(vector, self.upright));
        }
        let slack = ratios * (bottoms * arm.length() + wide);
        let more = known.short_of(&farthest) + slack;
        more.is_finite().then_some(more.max(0.0))
    }
}

/// Whether a triangle's image shares anything with that of another.
pub(super) fn meet(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    cell((a, a), (b, b)).is_some()
}

/// Whether a triangle's image lies all beyond one edge of that of another, of which bit i of `edges` names that opposite of corner i.
pub(super) fn is_beyond(own: [DVec3; 3], edges: u8, t3: [DVec3; 3]) -> bool {
    let middle = (own[0] + own[1] + own[2]) / 3.0;
    (0..3).filter(|i| edges >> i & 1 != 0).any(|i| {
        let (a, b) = (own[(i + 1) % 3], own[(i + 2) % 3]);
        let within = side(middle, a, b);
        t3.iter().all(|&p| side(p, a, b) * within < 0.0)
    })
}

/// Whether two triangles share more than an edge or a corner, by more than rounding.
pub(super) fn overlap(a: &GridTriangle, b: &GridTriangle) -> bool {
    let [a, b] = [a, b].map(|t| t.map(|p| DVec3::from(p.map(f64::from))));
    let Some(cell) = cell((a, a), (b, b)) else {
        return false;
    };
    let from = cell.corners[0].p;
    let sides = || cell.corners.iter().map(|corner| corner.p - from);
    let longest = sides().map(|v| v.length_squared()).fold(0.0, f64::max);
    sides().any(|v| sides().any(|w| v.cross(w).length() > THIN * longest))
}

/// What is thinner than this share of its length is no area.
const THIN: f64 = 1e-6;

/// A triangle in T3 and in space.
type Both = ([DVec3; 3], [DVec3; 3]);

/// The cell of a simplified triangle and one of the reference; none where they share nothing.
fn cell((own, corners): Both, (t3, positions): Both) -> Option<Cell> {
    let height = |corners: &[DVec3; 3]| {
        let z = corners.map(|p| p.z);
        (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]))
    };
    let (a, b) = (height(&own), height(&t3));
    if a.0 > b.1 || b.0 > a.1 {
        return None;
    }
    let met = |p: DVec3| {
        let (alpha, beta) = shares(p, &own).zip(shares(p, &t3))?;
        Some(Corner {
            p: blend(&t3, beta),
            reference: blend(&positions, beta),
            simplified: blend(&corners, alpha),
        })
    };
    let mut cell = Cell {
        corners: t3.iter().filter_map(|&p| met(p)).collect(),
        controls: Some(SmallVec::new()),
    };
    for k in 0..3 {
        let (from, to) = (own[k], own[(k + 1) % 3]);
        let crossed =
            (0..3).flat_map(|i| crossings(from, to, [t3[i], t3[(i + 1) % 3]]).chain([0.0, 1.0]));
        let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
        for s in crossed {
            if let Some(corner) = met(from.lerp(to, s)) {
                cell.corners.push(corner);
                (first, last) = (first.min(s), last.max(s));
            }
        }
        if first < last {
            let control = control([from.lerp(to, first), from.lerp(to, last)], &t3);
            match (control, &mut cell.controls) {
                (Some(control), Some(controls)) => controls.push(control),
                (_, controls) => *controls = None,
            }
        }
    }
    (!cell.corners.is_empty()).then_some(cell)
}

/// The middle control point of the image of the line between two points in a triangle's plane. A point q of the line is met there at
/// `k q` but for its height, `k` a quotient of linear functions: with the denominator as weight all is of second order.
fn control([q, r]: [DVec3; 2], &[a, b, c]: &[DVec3; 3]) -> Option<DVec3> {
    let normal = (b - a).cross(c - a);
    let offset = normal.dot(a);
    let above = |p: DVec3| offset - normal.z * p.z;
    let below = |p: DVec3| normal.truncate().dot(p.truncate());
    let weight = below(q) + below(r);
    let flat = q.truncate() * above(r) + r.truncate() * above(q);
    let height = q.z * below(r) + r.z * below(q);
    let found = flat.extend(height) / weight;
    (below(q) * below(r) > 0.0 && found.is_finite()).then_some(found)
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
