//! The binary tree with four children a node, boxes and triangles in the order that four at a time are tested in.

use super::V3;
use super::split::{Branch, LEAF};
use glam::Vec4;

/// A child that is a leaf: the rest is the number of its pack.
pub(super) const IS_LEAF: u32 = 1 << 31;

/// Four boxes, an axis after the other, and what is in them. A place without a child has a box that nothing meets.
pub(super) struct Node {
    pub(super) low: [Vec4; 3],
    pub(super) high: [Vec4; 3],
    pub(super) child: [u32; 4],
}

/// Four triangles: corner, axis. A place without one repeats the first.
pub(super) struct Pack {
    pub(super) corner: [[Vec4; 3]; 3],
    pub(super) id: [u32; 4],
}

impl Pack {
    fn of(ids: &[u32], triangles: &[[V3; 3]]) -> Pack {
        let id = [0, 1, 2, 3].map(|lane| ids[if lane < ids.len() { lane } else { 0 }]);
        let at = |corner: usize, axis: usize| {
            Vec4::from_array(id.map(|t| triangles[t as usize][corner][axis]))
        };
        Pack {
            corner: [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| at(corner, axis))),
            id,
        }
    }

    /// The corners of one triangle.
    pub(super) fn lane(&self, lane: usize) -> [V3; 3] {
        self.corner.map(|axes| axes.map(|axis| axis[lane]))
    }
}

/// Nodes and leaves; the first node is the root. No nodes without triangles.
pub(super) fn collapse(root: Option<Branch>, triangles: &[[V3; 3]]) -> (Vec<Node>, Vec<Pack>) {
    let mut wide = Wide {
        nodes: Vec::with_capacity(triangles.len() / 6 + 1),
        packs: Vec::with_capacity(triangles.len() / 2 + 1),
        triangles,
    };
    if let Some(root) = root {
        wide.node(vec![root]);
    }
    (wide.nodes, wide.packs)
}

struct Wide<'a> {
    nodes: Vec<Node>,
    packs: Vec<Pack>,
    triangles: &'a [[V3; 3]],
}

impl Wide<'_> {
    /// Appends the node with these children, the largest forks replaced by theirs while there is room; its number.
    /// Recursion is as deep as the tree, which `split` bounds.
    fn node(&mut self, mut children: Vec<Branch>) -> u32 {
        while let Some(largest) = largest_fork(&children).filter(|_| children.len() < 4) {
            if let Branch::Fork(_, both) = children.swap_remove(largest) {
                children.extend(*both);
            }
        }
        let at = self.nodes.len();
        let place = |k: usize, of: fn(&Branch) -> V3, none: f32| {
            Vec4::from_array(
                [0, 1, 2, 3].map(|lane| children.get(lane).map_or(none, |child| of(child)[k])),
            )
        };
        self.nodes.push(Node {
            low: [0, 1, 2].map(|k| place(k, |c| c.around().low, f32::MAX)),
            high: [0, 1, 2].map(|k| place(k, |c| c.around().high, f32::MIN)),
            child: [0; 4],
        });
        for (lane, child) in children.into_iter().enumerate() {
            self.nodes[at].child[lane] = match child {
                Branch::Leaf(_, ids) => self.leaf(&ids),
                Branch::Fork(_, both) => self.node(Vec::from(*both)),
            };
        }
        at as u32
    }

    fn leaf(&mut self, ids: &[u32]) -> u32 {
        debug_assert!(ids.len() <= LEAF);
        self.packs.push(Pack::of(ids, self.triangles));
        (self.packs.len() - 1) as u32 | IS_LEAF
    }
}

fn largest_fork(children: &[Branch]) -> Option<usize> {
    let forks = (0..children.len()).filter(|&k| matches!(children[k], Branch::Fork(..)));
    forks.reduce(|best, k| {
        if children[k].around().area() > children[best].around().area() {
            k
        } else {
            best
        }
    })
}
