//! A tree of boxes over triangles: closest points and rays, for everything that asks where another surface is.
//!
//! In: triangles. Out: [`Bvh`], asked through [`Asking`], which keeps the memory of a walk between questions.
//!
//! The answers are those of asking every triangle, to the bit, and do not depend on the tree: equal distances go to the
//! lowest triangle. That holds because boxes and triangles are measured by the same monotone arithmetic: a closest point
//! is brought into its triangle's box before its distance is taken, a hit counts where its distance lies within the
//! ray's stretch through that box. Rounding can make neither nearer than the boxes round it. Everything is `+ - * /` on
//! `f32`, nothing contracted.
//!
//! ```text
//! split.rs  binned surface area heuristic, on all cores -> wide.rs  four boxes a node, four triangles a leaf
//! bundle.rs where rays of one bundle begin
//! walk.rs   first hit, both halves of a line -> ray.rs     watertight (Woop et al. 2013)
//! closest.rs  closest point (Ericson 2005, 5.1.5)
//! ```

mod bundle;
mod closest;
mod ray;
mod split;
#[cfg(test)]
mod tests;
mod walk;
mod wide;

pub(crate) use bundle::Bundle;
pub(crate) use ray::{Ray, Sides};
use wide::{Node, Pack};

/// A point or a direction.
type V3 = [f32; 3];

/// The tree. Four children a node, up to four triangles a leaf.
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    packs: Vec<Pack>,
    /// The box round all triangles; its low corner is above its high one where there are none.
    low: V3,
    high: V3,
    /// The largest coordinate of any corner.
    largest: f32,
}

/// A point of the triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    /// Number of the triangle.
    pub(crate) triangle: u32,
    /// Barycentrics there.
    pub(crate) b: [f32; 3],
    /// The square of the distance (closest points), or how many lengths of the direction away (rays).
    pub(crate) distance: f32,
    /// Where the search for a neighbouring point may begin.
    pub(crate) hint: u32,
}

/// No place to begin at.
pub(crate) const NO_HINT: u32 = u32::MAX;

/// Asks a tree, question after question.
pub(crate) struct Asking<'a> {
    tree: &'a Bvh,
    /// What the processor at hand can do.
    arch: pulp::Arch,
    stack: Vec<(f32, u32)>,
    /// Of a line: what lies behind its beginning.
    behind: Vec<(f32, u32)>,
}

/// The lanes of a mask, in growing order.
#[inline(always)]
fn lanes(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}

/// Pushes a box onto a stack whose entries from `first` on are in order, the nearest last: it is the next to be looked into.
#[inline(always)]
fn push_nearest_last(stack: &mut Vec<(f32, u32)>, first: usize, entry: (f32, u32)) {
    let mut at = stack.len();
    stack.push(entry);
    while at > first && stack[at - 1].0 < entry.0 {
        stack.swap(at - 1, at);
        at -= 1;
    }
}

impl Bvh {
    /// The tree over `triangles`, which keep their numbers.
    pub(crate) fn new(triangles: &[[V3; 3]]) -> Bvh {
        let split = split::split(triangles);
        let (low, high) = split.as_ref().map_or(
            ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]),
            split::Branch::bounds,
        );
        let (nodes, packs) = wide::collapse(split, triangles);
        Bvh {
            nodes,
            packs,
            largest: largest(low.into_iter().chain(high)),
            low,
            high,
        }
    }

    /// The diagonal of the box round all triangles; 0 without any.
    pub(crate) fn diagonal(&self) -> f32 {
        let side = |k: usize| (self.high[k] - self.low[k]).max(0.0);
        let [x, y, z] = [0, 1, 2].map(side);
        (x * x + y * y + z * z).sqrt()
    }

    /// The box round all triangles.
    pub(crate) fn bounds(&self) -> (V3, V3) {
        (self.low, self.high)
    }

    /// Someone who asks.
    pub(crate) fn asking(&self) -> Asking<'_> {
        Asking {
            tree: self,
            arch: pulp::Arch::new(),
            stack: Vec::with_capacity(64),
            behind: Vec::with_capacity(64),
        }
    }

    /// Nodes and packs of triangles as four-word quads, as `glsl/recover/find.comp` reads them; one of zeros where there are none.
    #[cfg(feature = "gpu")]
    pub(crate) fn words(&self) -> [Vec<[u32; 4]>; 2] {
        let quad = |v: &glam::Vec4| v.to_array().map(f32::to_bits);
        let node = |n: &Node| {
            let boxes: Vec<_> = n.low.iter().chain(&n.high).map(quad).collect();
            boxes.into_iter().chain([n.child])
        };
        let pack = |p: &Pack| {
            let corners: Vec<_> = p.corner.as_flattened().iter().map(quad).collect();
            corners.into_iter().chain([p.id])
        };
        let mut both = [
            self.nodes.iter().flat_map(node).collect::<Vec<_>>(),
            self.packs.iter().flat_map(pack).collect(),
        ];
        both.iter_mut()
            .filter(|w| w.is_empty())
            .for_each(|w| w.push([0; 4]));
        both
    }

    /// Whether there are no triangles.
    #[cfg(feature = "gpu")]
    pub(crate) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The largest coordinate of any corner.
    pub(crate) fn largest(&self) -> f32 {
        self.largest
    }
}

/// The largest of some coordinates that are finite.
fn largest(coordinates: impl Iterator<Item = f32>) -> f32 {
    coordinates
        .filter(|c| c.is_finite())
        .fold(0.0, |m, c| m.max(c.abs()))
}
