//! Where rays that lie close together begin: not at the root, but at the subtrees that reach into a box round all of them.
//!
//! In: a box. Out: a [`Bundle`] for every ray that lies in it. Subtrees outside of the box hold nothing that such a ray meets, so
//! the answers are those of a walk from the root. The box is widened by more than rounding and the margin of rays can take.

use super::wide::{IS_LEAF, Node};
use super::{Bvh, V3, largest};
use glam::Vec4;

/// Subtrees of a bundle, at most, as long as the first level has no more: four times as many boxes are tested at once.
const MOST: usize = 16;
/// How much the box is widened, in the largest coordinate of anything: 25 times the margin of rays.
const WIDER: f32 = 1e-4;

/// Subtrees in a box, four in a node.
pub(crate) struct Bundle {
    pub(super) nodes: Vec<Node>,
}

/// A subtree and its box.
struct Entry {
    low: V3,
    high: V3,
    child: u32,
}

impl Bvh {
    /// For rays of which every point lies between `low` and `high`.
    pub(crate) fn bundle(&self, low: V3, high: V3) -> Bundle {
        let reach = largest(low.into_iter().chain(high));
        let wider = WIDER * self.largest.max(reach);
        let (low, high) = (low.map(|c| c - wider), high.map(|c| c + wider));
        let inside =
            |entry: &Entry| (0..3).all(|k| entry.low[k] <= high[k] && entry.high[k] >= low[k]);
        let children = |at: u32| {
            let node = &self.nodes[at as usize];
            (0..4).map(|lane| entry(node, lane)).filter(inside)
        };
        let mut entries: Vec<Entry> = match self.nodes.is_empty() {
            true => Vec::new(),
            false => children(0).collect(),
        };
        while entries.iter().any(|e| e.child & IS_LEAF == 0) {
            let mut next = Vec::with_capacity(2 * MOST);
            for e in &entries {
                match e.child & IS_LEAF {
                    0 => next.extend(children(e.child)),
                    _ => next.push(Entry { ..*e }),
                }
            }
            if next.len() > MOST {
                break;
            }
            entries = next;
        }
        Bundle {
            nodes: entries.chunks(4).map(packed).collect(),
        }
    }
}

fn entry(node: &Node, lane: usize) -> Entry {
    Entry {
        low: node.low.map(|axis| axis[lane]),
        high: node.high.map(|axis| axis[lane]),
        child: node.child[lane],
    }
}

/// Up to four entries as a node; a place without one has a box that nothing meets.
fn packed(entries: &[Entry]) -> Node {
    let axis = |of: &dyn Fn(&Entry) -> f32, none: f32| {
        Vec4::from_array([0, 1, 2, 3].map(|lane| entries.get(lane).map_or(none, of)))
    };
    Node {
        low: [0, 1, 2].map(|k| axis(&|e| e.low[k], f32::INFINITY)),
        high: [0, 1, 2].map(|k| axis(&|e| e.high[k], f32::NEG_INFINITY)),
        child: [0, 1, 2, 3].map(|lane| entries.get(lane).map_or(0, |e| e.child)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Ray, Sides};
    use super::*;
    use crate::mesh::shapes;

    /// Rays of small boxes, from a bundle and from the root: the same hits, bit by bit.
    #[test]
    fn rays_of_a_bundle_meet_what_they_meet_from_the_root() {
        let ball = shapes::icosphere(5);
        let corners: Vec<[V3; 3]> = (0..ball.triangles.len()).map(|t| ball.corners(t)).collect();
        let tree = Bvh::new(&corners);
        let (mut asking, mut met, mut smaller) = (tree.asking(), 0, 0);
        let noise = |k: u32| {
            [0.731_f64, 0.377, 0.913].map(|s| ((f64::from(k) * s).fract() * 2.0 - 1.0) as f32)
        };
        for k in 0..400 {
            let middle = noise(k).map(|c| c * 1.1);
            let low = middle.map(|c| c - 0.06);
            let high = middle.map(|c| c + 0.06);
            let bundle = tree.bundle(low, high);
            smaller += usize::from(bundle.nodes.len() <= MOST / 4);
            for r in 0..40 {
                let [a, b] = [0, 1].map(|e| {
                    let n = noise(1000 + 80 * k + 2 * r + e);
                    [0, 1, 2].map(|i| middle[i] + 0.06 * n[i])
                });
                let ray = Ray {
                    begin: [0, 1, 2].map(|i| (a[i] + b[i]) * 0.5),
                    way: [0, 1, 2].map(|i| (b[i] - a[i]) * 0.5),
                    reach: 1.0,
                    sides: [Sides::Both, Sides::Front, Sides::Back][r as usize % 3],
                };
                let found = asking.first_of_both(ray, None);
                assert_eq!(asking.first_of_both(ray, Some(&bundle)), found);
                met += usize::from(found.is_some());
            }
        }
        assert!(met > 200 && smaller == 400, "{met} {smaller}");
    }

    /// The negative control: a box that a ray does not lie in loses what it meets.
    #[test]
    fn a_bundle_of_another_box_has_other_answers() {
        let ball = shapes::icosphere(4);
        let corners: Vec<[V3; 3]> = (0..ball.triangles.len()).map(|t| ball.corners(t)).collect();
        let tree = Bvh::new(&corners);
        let ray = Ray {
            begin: [0.0, 0.0, 2.0],
            way: [0.01, 0.02, -1.0],
            reach: 2.0,
            sides: Sides::Both,
        };
        let elsewhere = tree.bundle([0.8, -0.1, -0.1], [1.1, 0.1, 0.1]);
        assert!(tree.asking().first(ray).is_some());
        let met = |bundle: &Bundle| tree.asking().first_of_both(ray, Some(bundle)).is_some();
        assert!(!met(&elsewhere));
        let far = tree.bundle([9.0; 3], [10.0; 3]);
        assert!(far.nodes.is_empty() && !met(&far));
        assert!(Bvh::new(&[]).bundle([0.0; 3], [1.0; 3]).nodes.is_empty());
    }
}
