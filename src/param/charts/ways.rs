//! Shortest ways along the edges of a graph (Dijkstra).
//!
//! In: where ways begin, the edges at each vertex. Out: [`Ways`]. Of equally short ways the one found first is kept, and what
//! is looked at first is decided by distance and number: the same on every run.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// An edge as its vertex sees it.
#[derive(Clone, Copy, Debug)]
pub(in crate::param) struct Edge {
    pub(in crate::param) to: u32,
    pub(in crate::param) length: f64,
    /// What the caller calls it.
    pub(in crate::param) number: u32,
}

/// Shortest ways from the nearest of some vertices.
pub(in crate::param) struct Ways {
    /// Length of the way to each vertex; infinite where none leads.
    pub(in crate::param) distance: Vec<f64>,
    /// The vertex before it, and the number of the edge from there; none where a way begins or none leads.
    pub(in crate::param) arrived: Vec<Option<(u32, u32)>>,
    /// Which of the sources the way begins at, by its place among them.
    pub(in crate::param) source: Vec<u32>,
}

/// Ways from the nearest of `sources` over `count` vertices with these edges.
pub(in crate::param) fn ways<E: Iterator<Item = Edge>>(
    count: usize,
    sources: impl IntoIterator<Item = u32>,
    edges: impl Fn(u32) -> E,
) -> Ways {
    let mut ways = Ways {
        distance: vec![f64::INFINITY; count],
        arrived: vec![None; count],
        source: vec![0; count],
    };
    let mut heap = BinaryHeap::new();
    for (k, v) in sources.into_iter().enumerate() {
        ways.distance[v as usize] = 0.0;
        ways.source[v as usize] = k as u32;
        heap.push(Reverse((0u64, v)));
    }
    while let Some(Reverse((bits, v))) = heap.pop() {
        let here = ways.distance[v as usize];
        if bits != here.to_bits() {
            continue;
        }
        for edge in edges(v) {
            let (to, far) = (edge.to as usize, here + edge.length);
            if far < ways.distance[to] {
                ways.distance[to] = far;
                ways.arrived[to] = Some((v, edge.number));
                ways.source[to] = ways.source[v as usize];
                // Lengths are not negative: their bits are in their order.
                heap.push(Reverse((far.to_bits(), edge.to)));
            }
        }
    }
    ways
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path 0 - 1 - 2 - 3 of lengths 1, 2, 4, a short cut of length 2.5 from 0 to 2, and 4 alone.
    fn edges(v: u32) -> impl Iterator<Item = Edge> {
        let all = [(0, 1, 1.0), (1, 2, 2.0), (2, 3, 4.0), (0, 2, 2.5)];
        (0..4u32).filter_map(move |number| {
            let (a, b, length) = all[number as usize];
            let to = if a == v { b } else { a };
            (a == v || b == v).then_some(Edge { to, length, number })
        })
    }

    #[test]
    fn ways_are_the_shortest() {
        let one = ways(5, [0], edges);
        assert_eq!(one.distance, [0.0, 1.0, 2.5, 6.5, f64::INFINITY]);
        assert_eq!(
            one.arrived,
            [None, Some((0, 0)), Some((0, 3)), Some((2, 2)), None]
        );
        let two = ways(5, [3, 0], edges);
        assert_eq!(two.distance[..4], [0.0, 1.0, 2.5, 0.0]);
        assert_eq!(two.source[..4], [1, 1, 1, 0]);
    }
}
