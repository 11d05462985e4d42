//! From many nearly flat pieces to few charts: neighbours are merged while the union can be laid flat within a bound.
//!
//! In: pieces of a [`Surface`], a way to flatten, a bound of the stretch. Out: charts with their maps, none of which turns a
//! triangle over or overlaps itself. In each round the pairs with the longest common border, for their size, are tried,
//! all at once since no chart is in two of them. What failed is not tried again until one of the two has changed. A piece
//! that cannot be laid flat itself is divided.

use super::chart::Chart;
use super::injective::fault;
use super::stretch::{Stretch, sums};
use super::surface::Surface;
use crate::mesh::NONE;
use glam::DVec2;
use rayon::prelude::*;
use std::collections::{BTreeSet, VecDeque};

/// A chart and its map.
#[derive(Clone, Debug)]
pub(crate) struct Flat {
    pub(crate) chart: Chart,
    /// For each local vertex its place in the plane; as large as the surface.
    pub(crate) places: Vec<DVec2>,
    pub(crate) stretch: Stretch,
}

/// How a chart is laid flat.
pub(crate) type Flatten = fn(&Chart) -> Option<Vec<DVec2>>;

/// How far maps may be from the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bound {
    /// Of [`Stretch::l2`] of a chart.
    pub(crate) l2: f64,
    /// Of [`Stretch::linf`].
    pub(crate) linf: f64,
}

impl Bound {
    fn holds(&self, stretch: &Stretch) -> bool {
        stretch.l2 <= self.l2 && stretch.linf <= self.linf
    }
}

/// Most rounds; each takes about as long as flattening the whole surface.
const ROUNDS: usize = 24;

/// Lays pieces flat and merges them. `piece` is [`NONE`] or below `count`.
pub(crate) fn charts(
    surface: &Surface,
    piece: &[u32],
    count: usize,
    flatten: Flatten,
    bound: Bound,
) -> Vec<Flat> {
    let mut groups = vec![vec![]; count];
    for (t, &p) in piece.iter().enumerate().filter(|(_, p)| **p != NONE) {
        groups[p as usize].push(t as u32);
    }
    let mut merging = Merging {
        surface,
        flatten,
        bound,
        charts: vec![],
        of: vec![NONE; piece.len()],
        failed: BTreeSet::new(),
    };
    let first: Vec<Vec<Flat>> = groups
        .into_par_iter()
        .map(|group| divided(surface, group, flatten))
        .collect();
    first
        .into_iter()
        .flatten()
        .for_each(|flat| merging.add(flat));
    for _ in 0..ROUNDS {
        if !merging.round() {
            break;
        }
    }
    let mut charts: Vec<Flat> = merging.charts.into_iter().flatten().collect();
    charts.sort_by_key(|flat| flat.chart.triangles[0]);
    charts
}

/// The charts laid flat by another method.
pub(crate) fn again(surface: &Surface, charts: Vec<Flat>, flatten: Flatten) -> Vec<Flat> {
    let other = |flat: Flat| divided(surface, flat.chart.triangles, flatten);
    let all: Vec<Vec<Flat>> = charts.into_par_iter().map(other).collect();
    all.into_iter().flatten().collect()
}

/// The triangles as a chart that is one-to-one, or as several.
pub(crate) fn divided(surface: &Surface, triangles: Vec<u32>, flatten: Flatten) -> Vec<Flat> {
    let mut out = vec![];
    let mut left = vec![triangles];
    while let Some(triangles) = left.pop() {
        match flat(surface, triangles, flatten) {
            Ok(flat) => out.push(flat),
            Err(triangles) if triangles.len() > 1 => {
                let (a, b) = halves(surface, &triangles);
                left.extend([a, b]);
            }
            // One triangle has a map, so this is one that rounding made none of.
            Err(_) => {}
        }
    }
    out
}

/// The triangles' map, where it is one-to-one.
fn flat(surface: &Surface, triangles: Vec<u32>, flatten: Flatten) -> Result<Flat, Vec<u32>> {
    let Some(chart) = Chart::new(surface, triangles.clone()) else {
        return Err(triangles);
    };
    match flatten(&chart).filter(|places| fault(&chart, places).is_none()) {
        Some(places) => {
            let stretch = sums(&chart, &places).stretch();
            Ok(Flat {
                chart,
                places,
                stretch,
            })
        }
        None => Err(triangles),
    }
}

/// Whether triangles can be laid flat as one chart within the bound.
pub(crate) fn within(surface: &Surface, triangles: &[u32], flatten: Flatten, bound: Bound) -> bool {
    flat(surface, triangles.to_vec(), flatten).is_ok_and(|flat| bound.holds(&flat.stretch))
}

/// Divides triangles (growing) in two halves that each hang together: what is nearer to one of two ends.
pub(crate) fn halves(surface: &Surface, triangles: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let last = |order: &[usize]| order.last().copied().unwrap_or(0);
    let reached = |from: &[usize]| {
        let mut side = vec![NONE; triangles.len()];
        let mut order = vec![];
        let mut queue: VecDeque<usize> = VecDeque::new();
        for (k, &start) in from.iter().enumerate() {
            side[start] = k as u32;
            queue.push_back(start);
        }
        while let Some(i) = queue.pop_front() {
            order.push(i);
            for h in 3 * triangles[i] as usize..3 * triangles[i] as usize + 3 {
                let next = surface
                    .neighbour(h)
                    .and_then(|t| triangles.binary_search(&(t as u32)).ok());
                if let Some(j) = next.filter(|&j| side[j] == NONE) {
                    side[j] = side[i];
                    queue.push_back(j);
                }
            }
        }
        (order, side)
    };
    let (order, _) = reached(&[0]);
    let one = last(&order);
    let (order, _) = reached(&[one]);
    let (_, side) = reached(&[one, last(&order)]);
    let of = |which: u32| {
        triangles
            .iter()
            .zip(&side)
            .filter(|(_, s)| **s == which)
            .map(|(t, _)| *t)
            .collect()
    };
    (of(0), of(1))
}

/// Two charts with a common border.
struct Pair {
    charts: [u32; 2],
    /// Length of the border over the smaller perimeter.
    closeness: f64,
}

struct Merging<'a> {
    surface: &'a Surface,
    flatten: Flatten,
    bound: Bound,
    charts: Vec<Option<Flat>>,
    /// For each triangle its chart.
    of: Vec<u32>,
    /// Pairs that were tried in vain.
    failed: BTreeSet<[u32; 2]>,
}

impl Merging<'_> {
    fn add(&mut self, flat: Flat) {
        let number = self.charts.len() as u32;
        flat.chart
            .triangles
            .iter()
            .for_each(|&t| self.of[t as usize] = number);
        self.charts.push(Some(flat));
    }

    /// Tries one set of pairs; false where there was nothing left to try.
    fn round(&mut self) -> bool {
        let pairs = self.pairs();
        let mut taken = vec![false; self.charts.len()];
        let mut tried: Vec<[u32; 2]> = vec![];
        for pair in &pairs {
            if pair.charts.iter().all(|&c| !taken[c as usize]) {
                pair.charts.iter().for_each(|&c| taken[c as usize] = true);
                tried.push(pair.charts);
            }
        }
        let unions: Vec<Option<Flat>> = tried.par_iter().map(|&pair| self.union(pair)).collect();
        for (pair, union) in tried.iter().zip(unions) {
            match union {
                Some(flat) => {
                    pair.iter().for_each(|&c| self.charts[c as usize] = None);
                    self.add(flat);
                }
                None => drop(self.failed.insert(*pair)),
            }
        }
        !tried.is_empty()
    }

    /// Pairs that have not failed, closest first.
    fn pairs(&self) -> Vec<Pair> {
        let mut borders: Vec<([u32; 2], f64)> = vec![];
        let mut perimeter = vec![0.0; self.charts.len()];
        for (t, &own) in self.of.iter().enumerate().filter(|(_, c)| **c != NONE) {
            for h in 3 * t..3 * t + 3 {
                let other = self.surface.neighbour(h).map_or(NONE, |n| self.of[n]);
                if other == own {
                    continue;
                }
                let length = self.surface.length(h);
                perimeter[own as usize] += length;
                if other != NONE && own < other {
                    borders.push(([own, other], length));
                }
            }
        }
        borders.sort_by_key(|border| border.0);
        let mut pairs: Vec<Pair> = borders
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|same| !self.failed.contains(&same[0].0))
            .map(|same| {
                let [a, b] = same[0].0;
                let common: f64 = same.iter().map(|s| s.1).sum();
                Pair {
                    charts: [a, b],
                    closeness: common / perimeter[a as usize].min(perimeter[b as usize]),
                }
            })
            .collect();
        pairs.sort_by(|a, b| {
            b.closeness
                .total_cmp(&a.closeness)
                .then(a.charts.cmp(&b.charts))
        });
        pairs
    }

    /// Both charts as one, where the bound allows.
    fn union(&self, pair: [u32; 2]) -> Option<Flat> {
        let [a, b] = pair.map(|c| self.charts[c as usize].as_ref());
        let mut triangles = [&a?.chart.triangles[..], &b?.chart.triangles[..]].concat();
        triangles.sort_unstable();
        let flat = flat(self.surface, triangles, self.flatten).ok()?;
        self.bound.holds(&flat.stretch).then_some(flat)
    }
}
