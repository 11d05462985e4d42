//! A closed surface without handles as a ring: without two poles, and with a line from one end to the other across which
//! angles go on by a whole turn.
//!
//! In: a [`Closed`] surface. Out: [`Annulus`]. Where a pole is the middle of a hole, its lid gets a ring of vertices of its own,
//! so that the hole's rim is free to lie as it likes. A pole that is a vertex of the surface must not have two neighbours
//! that an edge joins past it: what lies between would be squeezed into the end.

use crate::param::charts::ways::{Edge, Ways, ways};
use crate::param::spherical::closed::Closed;
use glam::DVec3;
use std::collections::HashMap;

/// Vertices tried for a pole, the farthest first.
const TRIED: usize = 64;

/// Width of the band inside of a hole's rim, as a share of the way to the middle.
const NARROW: f64 = 0.15;

/// A surface with two poles.
pub(super) struct Annulus {
    /// The surface, with lids; its own triangles come first.
    pub(super) closed: Closed,
    /// The poles: height grows from the first to the second.
    pub(super) poles: [u32; 2],
    /// The neighbours of each pole.
    pub(super) ends: [Vec<u32>; 2],
    /// Numbers of the triangles that no pole is a corner of.
    pub(super) sides: Vec<u32>,
    /// For each of them the corners that lie a turn further than their vertex.
    pub(super) further: Vec<[bool; 3]>,
}

impl Annulus {
    /// The ring of `closed`, or why there is none.
    pub(super) fn new(closed: &Closed) -> Result<Annulus, String> {
        let mut closed = closed.clone();
        let poles = poles(&mut closed)?;
        let rings = Rings::new(&closed.triangles, closed.places.len());
        let ends = poles.map(|pole| rings.of(pole));
        let at_pole = |t: &[u32; 3]| t.iter().any(|v| poles.contains(v));
        let sides: Vec<u32> = (0..closed.triangles.len() as u32)
            .filter(|&t| !at_pole(&closed.triangles[t as usize]))
            .collect();
        let corners: Vec<[u32; 3]> = sides
            .iter()
            .map(|&t| closed.triangles[t as usize])
            .collect();
        let way = way(&corners, closed.places.len(), &ends)
            .ok_or("its two ends have no side between them")?;
        let further = further(&corners, &way);
        Ok(Annulus {
            closed,
            poles,
            ends,
            sides,
            further,
        })
    }
}

/// The two poles; lids that have one get their ring.
fn poles(closed: &mut Closed) -> Result<[u32; 2], String> {
    let rings = Rings::new(&closed.triangles, closed.places.len());
    let middles = (0..closed.vertex.len() as u32).filter(|&v| closed.vertex[v as usize].is_none());
    let mut holes: Vec<(f64, u32)> = middles
        .map(|middle| (length(closed, &rings.of(middle)), middle))
        .collect();
    holes.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut chosen: Vec<u32> = holes.iter().take(2).map(|hole| hole.1).collect();
    let lids = chosen.clone();
    if chosen.is_empty() {
        chosen.push(far_vertex(closed, &rings, None)?);
    }
    if chosen.len() == 1 {
        chosen.push(far_vertex(closed, &rings, Some(chosen[0]))?);
    }
    for lid in lids {
        ring_inside(closed, lid, &rings.of(lid));
    }
    Ok([chosen[0], chosen[1]])
}

/// Length of a closed polygon.
fn length(closed: &Closed, ring: &[u32]) -> f64 {
    let place = |i: usize| closed.places[ring[i % ring.len()] as usize];
    (0..ring.len())
        .map(|i| place(i).distance(place(i + 1)))
        .sum()
}

/// A vertex far from `from` (from the one farthest from anything, without one) that can be a pole.
fn far_vertex(closed: &Closed, rings: &Rings, from: Option<u32>) -> Result<u32, String> {
    let first = match from {
        Some(v) => v,
        None => farthest(&distances(closed, 0))[0],
    };
    let taken: Vec<u32> = from.map_or(vec![], |v| rings.of(v));
    let can = |v: &&u32| {
        let ring = rings.of(**v);
        let own = closed.vertex[**v as usize].is_some();
        let apart =
            Some(**v) != from && !taken.contains(v) && ring.iter().all(|w| !taken.contains(w));
        own && apart && !rings.joined_past(**v, &ring)
    };
    let order = farthest(&distances(closed, first));
    let found = order.iter().take(TRIED).find(can);
    found
        .copied()
        .ok_or_else(|| "it has too few triangles for two ends".into())
}

/// Vertices, the farthest first.
fn farthest(distance: &[f64]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..distance.len() as u32)
        .filter(|&v| distance[v as usize].is_finite())
        .collect();
    let far = |v: &u32| distance[*v as usize];
    order.sort_by(|a, b| far(b).total_cmp(&far(a)).then(a.cmp(b)));
    order
}

/// Lengths of the shortest ways along edges.
fn distances(closed: &Closed, from: u32) -> Vec<f64> {
    let edges = edges(&closed.triangles, closed.places.len(), |a, b| {
        closed.places[a as usize].distance(closed.places[b as usize])
    });
    ways(closed.places.len(), [from], |v| {
        edges[v as usize].iter().copied()
    })
    .distance
}

/// The edges at each vertex.
fn edges(
    triangles: &[[u32; 3]],
    vertices: usize,
    length: impl Fn(u32, u32) -> f64,
) -> Vec<Vec<Edge>> {
    let mut edges: Vec<Vec<Edge>> = vec![vec![]; vertices];
    for t in triangles {
        for (from, to) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
            let (from, to) = (t[from], t[to]);
            edges[from as usize].push(Edge {
                to,
                length: length(from, to),
                number: 0,
            });
        }
    }
    edges
}

/// Which vertices follow each other about a vertex.
struct Rings {
    /// For each vertex pairs of neighbours (a, b) with a triangle (vertex, a, b).
    pairs: Vec<Vec<(u32, u32)>>,
}

impl Rings {
    fn new(triangles: &[[u32; 3]], vertices: usize) -> Rings {
        let mut pairs = vec![vec![]; vertices];
        for t in triangles {
            for k in 0..3 {
                pairs[t[k] as usize].push((t[(k + 1) % 3], t[(k + 2) % 3]));
            }
        }
        Rings { pairs }
    }

    /// The neighbours of `v`, counter-clockwise.
    fn of(&self, v: u32) -> Vec<u32> {
        let pairs = &self.pairs[v as usize];
        let mut ring: Vec<u32> = pairs.first().map(|p| p.0).into_iter().collect();
        while ring.len() < pairs.len() {
            let last = ring[ring.len() - 1];
            match pairs.iter().find(|p| p.0 == last) {
                Some(next) => ring.push(next.1),
                None => break,
            }
        }
        ring
    }

    /// Whether an edge that is none of its ring's joins two neighbours of `v`, or there are too few of them.
    fn joined_past(&self, v: u32, ring: &[u32]) -> bool {
        let n = ring.len();
        let beside = |i: usize, w: u32| w == ring[(i + 1) % n] || w == ring[(i + n - 1) % n];
        let joined = |i: usize| {
            let neighbours = self.pairs[ring[i] as usize].iter().map(|p| p.0);
            neighbours
                .filter(|&w| w != v)
                .any(|w| ring.contains(&w) && !beside(i, w))
        };
        n < 3 || (0..n).any(joined)
    }
}

/// Replaces the fan about `middle`, whose ring this is, by a band and a smaller fan.
fn ring_inside(closed: &mut Closed, middle: u32, ring: &[u32]) {
    let first = closed.places.len() as u32;
    let n = ring.len();
    let at = closed.places[middle as usize];
    let between = |v: &u32| closed.places[*v as usize].lerp(at, NARROW);
    let places: Vec<DVec3> = ring.iter().map(between).collect();
    closed.places.extend(places);
    closed.vertex.extend(std::iter::repeat_n(None, n));
    closed.triangles.retain(|t| !t.contains(&middle));
    for i in 0..n {
        let j = (i + 1) % n;
        let (a, b) = (ring[i], ring[j]);
        let (p, q) = (first + i as u32, first + j as u32);
        closed
            .triangles
            .extend([[p, a, b], [p, b, q], [middle, p, q]]);
    }
}

/// A way with the fewest edges from the one end to the other: it leaves the first at once, and ends where it meets the second.
fn way(corners: &[[u32; 3]], vertices: usize, ends: &[Vec<u32>; 2]) -> Option<Vec<u32>> {
    let edges = edges(corners, vertices, |_, _| 1.0);
    let Ways {
        distance, arrived, ..
    } = ways(vertices, ends[0].iter().copied(), |v| {
        edges[v as usize].iter().copied()
    });
    let near = |v: &&u32| distance[**v as usize];
    let last = ends[1].iter().min_by(|a, b| near(a).total_cmp(&near(b)))?;
    if !(distance[*last as usize].is_finite() && distance[*last as usize] > 0.0) {
        return None;
    }
    let mut way = vec![*last];
    while let Some((before, _)) = arrived[way[way.len() - 1] as usize] {
        way.push(before);
    }
    way.reverse();
    Some(way)
}

/// The corners left of the way at its vertices: there they lie a turn further.
fn further(corners: &[[u32; 3]], way: &[u32]) -> Vec<[bool; 3]> {
    let mut left: HashMap<(u32, u32), usize> = HashMap::with_capacity(3 * corners.len());
    for (t, c) in corners.iter().enumerate() {
        (0..3).for_each(|k| {
            left.insert((c[k], c[(k + 1) % 3]), t);
        });
    }
    let mut further = vec![[false; 3]; corners.len()];
    for (k, &v) in way.iter().enumerate() {
        let next = way.get(k + 1).copied();
        // From the side at which the way arrives round to that at which it leaves, or from there to the end of the surface.
        let mut at = match (k.checked_sub(1), next) {
            (Some(before), _) => left.get(&(way[before], v)).copied(),
            (None, Some(next)) => left.get(&(v, next)).copied(),
            (None, None) => None,
        };
        while let Some(t) = at {
            let i = corners[t].iter().position(|c| *c == v).unwrap_or(0);
            further[t][i] = true;
            let (following, before) = (corners[t][(i + 1) % 3], corners[t][(i + 2) % 3]);
            at = match k {
                0 => left.get(&(v, before)).copied(),
                _ if Some(following) == next => None,
                _ => left.get(&(following, v)).copied(),
            };
        }
    }
    further
}
