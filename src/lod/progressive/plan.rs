//! What a collapse would do, and what that costs.
//!
//! In: the surface as it is, and a place. Out: the price that its collapse seems to have, and when its turn comes a [`Plan`]: the
//! neighbour, the triangles that come to be, their deviation.
//!
//! See [`Cost`] for what the price is.

use super::Cost;
use super::grounds::Grounds;
use super::live::{Live, Turned};
use super::overlay::{Asked, Deviation, Overlay, Scratch, rims_of};
use super::quadric::Quadric;
use super::rim::{NewRim, Rims};
use super::ring::{Ring, Star};
use crate::lod::LodInput;
use crate::param::projection::{Line, orientation};
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;
use std::cmp::Ordering;

/// A triangle's normal turns by no more than the angle of this cosine (75 degrees) in one collapse.
const TURN: f64 = 0.25;

/// What a collapse would do, measured.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// What it costs; object units.
    pub(super) price: f64,
    pub(super) to: u32,
    pub(super) star: Star,
    /// For each triangle that comes to be.
    measured: SmallVec<[Measured; 6]>,
    /// Triangles of the reference that their images meet, one after the other.
    covers: Vec<u32>,
    pub(super) rims: Vec<NewRim>,
    /// How many collapses there had been.
    pub(super) made: u32,
}

/// What a place's collapse turned out to be.
pub(super) enum Planned {
    /// There is none.
    None,
    /// It costs so much at least, more than was asked for.
    Dear(f64),
    Whole(Box<Plan>),
}

/// A collapse that may be.
struct Best {
    /// The root of its quadric error: a distance.
    error: f64,
    to: u32,
    star: Star,
    rims: Vec<NewRim>,
}

/// A triangle that comes to be.
#[derive(Clone, Copy, Debug)]
struct Measured {
    sense: i8,
    deviation: Deviation,
    /// Where in the plan's `covers` its own end.
    end: u32,
}

impl Plan {
    /// The triangles that come to be, in the order of the star's.
    pub(super) fn turned(&self) -> impl Iterator<Item = Turned<'_>> {
        let mut start = 0;
        self.measured.iter().map(move |measured| {
            let from = std::mem::replace(&mut start, measured.end as usize);
            Turned {
                sense: measured.sense,
                deviation: measured.deviation,
                covers: &self.covers[from..start],
            }
        })
    }
}

/// The surface and what is known of its places.
pub(super) struct Surface<'a> {
    overlay: Overlay<'a>,
    grid: Vec<[i32; 3]>,
    pub(super) live: Live,
    pub(super) quadrics: Vec<Quadric>,
    pub(super) rims: Rims,
    /// For each vertex whether it lies on a rim or seam.
    on_rim: Vec<bool>,
    /// None where there are no rims.
    grounds: Option<Grounds>,
    /// What prices are made of.
    cost: Cost,
    /// What each place's collapse cost when it was last planned. Deviations seldom fall as the surface gets coarser: a place
    /// whose surroundings changed is not planned again before its turn comes.
    pub(super) known: Vec<f64>,
}

/// The order of prices, and of places where prices are equal.
pub(super) fn cheaper(a: &(f64, u32), b: &(f64, u32)) -> Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

impl<'a> Surface<'a> {
    pub(super) fn new(input: &LodInput<'a>, cost: Cost) -> Self {
        let overlay = Overlay::new(input.mesh, input.primary);
        let live = Live::new(input, |t| overlay.sense[t]);
        let places = live.round.count();
        let mut surface = Surface {
            grid: overlay.t3.iter().map(|p| p.as_ivec3().to_array()).collect(),
            overlay,
            quadrics: Vec::new(),
            rims: Rims::default(),
            on_rim: live.on_rim(),
            grounds: None,
            cost,
            known: vec![0.0; places],
            live,
        };
        let quadrics = (0..places as u32).into_par_iter();
        surface.quadrics = quadrics.map(|u| surface.quadric(u)).collect();
        let is_open = surface.on_rim.contains(&true);
        surface.grounds = is_open.then(|| Grounds::new(&surface.overlay, input.primary.kind));
        surface
    }

    /// Where a vertex of the surface lies: where its place does.
    fn position(&self, v: u32) -> DVec3 {
        self.overlay.positions[self.live.place[v as usize] as usize]
    }

    fn positions(&self, places: [u32; 3]) -> [DVec3; 3] {
        places.map(|p| self.overlay.positions[p as usize])
    }

    /// The quadric of a place: planes of the triangles round it, and upright ones on rims and seams.
    fn quadric(&self, u: u32) -> Quadric {
        let mut quadric = Quadric::default();
        for &f in self.live.round.get(u) {
            let face = &self.live.faces[f as usize];
            let at = self.positions(face.places);
            quadric += &Quadric::of_triangle(at);
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                let ends = [i, j].map(|k| face.places[k]);
                let edge = [i, j].map(|k| face.corners[k]);
                if ends.contains(&u) && self.live.is_rim(f, edge) {
                    quadric += &Quadric::of_edge([at[i], at[j]], at[3 - i - j]);
                }
            }
        }
        quadric
    }

    /// What the collapse of `u` seems to cost: the least quadric error at a neighbour, or what it cost before. Infinite where
    /// there is none.
    pub(super) fn estimate(&self, u: u32) -> f64 {
        let quadric = &self.quadrics[u as usize];
        let (mut least, mut far) = (f64::INFINITY, 0.0f64);
        for &f in self.live.round.get(u) {
            let face = &self.live.faces[f as usize];
            far = far.max(self.priced(&face.deviation));
            // Each neighbour once: what comes before is next in the other face there, where there is one.
            let k = face.places.iter().position(|&p| p == u).unwrap_or(0);
            let ahead = 1 + usize::from(self.on_rim[face.corners[k] as usize]);
            for step in 1..=ahead {
                let place = face.places[(k + step) % 3];
                least = least.min(quadric.error(self.overlay.positions[place as usize]));
            }
        }
        least.sqrt().max(far).max(self.known[u as usize])
    }

    /// What a deviation adds to a price: what has no bound is never made.
    fn priced(&self, deviation: &Deviation) -> f64 {
        match self.cost {
            Cost::Quadric if deviation.total.is_finite() => 0.0,
            _ => f64::from(deviation.total),
        }
    }

    /// The best collapse of `u`, by quadric error, that keeps the surface whole and lying well. What costs more than `limit` is
    /// not measured to the end, and what seems to more than `seems` not at all. `made` tells how many collapses there have been.
    pub(super) fn planned(
        &self,
        u: u32,
        (made, seems, limit): (u32, f64, f64),
        scratch: &mut Scratch,
    ) -> Planned {
        let Some((ring, best)) = self.best(u) else {
            return Planned::None;
        };
        let (least, limit) = match self.cost {
            Cost::Displacement => (best.error.max(self.left_behind(&ring, &best.star)), limit),
            Cost::Quadric => (best.error, f64::INFINITY),
        };
        if least > seems {
            return Planned::Dear(least);
        }
        let mut plan = Box::new(Plan {
            price: least,
            to: best.to,
            measured: SmallVec::new(),
            covers: Vec::new(),
            rims: best.rims,
            star: best.star,
            made,
        });
        self.measure(&ring, &mut plan, limit, scratch);
        match plan.price > limit {
            true => Planned::Dear(plan.price),
            false => Planned::Whole(plan),
        }
    }

    /// The ring of `u`, and of its collapses that may be the one of least quadric error.
    fn best(&self, u: u32) -> Option<(Ring, Best)> {
        let ring = self.live.ring(u)?;
        let is_whole = ring.is_whole();
        let quadric = &self.quadrics[u as usize];
        let error = |v: u32| (quadric.error(self.overlay.positions[v as usize]), v);
        let mut ordered: SmallVec<[(f64, u32); 10]> = ring.onto().into_iter().map(error).collect();
        ordered.sort_unstable_by(cheaper);
        let best = ordered.into_iter().find_map(|(error, to)| {
            let star = self.live.star(&ring, to)?;
            let lies_well = |turned: &(u32, [u32; 3])| self.lies_well(turned);
            if !star.turned.iter().all(lies_well) {
                return None;
            }
            let rims = match is_whole {
                true => Vec::new(),
                false => self.rims.renewed(&self.live, u, to, &star),
            };
            let keeps_off = |rim: &NewRim| self.keeps_off_others(&ring, rim);
            rims.iter().all(keeps_off).then_some(Best {
                error: error.sqrt(),
                to,
                star,
                rims,
            })
        })?;
        Some((ring, best))
    }

    /// Whether the ground that a face gains by the chord of a rim is nobody's, or that of triangles it is measured against.
    fn keeps_off_others(&self, ring: &Ring, rim: &NewRim) -> bool {
        let spokes = || ring.spokes.iter();
        let own = spokes().find(|s| s.face == rim.face).map(|s| s.own);
        let (Some(grounds), Some(own)) = (&self.grounds, own) else {
            return true;
        };
        let [to, other] = rim.edge;
        let face = &self.live.faces[rim.face as usize];
        let turned = face.corners.map(|v| if v == own { to } else { v });
        // The face as it will be, and what it gains, its third corner where the rim was.
        let gained = turned.map(|v| if v == to || v == other { v } else { own });
        let sense = self.sense(gained);
        if sense == 0 || sense != self.sense(turned) {
            // The chord cuts off.
            return true;
        }
        let corners = gained.map(|v| self.grid[v as usize]);
        let same = || spokes().filter(|s| s.own == own);
        let is_known = |t: u32| same().any(|s| self.live.covers.get(s.face).contains(&t));
        !grounds.are_others(&self.overlay, &corners, is_known)
    }

    /// How far the place that goes lies from where it will be: no plan costs less.
    fn left_behind(&self, ring: &Ring, star: &Star) -> f64 {
        let spokes = ring.spokes.iter();
        let far = star.turned.iter().filter_map(|&(f, corners)| {
            let own = spokes.clone().find(|s| s.face == f)?.own;
            self.overlay.displaced(own, &self.asked(corners))
        });
        far.fold(0.0, f64::max)
    }

    fn asked(&self, corners: [u32; 3]) -> Asked {
        Asked {
            t3: corners.map(|v| self.overlay.t3[v as usize]),
            corners: corners.map(|v| self.position(v)),
            sense: i32::from(self.sense(corners)),
            rims: rims_of(corners, &self.on_rim),
        }
    }

    /// Whether a face still faces its projection lines and turns little in space when it gets new corners.
    fn lies_well(&self, &(f, corners): &(u32, [u32; 3])) -> bool {
        let before = &self.live.faces[f as usize];
        let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        let from = normal(self.positions(before.places));
        let to = normal(corners.map(|v| self.position(v)));
        let kept = from.dot(to) >= TURN * from.length() * to.length();
        if !kept || to == DVec3::ZERO {
            return false;
        }
        let sense = self.sense(corners);
        sense != 0 && (before.sense == 0 || before.sense == sense)
    }

    fn sense(&self, corners: [u32; 3]) -> i8 {
        let [a, b, c] = corners.map(|v| self.overlay.t3[v as usize]);
        let (value, sure) = match self.overlay.line {
            Line::Parallel => ((b - a).cross(c - a).z, 0.0),
            Line::Sphere => (a.dot(b.cross(c)), SURE),
            Line::Cylinder => (0.0, 0.0),
        };
        if value.abs() > sure {
            return value.signum() as i8;
        }
        let corners = corners.map(|v| self.grid[v as usize]);
        orientation(self.overlay.line, &corners) as i8
    }

    /// Lays the triangles that a plan makes over the reference, until its price comes to more than `limit`.
    fn measure(&self, ring: &Ring, plan: &mut Plan, limit: f64, scratch: &mut Scratch) {
        // Which side of a seam was gathered.
        let mut gathered = None;
        let at_first: usize = ring
            .spokes
            .iter()
            .map(|s| self.live.covers.get(s.face).len())
            .sum();
        plan.covers.reserve_exact(at_first);
        for &(f, corners) in &plan.star.turned {
            if plan.price > limit {
                return;
            }
            let own = |face: u32| ring.spokes.iter().find(|s| s.face == face).map(|s| s.own);
            let side = own(f);
            if gathered != side {
                let same = ring.spokes.iter().filter(|s| Some(s.own) == side);
                let covers = same.map(|s| self.live.covers.get(s.face));
                self.overlay.gather(scratch, covers);
                gathered = side;
            }
            let asked = self.asked(corners);
            let mut deviation = self
                .overlay
                .deviation(&asked, limit, scratch, &mut plan.covers);
            for rim in plan.rims.iter().filter(|rim| rim.face == f) {
                self.leave_out(rim, asked.corners, &mut deviation);
            }
            plan.price = plan.price.max(self.priced(&deviation));
            plan.measured.push(Measured {
                sense: asked.sense as i8,
                deviation,
                end: plan.covers.len() as u32,
            });
        }
    }

    /// What a rim's chord leaves out lies as far from the triangle as its vertices do from the chord.
    fn leave_out(&self, rim: &NewRim, corners: [DVec3; 3], deviation: &mut Deviation) {
        let [a, b] = rim.edge.map(|v| self.position(v));
        let along = b - a;
        for &place in &rim.without {
            let from = self.position(place) - a;
            let s = (from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
            deviation.include(from - along * s, corners);
        }
    }
}

/// Volumes of grid points that are larger than this have the sign that they have in f64: of the sum of products below 2^71 the
/// last steps round, each by less than 2^19.
const SURE: f64 = (1u64 << 24) as f64;
