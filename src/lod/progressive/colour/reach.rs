//! What may be shown where places are not known one by one: beyond rims, and along a cylinder's lines.
//!
//! In: a cell. Out: bounds of its deviations, from rectangles: of the plane's coordinates ([`Chart::Flat`]), or of angle and
//! height ([`Chart::Round`]). All that the reference has within the rectangle of a part of the cell and of its feet may be shown
//! there; parts are halved until what may be there is near what is.
//!
//! Where the reference ends before the foot of a point, the colour shown is that of the rim where the way there leaves it.

use super::bound::Search;
use super::ground::{Ground, Plane, Walk};
use super::landing::{Cell, Linear};
use super::palette::Palette;
use super::polygon::Polygon;
use crate::mesh::NONE;
use glam::{DVec2, DVec3};

/// Parts of a cell that are looked at, along lines that meet in a point at most, and along a cylinder's.
const PATIENCE: [usize; 2] = [256, 8];
/// Triangles that a rectangle may hold.
const MOST: usize = 4096;

/// Coordinates in which rectangles are taken.
pub(super) enum Chart<'a> {
    /// Those of the simplified triangle's plane.
    Flat(&'a Plane),
    /// Angle from a direction, and height, of points of T3; the simplified triangle's corners there.
    Round { direction: DVec2, t3: [DVec3; 3] },
}

#[derive(Clone, Copy, Debug)]
struct Rectangle {
    low: DVec2,
    high: DVec2,
}

/// What may be shown: a rectangle of what a triangle shows.
struct Shown {
    triangle: u32,
    within: Rectangle,
}

impl Rectangle {
    fn around(points: impl IntoIterator<Item = DVec2>) -> Rectangle {
        let start = Rectangle {
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
        };
        points.into_iter().fold(start, |all, p| Rectangle {
            low: all.low.min(p),
            high: all.high.max(p),
        })
    }

    fn meets(&self, other: &Rectangle) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    /// The share of a segment that lies within, if any does. Source: Liang and Barsky 1984.
    fn part_of(&self, [a, b]: [DVec2; 2]) -> Option<[f64; 2]> {
        let (mut from, mut to) = (0f64, 1f64);
        for k in 0..2 {
            let along = b[k] - a[k];
            let ends = [self.low[k] - a[k], self.high[k] - a[k]];
            if along == 0.0 {
                if ends[0] > 0.0 || ends[1] < 0.0 {
                    return None;
                }
                continue;
            }
            let s = ends.map(|e| e / along);
            from = from.max(s[0].min(s[1]));
            to = to.min(s[0].max(s[1]));
        }
        (from <= to).then_some([from, to])
    }
}

impl Chart<'_> {
    /// A cylinder's, for a triangle about whose middle angles are counted.
    pub(super) fn round(t3: [DVec3; 3]) -> Self {
        let middle = (t3[0] + t3[1] + t3[2]).truncate();
        Chart::Round {
            direction: middle.normalize_or(DVec2::X),
            t3,
        }
    }

    fn angle(direction: DVec2, p: DVec3) -> DVec2 {
        let p2 = p.truncate();
        DVec2::new(direction.perp_dot(p2).atan2(direction.dot(p2)), p.z)
    }

    /// None where a point has no coordinates.
    fn of_image(&self, h: DVec3) -> Option<DVec2> {
        let weight = h.element_sum();
        (weight > 0.0).then(|| h.truncate() / weight)
    }

    fn foot(&self, foot: DVec3) -> Option<DVec2> {
        match self {
            Chart::Flat(_) => self.of_image(foot),
            Chart::Round { direction, t3 } => {
                let p = t3[0] * foot.x + t3[1] * foot.y + t3[2] * foot.z;
                Some(Self::angle(*direction, p))
            }
        }
    }

    /// Of a reference triangle's corners.
    fn corners(&self, ground: &Ground<'_>, t: u32) -> Option<[DVec2; 3]> {
        match self {
            Chart::Flat(plane) => {
                let [a, b, c] = ground.images(plane, t).map(|h| self.of_image(h));
                Some([a?, b?, c?])
            }
            Chart::Round { direction, .. } => {
                let corners = ground.t3(t).map(|p| Self::angle(*direction, p));
                let angles = corners.map(|c| c.x);
                let spread = angles.iter().copied().fold(f64::MIN, f64::max)
                    - angles.iter().copied().fold(f64::MAX, f64::min);
                // It would hold the axis, or lie across the far side.
                (spread < std::f64::consts::PI).then_some(corners)
            }
        }
    }
}

/// Bounds the deviations of a cell; `beyond`: of those of its points only whose way leads over a rim.
pub(super) fn bound(
    ground: &Ground<'_>,
    palette: &Palette,
    chart: &Chart<'_>,
    cell: &Cell,
    searches: &mut [Search],
) {
    let every = (1u32 << searches.len()) - 1;
    let mut waiting = vec![(cell.polygon, every)];
    let mut looked = 0;
    let patience = PATIENCE[usize::from(matches!(chart, Chart::Round { .. }))];
    while let Some((part, levels)) = waiting.pop() {
        if part.is_empty() {
            continue;
        }
        looked += 1;
        let reach = Reach {
            ground,
            palette,
            chart,
            cell,
        };
        let Some(shown) = reach.shown(&part) else {
            searches.iter_mut().for_each(|s| s.settle(palette.widest));
            return;
        };
        if shown.is_empty() {
            continue;
        }
        reach.lower(&part.middle(), searches);
        let mut open = 0;
        for (k, search) in searches.iter_mut().enumerate() {
            if levels >> k & 1 == 0 {
                continue;
            }
            let upper = reach.upper(&part, &shown, k);
            if upper <= search.enough() || looked + waiting.len() >= patience {
                search.settle(upper);
            } else {
                open |= 1 << k;
            }
        }
        if open != 0 {
            waiting.extend(halves(&part).map(|half| (half, open)));
        }
    }
}

/// Across the longer of the two coordinates.
fn halves(part: &Polygon<2>) -> [Polygon<2>; 2] {
    let around = Rectangle::around(part.corners().iter().map(|&r| DVec2::from(r)));
    let size = around.high - around.low;
    let k = usize::from(size.y > size.x);
    let middle = 0.5 * (around.low + around.high);
    part.halves(|r| r[k] - middle[k])
}

struct Reach<'a> {
    ground: &'a Ground<'a>,
    palette: &'a Palette,
    chart: &'a Chart<'a>,
    cell: &'a Cell,
}

impl Reach<'_> {
    /// What may be shown at the feet of a part of the cell; none where that cannot be said.
    fn shown(&self, part: &Polygon<2>) -> Option<Vec<Shown>> {
        let feet = self.feet(part)?;
        let whole = self.with_images(part, &feet)?;
        let mut shown = Vec::new();
        let mut seen = vec![self.cell.triangle];
        let mut next = 0;
        while let Some(&t) = seen.get(next) {
            next += 1;
            let corners = self.chart.corners(self.ground, t)?;
            let around = Rectangle::around(corners);
            if !around.meets(&whole) {
                continue;
            }
            if seen.len() > MOST {
                return None;
            }
            let coordinates = self.palette.coordinates(t);
            if matches!(self.chart, Chart::Round { .. }) && around.meets(&feet) {
                let within = Rectangle::around(coordinates);
                shown.push(Shown {
                    triangle: t,
                    within,
                });
            }
            for j in 0..3 {
                let other = self.ground.opposite(t, j);
                let ends = [(j + 1) % 3, (j + 2) % 3];
                if other == NONE {
                    shown.extend(self.rim(t, ends, corners, &whole));
                } else if !seen.contains(&other) {
                    seen.push(other);
                }
            }
        }
        Some(shown)
    }

    fn feet(&self, part: &Polygon<2>) -> Option<Rectangle> {
        let feet: Option<Vec<DVec2>> = part
            .corners()
            .iter()
            .map(|r| self.chart.foot(self.cell.feet.of(r)))
            .collect();
        let feet = Rectangle::around(feet?);
        // An angle from both sides of the far end.
        let round = matches!(self.chart, Chart::Round { .. });
        let wide = feet.high.x - feet.low.x > std::f64::consts::FRAC_PI_2;
        (!(round && wide) && feet.low.is_finite() && feet.high.is_finite()).then_some(feet)
    }

    /// The rectangle of the feet and of the part itself: ways between them stay within.
    fn with_images(&self, part: &Polygon<2>, feet: &Rectangle) -> Option<Rectangle> {
        let [a, b, c] = self.chart.corners(self.ground, self.cell.triangle)?;
        let images: Vec<DVec2> = match self.chart {
            Chart::Flat(_) => part
                .corners()
                .iter()
                .map(|r| self.chart.of_image(self.cell.image(r)))
                .collect::<Option<_>>()?,
            Chart::Round { .. } => vec![a, b, c],
        };
        Some(Rectangle::around(
            images.into_iter().chain([feet.low, feet.high]),
        ))
    }

    /// The part of a rim within a rectangle.
    fn rim(
        &self,
        t: u32,
        ends: [usize; 2],
        corners: [DVec2; 3],
        whole: &Rectangle,
    ) -> Option<Shown> {
        let coordinates = self.palette.coordinates(t);
        let [a, b] = ends.map(|k| coordinates[k]);
        let Chart::Flat(plane) = self.chart else {
            let within = Rectangle::around([a, b]);
            return Some(Shown {
                triangle: t,
                within,
            });
        };
        let [from, to] = whole.part_of(ends.map(|k| corners[k]))?;
        let weights = ends.map(|k| self.ground.images(plane, t)[k].element_sum());
        let at = |s: f64| {
            let shares = [(1.0 - s) / weights[0], s / weights[1]];
            (a * shares[0] + b * shares[1]) / (shares[0] + shares[1])
        };
        let within = Rectangle::around([at(from), at(to)]);
        Some(Shown {
            triangle: t,
            within,
        })
    }

    fn own(&self) -> Linear<DVec2> {
        Linear::<DVec2>::through(self.palette.coordinates(self.cell.triangle))
    }

    fn upper(&self, part: &Polygon<2>, shown: &[Shown], level: usize) -> f32 {
        let own = self.own();
        let around = Rectangle::around(part.corners().iter().map(|r| own.of(r)));
        let t = self.cell.triangle;
        let here = self.palette.side(t, t, level);
        let here = here.summary_of(around.low, around.high);
        let there = |s: &Shown| {
            let side = self.palette.side(s.triangle, t, level);
            here.farthest(&side.summary_of(s.within.low, s.within.high))
        };
        shown.iter().map(there).fold(0.0, f32::max)
    }

    /// What one point attains.
    fn lower(&self, r: &[f64; 2], searches: &mut [Search]) {
        let Chart::Flat(plane) = self.chart else {
            return;
        };
        let t = self.cell.triangle;
        let (from, to) = (self.cell.image(r), self.cell.feet.of(r));
        let Walk::Left(other, shares) = self.ground.walk(plane, t, from, to) else {
            return;
        };
        let corners = self.palette.coordinates(other);
        let there = corners[0] * shares[0] + corners[1] * shares[1] + corners[2] * shares[2];
        let here = self.own().of(r);
        for (k, search) in searches.iter_mut().enumerate() {
            let colours = [
                self.palette.side(t, t, k).colour(here),
                self.palette.side(other, t, k).colour(there),
            ];
            search.reach((colours[0] - colours[1]).length());
        }
    }
}
