//! Where a piece of surface is cut to become a disk.
//!
//! In: what lies across each half-edge, and lengths. Out: the same with cuts in it. A spanning tree over the triangles crosses
//! edges; cutting all others makes a disk, and dead ends of the cuts are closed again. Short cuts are what is left where the
//! tree avoids the shortest ways from the border: edges far from those are crossed first, the ways themselves last and the
//! longest of them before the others.
//! Source: cut graphs as in Gu, Gortler, Hoppe, Geometry Images (2002), section 3.1; the order as in Erickson, Whittlesey,
//! Greedy optimal homotopy and homology generators (2005).

use super::chart::{Vertices, next};
use super::ways::{Edge, Ways, ways};
use crate::mesh::NONE;
use std::collections::VecDeque;

/// Cuts edges of `across` until the piece is a disk; returns how many. `lengths` has one for each half-edge.
pub(super) fn cut_to_disk(across: &mut [u32], vertices: &Vertices, lengths: &[f64]) -> usize {
    let open = dead_ends_closed(across, vertices, not_crossed(across, vertices, lengths));
    let mut cuts = 0;
    for h in (0..across.len()).filter(|&h| open[h]) {
        let other = std::mem::replace(&mut across[h], NONE);
        across[other as usize] = NONE;
        cuts += 1;
    }
    cuts
}

/// The two ends of a half-edge.
fn ends(vertices: &Vertices, h: usize) -> [usize; 2] {
    [h, next(h as u32) as usize].map(|corner| vertices.of[corner] as usize)
}

/// Of each pair of half-edges that the spanning tree does not cross, the first.
fn not_crossed(across: &[u32], vertices: &Vertices, lengths: &[f64]) -> Vec<bool> {
    let Ways {
        distance, arrived, ..
    } = ways_from_border(across, vertices, lengths);
    let mut edges: Vec<(bool, u64, u32)> = vec![];
    for (h, &other) in across
        .iter()
        .enumerate()
        .filter(|&(h, o)| *o != NONE && h < *o as usize)
    {
        let [a, b] = ends(vertices, h);
        let on_a_way = [arrived[a], arrived[b]]
            .iter()
            .any(|way| way.is_some_and(|(_, by)| by == h as u32 || by == other));
        let far = if on_a_way {
            distance[a].max(distance[b])
        } else {
            distance[a] + distance[b] + lengths[h]
        };
        // Distances are not negative: their bits are in their order.
        edges.push((on_a_way, !far.to_bits(), h as u32));
    }
    edges.sort_unstable();
    let mut joined = crate::mesh::Union::new(across.len() / 3);
    let mut left = vec![false; across.len()];
    for (_, _, h) in edges {
        let (s, t) = (joined.root(h / 3), joined.root(across[h as usize] / 3));
        if s == t {
            left[h as usize] = true;
        } else {
            joined.join(s, t);
        }
    }
    left
}

/// For each vertex how far it is from the first border (from any vertex, of a closed surface), and the half-edge by which
/// the shortest way arrives.
fn ways_from_border(across: &[u32], vertices: &Vertices, lengths: &[f64]) -> Ways {
    let mut edges_at: Vec<Vec<u32>> = vec![vec![]; vertices.count];
    for h in 0..across.len() {
        ends(vertices, h)
            .iter()
            .for_each(|&v| edges_at[v].push(h as u32));
    }
    let sources = first_border(across, vertices).into_iter();
    ways(vertices.count, sources.map(|v| v as u32), |v| {
        let edge = move |&number: &u32| {
            let [a, b] = ends(vertices, number as usize);
            let to = if a == v as usize { b } else { a };
            Edge {
                to: to as u32,
                length: lengths[number as usize],
                number,
            }
        };
        edges_at[v as usize].iter().map(edge)
    })
}

/// Vertices of the border that the first open half-edge is on; vertex 0 where there is none.
fn first_border(across: &[u32], vertices: &Vertices) -> Vec<usize> {
    let mut to: Vec<Option<usize>> = vec![None; vertices.count];
    for h in (0..across.len()).filter(|&h| across[h] == NONE) {
        let [a, b] = ends(vertices, h);
        to[a] = Some(b);
    }
    let Some(start) = to.iter().position(Option::is_some) else {
        return vec![0];
    };
    let mut border = vec![start];
    let mut v = start;
    while let Some(after) = to[v].filter(|&after| after != start && border.len() <= vertices.count)
    {
        border.push(after);
        v = after;
    }
    border
}

/// Closes cuts that end in the middle of nothing, again and again.
fn dead_ends_closed(across: &[u32], vertices: &Vertices, mut open: Vec<bool>) -> Vec<bool> {
    // Cuts at each vertex; a border counts as two, which nothing mends.
    let mut degree = vec![0u32; vertices.count];
    let mut at: Vec<Vec<u32>> = vec![vec![]; vertices.count];
    let (mut border, mut cuts) = (false, 0usize);
    for h in 0..across.len() {
        if across[h] == NONE {
            ends(vertices, h).iter().for_each(|&v| degree[v] += 2);
            border = true;
        } else if open[h] {
            cuts += 1;
            for v in ends(vertices, h) {
                degree[v] += 1;
                at[v].push(h as u32);
            }
        }
    }
    let mut dead: VecDeque<usize> = (0..vertices.count).filter(|&v| degree[v] == 1).collect();
    while let Some(v) = dead.pop_front() {
        // A closed surface keeps a slit.
        if degree[v] != 1 || (!border && cuts <= 2) {
            continue;
        }
        if let Some(&h) = at[v].iter().find(|&&h| open[h as usize]) {
            open[h as usize] = false;
            cuts -= 1;
            for end in ends(vertices, h as usize) {
                degree[end] -= 1;
                if degree[end] == 1 {
                    dead.push_back(end);
                }
            }
        }
    }
    open
}
