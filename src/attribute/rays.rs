//! Whether rays meet triangles.
//!
//! In: triangles. Out: [`Rays`], a binary tree of boxes over them, asked whether anything lies on a stretch of a ray. The
//! answer does not depend on the order of the triangles in the tree.

use super::arithmetic::{V3, cross3, dot3, sub3};

/// Triangles in a leaf.
const LEAF: usize = 4;

/// A tree of boxes over triangles, as flat arrays; a node's first child follows it.
pub(super) struct Rays {
    nodes: Vec<Node>,
    triangles: Vec<[V3; 3]>,
}

/// A box; `count` triangles from `first`, or, when `count` is 0, the next node and node `first` as children.
struct Node {
    low: V3,
    high: V3,
    first: u32,
    count: u32,
}

impl Rays {
    pub(super) fn new(mut triangles: Vec<[V3; 3]>) -> Self {
        let mut nodes = Vec::with_capacity(triangles.len() / 2 + 1);
        if !triangles.is_empty() {
            split(&mut triangles, 0, &mut nodes);
        }
        Rays { nodes, triangles }
    }

    /// The diagonal of the box round all triangles; 0 without any.
    pub(super) fn diagonal(&self) -> f32 {
        let root = self.nodes.first();
        root.map_or(0.0, |root| {
            let d = sub3(root.high, root.low);
            dot3(d, d).sqrt()
        })
    }

    /// Whether a triangle lies on the ray from `begin` along `way`, not farther than `reach` times its length. Either side
    /// of a triangle counts.
    pub(super) fn meets(&self, begin: V3, way: V3, reach: f32) -> bool {
        let inverse = way.map(|c| 1.0 / c);
        let mut stack = [0u32; 64];
        let mut left = usize::from(!self.nodes.is_empty());
        while left > 0 {
            left -= 1;
            let at = stack[left] as usize;
            let node = &self.nodes[at];
            if !crosses(node, begin, inverse, reach) {
                continue;
            }
            let first = node.first as usize;
            if node.count > 0 {
                let leaf = &self.triangles[first..first + node.count as usize];
                if leaf.iter().any(|t| hit(t, begin, way, reach)) {
                    return true;
                }
            } else {
                // Median splits: the depth is under 32, two pending nodes a level.
                stack[left] = node.first;
                stack[left + 1] = at as u32 + 1;
                left += 2;
            }
        }
        false
    }
}

/// Splits at the median of the longest side, so the depth is logarithmic whatever the triangles look like.
fn split(triangles: &mut [[V3; 3]], first: usize, nodes: &mut Vec<Node>) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for corner in triangles.iter().flatten() {
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(corner[k]), high[k].max(corner[k]));
        }
    }
    let at = nodes.len();
    let count = triangles.len() as u32;
    nodes.push(Node {
        low,
        high,
        first: first as u32,
        count,
    });
    if triangles.len() <= LEAF {
        return;
    }
    let side = sub3(high, low);
    let axis = (0..3).fold(0, |best, k| if side[k] > side[best] { k } else { best });
    let middle = triangles.len() / 2;
    let key = |t: &[V3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
    triangles.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
    let (left, right) = triangles.split_at_mut(middle);
    split(left, first, nodes);
    nodes[at].first = nodes.len() as u32;
    nodes[at].count = 0;
    split(right, first + middle, nodes);
}

/// Slabs; a direction of 0 along an axis has an infinite inverse, and 0 times that (on a face) is left out by min and max.
fn crosses(node: &Node, begin: V3, inverse: V3, reach: f32) -> bool {
    let (mut from, mut to) = (0.0f32, reach);
    for k in 0..3 {
        let a = (node.low[k] - begin[k]) * inverse[k];
        let b = (node.high[k] - begin[k]) * inverse[k];
        from = from.max(a.min(b));
        // Widened by two units in the last place, so that rounding loses no box (Ize 2013).
        to = to.min(a.max(b) * 1.000_000_3);
    }
    from <= to
}

/// Möller and Trumbore's test, both sides.
fn hit(t: &[V3; 3], begin: V3, way: V3, reach: f32) -> bool {
    let (e1, e2) = (sub3(t[1], t[0]), sub3(t[2], t[0]));
    let p = cross3(way, e2);
    let determinant = dot3(e1, p);
    if determinant == 0.0 {
        return false;
    }
    let s = sub3(begin, t[0]);
    let q = cross3(s, e1);
    let u = dot3(s, p) / determinant;
    let v = dot3(way, q) / determinant;
    let along = dot3(e2, q) / determinant;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && along > 0.0 && along <= reach
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn the_tree_agrees_with_asking_every_triangle() {
        let mesh = shapes::icosphere(3);
        let triangles: Vec<[V3; 3]> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        let rays = Rays::new(triangles.clone());
        let mut met = 0;
        for i in 0..2000 {
            let t = i as f32;
            let wave = |k: f32| (t * k).fract() * 4.0 - 2.0;
            let begin = [wave(0.731), wave(0.377), wave(0.913)];
            let mut way = [wave(0.291), wave(0.553), wave(0.187)];
            // Along an axis now and then: two directions are 0.
            if i % 7 == 0 {
                way = [0.0, way[1], 0.0];
            }
            let brute = triangles.iter().any(|t| hit(t, begin, way, 0.8));
            assert_eq!(rays.meets(begin, way, 0.8), brute, "{begin:?} {way:?}");
            met += u32::from(brute);
        }
        assert!((150..1900).contains(&met), "{met}");
        assert!(!Rays::new(vec![]).meets([0.0; 3], [1.0, 0.0, 0.0], 9.0));
    }
}
