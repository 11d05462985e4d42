//! The surface built up again on the sphere.
//!
//! In: a [`Closed`] surface and how it was taken apart. Out: for each vertex a point of the unit sphere. Each vertex comes back
//! inside of its ring, where all of the ring is seen the right way round, so that the map stays one-to-one all the way; the
//! more there are, the more all of them are moved to where the surface is stretched less.
//! Source: Praun, Hoppe, Spherical Parametrization and Remeshing (2003), section 4.

use super::closed::Closed;
use super::coarsen::{Coarse, Removal};
use super::place::{Side, better, inside};
use glam::DVec3;

/// All vertices are moved each time there are so many times more.
const GROWTH: f64 = 1.5;
/// Vertices moved in all at such a time, where there are few; at least [`SWEEPS`] times each.
const FEW: usize = 20_000;
const SWEEPS: usize = 4;

/// Squared lengths and areas are at least this share of the mean squared length about.
const LEAST: f64 = 1e-3;

/// Places of all vertices; none where rounding left no room.
pub(super) fn build(closed: &Closed, coarse: &Coarse) -> Option<Vec<DVec3>> {
    let mut building = Building::new(closed, coarse);
    let mut swept = 4usize;
    let mut there: Vec<u32> = coarse.last.to_vec();
    for removal in coarse.removals.iter().rev() {
        building.bring_back(removal)?;
        there.push(removal.vertex);
        if there.len() as f64 >= GROWTH * swept as f64 || there.len() == building.rings.len() {
            swept = there.len();
            for _ in 0..(FEW / swept).max(SWEEPS) {
                there.iter().for_each(|&v| building.improve(v));
            }
        }
    }
    Some(building.places)
}

struct Building<'a> {
    closed: &'a Closed,
    /// On the sphere.
    places: Vec<DVec3>,
    /// Neighbours of those that are there, counter-clockwise.
    rings: Vec<Vec<u32>>,
    /// Room for the sides of a ring.
    sides: Vec<Side>,
}

impl<'a> Building<'a> {
    fn new(closed: &'a Closed, coarse: &Coarse) -> Self {
        let count = closed.places.len();
        let [a, b, c, d] = coarse.last;
        let mut building = Building {
            closed,
            places: vec![DVec3::ZERO; count],
            rings: vec![vec![]; count],
            sides: vec![],
        };
        for (v, ring) in [
            (a, [b, c, d]),
            (b, [a, d, c]),
            (c, [a, b, d]),
            (d, [a, c, b]),
        ] {
            building.rings[v as usize] = ring.to_vec();
        }
        // A regular tetrahedron; about its first corner the others are counter-clockwise.
        let corners = [
            (1.0, 1.0, 1.0),
            (-1.0, -1.0, 1.0),
            (1.0, -1.0, -1.0),
            (-1.0, 1.0, -1.0),
        ];
        for (v, corner) in coarse.last.into_iter().zip(corners) {
            building.places[v as usize] = DVec3::from(corner).normalize();
        }
        building
    }

    fn bring_back(&mut self, removal: &Removal) -> Option<()> {
        let (v, ring) = (removal.vertex, &removal.ring);
        let (u, last) = (ring[0], ring.len() - 1);
        let place = |w: u32| self.places[w as usize];
        let sides: Vec<(DVec3, DVec3)> = (0..ring.len())
            .map(|k| (place(ring[k]), place(ring[(k + 1) % ring.len()])))
            .collect();
        let at = inside(&sides, place(u))?;
        self.places[v as usize] = at;
        // About u the ones between the first and the last make room for v.
        let of = &mut self.rings[u as usize];
        let first = of.iter().position(|&w| w == ring[1])?;
        of.rotate_left(first);
        of.splice(1..last - 1, [v]);
        for (k, &w) in ring.iter().enumerate().skip(1) {
            let of = &mut self.rings[w as usize];
            let here = of.iter().position(|&x| x == u)?;
            match k {
                // About the first the order is: second, v, u; about the last: u, v, the one before.
                1 => of.insert(here, v),
                _ if k == last => of.insert(here + 1, v),
                _ => of[here] = v,
            }
        }
        self.rings[v as usize] = ring.clone();
        self.improve(v);
        Some(())
    }

    /// Moves a vertex to a better place.
    fn improve(&mut self, v: u32) {
        let mut sides = std::mem::take(&mut self.sides);
        sides.clear();
        let ring = &self.rings[v as usize];
        let surface = |w: u32| self.closed.places[w as usize];
        let own = surface(v);
        for (k, &a) in ring.iter().enumerate() {
            let b = ring[(k + 1) % ring.len()];
            let (p, q) = (surface(a), surface(b));
            sides.push(Side {
                from: self.places[a as usize],
                to: self.places[b as usize],
                squares: [
                    p.distance_squared(q),
                    own.distance_squared(p),
                    own.distance_squared(q),
                ],
                area: 0.5 * (p - own).cross(q - own).length(),
            });
        }
        // A sliver on the surface would cost nothing on the sphere, whatever became of it there.
        let mean = sides.iter().map(|s| s.squares[1]).sum::<f64>() / sides.len() as f64;
        for side in &mut sides {
            side.squares = side.squares.map(|square| square.max(LEAST * mean));
            side.area = side.area.max(LEAST * mean);
        }
        self.places[v as usize] = better(self.places[v as usize], &sides);
        self.sides = sides;
    }
}
