//! How far a level of detail lies from its reference, in object units.
//!
//! In: the triangles of both. Out: [`Deviation`]. Sampled both ways: every vertex of the reference to the nearest point
//! of the LoD, and every vertex, edge midpoint and centroid of the LoD to the nearest point of the reference. It is a
//! measurement, so the true distance can be a little larger between samples, but unlike the simplifier's own figure
//! it is a distance.

use glam::Vec3;
use rayon::prelude::*;

/// Triangles in a leaf of the tree.
const LEAF: usize = 4;

/// Distances between two surfaces, in the unit of their positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Largest distance found.
    pub max: f32,
    /// Root mean square over all samples of both directions.
    pub rms: f32,
}

/// A surface as positions and triangles.
pub type Surface<'a> = (&'a [[f32; 3]], &'a [[u32; 3]]);

/// The distance between `reference` and `lod`; zero where either has no triangles.
pub fn deviation(reference: Surface<'_>, lod: Surface<'_>) -> Deviation {
    let (Some(to_reference), Some(to_lod)) = (Tree::new(reference), Tree::new(lod)) else {
        return Deviation::default();
    };
    let squared = |tree: &Tree, points: Vec<Vec3>| -> (f32, f64, usize) {
        let count = points.len();
        let (max, sum) = points
            .into_par_iter()
            .map(|point| tree.squared_distance(point))
            .fold(
                || (0.0f32, 0.0f64),
                |(max, sum), d| (max.max(d), sum + f64::from(d)),
            )
            .reduce(|| (0.0, 0.0), |a, b| (a.0.max(b.0), a.1 + b.1));
        (max, sum, count)
    };
    let there = squared(&to_lod, reference_samples(reference));
    let back = squared(&to_reference, lod_samples(lod));
    let mean = (there.1 + back.1) / (there.2 + back.2).max(1) as f64;
    Deviation {
        max: there.0.max(back.0).sqrt(),
        rms: mean.sqrt() as f32,
    }
}

/// Vertices that a triangle uses; others are not part of the surface.
fn reference_samples((positions, triangles): Surface<'_>) -> Vec<Vec3> {
    let mut used = vec![false; positions.len()];
    triangles
        .iter()
        .flatten()
        .for_each(|&v| used[v as usize] = true);
    positions
        .iter()
        .zip(used)
        .filter(|(_, used)| *used)
        .map(|(&p, _)| Vec3::from(p))
        .collect()
}

fn lod_samples((positions, triangles): Surface<'_>) -> Vec<Vec3> {
    let corners = triangles
        .iter()
        .map(|t| t.map(|v| Vec3::from(positions[v as usize])));
    corners
        .flat_map(|[a, b, c]| {
            [
                a,
                b,
                c,
                (a + b) / 2.0,
                (b + c) / 2.0,
                (c + a) / 2.0,
                (a + b + c) / 3.0,
            ]
        })
        .collect()
}

/// A binary tree of boxes over triangles, as flat arrays; children follow their parent.
struct Tree {
    nodes: Vec<Node>,
    triangles: Vec<[Vec3; 3]>,
}

/// A box; `count` triangles from `first`, or, when `count` is 0, the next node and node `first` as children.
struct Node {
    low: Vec3,
    high: Vec3,
    first: u32,
    count: u32,
}

impl Tree {
    fn new((positions, triangles): Surface<'_>) -> Option<Self> {
        let mut triangles: Vec<[Vec3; 3]> = triangles
            .iter()
            .map(|t| t.map(|v| Vec3::from(positions[v as usize])))
            .collect();
        let mut nodes = Vec::with_capacity(triangles.len() / 2 + 1);
        (!triangles.is_empty()).then(|| {
            split(&mut triangles, 0, &mut nodes);
            Tree { nodes, triangles }
        })
    }

    fn squared_distance(&self, point: Vec3) -> f32 {
        let mut best = f32::INFINITY;
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at];
            if box_distance(node, point) >= best {
                continue;
            }
            if node.count > 0 {
                let leaf = &self.triangles[node.first as usize..(node.first + node.count) as usize];
                for triangle in leaf {
                    best = best.min(closest_point(triangle, point).distance_squared(point));
                }
                continue;
            }
            let (left, right) = (at + 1, node.first as usize);
            // The nearer child last, so that it is opened first.
            if box_distance(&self.nodes[left], point) < box_distance(&self.nodes[right], point) {
                stack.extend([right, left]);
            } else {
                stack.extend([left, right]);
            }
        }
        best
    }
}

/// Splits at the median of the longest side, so the depth is logarithmic whatever the triangles look like.
fn split(triangles: &mut [[Vec3; 3]], first: usize, nodes: &mut Vec<Node>) {
    let points = || triangles.iter().flatten();
    let low = points().fold(Vec3::INFINITY, |low, &p| low.min(p));
    let high = points().fold(Vec3::NEG_INFINITY, |high, &p| high.max(p));
    let at = nodes.len();
    nodes.push(Node {
        low,
        high,
        first: first as u32,
        count: triangles.len() as u32,
    });
    if triangles.len() <= LEAF {
        return;
    }
    let axis = (high - low).max_position();
    let middle = triangles.len() / 2;
    let key = |t: &[Vec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
    triangles.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
    let (left, right) = triangles.split_at_mut(middle);
    split(left, first, nodes);
    nodes[at].first = nodes.len() as u32;
    nodes[at].count = 0;
    split(right, first + middle, nodes);
}

fn box_distance(node: &Node, point: Vec3) -> f32 {
    point.distance_squared(point.clamp(node.low, node.high))
}

/// The point of a triangle closest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
fn closest_point([a, b, c]: &[Vec3; 3], p: Vec3) -> Vec3 {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    // A triangle without area reaches this only by rounding; any of its points is then as close as can be told.
    let sum = va + vb + vc;
    if sum > 0.0 {
        a + ab * (vb / sum) + ac * (vc / sum)
    } else {
        *a
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f32; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    const HALVES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    /// A bumpy grid of `n` by `n` squares over the unit square.
    fn sheet(n: u32, height: impl Fn(f32, f32) -> f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let at = |i: u32| i as f32 / n as f32;
        let grid = |i: u32| (at(i % (n + 1)), at(i / (n + 1)));
        let positions = (0..(n + 1) * (n + 1))
            .map(grid)
            .map(|(x, y)| [x, y, height(x, y)])
            .collect();
        let corner = |i: u32| i / n * (n + 1) + i % n;
        let squares = (0..n * n).map(corner);
        (
            positions,
            squares
                .flat_map(|i| [[i, i + 1, i + n + 2], [i, i + n + 2, i + n + 1]])
                .collect(),
        )
    }

    #[test]
    fn a_surface_is_at_no_distance_from_itself_and_a_shift_is_its_length() {
        assert!(deviation((&SQUARE, &HALVES), (&SQUARE, &HALVES)).max < 1e-6);
        let lifted = SQUARE.map(|[x, y, _]| [x, y, 0.25]);
        let d = deviation((&SQUARE, &HALVES), (&lifted, &HALVES));
        assert!(
            (d.max - 0.25).abs() < 1e-6 && (d.rms - 0.25).abs() < 1e-6,
            "{d:?}"
        );
    }

    #[test]
    fn what_only_one_of_the_two_has_is_seen_from_either_side() {
        let (bumpy, triangles) = sheet(16, |x, y| if x == 0.5 && y == 0.5 { 0.3 } else { 0.0 });
        let (there, back) = (
            deviation((&bumpy, &triangles), (&SQUARE, &HALVES)),
            deviation((&SQUARE, &HALVES), (&bumpy, &triangles)),
        );
        assert!(
            (there.max - 0.3).abs() < 1e-6 && (back.max - 0.3).abs() < 1e-6,
            "{there:?} {back:?}"
        );
    }

    #[test]
    fn the_tree_agrees_with_brute_force() {
        let (positions, triangles) = sheet(13, |x, y| (9.0 * x).sin() * (7.0 * y).cos() * 0.2);
        let tree = Tree::new((&positions, &triangles)).unwrap();
        for i in 0..500 {
            let t = i as f32;
            let p = Vec3::new(
                (t * 0.731).fract() * 2.0 - 0.5,
                (t * 0.377).fract() * 2.0 - 0.5,
                (t * 0.913).fract() - 0.5,
            );
            let all = triangles
                .iter()
                .map(|t| t.map(|v| Vec3::from(positions[v as usize])));
            let brute = all
                .map(|t| closest_point(&t, p).distance_squared(p))
                .fold(f32::INFINITY, f32::min);
            assert_eq!(tree.squared_distance(p), brute);
        }
    }

    #[test]
    fn triangles_without_area_and_empty_surfaces_are_no_trouble() {
        let line = [[0, 1, 1], [2, 2, 2]];
        assert!(
            deviation((&SQUARE, &line), (&SQUARE, &HALVES))
                .max
                .is_finite()
        );
        assert_eq!(
            deviation((&SQUARE, &[]), (&SQUARE, &HALVES)),
            Deviation::default()
        );
    }
}
