//! Beyond rims: what counts for points whose feet the reference does not have.
//!
//! The straight way from a point to its foot is walked over the reference as far as that goes. What counts is the place nearest to
//! the foot, so to say, in the last triangle: the foot's barycentric coordinates there, those below zero taken as zero. Over the
//! feet beyond one rim edge that is one formula, and two where the way leads past the edge's ends ([`clamped`]).
//!
//! Which triangle is the last one is known of small parts of a cell: those whose ways pass one rim only.

use super::bound::Search;
use super::ground::{Ground, Plane, Rows, Walk};
use super::landing::{Cell, Linear};
use super::palette::Palette;
use super::passed::{Passed, Rectangle};
use super::piece::Piece;
use super::polygon::Polygon;
use crate::mesh::NONE;
use glam::{DVec2, DVec3};
use std::collections::VecDeque;

/// Parts of a cell that are looked at, the largest first.
const PATIENCE: usize = 512;
/// Polygons that are looked at for a part at a level.
const POLYGONS: u32 = 4000;
/// Triangles that a part's ways may pass.
const MOST: usize = 4096;

/// A triangle, and which of its edges is a rim: the one opposite of this corner.
type Rim = (u32, usize);

/// Bounds the deviations of those of a cell's points whose ways lead over a rim.
pub(super) fn bound(
    ground: &Ground<'_>,
    palette: &Palette,
    plane: &Plane,
    cell: &Cell,
    searches: &mut [Search],
) {
    let beyond = Beyond {
        ground,
        palette,
        plane,
        cell,
    };
    let every = (1u32 << searches.len()) - 1;
    let mut waiting = VecDeque::from([(cell.polygon, every)]);
    let mut looked = 0;
    while let Some((part, levels)) = waiting.pop_front() {
        if part.is_empty() {
            continue;
        }
        looked += 1;
        let Some(rims) = beyond.rims(&part) else {
            searches.iter_mut().for_each(|s| s.settle(palette.widest));
            return;
        };
        if rims.is_empty() {
            continue;
        }
        beyond.attained(&part, searches);
        let pieces: Vec<Piece> = rims
            .iter()
            .flat_map(|rim| beyond.pieces(&part, *rim))
            .collect();
        let mut open = 0;
        for (k, search) in searches
            .iter_mut()
            .enumerate()
            .filter(|(k, _)| levels >> k & 1 == 1)
        {
            let upper = beyond.upper(&pieces, k, search);
            if upper <= search.enough() || looked + waiting.len() >= PATIENCE {
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

/// Barycentric coordinates without those below zero.
pub(super) fn clamped(shares: DVec3) -> DVec3 {
    let shares = shares.max(DVec3::ZERO);
    shares / shares.element_sum()
}

struct Beyond<'a> {
    ground: &'a Ground<'a>,
    palette: &'a Palette,
    plane: &'a Plane,
    cell: &'a Cell,
}

/// None for a point at the plane's horizon or behind it.
fn flat(h: DVec3) -> Option<DVec2> {
    let weight = h.element_sum();
    (weight > 0.0).then(|| h.truncate() / weight)
}

impl Beyond<'_> {
    /// The rims that ways of a part may lead over; none where that cannot be said.
    fn rims(&self, part: &Polygon<2>) -> Option<Vec<Rim>> {
        let corners = part.corners().iter();
        let images: Option<Vec<DVec2>> =
            corners.clone().map(|r| flat(self.cell.image(r))).collect();
        let feet: Option<Vec<DVec2>> = corners.map(|r| flat(self.cell.feet.of(r))).collect();
        let passed = Passed::new(&images?, &feet?);
        let (mut rims, mut seen, mut next) = (Vec::new(), vec![self.cell.triangle], 0);
        while let Some(&t) = seen.get(next) {
            next += 1;
            let [a, b, c] = self.ground.images(self.plane, t).map(flat);
            let corners = [a?, b?, c?];
            if !passed.meets(corners) {
                continue;
            }
            if seen.len() > MOST {
                return None;
            }
            for j in 0..3 {
                let other = self.ground.opposite(t, j);
                if other == NONE {
                    let edge = [corners[(j + 1) % 3], corners[(j + 2) % 3]];
                    rims.extend(passed.part_of(edge).map(|_| (t, j)));
                } else if !seen.contains(&other) {
                    seen.push(other);
                }
            }
        }
        Some(rims)
    }

    /// The pieces of a part whose feet lie beyond a rim, and what counts there.
    fn pieces(&self, part: &Polygon<2>, (t, j): Rim) -> Vec<Piece> {
        let Some(rows) = Rows::of(self.ground.images(self.plane, t)) else {
            return Vec::new();
        };
        let feet = &self.cell.feet;
        let ends = [feet.at, feet.at + feet.along[0], feet.at + feet.along[1]];
        let share = Linear::<DVec3>::through(ends.map(|p| rows.at(p)));
        let [k, l] = [(j + 1) % 3, (j + 2) % 3];
        let outside = part.cut(|r| -share.of(r)[j]);
        let coordinates = self.palette.coordinates(t);
        let pieces = [
            (
                outside.cut(|r| share.of(r)[k]).cut(|r| share.of(r)[l]),
                [k, l],
            ),
            (outside.cut(|r| -share.of(r)[k]), [l, l]),
            (outside.cut(|r| -share.of(r)[l]), [k, k]),
        ];
        let piece = |(polygon, [k, l]): (Polygon<2>, [usize; 2])| {
            let blend = |s: DVec3| match k == l {
                true => coordinates[k].extend(1.0),
                false => coordinates[k].extend(1.0) * s[k] + coordinates[l].extend(1.0) * s[l],
            };
            let at = share.at;
            let of = [at, at + share.along[0], at + share.along[1]].map(blend);
            Piece {
                shown: t,
                polygon,
                coordinates: Linear::<DVec3>::through(of).of_weight_one(&polygon.middle()),
            }
        };
        pieces
            .into_iter()
            .filter(|(polygon, _)| !polygon.is_empty())
            .map(piece)
            .collect()
    }

    /// No deviation of the pieces at a level is larger, as far as it matters.
    fn upper(&self, pieces: &[Piece], level: usize, search: &Search) -> f32 {
        let mut own = search.afresh(POLYGONS);
        for piece in pieces {
            piece
                .of(self.palette, self.cell.triangle)
                .look_at(level, &mut own);
        }
        own.upper
    }

    /// What a part's corners and its middle attain.
    fn attained(&self, part: &Polygon<2>, searches: &mut [Search]) {
        let t = self.cell.triangle;
        let own = Linear::<DVec2>::through(self.palette.coordinates(t));
        for r in part.corners().iter().chain([&part.middle()]) {
            let (from, to) = (self.cell.image(r), self.cell.feet.of(r));
            let Walk::Left(other, shares) = self.ground.walk(self.plane, t, from, to) else {
                continue;
            };
            let corners = self.palette.coordinates(other);
            let there = corners[0] * shares.x + corners[1] * shares.y + corners[2] * shares.z;
            for (k, search) in searches.iter_mut().enumerate() {
                search.reach(self.palette.difference((t, own.of(r)), (other, there), k));
            }
        }
    }
}
