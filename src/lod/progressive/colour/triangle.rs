//! The colour deviations of one simplified triangle.
//!
//! In: the triangle, and the triangles of the reference that its image may meet. Out: [`Measured`]: which it meets, and for every
//! level what its tangential part changes, at most, and the product of its normal part and the steepest colour near it.

use super::super::overlay::Asked;
use super::super::{Deviation, Made, radial};
use super::bound::Search;
use super::ground::{Ground, Plane};
use super::landing::{Cell, Linear, Piece, cell, whole};
use super::palette::{Palette, Side};
use super::reach::{Chart, bound};
use crate::mesh::NONE;
use crate::param::projection::{Line, nearest, orientation};
use glam::{DVec2, DVec3};

/// What was found.
#[derive(Clone, Debug, Default)]
pub(super) struct Measured {
    /// Triangles of the reference that its image meets, in growing order.
    pub(super) covers: Vec<u32>,
    /// For each level.
    pub(super) tangential: Vec<f32>,
    /// What of the tangential deviation is attained.
    pub(super) attained: Vec<f32>,
    pub(super) product: Vec<f32>,
}

/// All that triangles are measured against.
pub(super) struct Against<'a> {
    pub(super) ground: Ground<'a>,
    pub(super) palette: Palette,
    /// For each triangle of the reference and level.
    pub(super) steepness: Vec<f32>,
    /// For each vertex the one at whose position it is.
    pub(super) place: &'a [u32],
}

impl Against<'_> {
    /// Measures `made`, whose image meets none but triangles of `near`, which are in growing order.
    pub(super) fn measured(&self, made: &Made, near: &[u32]) -> Measured {
        let t3 = made.corners.map(|v| self.ground.t3[v as usize]);
        let corners = made
            .corners
            .map(|v| self.ground.positions[self.place[v as usize] as usize]);
        let own = orientation(self.ground.line, &t3.map(|p| p.as_ivec3().to_array()));
        let same_side = near
            .iter()
            .copied()
            .filter(|&t| i32::from(self.ground.sense[t as usize]) == own);
        let mut searches = vec![Search::new(self.palette.distance.floor()); self.palette.levels];
        let plane = Plane::new(self.ground.line, t3, corners);
        let mut covers: Vec<u32> = match (&plane, self.ground.line) {
            (_, Line::Cylinder) => {
                let asked = Asked {
                    t3,
                    corners,
                    sense: own,
                    rims: 0,
                };
                self.over_cylinder(&asked, plane.as_ref(), same_side, &mut searches)
            }
            (Some(plane), _) => {
                let mut cells: Vec<Cell> = same_side
                    .filter_map(|t| cell(&self.ground, plane, corners, t))
                    .collect();
                cells.sort_by(|a, b| b.far.total_cmp(&a.far));
                self.over_cells(plane, &cells, &mut searches);
                cells.iter().map(|cell| cell.triangle).collect()
            }
            (None, _) => {
                self.unknown(&mut searches);
                same_side.collect()
            }
        };
        covers.sort_unstable();
        if !made.deviation.total.is_finite() {
            self.unknown(&mut searches);
        }
        let widest = self.palette.widest;
        let upper = |s: &Search| s.upper.max(s.lower).min(widest);
        Measured {
            product: self.product(&made.deviation, corners, &covers),
            covers,
            tangential: not_rising(searches.iter().map(upper).collect()),
            attained: not_rising(searches.iter().map(|s| s.lower).collect()),
        }
    }

    /// Nothing is known but how far any two colours are from each other.
    fn unknown(&self, searches: &mut [Search]) {
        let widest = self.palette.widest;
        searches.iter_mut().for_each(|s| s.settle(widest));
    }

    fn over_cells(&self, plane: &Plane, cells: &[Cell], searches: &mut [Search]) {
        let mut pieces = Vec::new();
        for cell in cells {
            let whole = cell.pieces(&self.ground, plane, &self.palette, &mut pieces);
            for piece in &pieces {
                self.over_piece(cell.triangle, piece, searches);
            }
            if !whole {
                let chart = Chart::Flat(plane);
                bound(&self.ground, &self.palette, &chart, cell, searches);
            }
        }
    }

    /// From the coarsest level on: a finer one has deviations at least as large.
    fn over_piece(&self, t: u32, piece: &Piece, searches: &mut [Search]) {
        let own = Linear::<DVec2>::through(self.palette.coordinates(t));
        let repeats = self.palette.shared(t, piece.shown);
        let mut there = piece.coordinates;
        // The same copy of a picture that is repeated.
        if let Some(repeats) = repeats {
            let middle = piece.polygon.middle();
            let p = there.of(&middle);
            let apart = (p.truncate() / p.z - own.of(&middle)).round();
            for k in (0..2).filter(|&k| repeats[k] && apart[k] != 0.0) {
                let by = |c: &mut DVec3| c[k] -= apart[k] * c.z;
                by(&mut there.at);
                there.along.iter_mut().for_each(by);
            }
        }
        let far = way(piece, &own, &there);
        for k in (0..searches.len()).rev() {
            if k + 1 < searches.len() {
                searches[k].lower = searches[k].lower.max(searches[k + 1].lower);
            }
            if self.palette.is_as_next(piece.shown, t, k) {
                continue;
            }
            let sides = [
                self.palette.side(t, t, k),
                self.palette.side(piece.shown, t, k),
            ];
            self.over_level(sides, piece, (&own, &there), far, &mut searches[k]);
        }
    }

    fn over_level(
        &self,
        sides: [Side<'_>; 2],
        piece: &Piece,
        (own, there): (&Linear<DVec2>, &Linear<DVec3>),
        far: DVec2,
        search: &mut Search,
    ) {
        if let (Side::Texels(field), true) = (sides[0], sides[0].is_smooth_with(&sides[1])) {
            let slope = field.whole.slope;
            let texels = DVec2::new(far.x * field.size[0] as f64, far.y * field.size[1] as f64);
            let upper = (texels.x * f64::from(slope[0]) + texels.y * f64::from(slope[1])) as f32;
            if upper <= search.enough() {
                search.settle(upper);
                return;
            }
        }
        let [(a, a_shift), (b, b_shift)] = sides.map(|side| side.scale());
        let polygon = piece.polygon.map(|r| {
            let (here, p) = (own.of(r), there.of(r));
            [
                here.x * a[0] - a_shift,
                here.y * a[1] - a_shift,
                p.x * b[0] - p.z * b_shift,
                p.y * b[1] - p.z * b_shift,
                p.z,
            ]
        });
        search.look_at(sides, polygon);
    }

    /// Along a cylinder's lines: cells are whole triangles, which is more than there is.
    fn over_cylinder(
        &self,
        asked: &Asked,
        plane: Option<&Plane>,
        near: impl Iterator<Item = u32>,
        searches: &mut [Search],
    ) -> Vec<u32> {
        let meets = |t: &u32| radial::cell(asked, self.ground.t3(*t), self.ground.positions(*t));
        let covers: Vec<u32> = near.filter(|t| meets(t).is_some()).collect();
        let Some(plane) = plane else {
            self.unknown(searches);
            return covers;
        };
        let chart = Chart::round(asked.t3);
        for &t in &covers {
            let feet = self.ground.positions(t).map(|p| plane.foot(p));
            let cell = Cell {
                triangle: t,
                polygon: whole(),
                far: 0.0,
                feet: Linear::<DVec3>::through(feet),
                images: [DVec3::ZERO; 3],
            };
            bound(&self.ground, &self.palette, &chart, &cell, searches);
        }
        covers
    }

    /// The normal part times the steepest colour of what the image meets and what lies within reach of it.
    fn product(&self, deviation: &Deviation, corners: [DVec3; 3], covers: &[u32]) -> Vec<f32> {
        let levels = self.palette.levels;
        let mut steepest = vec![0f32; levels];
        let mut take = |t: u32| {
            let own = &self.steepness[t as usize * levels..][..levels];
            steepest
                .iter_mut()
                .zip(own)
                .for_each(|(all, one)| *all = all.max(*one));
        };
        covers.iter().for_each(|&t| take(t));
        let reach = f64::from(deviation.total) + f64::from(deviation.normal);
        let mut beside: Vec<u32> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        let mut look = |t: u32, beside: &mut Vec<u32>| {
            for other in self.ground.beside[t as usize] {
                let new = other != NONE && covers.binary_search(&other).is_err();
                if new && seen.insert(other) && self.is_within(other, corners, reach) {
                    beside.push(other);
                }
            }
        };
        covers.iter().for_each(|&t| look(t, &mut beside));
        while let Some(t) = beside.pop() {
            take(t);
            look(t, &mut beside);
        }
        let product = |s: f32| {
            if s > 0.0 {
                (deviation.normal * s).next_up()
            } else {
                0.0
            }
        };
        steepest.into_iter().map(product).collect()
    }

    /// Whether a reference triangle may come within `reach` of a triangle in space.
    fn is_within(&self, t: u32, corners: [DVec3; 3], reach: f64) -> bool {
        let own = self.ground.positions(t);
        let middle = (own[0] + own[1] + own[2]) / 3.0;
        let radius = own.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        let from_middle = corners.map(|p| (p - middle).as_vec3().to_array());
        let distance = f64::from(nearest(from_middle).1.max(0.0)).sqrt();
        distance * (1.0 - 1e-4) <= reach + radius
    }
}

/// Each the largest of those from it on.
fn not_rising(mut levels: Vec<f32>) -> Vec<f32> {
    for k in (0..levels.len().saturating_sub(1)).rev() {
        levels[k] = levels[k].max(levels[k + 1]);
    }
    levels
}

/// How far apart a point's two places are in a picture, at most, along either axis.
fn way(piece: &Piece, own: &Linear<DVec2>, there: &Linear<DVec3>) -> DVec2 {
    let (mut far, mut weights) = (DVec2::ZERO, [f64::INFINITY, 0f64]);
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for r in piece.polygon.corners() {
        let p = there.of(r);
        let place = p.truncate() / p.z;
        far = far.max((place - own.of(r)).abs());
        (low, high) = (low.min(place), high.max(place));
        weights = [weights[0].min(p.z), weights[1].max(p.z)];
    }
    if weights[0] <= 0.0 {
        return DVec2::INFINITY;
    }
    // What weights move a mean of places: see `bound`.
    far + (high - low) * (0.25 * (weights[1] / weights[0] - 1.0))
}
