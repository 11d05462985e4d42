//! Angle and height of a ring's vertices: both harmonic, so that the map of the flat ring is nearly conformal.
//!
//! In: an [`Annulus`]. Out: [`Flat`]: angles in radians, which go on by a turn across the ring's line, and heights from 0 at
//! the one end to 1 at the other. Weights are cotangents, kept positive: no triangle of the flat ring is then turned over
//! (see [`super`]). Two sparse systems with one matrix each, symmetric and positive definite.

use super::annulus::Annulus;
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use std::f64::consts::TAU;

/// The least and the largest weight of an edge: cotangents of angles near 0 and over 90 degrees.
const WEIGHTS: [f64; 2] = [0.02, 50.0];

/// Places in the flat ring.
pub(super) struct Flat {
    /// Of vertices; of the poles 0.
    pub(super) angle: Vec<f64>,
    pub(super) height: Vec<f64>,
}

impl Flat {
    /// Angles of the corners of triangle `i` of the ring's sides.
    pub(super) fn angles(&self, ring: &Annulus, i: usize) -> [f64; 3] {
        let corners = ring.closed.triangles[ring.sides[i] as usize];
        [0, 1, 2].map(|k| self.angle[corners[k] as usize] + turns(ring.further[i][k]))
    }
}

fn turns(further: bool) -> f64 {
    if further { TAU } else { 0.0 }
}

/// Solves for both; none where the numbers do not allow it.
pub(super) fn solve(ring: &Annulus) -> Option<Flat> {
    let edges = edges(ring);
    let count = ring.closed.places.len();
    let mut height: Vec<Option<f64>> = vec![None; count];
    let mut angle: Vec<Option<f64>> = vec![None; count];
    ring.poles.iter().for_each(|&pole| {
        height[pole as usize] = Some(0.0);
        angle[pole as usize] = Some(0.0);
    });
    for (end, at) in ring.ends.iter().zip([0.0, 1.0]) {
        end.iter().for_each(|&v| height[v as usize] = Some(at));
    }
    angle[ring.ends[0][0] as usize] = Some(0.0);
    Some(Flat {
        angle: means(&edges, &angle, true)?,
        height: means(&edges, &height, false)?,
    })
}

/// An edge of the sides: from a to b the angle goes on by `turns` besides what they have.
#[derive(Clone, Copy)]
struct Joint {
    a: u32,
    b: u32,
    weight: f64,
    turns: f64,
}

/// Edges with their weights, in order.
fn edges(ring: &Annulus) -> Vec<Joint> {
    let mut halves: Vec<Joint> = Vec::with_capacity(ring.sides.len() * 3);
    for (t, further) in ring.sides.iter().zip(&ring.further) {
        let corners = ring.closed.triangles[*t as usize];
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let [p, q, r] = [k, i, j].map(|c| ring.closed.places[corners[c] as usize]);
            let (x, y) = (q - p, r - p);
            let cotangent = x.dot(y) / x.cross(y).length();
            let weight = if cotangent.is_nan() {
                0.0
            } else {
                0.5 * cotangent
            };
            let turns = turns(further[j]) - turns(further[i]);
            let (a, b) = (corners[i], corners[j]);
            halves.push(match a < b {
                true => Joint {
                    a,
                    b,
                    weight,
                    turns,
                },
                false => Joint {
                    a: b,
                    b: a,
                    weight,
                    turns: -turns,
                },
            });
        }
    }
    halves.sort_by_key(|half| (half.a, half.b));
    let [least, most] = WEIGHTS;
    let whole = halves
        .chunk_by(|x, y| (x.a, x.b) == (y.a, y.b))
        .map(|same| {
            let sum: f64 = same.iter().map(|half| half.weight.clamp(-most, most)).sum();
            Joint {
                weight: sum.clamp(least, most),
                ..same[0]
            }
        });
    whole.collect()
}

/// Values with every vertex that is not `known` the mean of its neighbours, across turns where `turning`.
fn means(edges: &[Joint], known: &[Option<f64>], turning: bool) -> Option<Vec<f64>> {
    let mut number = vec![usize::MAX; known.len()];
    let mut count = 0;
    for (v, _) in known
        .iter()
        .enumerate()
        .filter(|(_, value)| value.is_none())
    {
        number[v] = count;
        count += 1;
    }
    let mut values: Vec<f64> = known.iter().map(|value| value.unwrap_or(0.0)).collect();
    if count == 0 {
        return Some(values);
    }
    let mut diagonal = vec![0.0; count];
    let mut entries: Vec<Triplet<usize, usize, f64>> = Vec::with_capacity(edges.len() + count);
    let mut right: Mat<f64> = Mat::zeros(count, 1);
    for edge in edges {
        let jump = if turning { edge.turns } else { 0.0 };
        for (from, to, jump) in [(edge.a, edge.b, jump), (edge.b, edge.a, -jump)] {
            let row = number[from as usize];
            if row == usize::MAX {
                continue;
            }
            diagonal[row] += edge.weight;
            right[(row, 0)] += edge.weight * jump;
            match (known[to as usize], number[to as usize]) {
                (Some(value), _) => right[(row, 0)] += edge.weight * value,
                (None, column) if row > column => {
                    entries.push(Triplet::new(row, column, -edge.weight));
                }
                _ => {}
            }
        }
    }
    entries.extend(
        diagonal
            .iter()
            .enumerate()
            .map(|(i, d)| Triplet::new(i, i, *d)),
    );
    let matrix = SparseColMat::try_new_from_triplets(count, count, &entries).ok()?;
    matrix
        .sp_cholesky(Side::Lower)
        .ok()?
        .solve_in_place(&mut right);
    for (v, &row) in number
        .iter()
        .enumerate()
        .filter(|(_, row)| **row != usize::MAX)
    {
        values[v] = right[(row, 0)];
    }
    values.iter().all(|x| x.is_finite()).then_some(values)
}
