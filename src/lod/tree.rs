//! Nearest points on a surface.
//!
//! In: triangles, each with a mark. Out: the point of a wanted triangle that is nearest to a given one.

use glam::Vec3;

/// Triangles in a leaf of the tree.
const LEAF: usize = 4;

/// A binary tree of boxes over triangles, as flat arrays; children follow their parent. Each triangle has a `mark`.
pub(super) struct Tree<M> {
    nodes: Vec<Node>,
    triangles: Vec<([Vec3; 3], M)>,
}

/// A box; `count` triangles from `first`, or, when `count` is 0, the next node and node `first` as children.
struct Node {
    low: Vec3,
    high: Vec3,
    first: u32,
    count: u32,
}

impl<M: Copy> Tree<M> {
    /// The tree of a surface, none without triangles; `mark` gives each triangle's.
    pub(super) fn new(
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        mark: impl Fn(usize) -> M,
    ) -> Option<Self> {
        let corners = |t: &[u32; 3]| t.map(|v| Vec3::from(positions[v as usize]));
        let mut triangles: Vec<_> = triangles
            .iter()
            .enumerate()
            .map(|(i, t)| (corners(t), mark(i)))
            .collect();
        let mut nodes = Vec::with_capacity(triangles.len() / 2 + 1);
        (!triangles.is_empty()).then(|| {
            split(&mut triangles, 0, &mut nodes);
            Tree { nodes, triangles }
        })
    }

    /// The nearest point of the triangles whose mark is `wanted`, and that mark; none within `limit`.
    pub(super) fn nearest(
        &self,
        point: Vec3,
        limit: f32,
        wanted: impl Fn(M) -> bool,
    ) -> Option<(Vec3, M)> {
        let (mut best, mut found) = (limit * limit, None);
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at];
            if box_distance(node, point) >= best {
                continue;
            }
            if node.count > 0 {
                let leaf = &self.triangles[node.first as usize..(node.first + node.count) as usize];
                for &(triangle, mark) in leaf.iter().filter(|(_, mark)| wanted(*mark)) {
                    let near = closest_point(&triangle, point);
                    let squared = near.distance_squared(point);
                    if squared < best {
                        (best, found) = (squared, Some((near, mark)));
                    }
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
        found
    }
}

/// Splits at the median of the longest side, so the depth is logarithmic whatever the triangles look like.
fn split<M>(triangles: &mut [([Vec3; 3], M)], first: usize, nodes: &mut Vec<Node>) {
    let points = || triangles.iter().flat_map(|(corners, _)| corners);
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
    let key = |(t, _): &([Vec3; 3], M)| t[0][axis] + t[1][axis] + t[2][axis];
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
pub(super) fn closest_point([a, b, c]: &[Vec3; 3], p: Vec3) -> Vec3 {
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
    use crate::mesh::shapes;

    #[test]
    fn the_tree_agrees_with_brute_force_over_the_wanted_triangles() {
        let mesh = shapes::icosphere(3);
        let corners = |t: &[u32; 3]| t.map(|v| Vec3::from(mesh.positions[v as usize]));
        let tree = Tree::new(&mesh.positions, &mesh.triangles, |t| t % 3).unwrap();
        for i in 0..500 {
            let t = i as f32;
            let p = Vec3::new(
                (t * 0.731).fract() * 3.0 - 1.5,
                (t * 0.377).fract() * 3.0 - 1.5,
                (t * 0.913).fract() * 3.0 - 1.5,
            );
            let brute = mesh
                .triangles
                .iter()
                .enumerate()
                .filter(|(t, _)| t % 3 != i % 3);
            let brute = brute
                .map(|(_, t)| closest_point(&corners(t), p).distance_squared(p))
                .fold(0.25, f32::min);
            let found = tree.nearest(p, 0.5, |mark| mark != i % 3);
            assert_eq!(found.is_some(), brute < 0.25);
            if let Some((near, mark)) = found {
                assert_eq!(near.distance_squared(p), brute);
                assert_ne!(mark, i % 3);
            }
        }
    }
}
