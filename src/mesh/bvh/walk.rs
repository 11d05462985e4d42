//! The ways of rays through the tree: the first hit, the first on both halves of a line, any.
//!
//! Everything here is inlined into [`WithSimd::with_simd`], which is compiled for the instructions that the processor at hand
//! has. The arithmetic, and so every bit, is the same with any of them.

use super::ray::{Hits, Prepared, Ray};
use super::wide::{IS_LEAF, Node, Pack};
use super::{Asking, Bundle, Found, V3, lanes, push_nearest_last};
use glam::Vec4;
use pulp::{Simd, WithSimd};

/// Who is shown the leaves that a ray passes.
trait Leaves {
    /// Takes a leaf; how far the ray still reaches. None ends the walk.
    fn take(&mut self, pack: &Pack, number: u32) -> Option<f32>;
}

/// The first hit so far.
struct First<'a> {
    ray: &'a Prepared,
    best: (f32, u32),
    found: Option<Found>,
}

impl First<'_> {
    #[inline(always)]
    fn new(ray: &Prepared) -> First<'_> {
        First {
            ray,
            best: (ray.ray.reach, u32::MAX),
            found: None,
        }
    }

    /// Takes a hit that is nearer, or as near with a lower number. `t` is where it lies on the line, `far` how far away.
    #[inline(always)]
    fn offer(&mut self, pack: &Pack, number: u32, lane: usize, (t, far): (f32, f32), b: V3) {
        let hit = (far, pack.id[lane]);
        if hit < self.best && self.ray.within(&pack.lane(lane), t) {
            self.best = hit;
            self.found = Some(Found {
                triangle: pack.id[lane],
                b,
                distance: far,
                hint: number,
            });
        }
    }
}

impl Leaves for First<'_> {
    #[inline(always)]
    fn take(&mut self, pack: &Pack, number: u32) -> Option<f32> {
        let Hits { lanes: some, t, b } = self.ray.hits(pack, 0.0);
        for lane in lanes(some) {
            self.offer(pack, number, lane, (t[lane], t[lane]), b.map(|b| b[lane]));
        }
        Some(self.best.0)
    }
}

/// Whether anything was met.
struct Any<'a> {
    ray: &'a Prepared,
    met: bool,
}

impl Leaves for Any<'_> {
    #[inline(always)]
    fn take(&mut self, pack: &Pack, _: u32) -> Option<f32> {
        let hits = self.ray.hits(pack, 0.0);
        let met = |lane: usize| self.ray.within(&pack.lane(lane), hits.t[lane]);
        self.met = lanes(hits.lanes).any(met);
        (!self.met).then_some(self.ray.ray.reach)
    }
}

/// The first hits so far on both halves of a line.
///
/// A ray and its reverse compute the same numbers but for their signs, and those of zeros: what is added, multiplied and
/// divided is the same, and rounding knows no sign. So one walk serves both.
struct Halves<'a> {
    ahead: First<'a>,
    behind: First<'a>,
}

impl Halves<'_> {
    #[inline(always)]
    fn take(&mut self, pack: &Pack, number: u32) {
        let ray = self.ahead.ray;
        let Hits { lanes: some, t, b } = ray.hits(pack, -ray.ray.reach);
        for lane in lanes(some) {
            let (t, b) = (t[lane], b.map(|b| b[lane]));
            let half = match t >= 0.0 {
                true => &mut self.ahead,
                false => &mut self.behind,
            };
            half.offer(pack, number, lane, (t, t.abs()), b);
        }
    }
}

impl Asking<'_> {
    /// The first hit; of equally far ones that of the lowest triangle.
    pub(crate) fn first(&mut self, ray: Ray) -> Option<Found> {
        let arch = self.arch;
        arch.dispatch(AskFirst { asking: self, ray })
    }

    /// The first hit of `ray` or, where there is none, that of its reverse: from the same
    /// place the other way, the same triangles counting. The walk begins at `bundle`, in whose box both must lie, or at the root.
    pub(crate) fn first_of_both(&mut self, ray: Ray, bundle: Option<&Bundle>) -> Option<Found> {
        let arch = self.arch;
        arch.dispatch(AskBoth {
            asking: self,
            ray,
            bundle,
        })
    }

    /// Whether anything lies on the ray.
    pub(crate) fn meets(&mut self, ray: Ray) -> bool {
        let arch = self.arch;
        arch.dispatch(AskAny { asking: self, ray })
    }

    /// The first hit by asking every triangle: what the walk is held against.
    pub(crate) fn first_of_every(&self, ray: Ray) -> Option<Found> {
        let prepared = Prepared::new(self.tree, ray);
        let mut first = First::new(&prepared);
        for (number, pack) in self.tree.packs.iter().enumerate() {
            first.take(pack, number as u32);
        }
        first.found
    }

    /// Shows leaves along a ray, near ones first.
    #[inline(always)]
    fn walk(&mut self, ray: &Prepared, leaves: &mut impl Leaves) {
        let mut end = ray.ray.reach;
        self.stack.clear();
        if !self.tree.nodes.is_empty() {
            self.stack.push((0.0, 0));
        }
        while let Some((enters, at)) = self.stack.pop() {
            if enters > end {
                continue;
            }
            if at & IS_LEAF != 0 {
                let number = at & !IS_LEAF;
                match leaves.take(&self.tree.packs[number as usize], number) {
                    Some(left) => end = left,
                    None => return,
                }
                continue;
            }
            let node = &self.tree.nodes[at as usize];
            let (from, to) = ray.stretches(node);
            let from = from.max(Vec4::ZERO);
            let met = from.cmple(to.min(Vec4::splat(end)));
            let (from, first) = (from.to_array(), self.stack.len());
            for lane in lanes(met.bitmask()) {
                push_nearest_last(&mut self.stack, first, (from[lane], node.child[lane]));
            }
        }
    }

    /// Shows leaves along a line: first those that reach ahead of its beginning, near ones first; then, where nothing was met
    /// there, those behind.
    #[inline(always)]
    fn walk_both(&mut self, halves: &mut Halves, bundle: Option<&Bundle>) {
        self.stack.clear();
        self.behind.clear();
        match bundle {
            Some(bundle) => {
                for node in &bundle.nodes {
                    self.push_both(halves, node, [0, 0]);
                }
            }
            None if !self.tree.nodes.is_empty() => self.stack.push((0.0, 0)),
            None => {}
        }
        while let Some((enters, at)) = self.stack.pop() {
            if enters <= halves.ahead.best.0 {
                self.open_both(halves, at);
            }
        }
        if halves.ahead.found.is_some() {
            return;
        }
        while let Some((enters, at)) = self.behind.pop() {
            if enters <= halves.behind.best.0 {
                self.open_both(halves, at);
            }
        }
    }

    #[inline(always)]
    fn open_both(&mut self, halves: &mut Halves, at: u32) {
        if at & IS_LEAF != 0 {
            let number = at & !IS_LEAF;
            halves.take(&self.tree.packs[number as usize], number);
            return;
        }
        let firsts = [self.stack.len(), self.behind.len()];
        self.push_both(halves, &self.tree.nodes[at as usize], firsts);
    }

    /// Pushes what the line enters of a node's children: what reaches ahead of its beginning, and what lies behind alone. What
    /// is on the stacks from `firsts` on stays in order.
    #[inline(always)]
    fn push_both(&mut self, halves: &Halves, node: &Node, firsts: [usize; 2]) {
        let (from, to) = halves.ahead.ray.stretches(node);
        let enters = from.max(Vec4::ZERO);
        let ahead = enters.cmple(to.min(Vec4::splat(halves.ahead.best.0)));
        let ahead = ahead.bitmask();
        let enters = enters.to_array();
        for lane in lanes(ahead) {
            push_nearest_last(&mut self.stack, firsts[0], (enters[lane], node.child[lane]));
        }
        let enters = (-to).max(Vec4::ZERO);
        let behind = enters.cmple((-from).min(Vec4::splat(halves.behind.best.0)));
        let behind = behind.bitmask() & !ahead;
        let enters = enters.to_array();
        for lane in lanes(behind) {
            push_nearest_last(
                &mut self.behind,
                firsts[1],
                (enters[lane], node.child[lane]),
            );
        }
    }
}

/// [`Asking::first`].
struct AskFirst<'q, 'a> {
    asking: &'q mut Asking<'a>,
    ray: Ray,
}

impl WithSimd for AskFirst<'_, '_> {
    type Output = Option<Found>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<Found> {
        let prepared = Prepared::new(self.asking.tree, self.ray);
        let mut first = First::new(&prepared);
        self.asking.walk(&prepared, &mut first);
        first.found
    }
}

/// [`Asking::first_of_both`].
struct AskBoth<'q, 'a> {
    asking: &'q mut Asking<'a>,
    ray: Ray,
    bundle: Option<&'q Bundle>,
}

impl WithSimd for AskBoth<'_, '_> {
    type Output = Option<Found>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<Found> {
        let prepared = Prepared::new(self.asking.tree, self.ray);
        let mut halves = Halves {
            ahead: First::new(&prepared),
            behind: First::new(&prepared),
        };
        self.asking.walk_both(&mut halves, self.bundle);
        halves.ahead.found.or(halves.behind.found)
    }
}

/// [`Asking::meets`].
struct AskAny<'q, 'a> {
    asking: &'q mut Asking<'a>,
    ray: Ray,
}

impl WithSimd for AskAny<'_, '_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let prepared = Prepared::new(self.asking.tree, self.ray);
        let mut any = Any {
            ray: &prepared,
            met: false,
        };
        self.asking.walk(&prepared, &mut any);
        any.met
    }
}
