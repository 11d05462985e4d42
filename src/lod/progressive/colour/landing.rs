//! Where the points that a simplified triangle stands for come to lie, and what is shown there.
//!
//! In: the triangle's plane and the triangles of the reference that its image meets. Out: [`Cell`]s, the parts of those, and for
//! each cell its [`Piece`]s: the foot of a cell's point on the plane is again a point of T3, where some other triangle of the
//! reference is shown. Over a piece that is one triangle, and both places in the texture vary linearly (or as quotients).

use super::ground::{Ground, Plane, Rows, Walk};
use super::palette::Palette;
use super::piece::Piece;
use super::polygon::Polygon;
use crate::mesh::NONE;
use glam::{DVec2, DVec3};

/// The part of a reference triangle that a simplified triangle stands for.
pub(super) struct Cell {
    pub(super) triangle: u32,
    /// Its corners' second and third barycentric coordinates.
    pub(super) polygon: Polygon<2>,
    /// How far the corners' feet lie from the places where they are shown, at most; object units.
    pub(super) far: f64,
    pub(super) feet: Linear<DVec3>,
    /// Of the triangle's corners.
    pub(super) images: [DVec3; 3],
}

/// A linear function of a reference triangle's second and third barycentric coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Linear<T> {
    pub(super) at: T,
    pub(super) along: [T; 2],
}

/// A piece may be short of its cell by this share, by rounding.
const ROUNDING: f64 = 1e-6;

impl Linear<DVec3> {
    pub(super) fn through([a, b, c]: [DVec3; 3]) -> Self {
        Linear {
            at: a,
            along: [b - a, c - a],
        }
    }

    pub(super) fn of(&self, r: &[f64; 2]) -> DVec3 {
        self.at + self.along[0] * r[0] + self.along[1] * r[1]
    }
}

impl Linear<DVec3> {
    /// The same homogeneous coordinates, of a weight that is one at a point.
    pub(super) fn of_weight_one(self, r: &[f64; 2]) -> Self {
        let weight = self.of(r).z;
        if weight <= 0.0 {
            return self;
        }
        Linear {
            at: self.at / weight,
            along: self.along.map(|c| c / weight),
        }
    }
}

impl Linear<DVec2> {
    pub(super) fn through([a, b, c]: [DVec2; 3]) -> Self {
        Linear {
            at: a,
            along: [b - a, c - a],
        }
    }

    pub(super) fn of(&self, r: &[f64; 2]) -> DVec2 {
        self.at + self.along[0] * r[0] + self.along[1] * r[1]
    }
}

/// The whole of a reference triangle.
pub(super) fn whole() -> Polygon<2> {
    Polygon::new([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
}

/// The cell of a reference triangle; none where the simplified triangle's image does not meet it.
pub(super) fn cell(
    ground: &Ground<'_>,
    plane: &Plane,
    corners: [DVec3; 3],
    t: u32,
) -> Option<Cell> {
    let images = ground.images(plane, t);
    let most = images[0].max(images[1]).max(images[2]);
    if most.min_element() <= 0.0 {
        return None;
    }
    let image = Linear::<DVec3>::through(images);
    let least = images[0].min(images[1]).min(images[2]);
    let mut polygon = whole();
    for k in (0..3).filter(|&k| least[k] < 0.0) {
        polygon = polygon.cut(|r| image.of(r)[k]);
    }
    if polygon.is_empty() {
        return None;
    }
    let feet = Linear::<DVec3>::through(ground.positions(t).map(|p| plane.foot(p)));
    let way = |r: &[f64; 2]| {
        let h = image.of(r);
        let by = feet.of(r) - h / h.element_sum();
        (corners[0] * by.x + corners[1] * by.y + corners[2] * by.z).length()
    };
    Some(Cell {
        triangle: t,
        far: polygon.corners().iter().map(way).fold(0.0, f64::max),
        polygon,
        feet,
        images,
    })
}

impl Cell {
    /// The image of the cell's point.
    pub(super) fn image(&self, r: &[f64; 2]) -> DVec3 {
        Linear::<DVec3>::through(self.images).of(r)
    }

    /// Its pieces; whether they are all of it.
    pub(super) fn pieces(
        &self,
        ground: &Ground<'_>,
        plane: &Plane,
        palette: &Palette,
        into: &mut Vec<Piece>,
    ) -> bool {
        into.clear();
        let Some(first) = self.first(ground, plane) else {
            return false;
        };
        let mut area = 0.0;
        let mut seen = vec![first];
        let mut next = 0;
        while let Some(&t) = seen.get(next) {
            next += 1;
            let met = match Rows::of(ground.images(plane, t)) {
                Some(rows) => {
                    let piece = self.piece(&rows, t, palette);
                    let met = !piece.polygon.is_empty();
                    area += piece.polygon.area();
                    into.extend(met.then_some(piece));
                    met
                }
                // It has no area there: what lies behind it may be met.
                None => true,
            };
            if met {
                for other in ground.across[t as usize] {
                    if other != NONE && !seen.contains(&other) {
                        seen.push(other);
                    }
                }
            }
        }
        area >= self.polygon.area() * (1.0 - ROUNDING)
    }

    /// A triangle that some foot is shown by.
    fn first(&self, ground: &Ground<'_>, plane: &Plane) -> Option<u32> {
        let middle = self.polygon.middle();
        let points = [&middle].into_iter().chain(self.polygon.corners());
        points
            .map(|r| ground.walk(plane, self.triangle, self.image(r), self.feet.of(r)))
            .find_map(|walk| match walk {
                Walk::Arrived(t) => Some(t),
                Walk::Left(..) => None,
            })
    }

    fn piece(&self, rows: &Rows, t: u32, palette: &Palette) -> Piece {
        // Barycentric coordinates there, of the feet of the reference triangle's corners.
        let feet = &self.feet;
        let shares =
            [feet.at, feet.at + feet.along[0], feet.at + feet.along[1]].map(|p| rows.at(p));
        let share = Linear::<DVec3>::through(shares);
        let least = shares[0].min(shares[1]).min(shares[2]);
        let mut polygon = self.polygon;
        for k in (0..3).filter(|&k| least[k] < 0.0) {
            polygon = polygon.cut(|r| share.of(r)[k]);
        }
        let corners = palette.coordinates(t).map(|c| c.extend(1.0));
        let blend = |s: DVec3| corners[0] * s.x + corners[1] * s.y + corners[2] * s.z;
        let coordinates = Linear::<DVec3>::through(shares.map(blend));
        Piece {
            shown: t,
            coordinates: coordinates.of_weight_one(&polygon.middle()),
            polygon,
        }
    }
}
