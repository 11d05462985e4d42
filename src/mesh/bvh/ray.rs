//! The first hit of a ray.
//!
//! Watertight after Woop, Benthin and Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013: two triangles that
//! share an edge compute the same number for it with opposite signs, so no ray passes between them. Four at once.

use super::wide::{IS_LEAF, Node, Pack};
use super::{Asking, Bundle, Bvh, Found, V3, push_nearest_last};
use glam::Vec4;

/// Boxes are larger by this share of the largest coordinate: more than rounding takes from any of them.
const MARGIN: f32 = 4e-6;
/// In place of the inverse of a direction's zero.
const ENDLESS: f32 = 1e30;
/// The smallest part of a direction that is no zero.
const SHORTEST: f32 = 1e-30;

/// Which sides of triangles count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sides {
    /// Both.
    Both,
    /// Those whose normal the ray runs against.
    Front,
    /// Those whose normal the ray runs along.
    Back,
}

/// A ray from `begin` along `way`, from 0 to `reach` times its length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) begin: V3,
    /// Of any length but 0.
    pub(crate) way: V3,
    pub(crate) reach: f32,
    pub(crate) sides: Sides,
}

/// What of a ray is the same for all boxes and triangles.
struct Prepared {
    ray: Ray,
    inverse: V3,
    /// Where the slabs' near and far planes are measured from: the beginning, moved by the margin.
    near_from: V3,
    far_from: V3,
    /// The longest axis of the direction and the other two, so that the winding stays.
    axes: [usize; 3],
    shear: V3,
}

impl Prepared {
    fn new(tree: &Bvh, ray: Ray) -> Prepared {
        let Ray { begin, way, .. } = ray;
        let largest = begin.iter().fold(tree.largest(), |m, c| m.max(c.abs()));
        let margin = MARGIN * largest;
        let inverse = way.map(|c| {
            if c.abs() > SHORTEST {
                1.0 / c
            } else {
                ENDLESS.copysign(c)
            }
        });
        let ahead = |k: usize| margin.copysign(inverse[k]);
        let z = (0..3).fold(0, |best, k| {
            if way[k].abs() > way[best].abs() {
                k
            } else {
                best
            }
        });
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if way[z] < 0.0 {
            (x, y) = (y, x);
        }
        Prepared {
            ray,
            inverse,
            near_from: [0, 1, 2].map(|k| begin[k] + ahead(k)),
            far_from: [0, 1, 2].map(|k| begin[k] - ahead(k)),
            axes: [x, y, z],
            shear: [way[x] / way[z], way[y] / way[z], 1.0 / way[z]],
        }
    }

    /// Where the ray enters each of four boxes; infinite where it misses them, or enters behind `end`.
    fn enters(&self, node: &Node, end: f32) -> Vec4 {
        let (mut from, mut to) = (Vec4::ZERO, Vec4::splat(end));
        for k in 0..3 {
            let (near, far) = if self.inverse[k] >= 0.0 {
                (node.low[k], node.high[k])
            } else {
                (node.high[k], node.low[k])
            };
            let inverse = Vec4::splat(self.inverse[k]);
            from = from.max((near - Vec4::splat(self.near_from[k])) * inverse);
            to = to.min((far - Vec4::splat(self.far_from[k])) * inverse);
        }
        Vec4::select(from.cmple(to), from, Vec4::INFINITY)
    }

    /// Whether `t` lies in the stretch of the ray through the box of one triangle: the same arithmetic as for nodes.
    fn within(&self, corners: &[V3; 3], t: f32) -> bool {
        (0..3).all(|k| {
            let [a, b, c] = corners.map(|p| p[k]);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let (near, far) = if self.inverse[k] >= 0.0 {
                (low, high)
            } else {
                (high, low)
            };
            (near - self.near_from[k]) * self.inverse[k] <= t
                && t <= (far - self.far_from[k]) * self.inverse[k]
        })
    }

    /// The hits of four triangles: distances (infinite where there is none) and barycentrics up to their sum.
    fn hits(&self, pack: &Pack) -> (Vec4, [Vec4; 3]) {
        let [x, y, z] = self.axes;
        let begin = self.ray.begin.map(Vec4::splat);
        let [sx, sy, sz] = self.shear.map(Vec4::splat);
        let seen = pack.corner.map(|c| {
            let depth = c[z] - begin[z];
            [
                (c[x] - begin[x]) - sx * depth,
                (c[y] - begin[y]) - sy * depth,
                sz * depth,
            ]
        });
        let [a, b, c] = &seen;
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let zero = Vec4::ZERO;
        let sum = u + v + w;
        let front = u.cmpge(zero) & v.cmpge(zero) & w.cmpge(zero);
        let back = u.cmple(zero) & v.cmple(zero) & w.cmple(zero);
        let inside = match self.ray.sides {
            Sides::Both => front | back,
            Sides::Front => front,
            Sides::Back => back,
        } & sum.cmpne(zero);
        if !inside.any() {
            return (Vec4::INFINITY, seen[0]);
        }
        let t = (u * a[2] + v * b[2] + w * c[2]) / sum;
        let hit = inside & t.cmpge(zero) & t.cmple(Vec4::splat(self.ray.reach));
        let t = Vec4::select(hit, t, Vec4::INFINITY);
        (t, [u / sum, v / sum, w / sum])
    }
}

/// The first hit so far.
struct First<'a> {
    ray: &'a Prepared,
    best: (f32, u32),
    found: Option<Found>,
}

impl First<'_> {
    fn new(ray: &Prepared) -> First<'_> {
        First {
            ray,
            best: (ray.ray.reach, u32::MAX),
            found: None,
        }
    }

    /// Takes from a leaf what is nearer, or as near with a lower number; how far the ray still reaches.
    fn take(&mut self, pack: &Pack, number: u32) -> f32 {
        let (t, b) = self.ray.hits(pack);
        for lane in (0..4).filter(|&lane| t[lane].is_finite()) {
            let hit = (t[lane], pack.id[lane]);
            if hit < self.best && self.ray.within(&pack.lane(lane), t[lane]) {
                self.best = hit;
                self.found = Some(Found {
                    triangle: pack.id[lane],
                    b: b.map(|b| b[lane]),
                    distance: t[lane],
                    hint: number,
                });
            }
        }
        self.best.0
    }
}

impl Asking<'_> {
    /// The first hit; of equally far ones that of the lowest triangle.
    pub(crate) fn first(&mut self, ray: Ray) -> Option<Found> {
        self.first_from(ray, None)
    }

    /// Likewise, the walk beginning at `bundle`, in whose box the ray must lie.
    pub(crate) fn first_in(&mut self, ray: Ray, bundle: &Bundle) -> Option<Found> {
        self.first_from(ray, Some(bundle))
    }

    fn first_from(&mut self, ray: Ray, bundle: Option<&Bundle>) -> Option<Found> {
        let prepared = Prepared::new(self.tree, ray);
        let mut first = First::new(&prepared);
        self.walk(&prepared, bundle, |pack, number| {
            Some(first.take(pack, number))
        });
        first.found
    }

    /// The same by asking every triangle: what the walk is held against.
    pub(crate) fn first_of_every(&self, ray: Ray) -> Option<Found> {
        let prepared = Prepared::new(self.tree, ray);
        let mut first = First::new(&prepared);
        for (number, pack) in self.tree.packs.iter().enumerate() {
            first.take(pack, number as u32);
        }
        first.found
    }

    /// Whether anything lies on the ray.
    pub(crate) fn meets(&mut self, ray: Ray) -> bool {
        let prepared = Prepared::new(self.tree, ray);
        let mut met = false;
        self.walk(&prepared, None, |pack, _| {
            let (t, _) = prepared.hits(pack);
            met = (0..4)
                .any(|lane| t[lane].is_finite() && prepared.within(&pack.lane(lane), t[lane]));
            (!met).then_some(ray.reach)
        });
        met
    }

    /// Shows leaves along a ray, near ones first, to `take`, which says how far the ray still reaches; none ends the walk. It
    /// begins at the root or where `bundle` says.
    fn walk(
        &mut self,
        ray: &Prepared,
        bundle: Option<&Bundle>,
        mut take: impl FnMut(&Pack, u32) -> Option<f32>,
    ) {
        let mut end = ray.ray.reach;
        self.stack.clear();
        match bundle {
            Some(bundle) => bundle
                .nodes
                .iter()
                .for_each(|node| self.push(ray, node, end, 0)),
            None if !self.tree.nodes.is_empty() => self.stack.push((0.0, 0)),
            None => {}
        }
        while let Some((enters, at)) = self.stack.pop() {
            if enters > end {
                continue;
            }
            if at & IS_LEAF != 0 {
                let number = at & !IS_LEAF;
                match take(&self.tree.packs[number as usize], number) {
                    Some(left) => end = left,
                    None => return,
                }
                continue;
            }
            self.push(ray, &self.tree.nodes[at as usize], end, self.stack.len());
        }
    }

    /// Pushes what the ray enters of a node's children; what is on the stack from `first` on stays in order.
    fn push(&mut self, ray: &Prepared, node: &Node, end: f32, first: usize) {
        let enters = ray.enters(node, end).to_array();
        for (lane, &enters) in enters.iter().enumerate() {
            if enters <= end && enters < f32::INFINITY {
                push_nearest_last(&mut self.stack, first, (enters, node.child[lane]));
            }
        }
    }
}
