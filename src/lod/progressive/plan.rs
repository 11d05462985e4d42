//! What a collapse would do, and what that costs.
//!
//! In: the surface as it is, and a place. Out: its [`Candidate`]: a price that it seems to have, and when its turn comes a
//! [`Plan`]: the neighbour, the triangles that come to be, their deviation.
//!
//! The price is the larger of the root of the quadric error and the deviation of the triangles that come to be: geometry and
//! texture may each be displaced so far.

use super::live::{Fan, Live, Star};
use super::overlay::{Asked, Deviation, Overlay};
use super::quadric::Quadric;
use super::rim::{NewRim, Rims};
use crate::lod::LodInput;
use crate::param::projection::orientation;
use glam::DVec3;
use std::cmp::Ordering;

/// A triangle's normal turns by no more than the angle of this cosine (75 degrees) in one collapse.
const TURN: f64 = 0.25;

/// A collapse that may come.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    /// What it seems to cost, and once it is planned, what it costs; object units.
    pub(super) price: f64,
    pub(super) plan: Option<Plan>,
}

/// What a collapse would do, measured.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) to: u32,
    pub(super) star: Star,
    /// For each triangle that comes to be.
    pub(super) measured: Vec<Measured>,
    pub(super) rims: Vec<NewRim>,
}

#[derive(Clone, Debug)]
pub(super) struct Measured {
    pub(super) deviation: Deviation,
    /// Triangles of the reference that its image meets.
    pub(super) covers: Vec<u32>,
}

/// The surface and what is known of its places.
pub(super) struct Surface<'a> {
    overlay: Overlay<'a>,
    grid: Vec<[i32; 3]>,
    pub(super) live: Live,
    pub(super) quadrics: Vec<Quadric>,
    pub(super) rims: Rims,
    /// What each place's collapse cost when it was last planned. Deviations seldom fall as the surface gets coarser: a place
    /// whose surroundings changed is not planned again before its turn comes.
    pub(super) known: Vec<f64>,
}

/// The order of prices, and of places where prices are equal.
pub(super) fn cheaper(a: &(f64, u32), b: &(f64, u32)) -> Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

impl<'a> Surface<'a> {
    pub(super) fn new(input: &LodInput<'a>) -> Self {
        let overlay = Overlay::new(input.mesh, input.primary);
        let live = Live::new(input);
        let places = live.round.len();
        let mut surface = Surface {
            grid: overlay.t3.iter().map(|p| p.as_ivec3().to_array()).collect(),
            overlay,
            quadrics: vec![Quadric::default(); places],
            rims: Rims::default(),
            known: vec![0.0; places],
            live,
        };
        surface.weigh();
        surface
    }

    /// Where a vertex of the surface lies: where its place does.
    fn position(&self, v: u32) -> DVec3 {
        self.overlay.positions[self.live.place[v as usize] as usize]
    }

    /// The quadrics of all places: planes of triangles, and upright ones on rims and seams.
    fn weigh(&mut self) {
        for f in 0..self.live.faces.len() as u32 {
            let corners = self.live.faces[f as usize].corners;
            let at = corners.map(|v| self.position(v));
            let places = self.live.places(f);
            let plane = Quadric::of_triangle(at);
            places
                .iter()
                .for_each(|&u| self.quadrics[u as usize] += &plane);
            for k in 0..3 {
                let (i, j) = (k, (k + 1) % 3);
                if self.live.is_rim(f, [corners[i], corners[j]]) {
                    let edge = Quadric::of_edge([at[i], at[j]], at[(k + 2) % 3]);
                    self.quadrics[places[i] as usize] += &edge;
                    self.quadrics[places[j] as usize] += &edge;
                }
            }
        }
    }

    /// What the collapse of `u` seems to cost: the least quadric error at a neighbour, or what it cost before.
    pub(super) fn candidate(&self, u: u32) -> Option<Candidate> {
        let round = self.live.round[u as usize].iter();
        let around = round.flat_map(|&f| self.live.faces[f as usize].corners);
        let neighbours = around.filter(|&v| self.live.place[v as usize] != u);
        let error = |v: u32| self.quadrics[u as usize].error(self.position(v));
        let least = neighbours.map(error).min_by(f64::total_cmp)?;
        Some(Candidate {
            price: least.sqrt().max(self.known[u as usize]),
            plan: None,
        })
    }

    /// The best collapse of `u`, by quadric error, that keeps the surface whole and lying well; its price and what it does.
    pub(super) fn planned(&self, u: u32) -> Option<Candidate> {
        let (fan, onto) = self.live.fan(u);
        if fan == Fan::Broken {
            return None;
        }
        let error = |&v: &u32| (self.quadrics[u as usize].error(self.position(v)), v);
        let mut ordered: Vec<(f64, u32)> = onto.iter().map(error).collect();
        ordered.sort_unstable_by(cheaper);
        let (error, to, star) = ordered.into_iter().find_map(|(error, to)| {
            let star = self.live.star(u, to)?;
            let lies_well = |turned: &(u32, [u32; 3])| self.lies_well(turned);
            star.turned
                .iter()
                .all(lies_well)
                .then_some((error, to, star))
        })?;
        let rims = self.rims.renewed(&self.live, u, to, &star);
        let measured = self.measured(u, &star, &rims);
        let far = measured
            .iter()
            .map(|m| m.deviation.total)
            .fold(0.0, f32::max);
        Some(Candidate {
            price: error.sqrt().max(f64::from(far)),
            plan: Some(Plan {
                to,
                star,
                measured,
                rims,
            }),
        })
    }

    /// Whether a face still faces its projection lines and turns little in space when it gets new corners.
    fn lies_well(&self, &(f, corners): &(u32, [u32; 3])) -> bool {
        let before = self.live.faces[f as usize].corners;
        let senses = [before, corners].map(|corners| self.sense(corners));
        if senses[1] == 0 || (senses[0] != 0 && senses[0] != senses[1]) {
            return false;
        }
        let normal = |corners: [u32; 3]| {
            let [a, b, c] = corners.map(|v| self.position(v));
            (b - a).cross(c - a)
        };
        let (from, to) = (normal(before), normal(corners));
        to != DVec3::ZERO && from.dot(to) >= TURN * from.length() * to.length()
    }

    fn sense(&self, corners: [u32; 3]) -> i32 {
        orientation(self.overlay.line, &corners.map(|v| self.grid[v as usize]))
    }

    /// The triangles that a collapse of `u` makes, laid over the reference.
    fn measured(&self, u: u32, star: &Star, rims: &[NewRim]) -> Vec<Measured> {
        let vertex = |f: u32| self.live.vertex(f, u);
        let mut near: Vec<(Option<u32>, Vec<u32>)> = Vec::with_capacity(2);
        for &f in &self.live.round[u as usize] {
            let (side, covers) = (vertex(f), &self.live.faces[f as usize].covers);
            match near.iter_mut().find(|other| other.0 == side) {
                Some((_, all)) => all.extend(covers),
                None => near.push((side, covers.clone())),
            }
        }
        for (_, all) in &mut near {
            all.sort_unstable();
            all.dedup();
        }
        let laid_over = |&(f, corners): &(u32, [u32; 3])| {
            let side = vertex(f);
            let near = near.iter().find(|other| other.0 == side);
            let mut measured = self.laid_over(corners, near.map_or(&[], |near| &near.1));
            for rim in rims.iter().filter(|rim| rim.face == f) {
                self.leave_out(rim, corners, &mut measured.deviation);
            }
            measured
        };
        star.turned.iter().map(laid_over).collect()
    }

    /// What a rim's chord leaves out lies as far from the triangle as its vertices do from the chord.
    fn leave_out(&self, rim: &NewRim, corners: [u32; 3], deviation: &mut Deviation) {
        let [a, b] = rim.edge.map(|v| self.position(v));
        let along = b - a;
        for &place in &rim.without {
            let from = self.position(place) - a;
            let s = (from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
            deviation.include(from - along * s, corners.map(|v| self.position(v)));
        }
    }

    fn laid_over(&self, corners: [u32; 3], near: &[u32]) -> Measured {
        let asked = Asked {
            t3: corners.map(|v| self.overlay.t3[v as usize]),
            corners: corners.map(|v| self.position(v)),
            sense: self.sense(corners),
        };
        let mut covers = Vec::new();
        let deviation = self.overlay.deviation(&asked, near, &mut covers);
        covers.shrink_to_fit();
        Measured { deviation, covers }
    }
}
