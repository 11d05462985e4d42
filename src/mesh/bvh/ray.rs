//! The first hit of a ray.
//!
//! Watertight after Woop, Benthin and Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013: two triangles that
//! share an edge compute the same number for it with opposite signs, so no ray passes between them. Four at once.
//!
//! Here is what a ray meets of one node and one leaf; `walk.rs` has the ways through the tree.

use super::wide::{Node, Pack};
use super::{Bvh, V3};
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
pub(super) struct Prepared {
    pub(super) ray: Ray,
    inverse: V3,
    /// Where the slabs' near and far planes are measured from: the beginning, moved by the margin.
    near_from: V3,
    far_from: V3,
    /// The longest axis of the direction and the other two, so that the winding stays.
    axes: [usize; 3],
    shear: V3,
}

/// What a ray meets of four triangles: the lanes, how far away, and barycentrics up to their sum.
pub(super) struct Hits {
    pub(super) lanes: u32,
    pub(super) t: [f32; 4],
    pub(super) b: [Vec4; 3],
}

impl Hits {
    const NONE: Hits = Hits {
        lanes: 0,
        t: [0.0; 4],
        b: [Vec4::ZERO; 3],
    };
}

impl Prepared {
    #[inline(always)]
    pub(super) fn new(tree: &Bvh, ray: Ray) -> Prepared {
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

    /// Where the whole line of the ray enters and leaves each of four boxes; it misses those that it leaves first.
    #[inline(always)]
    pub(super) fn stretches(&self, node: &Node) -> (Vec4, Vec4) {
        let (mut from, mut to) = (Vec4::NEG_INFINITY, Vec4::INFINITY);
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
        (from, to)
    }

    /// Whether `t` lies in the stretch of the line through the box of one triangle: the same arithmetic as for nodes.
    #[inline(always)]
    pub(super) fn within(&self, corners: &[V3; 3], t: f32) -> bool {
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

    /// A corner of each of four triangles where the ray begins at 0 and runs along the third axis.
    #[inline(always)]
    fn seen(&self, corner: &[Vec4; 3]) -> [Vec4; 3] {
        let [x, y, z] = self.axes;
        let [bx, by, bz] = [x, y, z].map(|k| Vec4::splat(self.ray.begin[k]));
        let [sx, sy, sz] = self.shear.map(Vec4::splat);
        let depth = corner[z] - bz;
        [
            (corner[x] - bx) - sx * depth,
            (corner[y] - by) - sy * depth,
            sz * depth,
        ]
    }

    /// The hits of four triangles, from `from` on.
    #[inline(always)]
    pub(super) fn hits(&self, pack: &Pack, from: f32) -> Hits {
        let (a, b, c) = (
            self.seen(&pack.corner[0]),
            self.seen(&pack.corner[1]),
            self.seen(&pack.corner[2]),
        );
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
            return Hits::NONE;
        }
        let t = (u * a[2] + v * b[2] + w * c[2]) / sum;
        let hit = inside & t.cmpge(Vec4::splat(from)) & t.cmple(Vec4::splat(self.ray.reach));
        if !hit.any() {
            return Hits::NONE;
        }
        Hits {
            lanes: hit.bitmask(),
            t: t.to_array(),
            b: [u / sum, v / sum, w / sum],
        }
    }
}
