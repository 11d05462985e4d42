//! The closest point of all triangles.
//!
//! Regions of a triangle after Ericson, *Real-Time Collision Detection* (2005), 5.1.5, without branches, four triangles
//! at once; compiled for the processor at hand, as [`super::walk`] is.

use super::wide::{IS_LEAF, Node, Pack};
use super::{Asking, Found, NO_HINT, V3, lanes, push_nearest_last};
use glam::{BVec4A, Vec4};
use pulp::{Simd, WithSimd};

/// Divisors are no smaller: a triangle without length gives a point of it all the same.
const LEAST: f32 = 1e-37;

impl Asking<'_> {
    /// The closest point to `p` among triangles that are not farther than the square root of `within`; `facing`: among
    /// those whose normal does not point away from this direction. `hint`: that of a point nearby, or [`NO_HINT`]; it
    /// changes nothing but the time.
    pub(crate) fn closest(
        &mut self,
        p: V3,
        within: f32,
        facing: Option<V3>,
        hint: u32,
    ) -> Option<Found> {
        let arch = self.arch;
        let best = Best::new(within, facing);
        arch.dispatch(AskClosest {
            asking: self,
            p,
            hint,
            best,
        })
    }

    #[inline(always)]
    fn walk_closest(&mut self, p: V3, hint: u32, best: &mut Best) {
        let splat = p.map(Vec4::splat);
        if let Some(pack) = self.tree.packs.get(hint as usize) {
            best.take(pack, hint, &splat);
        }
        self.stack.clear();
        if !self.tree.nodes.is_empty() {
            self.stack.push((0.0, 0));
        }
        while let Some((distance, at)) = self.stack.pop() {
            if distance > best.found.distance {
                continue;
            }
            if at & IS_LEAF != 0 {
                let pack = at & !IS_LEAF;
                if pack != hint {
                    best.take(&self.tree.packs[pack as usize], pack, &splat);
                }
                continue;
            }
            let node = &self.tree.nodes[at as usize];
            let distances = distances(node, &splat);
            let near = distances.cmple(Vec4::splat(best.found.distance))
                // A place without a box is infinitely far.
                & distances.cmplt(Vec4::INFINITY);
            let (distances, first) = (distances.to_array(), self.stack.len());
            for lane in lanes(near.bitmask()) {
                let entry = (distances[lane], node.child[lane]);
                push_nearest_last(&mut self.stack, first, entry);
            }
        }
    }

    /// The same by asking every triangle: what the walk is held against.
    pub(crate) fn closest_of_every(&self, p: V3, within: f32, facing: Option<V3>) -> Option<Found> {
        let mut best = Best::new(within, facing);
        let splat = p.map(Vec4::splat);
        for (number, pack) in self.tree.packs.iter().enumerate() {
            best.take(pack, number as u32, &splat);
        }
        best.any()
    }
}

/// [`Asking::closest`].
struct AskClosest<'q, 'a> {
    asking: &'q mut Asking<'a>,
    p: V3,
    hint: u32,
    best: Best,
}

impl WithSimd for AskClosest<'_, '_> {
    type Output = Option<Found>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) -> Option<Found> {
        self.asking.walk_closest(self.p, self.hint, &mut self.best);
        self.best.any()
    }
}

/// Squares of the distances to four boxes; infinite for a place without a box.
#[inline(always)]
fn distances(node: &Node, p: &[Vec4; 3]) -> Vec4 {
    let [x, y, z] = [0, 1, 2].map(|k| {
        let outside = (node.low[k] - p[k])
            .max(p[k] - node.high[k])
            .max(Vec4::ZERO);
        outside * outside
    });
    x + y + z
}

struct Best {
    facing: Option<V3>,
    found: Found,
}

impl Best {
    #[inline(always)]
    fn new(within: f32, facing: Option<V3>) -> Best {
        Best {
            facing,
            found: Found {
                triangle: u32::MAX,
                b: [1.0, 0.0, 0.0],
                distance: within,
                hint: NO_HINT,
            },
        }
    }

    #[inline(always)]
    fn any(self) -> Option<Found> {
        (self.found.triangle != u32::MAX).then_some(self.found)
    }

    /// Takes from a leaf what is closer, or as close with a lower number.
    #[inline(always)]
    fn take(&mut self, pack: &Pack, hint: u32, p: &[Vec4; 3]) {
        let (v, w, distance) = four(pack, p);
        let mut near = distance.cmple(Vec4::splat(self.found.distance));
        if let Some(facing) = self.facing {
            near &= along(pack, facing);
        }
        if !near.any() {
            return;
        }
        for lane in lanes(near.bitmask()) {
            let (distance, id) = (distance[lane], pack.id[lane]);
            if (distance, id) < (self.found.distance, self.found.triangle) {
                self.found = Found {
                    triangle: id,
                    b: [1.0 - v[lane] - w[lane], v[lane], w[lane]],
                    distance,
                    hint,
                };
            }
        }
    }
}

/// The triangles whose normal does not point away from `facing`.
#[inline(always)]
fn along(pack: &Pack, facing: V3) -> BVec4A {
    let [a, b, c] = &pack.corner;
    let (e, f) = (
        [0, 1, 2].map(|k| b[k] - a[k]),
        [0, 1, 2].map(|k| c[k] - a[k]),
    );
    let [x, y, z] = facing.map(Vec4::splat);
    let dot = (e[1] * f[2] - e[2] * f[1]) * x
        + (e[2] * f[0] - e[0] * f[2]) * y
        + (e[0] * f[1] - e[1] * f[0]) * z;
    dot.cmpge(Vec4::ZERO)
}

#[inline(always)]
fn dot(a: &[Vec4; 3], b: &[Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Barycentrics of corners 1 and 2 of the closest points of four triangles, and the squares of their distances.
#[inline(always)]
fn four(pack: &Pack, p: &[Vec4; 3]) -> (Vec4, Vec4, Vec4) {
    let [a, b, c] = &pack.corner;
    let less = |x: &[Vec4; 3], y: &[Vec4; 3]| [x[0] - y[0], x[1] - y[1], x[2] - y[2]];
    let (ab, ac) = (less(b, a), less(c, a));
    let (ap, bp, cp) = (less(p, a), less(p, b), less(p, c));
    let (d1, d2) = (dot(&ab, &ap), dot(&ac, &ap));
    let (d3, d4) = (dot(&ab, &bp), dot(&ac, &bp));
    let (d5, d6) = (dot(&ab, &cp), dot(&ac, &cp));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let (zero, one, least) = (Vec4::ZERO, Vec4::ONE, Vec4::splat(LEAST));
    // Inside, then edges, then corners: what is asked first has the last word.
    let sum = (va + vb + vc).max(least);
    let (mut v, mut w) = (vb / sum, vc / sum);
    let mut put = |where_: BVec4A, to_v: Vec4, to_w: Vec4| {
        (v, w) = (Vec4::select(where_, to_v, v), Vec4::select(where_, to_w, w));
    };
    let (e, f) = (d4 - d3, d5 - d6);
    let along_bc = e / (e + f).max(least);
    put(
        va.cmple(zero) & e.cmpge(zero) & f.cmpge(zero),
        one - along_bc,
        along_bc,
    );
    put(
        vb.cmple(zero) & d2.cmpge(zero) & d6.cmple(zero),
        zero,
        d2 / (d2 - d6).max(least),
    );
    put(d6.cmpge(zero) & d5.cmple(d6), zero, one);
    put(
        vc.cmple(zero) & d1.cmpge(zero) & d3.cmple(zero),
        d1 / (d1 - d3).max(least),
        zero,
    );
    put(d3.cmpge(zero) & d4.cmple(d3), one, zero);
    put(d1.cmple(zero) & d2.cmple(zero), zero, zero);
    // Rounding leaves a sliver's interior at times.
    let v = v.max(zero).min(one);
    let w = w.max(zero).min(one - v);
    let mut distance = zero;
    for k in 0..3 {
        let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
        let q = (a[k] + ab[k] * v + ac[k] * w).max(low).min(high);
        // As the distance to a box: above or below, whichever is not negative.
        let apart = (q - p[k]).max(p[k] - q).max(zero);
        distance = if k == 0 {
            apart * apart
        } else {
            distance + apart * apart
        };
    }
    (v, w, distance)
}
