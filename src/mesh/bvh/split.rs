//! Triangles divided into halves of halves, by the surface area heuristic over bins (Wald 2007).
//!
//! In: triangles. Out: a binary tree whose leaves hold up to [`LEAF`] of them. The same tree on any number of cores.

use super::V3;
use rayon::prelude::*;

/// Triangles in a leaf, at most: what is tested at once.
pub(super) const LEAF: usize = 4;
/// Places where a set may be cut along an axis, and one.
const BINS: usize = 16;
/// From this many triangles on halves are worked on by different cores.
const APART: usize = 4096;
/// From this depth on sets are halved by number, so that no input makes the tree deep.
const DEEP: u32 = 48;

/// A part of the tree.
pub(super) enum Branch {
    /// Numbers of triangles.
    Leaf(Bounds, Vec<u32>),
    /// Two parts.
    Fork(Bounds, Box<[Branch; 2]>),
}

/// A box.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub(super) low: V3,
    pub(super) high: V3,
}

impl Bounds {
    const EMPTY: Bounds = Bounds {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    fn of(corners: &[V3; 3]) -> Bounds {
        corners.iter().fold(Bounds::EMPTY, |b, p| b.with(p, p))
    }

    fn with(self, low: &V3, high: &V3) -> Bounds {
        let pick = |k: usize| (self.low[k].min(low[k]), self.high[k].max(high[k]));
        let both = [0, 1, 2].map(pick);
        Bounds {
            low: both.map(|b| b.0),
            high: both.map(|b| b.1),
        }
    }

    fn join(self, other: &Bounds) -> Bounds {
        self.with(&other.low, &other.high)
    }

    /// Half the surface; 0 for an empty box.
    pub(super) fn area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|k| (self.high[k] - self.low[k]).max(0.0));
        x * y + y * z + z * x
    }
}

impl Branch {
    pub(super) fn bounds(&self) -> (V3, V3) {
        let b = self.around();
        (b.low, b.high)
    }

    pub(super) fn around(&self) -> &Bounds {
        match self {
            Branch::Leaf(bounds, _) | Branch::Fork(bounds, _) => bounds,
        }
    }
}

/// A triangle while sets are divided.
#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    /// Twice the middle of its box.
    middle: V3,
    id: u32,
}

/// The tree over `triangles`; none without any.
pub(super) fn split(triangles: &[[V3; 3]]) -> Option<Branch> {
    let item = |(id, corners): (usize, &[V3; 3])| {
        let bounds = Bounds::of(corners);
        // Halved first: the sum of two coordinates may leave the range of floats.
        let middle = [0, 1, 2].map(|k| bounds.low[k] * 0.5 + bounds.high[k] * 0.5);
        Item {
            bounds,
            middle,
            id: id as u32,
        }
    };
    let mut items: Vec<Item> = triangles.par_iter().enumerate().map(item).collect();
    (!items.is_empty()).then(|| divide(&mut items, 0))
}

fn divide(items: &mut [Item], depth: u32) -> Branch {
    let around = items
        .iter()
        .fold(Bounds::EMPTY, |b, item| b.join(&item.bounds));
    if items.len() <= LEAF {
        let mut ids: Vec<u32> = items.iter().map(|item| item.id).collect();
        ids.sort_unstable();
        return Branch::Leaf(around, ids);
    }
    let cut = cut(items, depth);
    let (left, right) = items.split_at_mut(cut);
    let (left, right) = if left.len() + right.len() > APART {
        rayon::join(|| divide(left, depth + 1), || divide(right, depth + 1))
    } else {
        (divide(left, depth + 1), divide(right, depth + 1))
    };
    Branch::Fork(around, Box::new([left, right]))
}

/// Puts `items` in an order in which they are cut in two; the place of the cut.
fn cut(items: &mut [Item], depth: u32) -> usize {
    let middles = items
        .iter()
        .fold(Bounds::EMPTY, |b, item| b.with(&item.middle, &item.middle));
    let side = [0, 1, 2].map(|k| middles.high[k] - middles.low[k]);
    let axis = (0..3).fold(0, |best, k| if side[k] > side[best] { k } else { best });
    let half = items.len() / 2;
    if side[axis] <= 0.0 || depth >= DEEP {
        // By number where places say nothing.
        items.select_nth_unstable_by_key(half, |item| item.id);
        return half;
    }
    let scale = BINS as f32 / side[axis];
    let bin =
        |item: &Item| (((item.middle[axis] - middles.low[axis]) * scale) as usize).min(BINS - 1);
    let limit = cheapest(items, bin);
    let mut at = 0;
    for k in 0..items.len() {
        if bin(&items[k]) < limit {
            items.swap(at, k);
            at += 1;
        }
    }
    if at == 0 || at == items.len() {
        let key = |item: &Item| item.middle[axis];
        items.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.id.cmp(&b.id)));
        return half;
    }
    at
}

/// The first bin of the right half for which a ray is expected to meet the fewest triangles.
fn cheapest(items: &[Item], bin: impl Fn(&Item) -> usize) -> usize {
    let mut bins = [(Bounds::EMPTY, 0usize); BINS];
    for item in items {
        let slot = &mut bins[bin(item)];
        *slot = (slot.0.join(&item.bounds), slot.1 + 1);
    }
    let join = |a: (Bounds, usize), b: &(Bounds, usize)| (a.0.join(&b.0), a.1 + b.1);
    let mut right = [0.0; BINS];
    let mut sum = (Bounds::EMPTY, 0);
    for k in (1..BINS).rev() {
        sum = join(sum, &bins[k]);
        right[k] = cost(&sum);
    }
    let (mut best, mut limit) = (f32::INFINITY, BINS / 2);
    let mut sum = (Bounds::EMPTY, 0);
    for k in 1..BINS {
        sum = join(sum, &bins[k - 1]);
        let both = cost(&sum) + right[k];
        if both < best {
            (best, limit) = (both, k);
        }
    }
    limit
}

/// Surface times packs of triangles.
fn cost((bounds, count): &(Bounds, usize)) -> f32 {
    bounds.area() * count.div_ceil(LEAF) as f32
}
