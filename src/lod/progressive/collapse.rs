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
const PIECE: usize = 8;

/// A plan is not made to the end where it comes to cost more than this many times the price of its round: it would seldom be
/// still right when its turn comes.
const DEAR: f64 = 2.0;

/// So few candidates are all planned to the end: the cheapest of them may set the price.
const FEW: usize = 32;

/// The work: the surface, candidates, what was done.
struct Work<'a> {
    surface: Surface<'a>,
    /// For each place what its collapse seems to cost, and once it is planned, what it costs; infinite where there is none.
    prices: Vec<f64>,
    plans: Vec<Option<Box<Plan>>>,
    /// With their numbers, which have gaps: some that were to be made did not hold.
    collapses: Vec<(u32, Collapse)>,
    numbers: u32,
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
    work.into_history()
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
            numbers: 0,
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
        self.make(ordered, least)
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
        let mut open: Vec<u32> = places.iter().copied().filter(unplanned).collect();
        // What lies side by side is planned one after the other: it is in the cache then.
        open.sort_unstable();
        let (surface, asked) = (&self.surface, (self.numbers, limit, DEAR * limit));
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

    /// Makes the collapses of places, of which none shares a face with another, but no more than lead to `least` triangles; the
    /// places whose surroundings changed. `ordered` tells their order in the history; they are made in that of memory, since
    /// of such collapses those that hold in one order do so in any.
    fn make(&mut self, mut ordered: Vec<(f64, u32)>, least: usize) -> Vec<u32> {
        self.plenty(&mut ordered, least);
        let before = self.numbers;
        self.numbers += ordered.len() as u32;
        let mut numbered: Vec<(u32, u32, f64)> = (before..)
            .zip(ordered)
            .map(|(number, (price, u))| (u, number, price))
            .collect();
        numbered.sort_unstable_by_key(|&(u, ..)| u);
        let mut dirty = Vec::new();
        for (u, number, price) in numbered {
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
            self.collapse(u, *plan, (number, price));
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

    /// Leaves of collapses in order only as many as take the surface down to `least` triangles.
    fn plenty(&self, ordered: &mut Vec<(f64, u32)>, least: usize) {
        let (mut left, mut needed) = (self.surface.live.count, 0);
        let lost = |plan: &Plan| plan.star.lost.len();
        for &(_, u) in ordered.iter() {
            if left <= least {
                break;
            }
            left -= self.plans[u as usize].as_deref().map_or(0, lost);
            needed += 1;
        }
        ordered.truncate(needed);
    }

    /// Whether a collapse is still what was planned: where the neighbour gained neighbours meanwhile the surface might close
    /// on itself.
    fn holds(&self, u: u32, plan: &Plan) -> bool {
        let live = &self.surface.live;
        let star = || live.star(&live.ring(u)?, plan.to);
        live.changed[plan.to as usize] <= plan.made || star().as_ref() == Some(&plan.star)
    }

    fn collapse(&mut self, u: u32, plan: Plan, (number, price): (u32, f64)) {
        let surface = &mut self.surface;
        let to = plan.to;
        surface
            .live
            .collapse([u, to], &plan.star, plan.turned(), number);
        surface.rims.renew(plan.rims);
        let gone = surface.quadrics[u as usize];
        surface.quadrics[to as usize] += &gone;
        let from = u;
        self.collapses.push((number, Collapse { from, to, price }));
    }

    /// What became of the surface: collapses in the order of their numbers, and numbered without gaps.
    fn into_history(mut self) -> Progressive {
        self.collapses.sort_unstable_by_key(|&(number, _)| number);
        let mut rank = vec![0; self.numbers as usize];
        let mut dearest = 0.0f64;
        for ((number, collapse), k) in self.collapses.iter_mut().zip(0..) {
            rank[*number as usize] = k;
            dearest = dearest.max(collapse.price);
            collapse.price = dearest;
        }
        let collapses = self.collapses.into_iter().map(|(_, collapse)| collapse);
        let mut history = self.surface.live.into_history(collapses.collect());
        for made in &mut history.triangles {
            for number in [&mut made.made, &mut made.gone].into_iter().flatten() {
                *number = rank[*number as usize];
            }
        }
        // Those that one collapse made stand in their order already.
        history.triangles.par_sort_by_key(|made| made.made);
        history
    }
}
