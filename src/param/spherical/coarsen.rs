//! From a closed surface down to a tetrahedron, one vertex at a time.
//!
//! In: a [`Closed`] surface. Out: the four vertices that are left, and every removal with the ring that the vertex had: undone in
//! the opposite order they build the surface again. A vertex goes by moving onto a neighbour; the surface stays a sphere
//! because the two have exactly two neighbours in common. Least distance from the planes that were there goes first
//! (quadrics of Garland and Heckbert), so that the coarse surface has the shape of the fine one.
//! Source: Praun, Hoppe, Spherical Parametrization and Remeshing (2003), section 4.

use super::closed::Closed;
use glam::{DMat3, DVec3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A vertex that was removed.
pub(super) struct Removal {
    pub(super) vertex: u32,
    /// Its neighbours, counter-clockwise; it moved onto the first.
    pub(super) ring: Vec<u32>,
}

/// What is left: four vertices, wound so that (0, 1, 2) is seen counter-clockwise from outside, with 3 behind it.
pub(super) struct Coarse {
    pub(super) last: [u32; 4],
    /// In the order they were made.
    pub(super) removals: Vec<Removal>,
}

/// Rings longer than this make thin triangles: their vertices go later.
const LONG_RING: usize = 8;
/// And those of rings longer than this not at all.
const LONGEST_RING: usize = 48;
/// Weight of an edge's length, squared, times area, beside the distance from planes.
const SHORT: f64 = 1e-4;

/// A sum of squared distances from planes, weighted by area.
#[derive(Clone, Copy, Default)]
struct Quadric {
    squares: DMat3,
    linear: DVec3,
    constant: f64,
    area: f64,
}

impl Quadric {
    fn plane([a, b, c]: [DVec3; 3]) -> Quadric {
        let double = (b - a).cross(c - a);
        let area = double.length();
        let n = if area > 0.0 {
            double / area
        } else {
            DVec3::ZERO
        };
        let d = -n.dot(a);
        let squares = DMat3::from_cols(n * n.x, n * n.y, n * n.z) * area;
        Quadric {
            squares,
            linear: n * (d * area),
            constant: d * d * area,
            area,
        }
    }

    fn add(&mut self, other: &Quadric) {
        self.squares += other.squares;
        self.linear += other.linear;
        self.constant += other.constant;
        self.area += other.area;
    }

    fn at(&self, p: DVec3) -> f64 {
        (p.dot(self.squares * p) + 2.0 * self.linear.dot(p) + self.constant).max(0.0)
    }
}

/// Removes vertices until four are left; none where that cannot be (no surface of genus 0).
pub(super) fn coarsen(closed: &Closed) -> Option<Coarse> {
    let mut coarsening = Coarsening::new(closed)?;
    let mut left = closed.places.len();
    while left > 4 {
        let (v, u) = coarsening.cheapest()?;
        coarsening.remove(v, u);
        left -= 1;
    }
    let alive: Vec<u32> = (0..closed.places.len() as u32)
        .filter(|&v| coarsening.alive[v as usize])
        .collect();
    let &[a, ..] = &alive[..] else { return None };
    let &[b, c, d] = &coarsening.rings[a as usize][..] else {
        return None;
    };
    // About a the ring b, c, d is counter-clockwise: so is the face a, b, c, with d behind it.
    Some(Coarse {
        last: [a, b, c, d],
        removals: coarsening.removals,
    })
}

struct Coarsening<'a> {
    places: &'a [DVec3],
    /// Neighbours of each vertex, counter-clockwise.
    rings: Vec<Vec<u32>>,
    alive: Vec<bool>,
    quadrics: Vec<Quadric>,
    stamps: Vec<u32>,
    /// Cost (bits), vertex, stamp, neighbour it would move onto.
    heap: BinaryHeap<Reverse<(u64, u32, u32, u32)>>,
    removals: Vec<Removal>,
}

impl<'a> Coarsening<'a> {
    fn new(closed: &'a Closed) -> Option<Self> {
        let count = closed.places.len();
        let mut quadrics = vec![Quadric::default(); count];
        for t in &closed.triangles {
            let plane = Quadric::plane(t.map(|v| closed.places[v as usize]));
            t.iter().for_each(|&v| quadrics[v as usize].add(&plane));
        }
        let mut coarsening = Coarsening {
            places: &closed.places,
            rings: rings(&closed.triangles, count)?,
            alive: vec![true; count],
            quadrics,
            stamps: vec![0; count],
            heap: BinaryHeap::new(),
            removals: Vec::with_capacity(count),
        };
        (0..count as u32).for_each(|v| coarsening.offer(v));
        Some(coarsening)
    }

    /// Puts the cheapest removal of `v` into the heap.
    fn offer(&mut self, v: u32) {
        let ring = &self.rings[v as usize];
        // It comes back when its ring is shorter; a hub of thousands would be looked at for every spoke.
        if ring.len() > LONGEST_RING {
            return;
        }
        let long = ring.len().saturating_sub(LONG_RING) as f64;
        let from = self.places[v as usize];
        let best = ring
            .iter()
            .filter(|&&u| self.removable(v, u))
            .map(|&u| {
                let onto = self.places[u as usize];
                let (p, q) = (&self.quadrics[v as usize], &self.quadrics[u as usize]);
                let short = SHORT * (p.area + q.area) * from.distance_squared(onto);
                ((p.at(onto) + q.at(onto) + short) * (1.0 + long * long), u)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        if let Some((cost, u)) = best {
            self.heap
                .push(Reverse((cost.to_bits(), v, self.stamps[v as usize], u)));
        }
    }

    /// Whether the surface stays a sphere: the two have two neighbours in common.
    fn removable(&self, v: u32, u: u32) -> bool {
        let others = &self.rings[u as usize];
        self.rings[v as usize]
            .iter()
            .filter(|w| others.contains(w))
            .count()
            == 2
    }

    fn cheapest(&mut self) -> Option<(u32, u32)> {
        while let Some(Reverse((_, v, stamp, u))) = self.heap.pop() {
            let current = self.alive[v as usize] && self.stamps[v as usize] == stamp;
            if current && self.alive[u as usize] && self.removable(v, u) {
                return Some((v, u));
            }
            if current {
                self.stamps[v as usize] += 1;
                self.offer(v);
            }
        }
        None
    }

    fn remove(&mut self, v: u32, u: u32) {
        let mut ring = std::mem::take(&mut self.rings[v as usize]);
        let at = ring.iter().position(|&w| w == u).unwrap_or(0);
        ring.rotate_left(at);
        let last = ring.len() - 1;
        for (k, &w) in ring.iter().enumerate().skip(1) {
            let of = &mut self.rings[w as usize];
            let Some(here) = of.iter().position(|&x| x == v) else {
                continue;
            };
            if k == 1 || k == last {
                of.remove(here);
            } else {
                of[here] = u;
            }
        }
        // About u, between the first and the last of the others, those between come in place of v.
        let of = &mut self.rings[u as usize];
        if let Some(here) = of.iter().position(|&x| x == v) {
            of.splice(here..=here, ring[2..last].iter().copied());
        }
        self.alive[v as usize] = false;
        let gone = self.quadrics[v as usize];
        self.quadrics[u as usize].add(&gone);
        for &w in &ring {
            self.stamps[w as usize] += 1;
            self.offer(w);
        }
        self.removals.push(Removal { vertex: v, ring });
    }
}

/// Neighbours of each vertex, counter-clockwise; none where they are not one ring.
pub(super) fn rings(triangles: &[[u32; 3]], count: usize) -> Option<Vec<Vec<u32>>> {
    let mut sides: Vec<(u32, u32, u32)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b, c), (b, c, a), (c, a, b)])
        .collect();
    sides.sort_unstable();
    let mut rings = vec![vec![]; count];
    for of_one in sides.chunk_by(|x, y| x.0 == y.0) {
        let after = |v: u32| {
            of_one
                .binary_search_by_key(&v, |side| side.1)
                .ok()
                .map(|i| of_one[i].2)
        };
        let ring = &mut rings[of_one[0].0 as usize];
        let start = of_one[0].1;
        let mut v = start;
        loop {
            ring.push(v);
            v = after(v)?;
            if v == start {
                break;
            }
            if ring.len() > of_one.len() {
                return None;
            }
        }
        if ring.len() != of_one.len() {
            return None;
        }
    }
    rings.iter().all(|ring| ring.len() >= 3).then_some(rings)
}
