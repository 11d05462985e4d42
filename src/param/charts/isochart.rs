//! Pieces of a surface by spectral analysis of its geodesic distances.
//!
//! In: a [`Surface`] and what says whether a piece can be laid flat well enough. Out: pieces. Distances along the surface from
//! some vertices far apart make a matrix whose first eigenvectors unfold the surface (Isomap, with landmarks); a piece that
//! cannot be laid flat is divided among the vertices at the ends of those eigenvectors that matter, as many as come before
//! the largest drop of the eigenvalues: a limb each, not a patch each. And so on with the parts.
//! Source: Zhou, Snyder, Guo, Shum, Iso-charts: Stretch-driven Mesh Parameterization using Spectral Analysis (2004),
//! sections 4 and 5; de Silva, Tenenbaum, Sparse multidimensional scaling using landmark points (2004).

use super::surface::Surface;
use super::ways::{Edge, Ways, ways};
use crate::mesh::NONE;

/// Vertices that distances are measured from.
const LANDMARKS: usize = 40;
/// Eigenvectors looked at.
const DIMENSIONS: usize = 8;
/// Ends closer than this share of the longest distance are one.
const NEAR: f64 = 0.15;

/// Divides `triangles` (which hang together, growing) until each piece is `good`; pieces of a single triangle are.
pub(super) fn pieces(
    surface: &Surface,
    triangles: Vec<u32>,
    good: &(impl Fn(&[u32]) -> bool + Sync),
) -> Vec<Vec<u32>> {
    let mut out = vec![];
    let mut left = vec![triangles];
    while let Some(triangles) = left.pop() {
        if triangles.len() < 2 || good(&triangles) {
            out.push(triangles);
        } else {
            left.extend(divided(surface, triangles));
        }
    }
    out.sort_unstable_by_key(|piece| piece[0]);
    out
}

/// The piece divided in two or more.
fn divided(surface: &Surface, triangles: Vec<u32>) -> Vec<Vec<u32>> {
    let graph = Graph::new(surface, &triangles);
    let ends = graph.ends();
    let label = graph.ways(&ends).source;
    let of = |t: usize| label[graph.corners[t][0] as usize];
    let mut groups = vec![vec![]; ends.len()];
    for t in 0..triangles.len() {
        groups[of(t) as usize].push(triangles[t]);
    }
    groups.retain(|group| !group.is_empty());
    let whole = groups.len() < 2;
    let mut parts: Vec<Vec<u32>> = groups
        .into_iter()
        .flat_map(|group| connected(surface, group))
        .collect();
    if whole && parts.len() < 2 {
        let (a, b) = super::merge::halves(surface, &triangles);
        parts = vec![a, b];
    }
    parts
}

/// Triangles (growing) as groups that hang together over edges.
pub(super) fn connected(surface: &Surface, triangles: Vec<u32>) -> Vec<Vec<u32>> {
    let mut group = vec![NONE; triangles.len()];
    let mut groups: Vec<Vec<u32>> = vec![];
    for start in 0..triangles.len() {
        if group[start] != NONE {
            continue;
        }
        let number = groups.len() as u32;
        let mut members = vec![];
        let mut stack = vec![start];
        group[start] = number;
        while let Some(i) = stack.pop() {
            members.push(triangles[i]);
            for h in 3 * triangles[i] as usize..3 * triangles[i] as usize + 3 {
                let next = surface
                    .neighbour(h)
                    .and_then(|t| triangles.binary_search(&(t as u32)).ok());
                if let Some(j) = next.filter(|&j| group[j] == NONE) {
                    group[j] = number;
                    stack.push(j);
                }
            }
        }
        members.sort_unstable();
        groups.push(members);
    }
    groups
}

/// Vertices of a piece and the edges between them.
struct Graph {
    /// Local vertices of each triangle.
    corners: Vec<[u32; 3]>,
    /// First edge of each vertex in `edges`, and the end.
    first: Vec<u32>,
    edges: Vec<(u32, f64)>,
}

impl Graph {
    fn new(surface: &Surface, triangles: &[u32]) -> Graph {
        let mut used: Vec<u32> = triangles
            .iter()
            .flat_map(|&t| surface.triangles[t as usize])
            .collect();
        used.sort_unstable();
        used.dedup();
        let local = |v: u32| used.binary_search(&v).unwrap_or(0) as u32;
        let corners: Vec<[u32; 3]> = triangles
            .iter()
            .map(|&t| surface.triangles[t as usize].map(local))
            .collect();
        let mut pairs: Vec<(u32, u32)> = vec![];
        for &[a, b, c] in &corners {
            pairs.extend([(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)]);
        }
        // Across an edge, too: ways along edges alone are up to a sixth too long.
        for (i, &t) in triangles.iter().enumerate() {
            for k in 0..3 {
                let h = 3 * t as usize + k;
                let other = surface
                    .neighbour(h)
                    .and_then(|n| triangles.binary_search(&(n as u32)).ok());
                if let Some(j) = other {
                    let across = corners[j][(surface.across[h] as usize + 2) % 3];
                    pairs.push((corners[i][(k + 2) % 3], across));
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let place = |v: u32| surface.places[used[v as usize] as usize];
        let mut first = vec![0u32; used.len() + 1];
        pairs.iter().for_each(|&(a, _)| first[a as usize + 1] += 1);
        for v in 0..used.len() {
            first[v + 1] += first[v];
        }
        Graph {
            corners,
            first,
            edges: pairs
                .iter()
                .map(|&(a, b)| (b, place(a).distance(place(b))))
                .collect(),
        }
    }

    fn count(&self) -> usize {
        self.first.len() - 1
    }

    /// Ways from the nearest of `sources`.
    fn ways(&self, sources: &[u32]) -> Ways {
        ways(self.count(), sources.iter().copied(), |v| {
            let all = self.first[v as usize] as usize..self.first[v as usize + 1] as usize;
            let edge = |(number, &(to, length)): (usize, &(u32, f64))| Edge {
                to,
                length,
                number: number as u32,
            };
            self.edges[all].iter().enumerate().map(edge)
        })
    }

    /// Vertices at the ends of the directions in which the piece unfolds; two at least, where it has two vertices.
    fn ends(&self) -> Vec<u32> {
        let (landmarks, rows) = self.landmarks();
        let longest = rows
            .iter()
            .flatten()
            .copied()
            .filter(|d| d.is_finite())
            .fold(0.0, f64::max);
        let spectrum = Spectrum::new(&landmarks, &rows);
        let mut ends: Vec<u32> = vec![];
        for axis in 0..spectrum.dimensions() {
            let along: Vec<f64> = (0..self.count())
                .map(|v| spectrum.coordinate(axis, &rows, v))
                .collect();
            let extreme = |better: fn(f64, f64) -> bool| {
                (1..along.len()).fold(0, |best, v| {
                    if better(along[v], along[best]) {
                        v
                    } else {
                        best
                    }
                }) as u32
            };
            for end in [extreme(|a, b| a > b), extreme(|a, b| a < b)] {
                if self.ways(&ends).distance[end as usize] > NEAR * longest {
                    ends.push(end);
                }
            }
        }
        ends
    }

    /// Vertices far from each other, and the distance of every vertex from each.
    fn landmarks(&self) -> (Vec<u32>, Vec<Vec<f64>>) {
        let mut landmarks = vec![];
        let mut rows: Vec<Vec<f64>> = vec![];
        let mut least = vec![f64::INFINITY; self.count()];
        let mut next = 0u32;
        while landmarks.len() < LANDMARKS.min(self.count()) {
            let row = self.ways(&[next]).distance;
            landmarks.push(next);
            least
                .iter_mut()
                .zip(&row)
                .for_each(|(least, d)| *least = least.min(*d));
            rows.push(row);
            let far =
                (1..least.len()).fold(0, |best, v| if least[v] > least[best] { v } else { best });
            if least[far] <= 0.0 {
                break;
            }
            next = far as u32;
        }
        (landmarks, rows)
    }
}

/// The first eigenvectors of landmarks' squared distances, centred.
struct Spectrum {
    /// Eigenvalues, falling, and their vectors.
    pairs: Vec<(f64, Vec<f64>)>,
    /// Mean squared distance of each landmark from the others.
    means: Vec<f64>,
}

impl Spectrum {
    fn new(landmarks: &[u32], rows: &[Vec<f64>]) -> Spectrum {
        let count = landmarks.len();
        let square = |i: usize, j: usize| {
            let d = rows[i][landmarks[j] as usize];
            if d.is_finite() { d * d } else { 0.0 }
        };
        let means: Vec<f64> = (0..count)
            .map(|i| (0..count).map(|j| square(i, j)).sum::<f64>() / count as f64)
            .collect();
        let mean = means.iter().sum::<f64>() / count.max(1) as f64;
        let centred = |i: usize, j: usize| {
            -0.5 * (0.5 * (square(i, j) + square(j, i)) - means[i] - means[j] + mean)
        };
        let mut pairs = vec![];
        let mut found: Vec<Vec<f64>> = vec![];
        for k in 0..DIMENSIONS.min(count) {
            // Power iteration, orthogonal to those before: the first few are all that is wanted.
            let mut vector: Vec<f64> = (0..count)
                .map(|i| ((i * (k + 2)) as f64 + 0.5).sin() + 0.1)
                .collect();
            let mut value = 0.0;
            for _ in 0..200 {
                for other in &found {
                    let along: f64 = vector.iter().zip(other).map(|(a, b)| a * b).sum();
                    vector
                        .iter_mut()
                        .zip(other)
                        .for_each(|(a, b)| *a -= along * b);
                }
                let next: Vec<f64> = (0..count)
                    .map(|i| (0..count).map(|j| centred(i, j) * vector[j]).sum())
                    .collect();
                let length = next.iter().map(|x| x * x).sum::<f64>().sqrt();
                if length.is_nan() || length <= 0.0 {
                    break;
                }
                value = next.iter().zip(&vector).map(|(a, b)| a * b).sum::<f64>()
                    / vector.iter().map(|x| x * x).sum::<f64>();
                vector = next.into_iter().map(|x| x / length).collect();
            }
            if value.is_nan() || value <= 0.0 {
                break;
            }
            found.push(vector.clone());
            pairs.push((value, vector));
        }
        Spectrum { pairs, means }
    }

    /// How many matter: those before the largest drop, two at least.
    fn dimensions(&self) -> usize {
        let drop = |k: usize| self.pairs[k - 1].0 / self.pairs[k].0.max(f64::MIN_POSITIVE);
        let gaps = 2..self.pairs.len();
        let best = gaps.fold(2, |best, k| {
            if k > 2 && drop(k) > drop(best) {
                k
            } else {
                best
            }
        });
        best.min(self.pairs.len())
    }

    /// The coordinate of vertex `v` along eigenvector `axis`, up to a constant and scale.
    fn coordinate(&self, axis: usize, rows: &[Vec<f64>], v: usize) -> f64 {
        let vector = &self.pairs[axis].1;
        -rows
            .iter()
            .zip(vector)
            .zip(&self.means)
            .map(|((row, e), mean)| e * (row[v] * row[v] - mean))
            .sum::<f64>()
    }
}
