//! The colour deviations of one simplified triangle.
//!
//! In: the triangle, and the triangles of the reference that its image may meet. Out: [`Measured`]: which it meets, and for every
//! level what its tangential part changes, at most, and the product of its normal part and the steepest colour near it.

use super::super::overlay::{Asked, rims_of};
use super::super::{Deviation, Made, radial};
use super::beyond;
use super::bound::Search;
use super::ground::{Ground, Plane};
use super::landing::{Cell, Linear, cell, whole};
use super::palette::Palette;
use super::round::Round;
use crate::mesh::NONE;
use crate::param::projection::{Line, nearest, orientation};
use glam::DVec3;

/// What was found.
#[derive(Clone, Debug, Default)]
pub(super) struct Measured {
    /// Triangles of the reference that its image meets, and those beyond its rims, which chords to come may take in again; in growing
    /// order.
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
                self.over_cylinder(&asked, plane.as_ref(), same_side.clone(), &mut searches)
            }
            (Some(plane), _) => {
                let mut cells: Vec<Cell> = same_side
                    .clone()
                    .filter_map(|t| cell(&self.ground, plane, corners, t))
                    .collect();
                cells.sort_by(|a, b| b.far.total_cmp(&a.far));
                self.over_cells(plane, &cells, &mut searches);
                cells.iter().map(|cell| cell.triangle).collect()
            }
            (None, _) => {
                self.unknown(&mut searches);
                same_side.clone().collect()
            }
        };
        covers.sort_unstable();
        let product = self.product(&made.deviation, corners, &covers);
        let rims = rims_of(made.corners, &self.ground.on_rim);
        covers.extend(same_side.filter(|&t| self.is_beyond(rims, t, t3, plane.as_ref())));
        covers.sort_unstable();
        covers.dedup();
        if !made.deviation.total.is_finite() {
            self.unknown(&mut searches);
        }
        let widest = self.palette.widest;
        let upper = |s: &Search| s.upper.max(s.lower).min(widest);
        Measured {
            product,
            covers,
            tangential: not_rising(searches.iter().map(upper).collect()),
            attained: not_rising(searches.iter().map(|s| s.lower).collect()),
        }
    }

    /// Whether a triangle of the reference lies all beyond one of the rims of a simplified one.
    fn is_beyond(&self, rims: u8, t: u32, t3: [DVec3; 3], plane: Option<&Plane>) -> bool {
        match (plane, self.ground.line) {
            _ if rims == 0 => false,
            (_, Line::Cylinder) => radial::is_beyond(t3, rims, self.ground.t3(t)),
            (Some(plane), _) => {
                let images = self.ground.images(plane, t);
                let all = |i: &usize| images.iter().all(|h| h[*i] < 0.0);
                (0..3).filter(|i| rims >> i & 1 != 0).any(|i| all(&i))
            }
            (None, _) => false,
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
                piece.of(&self.palette, cell.triangle).look(searches);
            }
            if !whole {
                beyond::bound(&self.ground, &self.palette, plane, cell, searches);
            }
        }
    }

    /// Along a cylinder's lines cells have curved sides: whole triangles are looked at, and what is outside is left out.
    fn over_cylinder(
        &self,
        asked: &Asked,
        plane: Option<&Plane>,
        near: impl Iterator<Item = u32>,
        searches: &mut [Search],
    ) -> Vec<u32> {
        let meets = |t: &u32| radial::meet(asked.t3, self.ground.t3(*t));
        let covers: Vec<u32> = near.filter(meets).collect();
        let Some(plane) = plane else {
            self.unknown(searches);
            return covers;
        };
        let round = Round::new(&self.ground, &self.palette, asked);
        // The farthest first: what cannot raise the bound after them is not looked at.
        let mut cells: Vec<Cell> = covers.iter().map(|&t| self.round_cell(plane, t)).collect();
        cells
            .iter_mut()
            .for_each(|cell| cell.far = round.displaced(cell));
        cells.sort_by(|a, b| b.far.total_cmp(&a.far));
        for cell in &cells {
            round.bound(cell, searches);
            for k in (1..searches.len()).rev() {
                searches[k - 1].reach(searches[k].lower);
            }
        }
        covers
    }

    fn round_cell(&self, plane: &Plane, t: u32) -> Cell {
        let positions = self.ground.positions(t);
        Cell {
            triangle: t,
            polygon: whole(),
            far: 0.0,
            feet: Linear::<DVec3>::through(positions.map(|p| plane.foot(p))),
            images: [DVec3::ZERO; 3],
        }
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
