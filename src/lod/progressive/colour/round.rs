//! Along a cylinder's lines: where points of T3 lie in a triangle, as quotients of quadratic functions.
//!
//! The side products of a point with a triangle's edges are quadratic in the point. Over a polygon such a function is a mean of
//! its values between pairs of corners, and a quotient of two is a mean of theirs, weighed by the second: so values between pairs
//! bound where a polygon's points lie.

use super::super::overlay::Asked;
use super::bound::Search;
use super::ground::Ground;
use super::landing::{Cell, Linear};
use super::palette::Palette;
use super::passed::Rectangle;
use super::piece::{Places, Ready};
use super::polygon::Polygon;
use crate::mesh::NONE;
use glam::{DVec2, DVec3};
use std::collections::VecDeque;

/// Parts of a cell that are looked at, the largest first: few, since each is laid over the reference anew. Bounds hold, and
/// are wider than elsewhere.
const PATIENCE: usize = 4;
/// Polygons that are looked at for a part, a triangle and a level.
const POLYGONS: u32 = 40;
/// Triangles that a rectangle may hold.
const MOST: usize = 4096;

/// A triangle's side products, positive within.
pub(super) struct Sides {
    corners: [DVec3; 3],
    sense: f64,
}

impl Sides {
    /// Of a triangle in T3 that lines meet in `sense`.
    pub(super) fn new(corners: [DVec3; 3], sense: f64) -> Self {
        Sides { corners, sense }
    }

    /// Between two points: symmetric, linear in each, and at one point twice the products themselves. A product is
    /// `det(d, a - p, b - p)`, d being p without its height.
    fn between(&self, p: DVec3, q: DVec3) -> DVec3 {
        let turn = |p: DVec3, a: DVec3| p.x * a.y - p.y * a.x;
        let side = |a: DVec3, b: DVec3| {
            let by_b = turn(p, b) * (a.z - q.z) + turn(q, b) * (a.z - p.z);
            let by_a = turn(p, a) * (b.z - q.z) + turn(q, a) * (b.z - p.z);
            0.5 * (by_a - by_b) * self.sense
        };
        let [a, b, c] = self.corners;
        DVec3::new(side(b, c), side(c, a), side(a, b))
    }

    /// The barycentric coordinates of a point's line there; none where it passes the triangle.
    pub(super) fn shares(&self, p: DVec3) -> Option<DVec3> {
        let sides = self.between(p, p);
        let sum = sides.element_sum();
        (sides.min_element() >= 0.0 && sum > 0.0).then(|| sides / sum)
    }

    /// Whether the lines of all points of a polygon pass beside one edge.
    pub(super) fn miss(&self, points: &[DVec3]) -> bool {
        let most = pairs(points.len())
            .map(|(i, j)| self.between(points[i], points[j]))
            .fold(DVec3::NEG_INFINITY, DVec3::max);
        most.min_element() < 0.0
    }
}

fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i..n).map(move |j| (i, j)))
}

/// A simplified triangle along a cylinder's lines.
pub(super) struct Round<'a> {
    ground: &'a Ground<'a>,
    palette: &'a Palette,
    /// Angles are counted from here.
    direction: DVec2,
    t3: [DVec3; 3],
    own: Sides,
    sense: f64,
}

/// What may be shown: a rectangle of what a triangle shows.
struct Shown {
    triangle: u32,
    within: Rectangle,
    /// What is shown if places there vary linearly between the part's corners, and by how much they do not; none for rims.
    linear: Option<(Places, DVec2)>,
}

/// A part of a cell: a triangle, its corners' points of T3 and of the simplified triangle's plane there.
struct Part {
    corners: [[f64; 2]; 3],
    points: [DVec3; 3],
    feet: [DVec3; 3],
}

impl<'a> Round<'a> {
    pub(super) fn new(ground: &'a Ground<'a>, palette: &'a Palette, asked: &Asked) -> Self {
        let [a, b, c] = asked.t3;
        let sense = f64::from(asked.sense);
        Round {
            ground,
            palette,
            direction: (a + b + c).truncate().normalize_or(DVec2::X),
            t3: asked.t3,
            own: Sides::new(asked.t3, sense),
            sense,
        }
    }

    /// Bounds the deviations of a cell, which is a whole triangle of the reference.
    pub(super) fn bound(&self, cell: &Cell, searches: &mut [Search]) {
        let every = (1u32 << searches.len()) - 1;
        let mut waiting = VecDeque::from([([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], every)]);
        let mut looked = 0;
        while let Some((corners, levels)) = waiting.pop_front() {
            let part = self.part(cell, corners);
            // What the simplified triangle does not stand for.
            if self.own.miss(&part.points) {
                continue;
            }
            looked += 1;
            let Some(shown) = self.shown(cell.triangle, &part) else {
                let widest = self.palette.widest;
                searches.iter_mut().for_each(|s| s.settle(widest));
                return;
            };
            self.attained(cell, &part, &shown, searches);
            let mut open = 0;
            for (k, search) in searches.iter_mut().enumerate() {
                if levels >> k & 1 == 0 {
                    continue;
                }
                let upper = self.upper(cell.triangle, &part, &shown, (k, search));
                if upper <= search.upper {
                    // Another part may show more: nothing is gained here.
                    continue;
                }
                if upper <= search.enough() || looked + waiting.len() >= PATIENCE {
                    search.settle(upper);
                } else {
                    open |= 1 << k;
                }
            }
            if open != 0 {
                waiting.extend(halves(corners).map(|half| (half, open)));
            }
        }
    }

    /// How far from each other in T3 the middle of a cell and its foot are.
    pub(super) fn displaced(&self, cell: &Cell) -> f64 {
        let middle = [1.0 / 3.0; 2];
        let own = Linear::<DVec3>::through(self.ground.t3(cell.triangle));
        self.foot(cell, &middle).distance(own.of(&middle))
    }

    fn part(&self, cell: &Cell, corners: [[f64; 2]; 3]) -> Part {
        let own = Linear::<DVec3>::through(self.ground.t3(cell.triangle));
        Part {
            points: corners.map(|r| own.of(&r)),
            feet: corners.map(|r| self.foot(cell, &r)),
            corners,
        }
    }

    fn foot(&self, cell: &Cell, r: &[f64; 2]) -> DVec3 {
        let [a, b, c] = self.t3;
        let shares = cell.feet.of(r);
        a * shares.x + b * shares.y + c * shares.z
    }

    /// Angle and height.
    fn place(&self, p: DVec3) -> DVec2 {
        let q = p.truncate();
        DVec2::new(self.direction.perp_dot(q).atan2(self.direction.dot(q)), p.z)
    }

    /// The rectangle of a triangle; none where it would hold the axis, or lie across the far side.
    fn rectangle(&self, points: &[DVec3]) -> Option<Rectangle> {
        let around = Rectangle::around(points.iter().map(|&p| self.place(p)));
        let spread = around.high.x - around.low.x;
        (spread < std::f64::consts::PI && around.low.is_finite()).then_some(around)
    }

    /// What may be shown at the feet of a part: of all triangles there, and of rims that the ways there may lead over.
    fn shown(&self, from: u32, part: &Part) -> Option<Vec<Shown>> {
        let (feet, points) = (self.rectangle(&part.feet)?, self.rectangle(&part.points)?);
        let whole = Rectangle::around([feet.low, feet.high, points.low, points.high]);
        let (mut shown, mut seen, mut next) = (Vec::new(), vec![from], 0);
        while let Some(&t) = seen.get(next) {
            next += 1;
            let t3 = self.ground.t3(t);
            let around = self.rectangle(&t3)?;
            if !around.meets(&whole) {
                continue;
            }
            if seen.len() > MOST {
                return None;
            }
            if around.meets(&feet) {
                shown.extend(self.there(t, &Sides::new(t3, self.sense), (from, part)));
            }
            for j in 0..3 {
                let other = self.ground.opposite(t, j);
                if other == NONE {
                    let ends = [(j + 1) % 3, (j + 2) % 3];
                    let coordinates = self.palette.coordinates(t);
                    shown.push(Shown {
                        triangle: t,
                        within: Rectangle::around(ends.map(|k| coordinates[k])),
                        linear: None,
                    });
                } else if !seen.contains(&other) {
                    seen.push(other);
                }
            }
        }
        Some(shown)
    }

    /// What of triangle `t` is shown at the feet of a part of another; none where nothing is.
    fn there(&self, t: u32, sides: &Sides, (from, part): (u32, &Part)) -> Option<Shown> {
        if sides.miss(&part.feet) {
            return None;
        }
        let corners = self.palette.coordinates(t);
        let all = Rectangle::around(corners);
        let own = Linear::<DVec2>::through(self.palette.coordinates(from));
        let place = |p: DVec3, q: DVec3| {
            let shares = sides.between(p, q);
            let weight = shares.element_sum();
            let place = corners[0] * shares.x + corners[1] * shares.y + corners[2] * shares.z;
            (place / weight, weight)
        };
        let at = part.feet.map(|p| place(p, p));
        let between = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| {
            let (place, weight) = place(part.feet[i], part.feet[j]);
            (place, weight, (place - 0.5 * (at[i].0 + at[j].0)).abs())
        });
        let weights = at.iter().map(|a| a.1).chain(between.iter().map(|b| b.1));
        let least = weights.clone().fold(f64::INFINITY, f64::min);
        if least <= 0.0 {
            return Some(Shown {
                triangle: t,
                within: all,
                linear: None,
            });
        }
        let places = at.iter().map(|a| a.0).chain(between.iter().map(|b| b.0));
        let around = Rectangle::around(places);
        let bent = between.iter().map(|b| b.2).fold(DVec2::ZERO, DVec2::max);
        // What weights move a mean of places: see `bound`.
        let moved =
            (around.high - around.low) * (0.25 * (weights.fold(0.0, f64::max) / least - 1.0));
        let linear = Polygon::new([0, 1, 2].map(|k| {
            let (here, there) = (own.of(&part.corners[k]), at[k].0);
            [here.x, here.y, there.x, there.y, 1.0]
        }));
        Some(Shown {
            triangle: t,
            within: Rectangle {
                low: around.low.max(all.low),
                high: around.high.min(all.high),
            },
            linear: Some((linear, bent + moved)),
        })
    }

    fn upper(
        &self,
        t: u32,
        part: &Part,
        shown: &[Shown],
        (level, search): (usize, &Search),
    ) -> f32 {
        let own = Linear::<DVec2>::through(self.palette.coordinates(t));
        let around = Rectangle::around(part.corners.iter().map(|r| own.of(r)));
        let known = self
            .palette
            .side(t, t, level)
            .summary_of(around.low, around.high);
        let there = |s: &Shown| {
            let side = self.palette.side(s.triangle, t, level);
            let farthest = known.farthest(&side.summary_of(s.within.low, s.within.high));
            let Some((places, more)) = &s.linear else {
                return farthest;
            };
            if farthest <= search.enough().max(search.upper) {
                return farthest;
            }
            let mut own = search.afresh(POLYGONS);
            Ready::new(self.palette, [t, s.triangle], *places).look_at(level, &mut own);
            farthest.min(own.upper + side.along(*more))
        };
        shown.iter().map(there).fold(0.0, f32::max)
    }

    /// What a part's corners and its middle attain.
    fn attained(&self, cell: &Cell, part: &Part, shown: &[Shown], searches: &mut [Search]) {
        let t = cell.triangle;
        let triangle = Polygon::new(part.corners);
        for r in part.corners.iter().chain([&triangle.middle()]) {
            let point = Linear::<DVec3>::through(self.ground.t3(t)).of(r);
            if self.own.shares(point).is_none() {
                continue;
            }
            let foot = self.foot(cell, r);
            let there = shown.iter().filter(|s| s.linear.is_some()).find_map(|s| {
                let sides = Sides::new(self.ground.t3(s.triangle), self.sense);
                Some((s.triangle, sides.shares(foot)?))
            });
            if let Some((other, shares)) = there {
                let [a, b, c] = self.palette.coordinates(other);
                let there = a * shares.x + b * shares.y + c * shares.z;
                let here = Linear::<DVec2>::through(self.palette.coordinates(t)).of(r);
                for (k, search) in searches.iter_mut().enumerate() {
                    search.reach(self.palette.difference((t, here), (other, there), k));
                }
            }
        }
    }
}

/// A triangle's halves across its longest side.
fn halves(corners: [[f64; 2]; 3]) -> [[[f64; 2]; 3]; 2] {
    let length = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    let longest = (0..3)
        .max_by(|&a, &b| length(a).total_cmp(&length(b)))
        .unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    [[a, middle, c], [middle, b, c]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_between_a_point_and_itself_are_its_shares() {
        let corners = [
            DVec3::new(2.0, 0.1, 0.0),
            DVec3::new(1.5, 1.4, 0.2),
            DVec3::new(1.8, 0.6, 1.3),
        ];
        let sides = Sides::new(corners, 1.0);
        let blend = |s: DVec3| corners[0] * s.x + corners[1] * s.y + corners[2] * s.z;
        let share = DVec3::new(0.2, 0.5, 0.3);
        let on_it = blend(share);
        // Nearer to the axis and farther off: the same line.
        for factor in [0.3, 1.0, 4.0] {
            let p = DVec3::new(on_it.x * factor, on_it.y * factor, on_it.z);
            let found = [1.0, -1.0].map(|s| Sides::new(corners, s).shares(p));
            let found = found[0].or(found[1]).unwrap();
            assert!((found - share).length() < 1e-9, "{found}");
        }
        let within = DVec3::splat(1.0 / 3.0);
        let sense = if sides.shares(blend(within)).is_some() {
            1.0
        } else {
            -1.0
        };
        let sides = Sides::new(corners, sense);
        assert!(!sides.miss(&[blend(within), blend(DVec3::new(-0.1, 0.6, 0.5))]));
        assert!(sides.miss(&[blend(DVec3::new(-0.1, 0.6, 0.5)); 2]));
    }
}
