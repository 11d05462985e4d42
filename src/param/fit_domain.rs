//! The hash domain of a primary parameterization as flat sheets, for counting coverage and for footprints of parts.
//!
//! In: triangles in T3, relative to the primary's origin, axis along z. Out: where they lie on the sheets
//! ([`Domain::pieces`]) and whether the projection line through a point of a sheet meets them ([`Domain::probe`]).
//!
//! Sheets: one rectangle for uv sets and planes; the four sides of a square prism about the axis of a cylinder; the
//! six faces of a cube about the centre of a sphere. Projecting onto sides and faces is done by clipping and one
//! division, so a triangle over a seam, over the axis or round a pole is an ordinary case. This is a measuring
//! instrument: nothing of it is stored, the tables have their own addresses.

use super::PrimaryKind;
use super::projection::Line;

type Point = [f64; 3];

/// What the sheets are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    Flat,
    Prism,
    Cube,
}

/// Sheets over the bounding box of a mesh's T3 points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Domain {
    shape: Shape,
    /// Smallest flat coordinates (u, v); for the prism only the second (z) is used.
    low: [f64; 2],
    /// Extent of the same; never 0.
    size: [f64; 2],
    /// How far a sheet of the prism or cube reaches over its edge, as a share of its half-width: neighbours overlap
    /// there, so that things next to a fold meet on one sheet.
    apron: f64,
}

/// A bounding rectangle on a sheet, in sheet coordinates (0..1, both ends included).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) sheet: usize,
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
}

impl Domain {
    /// The domain of `kind` over `points` (T3, relative to the origin).
    pub(crate) fn new(kind: PrimaryKind, points: &[Point], apron: f64) -> Self {
        let (shape, axes) = match kind.line() {
            Line::Parallel => (Shape::Flat, [0, 1]),
            Line::Cylinder => (Shape::Prism, [0, 2]),
            Line::Sphere => (Shape::Cube, [0, 1]),
        };
        let bound = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
            points.iter().map(|p| p[axis]).fold(from, pick)
        };
        let low = axes.map(|axis| bound(axis, f64::min, f64::INFINITY));
        let high = axes.map(|axis| bound(axis, f64::max, f64::NEG_INFINITY));
        let size = [0, 1].map(|i| {
            if high[i] > low[i] {
                high[i] - low[i]
            } else {
                1.0
            }
        });
        Domain {
            shape,
            low,
            size,
            apron,
        }
    }

    /// A uv domain that is the tile `[tile, tile + 1]` instead of the bounding box.
    pub(crate) fn tile(tile: [f64; 2]) -> Self {
        Domain {
            shape: Shape::Flat,
            low: tile,
            size: [1.0, 1.0],
            apron: 0.0,
        }
    }

    /// How many sheets there are.
    pub(crate) fn sheets(&self) -> usize {
        match self.shape {
            Shape::Flat => 1,
            Shape::Prism => 4,
            Shape::Cube => 6,
        }
    }

    /// Calls `visit` with a rectangle on every sheet that the triangle's image may touch.
    pub(crate) fn pieces(&self, triangle: &[Point; 3], mut visit: impl FnMut(Piece)) {
        if self.shape == Shape::Flat {
            let flat = triangle.map(|p| [0, 1].map(|i| (p[i] - self.low[i]) / self.size[i]));
            visit(bounds(0, flat.iter().copied()));
            return;
        }
        let reach = 1.0 + self.apron;
        for sheet in 0..self.sheets() {
            let local = triangle.map(|p| self.local(sheet, p));
            let mut polygon = Polygon::new(&local);
            polygon.clip(|p| reach * p[2] - p[0]);
            polygon.clip(|p| reach * p[2] + p[0]);
            if self.shape == Shape::Cube {
                polygon.clip(|p| reach * p[2] - p[1]);
                polygon.clip(|p| reach * p[2] + p[1]);
            }
            if !polygon.is_empty() {
                visit(self.image(sheet, &polygon));
            }
        }
    }

    /// A triangle on a sheet, ready to be asked about many points.
    pub(crate) fn probe(&self, triangle: &[Point; 3], sheet: usize) -> Probe {
        Probe {
            domain: *self,
            corners: triangle.map(|p| self.local(sheet, p)),
        }
    }

    /// The point in a sheet's own axes: across, along, outwards.
    fn local(&self, sheet: usize, p: Point) -> Point {
        let sign = if sheet.is_multiple_of(2) { 1.0 } else { -1.0 };
        match self.shape {
            Shape::Flat => p,
            Shape::Prism => {
                let out = sheet / 2;
                [p[1 - out], p[2], sign * p[out]]
            }
            Shape::Cube => {
                let out = sheet / 2;
                [p[(out + 1) % 3], p[(out + 2) % 3], sign * p[out]]
            }
        }
    }

    /// Bounds of a clipped polygon on its sheet.
    fn image(&self, sheet: usize, polygon: &Polygon) -> Piece {
        let reach = 1.0 + self.apron;
        // A point on the axis or at the centre lies everywhere.
        let share = |x: f64, w: f64| {
            if w > 0.0 {
                (x / w).clamp(-reach, reach)
            } else {
                f64::NAN
            }
        };
        let sheet_coordinate = |x: f64| 0.5 * (x / reach + 1.0);
        let point = |p: &Point| {
            let along = match self.shape {
                Shape::Cube => sheet_coordinate(share(p[1], p[2])),
                _ => (p[1] - self.low[1]) / self.size[1],
            };
            [sheet_coordinate(share(p[0], p[2])), along]
        };
        let whole = |p: [f64; 2]| p[0].is_nan() || p[1].is_nan();
        if polygon.points().iter().map(point).any(whole) {
            let mut piece = Piece {
                sheet,
                low: [0.0; 2],
                high: [1.0; 2],
            };
            if self.shape == Shape::Prism {
                let along = bounds(
                    sheet,
                    polygon
                        .points()
                        .iter()
                        .map(|p| [0.0, (p[1] - self.low[1]) / self.size[1]]),
                );
                (piece.low[1], piece.high[1]) = (along.low[1], along.high[1]);
            }
            return piece;
        }
        bounds(sheet, polygon.points().iter().map(point))
    }
}

/// See [`Domain::probe`].
pub(crate) struct Probe {
    domain: Domain,
    /// Corners in the sheet's own axes.
    corners: [Point; 3],
}

impl Probe {
    /// True where the projection line through the sheet's point `at` meets the triangle strictly inside.
    pub(crate) fn inside(&self, at: [f64; 2]) -> bool {
        let (domain, corners) = (&self.domain, &self.corners);
        let reach = 1.0 + domain.apron;
        let flat = |k: usize| domain.low[k] + at[k] * domain.size[k];
        let folded = |k: usize| (2.0 * at[k] - 1.0) * reach;
        // Two planes that hold the projection line: across the sheet, and along it.
        let (first, second) = match domain.shape {
            Shape::Flat => (
                corners.map(|p| p[0] - flat(0)),
                corners.map(|p| p[1] - flat(1)),
            ),
            Shape::Prism => (
                corners.map(|p| p[0] - folded(0) * p[2]),
                corners.map(|p| p[1] - flat(1)),
            ),
            Shape::Cube => (
                corners.map(|p| p[0] - folded(0) * p[2]),
                corners.map(|p| p[1] - folded(1) * p[2]),
            ),
        };
        one_sign(first, second).is_some_and(|b| {
            // The line is a half-line: the hit must lie on the sheet's side of the axis or centre.
            let outwards = b[0] * corners[0][2] + b[1] * corners[1][2] + b[2] * corners[2][2];
            domain.shape == Shape::Flat || outwards * (b[0] + b[1] + b[2]) > 0.0
        })
    }
}

fn bounds(sheet: usize, points: impl Iterator<Item = [f64; 2]>) -> Piece {
    let mut piece = Piece {
        sheet,
        low: [f64::INFINITY; 2],
        high: [f64::NEG_INFINITY; 2],
    };
    for p in points {
        piece.low = [piece.low[0].min(p[0]), piece.low[1].min(p[1])];
        piece.high = [piece.high[0].max(p[0]), piece.high[1].max(p[1])];
    }
    piece
}

/// `first x second` when its three numbers have one strict sign: the line where both planes vanish passes through the
/// triangle's inside.
fn one_sign(first: [f64; 3], second: [f64; 3]) -> Option<[f64; 3]> {
    let b = super::fit_centre::cross(first, second);
    (b.iter().all(|&x| x > 0.0) || b.iter().all(|&x| x < 0.0)).then_some(b)
}

/// A triangle cut by up to four planes: at most seven corners.
struct Polygon {
    corners: [Point; 8],
    count: usize,
}

impl Polygon {
    fn new(triangle: &[Point; 3]) -> Self {
        let mut corners = [[0.0; 3]; 8];
        corners[..3].copy_from_slice(triangle);
        Polygon { corners, count: 3 }
    }

    fn points(&self) -> &[Point] {
        &self.corners[..self.count]
    }

    fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Keeps what has `side >= 0` (Sutherland and Hodgman).
    fn clip(&mut self, side: impl Fn(&Point) -> f64) {
        let sides: [f64; 8] = std::array::from_fn(|i| {
            if i < self.count {
                side(&self.corners[i])
            } else {
                0.0
            }
        });
        if sides[..self.count].iter().all(|&s| s >= 0.0) {
            return;
        }
        let (mut corners, mut count) = ([[0.0; 3]; 8], 0);
        for i in 0..self.count {
            let j = (i + 1) % self.count;
            if sides[i] >= 0.0 {
                corners[count] = self.corners[i];
                count += 1;
            }
            if (sides[i] >= 0.0) != (sides[j] >= 0.0) && count < 8 {
                let t = sides[i] / (sides[i] - sides[j]);
                corners[count] = std::array::from_fn(|k| {
                    self.corners[i][k] + t * (self.corners[j][k] - self.corners[i][k])
                });
                count += 1;
            }
        }
        (self.corners, self.count) = (corners, count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::param::Axis;

    const TRIANGLE: [Point; 3] = [[0.5, 0.1, 0.2], [0.4, 0.6, 0.1], [0.3, 0.2, 0.9]];

    /// Points of a grid on every sheet that are inside, against the rectangle that should hold them all.
    fn check(kind: PrimaryKind, triangle: &[Point; 3]) -> usize {
        let domain = Domain::new(kind, triangle, 0.1);
        let mut pieces = vec![];
        domain.pieces(triangle, |p| pieces.push(p));
        let mut hits = 0;
        for sheet in 0..domain.sheets() {
            for cell in 0..64 * 64 {
                let at = [cell % 64, cell / 64].map(|i| (f64::from(i) + 0.5) / 64.0);
                if domain.probe(triangle, sheet).inside(at) {
                    hits += 1;
                    let held = |p: &Piece| {
                        p.sheet == sheet && (0..2).all(|i| p.low[i] <= at[i] && at[i] <= p.high[i])
                    };
                    assert!(
                        pieces.iter().any(held),
                        "{kind:?} sheet {sheet} {at:?} outside {pieces:?}"
                    );
                }
            }
        }
        hits
    }

    #[test]
    fn what_is_inside_is_inside_the_rectangle() {
        for kind in [
            PrimaryKind::UvSet(0),
            PrimaryKind::Cylinder(Axis::Z),
            PrimaryKind::Sphere,
        ] {
            assert!(check(kind, &TRIANGLE) > 0, "{kind:?}");
        }
    }

    #[test]
    fn a_triangle_round_the_pole_covers_the_pole() {
        let cap = [[1.0, 0.0, 1.0], [-0.5, 0.8, 1.0], [-0.5, -0.8, 1.0]];
        let domain = Domain::new(PrimaryKind::Sphere, &cap, 0.0);
        assert!(domain.probe(&cap, 4).inside([0.5, 0.5]));
        assert!(
            !domain.probe(&cap, 5).inside([0.5, 0.5]),
            "the half-line goes one way only"
        );
        check(PrimaryKind::Sphere, &cap);
        check(
            PrimaryKind::Cylinder(Axis::Z),
            &cap.map(|p| [p[0], p[1], p[2] + p[0]]),
        );
    }

    #[test]
    fn a_triangle_over_the_seam_is_on_two_sheets() {
        let over = [[1.0, 0.9, 0.0], [0.9, 1.0, 0.0], [0.9, 0.9, 0.5]];
        let domain = Domain::new(PrimaryKind::Cylinder(Axis::Z), &over, 0.0);
        let mut sheets = vec![];
        domain.pieces(&over, |p| sheets.push(p.sheet));
        assert_eq!(sheets, [0, 2]);
    }
}
