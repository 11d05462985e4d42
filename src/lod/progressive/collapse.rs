//! Which collapses come when: rounds of the cheapest that do not meet.
//!
//! In: the surface as it is. Out: a history of collapses. In a round every place that may go has a candidate: the neighbour
//! where the quadric error is least. Of the cheapest of them those that share no triangle with a cheaper one are measured
//! exactly, and those that keep within the price are made. They do not touch each other, so they are measured on all cores,
//! and the history is shallow; the result does not depend on the cores.

use super::overlay::Scratch;
use super::plan::{Plan, Planned, Surface, cheaper};
use super::{Collapse, Cost, Progressive};
use crate::lod::LodInput;
use rayon::prelude::*;

/// Of the candidates the share that a round considers.
const SHARE: usize = 4;

/// Candidates that one processor plans at a time, at least: its scratch is filled anew for each such piece.
const PIECE: usize = 32;

/// A plan is not made to the end where it comes to cost more than this many times the price of its round: it would seldom be
/// still right when its turn comes.
const DEAR: f64 = 2.0;

/// So few candidates are all planned to the end: the cheapest of them may set the price.
const FEW: usize = 256;

/// The work: the surface, candidates, what was done.
struct Work<'a> {
    surface: Surface<'a>,
    /// For each place what its collapse seems to cost, and once it is planned, what it costs; infinite where there is none.
    prices: Vec<f64>,
    plans: Vec<Option<Box<Plan>>>,
    collapses: Vec<Collapse>,
    /// For each place the last round in which it or a neighbour was considered.
    taken: Vec<u32>,
    rounds: u32,
}

/// Simplifies until at most `least` triangles are left, or nothing may collapse.
pub(super) fn simplify(input: &LodInput<'_>, cost: Cost, least: usize) -> Progressive {
    let mut work = Work::new(input, cost);
    let mut dirty: Vec<u32> = (0..work.prices.len() as u32).collect();
    while work.surface.live.count > least {
        work.look_at(&dirty);
        dirty = work.round(least);
        if dirty.is_empty() {
            break;
        }
    }
    work.surface.live.history(work.collapses)
}

impl<'a> Work<'a> {
    fn new(input: &LodInput<'a>, cost: Cost) -> Self {
        let surface = Surface::new(input, cost);
        let places = surface.live.round.count();
        Work {
            surface,
            prices: vec![f64::INFINITY; places],
            plans: (0..places).map(|_| None).collect(),
            collapses: Vec::new(),
            taken: vec![0; places],
            rounds: 0,
        }
    }

    /// Estimates the candidates of `places` anew.
    fn look_at(&mut self, places: &[u32]) {
        let surface = &self.surface;
        let found: Vec<f64> = places.par_iter().map(|&u| surface.estimate(u)).collect();
        for (&u, price) in places.iter().zip(found) {
            self.prices[u as usize] = price;
            self.plans[u as usize] = None;
        }
    }

    /// Makes a round of collapses; the places whose surroundings changed.
    fn round(&mut self, least: usize) -> Vec<u32> {
        let Some((cheap, limit)) = self.cheapest() else {
            return Vec::new();
        };
        let apart = self.apart(&cheap);
        self.plan(&apart, limit);
        let price = |u: u32| (self.prices[u as usize], u);
        let mut ordered: Vec<(f64, u32)> = apart.into_iter().map(price).collect();
        ordered.sort_unstable_by(cheaper);
        // Where all turn out dearer than they seemed, the cheapest of them sets the price.
        let limit = ordered.first().map_or(limit, |first| first.0.max(limit));
        ordered.retain(|&(price, _)| price <= limit && price.is_finite());
        self.make(&ordered, least)
    }

    /// The cheapest candidates in order, and the price up to which they are that.
    fn cheapest(&self) -> Option<(Vec<u32>, f64)> {
        let priced = self.prices.iter().zip(0u32..);
        let mut priced: Vec<(f64, u32)> = priced
            .filter(|(price, _)| price.is_finite())
            .map(|(&price, u)| (price, u))
            .collect();
        let last = priced.len().checked_sub(1)? / SHARE;
        let (_, &mut (limit, _), _) = priced.select_nth_unstable_by(last, cheaper);
        priced.truncate(last + 1);
        priced.par_sort_unstable_by(cheaper);
        Some((priced.into_iter().map(|(_, u)| u).collect(), limit))
    }

    /// Of candidates in order those that share no face with an earlier one: they are no neighbours.
    fn apart(&mut self, ordered: &[u32]) -> Vec<u32> {
        self.rounds += 1;
        let (live, taken, now) = (&self.surface.live, &mut self.taken, self.rounds);
        let is_apart = |u: &u32| {
            let free = taken[*u as usize] != now;
            if free {
                let round = live.round.get(*u).iter();
                let places = round.flat_map(|&f| live.faces[f as usize].places);
                places.for_each(|p| taken[p as usize] = now);
            }
            free
        };
        ordered.iter().copied().filter(is_apart).collect()
    }

    /// Plans the candidates of `places` that are not planned yet. Of those that cost far more than `limit` it finds out no more, as
    /// long as there are others.
    fn plan(&mut self, places: &[u32], limit: f64) {
        let limit = if places.len() < FEW {
            f64::INFINITY
        } else {
            limit
        };
        let unplanned = |u: &u32| self.plans[*u as usize].is_none();
        let open: Vec<u32> = places.iter().copied().filter(unplanned).collect();
        let (surface, asked) = (
            &self.surface,
            (self.collapses.len() as u32, limit, DEAR * limit),
        );
        let planned = |scratch: &mut Scratch, &u: &u32| surface.planned(u, asked, scratch);
        let pieces = open.par_iter().with_min_len(PIECE);
        let plans: Vec<_> = pieces.map_init(Scratch::default, planned).collect();
        for (u, planned) in open.into_iter().map(|u| u as usize).zip(plans) {
            let (price, plan) = match planned {
                Planned::None => (f64::INFINITY, None),
                Planned::Dear(price) => (price, None),
                Planned::Whole(plan) => (plan.price, Some(plan)),
            };
            self.surface.known[u] = if price.is_finite() { price } else { 0.0 };
            self.prices[u] = price;
            self.plans[u] = plan;
        }
        if limit.is_finite() && places.iter().all(|&u| self.plans[u as usize].is_none()) {
            self.plan(places, f64::INFINITY);
        }
    }

    /// Makes the collapses of places, in order; the places whose surroundings changed.
    fn make(&mut self, ordered: &[(f64, u32)], least: usize) -> Vec<u32> {
        let before = self.collapses.len() as u32;
        let mut dirty = Vec::new();
        for &(price, u) in ordered {
            if self.surface.live.count <= least {
                break;
            }
            let Some(plan) = self.plans[u as usize].take() else {
                continue;
            };
            if !self.holds(u, &plan) {
                dirty.push(u);
                continue;
            }
            let live = &self.surface.live;
            let round = live.round.get(u).iter();
            let around = round.flat_map(|&f| live.faces[f as usize].places);
            let unseen = |&p: &u32| live.changed[p as usize] <= before;
            dirty.extend(around.filter(unseen));
            self.collapse(u, *plan, price);
        }
        let live = &self.surface.live;
        dirty.sort_unstable();
        dirty.dedup();
        for &u in dirty.iter().filter(|&&u| live.round.get(u).is_empty()) {
            self.prices[u as usize] = f64::INFINITY;
        }
        dirty.retain(|&u| !live.round.get(u).is_empty());
        dirty
    }

    /// Whether a collapse is still what was planned: where the neighbour gained neighbours meanwhile the surface might close
    /// on itself.
    fn holds(&self, u: u32, plan: &Plan) -> bool {
        let live = &self.surface.live;
        let star = || live.star(&live.ring(u)?, plan.to);
        live.changed[plan.to as usize] <= plan.made || star().as_ref() == Some(&plan.star)
    }

    fn collapse(&mut self, u: u32, plan: Plan, price: f64) {
        let surface = &mut self.surface;
        let (to, number) = (plan.to, self.collapses.len() as u32);
        surface
            .live
            .collapse([u, to], &plan.star, plan.turned(), number);
        surface.rims.renew(plan.rims);
        let gone = surface.quadrics[u as usize];
        surface.quadrics[to as usize] += &gone;
        let dearest = self.collapses.last().map_or(0.0, |last| last.price);
        self.collapses.push(Collapse {
            from: u,
            to,
            price: dearest.max(price),
        });
    }
}
