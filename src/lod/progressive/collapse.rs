//! Which collapses come when: rounds of the cheapest that do not meet.
//!
//! In: the surface as it is. Out: a history of collapses. In a round every place that may go has a candidate: the neighbour
//! where the quadric error is least. Of the cheapest of them those that share no triangle with a cheaper one are measured
//! exactly, and those that keep within the price are made. They do not touch each other, so they are measured on all cores,
//! and the history is shallow; the result does not depend on the cores.

use super::live::{Face, NEVER};
use super::plan::{Candidate, Plan, Surface, cheaper};
use super::{Collapse, Progressive};
use crate::lod::LodInput;
use rayon::prelude::*;
use std::collections::HashSet;

/// Of the candidates the share that a round considers.
const SHARE: usize = 4;

/// The work: the surface, candidates, what was done.
struct Work<'a> {
    surface: Surface<'a>,
    /// For each place.
    candidates: Vec<Option<Candidate>>,
    collapses: Vec<Collapse>,
    /// For each face the round that last considered it.
    taken: Vec<u32>,
    rounds: u32,
}

/// Simplifies until at most `least` triangles are left, or nothing may collapse.
pub(super) fn simplify(input: &LodInput<'_>, least: usize) -> Progressive {
    let mut work = Work::new(input);
    let mut dirty: Vec<u32> = (0..work.surface.live.round.len() as u32)
        .filter(|&u| !work.surface.live.round[u as usize].is_empty())
        .collect();
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
    fn new(input: &LodInput<'a>) -> Self {
        let surface = Surface::new(input);
        Work {
            candidates: vec![None; surface.live.round.len()],
            surface,
            collapses: Vec::new(),
            taken: Vec::new(),
            rounds: 0,
        }
    }

    /// Finds the candidates of `places` anew.
    fn look_at(&mut self, places: &[u32]) {
        let found: Vec<_> = places
            .par_iter()
            .map(|&u| self.surface.candidate(u))
            .collect();
        for (&u, candidate) in places.iter().zip(found) {
            self.candidates[u as usize] = candidate;
        }
    }

    /// Makes a round of collapses; the places whose surroundings changed.
    fn round(&mut self, least: usize) -> Vec<u32> {
        let Some((cheap, limit)) = self.cheapest() else {
            return Vec::new();
        };
        let apart = self.apart(&cheap);
        self.plan(&apart);
        let price = |u: u32| Some((self.candidates[u as usize].as_ref()?.price, u));
        let mut ordered: Vec<(f64, u32)> = apart.into_iter().filter_map(price).collect();
        ordered.sort_unstable_by(cheaper);
        // Where all turn out dearer than they seemed, the cheapest of them sets the price.
        let limit = ordered.first().map_or(limit, |first| first.0.max(limit));
        ordered.retain(|&(price, _)| price <= limit && price.is_finite());
        self.make(&ordered, least)
    }

    /// The cheapest candidates in order, and the price up to which they are that.
    fn cheapest(&self) -> Option<(Vec<u32>, f64)> {
        let price = |(u, c): (usize, &Option<Candidate>)| Some((c.as_ref()?.price, u as u32));
        let mut priced: Vec<(f64, u32)> = self
            .candidates
            .iter()
            .enumerate()
            .filter_map(price)
            .filter(|priced| priced.0.is_finite())
            .collect();
        let last = priced.len().checked_sub(1)? / SHARE;
        let (_, &mut (limit, _), _) = priced.select_nth_unstable_by(last, cheaper);
        priced.truncate(last + 1);
        priced.sort_unstable_by(cheaper);
        Some((priced.into_iter().map(|(_, u)| u).collect(), limit))
    }

    /// Of candidates in order those that share no face with an earlier one.
    fn apart(&mut self, ordered: &[u32]) -> Vec<u32> {
        self.taken.resize(self.surface.live.faces.len(), 0);
        self.rounds += 1;
        let (taken, now) = (&mut self.taken, self.rounds);
        let is_apart = |u: &u32| {
            let round = &self.surface.live.round[*u as usize];
            let free = round.iter().all(|&f| taken[f as usize] != now);
            if free {
                round.iter().for_each(|&f| taken[f as usize] = now);
            }
            free
        };
        ordered.iter().copied().filter(is_apart).collect()
    }

    /// Plans the candidates of `places` that are not planned yet.
    fn plan(&mut self, places: &[u32]) {
        let unplanned = |u: &u32| {
            let candidate = self.candidates[*u as usize].as_ref();
            candidate.is_some_and(|c| c.plan.is_none())
        };
        let places: Vec<u32> = places.iter().copied().filter(unplanned).collect();
        let plans: Vec<_> = places
            .par_iter()
            .map(|&u| self.surface.planned(u))
            .collect();
        for (&u, plan) in places.iter().zip(plans) {
            self.surface.known[u as usize] = plan.as_ref().map_or(0.0, |plan| plan.price);
            self.candidates[u as usize] = plan;
        }
    }

    /// Makes those of the candidates, in order, that meet no other of this round.
    fn make(&mut self, ordered: &[(f64, u32)], least: usize) -> Vec<u32> {
        let mut changed: HashSet<u32> = HashSet::new();
        for &(price, u) in ordered {
            if self.surface.live.count <= least {
                break;
            }
            let Some(candidate) = self.candidates[u as usize].take() else {
                continue;
            };
            changed.insert(u);
            let Some(plan) = candidate.plan else {
                continue;
            };
            // Where the neighbour gained neighbours meanwhile the surface might close on itself: it is looked at again.
            if self.surface.live.star(u, plan.to).as_ref() == Some(&plan.star) {
                self.collapse(u, plan, price, &mut changed);
            }
        }
        let mut changed: Vec<u32> = changed
            .into_iter()
            .filter(|&u| !self.surface.live.round[u as usize].is_empty())
            .collect();
        changed.sort_unstable();
        changed
    }

    fn collapse(&mut self, u: u32, plan: Plan, price: f64, changed: &mut HashSet<u32>) {
        let number = self.collapses.len() as u32;
        let Plan {
            to,
            star,
            measured,
            rims,
        } = plan;
        for &f in &self.surface.live.round[u as usize] {
            changed.extend(self.surface.live.places(f));
        }
        let layer = |&(f, _): &(u32, [u32; 3])| self.surface.live.faces[f as usize].layer;
        let layers: Vec<u8> = star.turned.iter().map(layer).collect();
        let turned = star.turned.iter().map(|(f, _)| f);
        for &f in star.lost.iter().chain(turned) {
            self.surface.live.remove(f, number);
        }
        for ((&(_, corners), measured), layer) in star.turned.iter().zip(measured).zip(layers) {
            self.surface.live.push(Face {
                corners,
                layer,
                deviation: measured.deviation,
                covers: measured.covers,
                made: number,
                gone: NEVER,
            });
        }
        self.surface.rims.renew(rims);
        let gone = self.surface.quadrics[u as usize];
        self.surface.quadrics[to as usize] += &gone;
        let dearest = self.collapses.last().map_or(0.0, |last| last.price);
        self.collapses.push(Collapse {
            from: u,
            to,
            price: dearest.max(price),
        });
    }
}
