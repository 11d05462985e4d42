//! The triangles of a texel, the one that covers most of it first.
//!
//! In: a texel and its triangles. Out: [`Ranked`], a workspace that is used again for every texel: nothing is asked of the
//! allocator. Shares are estimated, and pairs looked at in the plane of the texel ([`flat`](super::flat)); what cannot be
//! told there, and lists about an axis, across octants or very long ones, is worked out ([`weigh`], [`sides`]). The
//! answers are the same.

use super::super::Reference;
use super::estimate::{CLOSE, Frame};
use super::flat::Flat;
use super::sides::{self, Piece};
use super::weigh::{self, Corners};
use crate::param::projection::Line;

/// A texel of which so much is covered has hardly a point outside of all triangles.
const FULLY: f64 = 1.0 - 1e-6;
/// Longer lists are not looked at pair by pair: they count as overlapping.
const MOST_PAIRED: usize = 64;
/// The shares of longer lists are worked out: estimates of that many would not tell whether they cover the texel.
const ESTIMATED: usize = 16;
/// Pairs of so few triangles are all looked at.
const FEW: usize = 6;

/// A triangle and the share of the texel that it covers.
#[derive(Clone, Copy)]
pub(super) struct Rank {
    share: f64,
    pub(super) triangle: u32,
    /// Its place in the list that was ranked.
    place: u32,
}

impl Rank {
    #[inline]
    fn before(&self, other: &Rank) -> bool {
        self.share > other.share || self.share == other.share && self.triangle < other.triangle
    }
}

/// The triangles of a texel.
pub(super) struct Ranked<'a> {
    reference: &'a Reference,
    line: Line,
    /// log2 of the resolution, column, row.
    texel: [u32; 3],
    order: Vec<Rank>,
    /// The triangles in texels, by place; only where `is_flat`.
    flat: [Flat; MOST_PAIRED],
    is_flat: bool,
    /// The triangles' pieces, by place; made when they are first asked for.
    pieces: Vec<Piece>,
    /// Whether all shares are worked out rather than estimated.
    exact: bool,
}

impl<'a> Ranked<'a> {
    pub(super) fn new(reference: &'a Reference) -> Self {
        Ranked {
            reference,
            line: reference.primary.line(),
            texel: [0; 3],
            order: Vec::new(),
            flat: [Flat::default(); MOST_PAIRED],
            is_flat: false,
            pieces: Vec::new(),
            exact: false,
        }
    }

    /// Puts the triangles `own` of the texel (x, y) in a table of `2^bits` squared ones in order.
    pub(super) fn rank(&mut self, bits: u32, [x, y]: [u32; 2], own: &[u32]) {
        self.texel = [bits, x, y];
        self.pieces.clear();
        self.order.clear();
        self.order
            .extend(own.iter().enumerate().map(|(place, &triangle)| Rank {
                share: 0.0,
                triangle,
                place: place as u32,
            }));
        self.is_flat = own.len() <= MOST_PAIRED && self.flatten(own);
        self.exact = !self.is_flat || own.len() > ESTIMATED;
        if self.exact {
            self.work_out();
        } else {
            self.sort();
            self.settle();
        }
    }

    /// Brings the triangles to the plane of the texel and estimates their shares; whether that was possible.
    fn flatten(&mut self, own: &[u32]) -> bool {
        let [bits, x, y] = self.texel;
        let frame = Frame::new(self.line, bits, x, y);
        for ((triangle, flat), rank) in own.iter().zip(&mut self.flat).zip(&mut self.order) {
            let ids = self.reference.triangles[*triangle as usize];
            let t3 = &self.reference.t3;
            let corners = [
                t3[ids[0] as usize],
                t3[ids[1] as usize],
                t3[ids[2] as usize],
            ];
            match Flat::new(&frame, ids, &corners) {
                Some(one) => *flat = one,
                None => return false,
            }
            rank.share = flat.share();
        }
        true
    }

    /// Works all shares out.
    fn work_out(&mut self) {
        self.exact = true;
        let corners = self.corners();
        for i in 0..self.order.len() {
            self.order[i].share = self.share(i, &corners);
        }
        self.sort();
    }

    fn corners(&self) -> Corners {
        let [bits, x, y] = self.texel;
        weigh::corners(self.line, bits, x, y)
    }

    fn share(&mut self, i: usize, corners: &Corners) -> f64 {
        self.piece(i).share(corners)
    }

    /// Works out the shares that are too close to others, or to none at all, for estimates.
    fn settle(&mut self) {
        let mut doubtful = 0u32;
        for i in 0..self.order.len() {
            let next = self.order.get(i + 1).map_or(0.0, |next| next.share);
            if self.order[i].share - next <= 2.0 * CLOSE {
                doubtful |= 3 << i;
            }
        }
        if doubtful == 0 {
            return;
        }
        let corners = self.corners();
        for i in 0..self.order.len() {
            if doubtful >> i & 1 != 0 {
                self.order[i].share = self.share(i, &corners);
            }
        }
        self.sort();
    }

    fn sort(&mut self) {
        let order = self.order.as_mut_slice();
        if order.len() > ESTIMATED {
            order.sort_unstable_by(|a, b| {
                let by_share = b.share.total_cmp(&a.share);
                by_share.then(a.triangle.cmp(&b.triangle))
            });
            return;
        }
        for i in 1..order.len() {
            let (one, mut at) = (order[i], i);
            while at > 0 && one.before(&order[at - 1]) {
                order[at] = order[at - 1];
                at -= 1;
            }
            order[at] = one;
        }
    }

    /// The triangles in order.
    pub(super) fn order(&self) -> &[Rank] {
        &self.order
    }

    /// The piece of the i-th in order.
    pub(super) fn piece(&mut self, i: usize) -> &Piece {
        let place = self.order[i].place as usize;
        self.make_pieces();
        &self.pieces[place]
    }

    fn make_pieces(&mut self) {
        if self.pieces.is_empty() {
            self.pieces.resize_with(self.order.len(), Piece::default);
            for one in &self.order {
                self.pieces[one.place as usize] = piece(self.reference, one.triangle);
            }
        }
    }

    /// Whether there are triangles, the first has a share, and all shares together are the texel.
    pub(super) fn cover_all(&mut self) -> bool {
        if self.order.first().is_none_or(|first| first.share == 0.0) {
            return false;
        }
        let sum = |order: &[Rank]| order.iter().map(|w| w.share).sum::<f64>();
        let doubt = self.order.len() as f64 * CLOSE;
        if !self.exact && (sum(&self.order) - FULLY).abs() <= doubt {
            self.work_out();
        }
        sum(&self.order) > FULLY
    }

    /// Whether no two triangles of a layer have a line in common.
    pub(super) fn is_single(&mut self) -> bool {
        let count = self.order.len();
        if self.is_flat && count > FEW {
            return self.is_single_by_rows();
        }
        count <= MOST_PAIRED && (1..count).all(|i| (0..i).all(|j| self.apart(i, j)))
    }

    /// The same, by ascending rows: what begins above a triangle need not be compared with it.
    fn is_single_by_rows(&mut self) -> bool {
        let mut rows = [([0.0; 2], 0); MOST_PAIRED];
        let count = self.order.len();
        for i in 0..count {
            let one = (self.flat[self.order[i].place as usize].rows(), i);
            let mut at = i;
            while at > 0 && one.0[0] < rows[at - 1].0[0] {
                rows[at] = rows[at - 1];
                at -= 1;
            }
            rows[at] = one;
        }
        (1..count).all(|k| {
            let ([low, _], i) = rows[k];
            rows[..k]
                .iter()
                .all(|([_, high], j)| *high < low || self.apart(i, *j))
        })
    }

    /// Whether two triangles in order have different layers or no line in common.
    #[inline]
    fn apart(&mut self, i: usize, j: usize) -> bool {
        let (a, b) = (self.order[i], self.order[j]);
        let layer = &self.reference.layer;
        let (i, j) = (a.place as usize, b.place as usize);
        if self.is_flat && self.flat[i].surely_apart(&self.flat[j])
            || layer[a.triangle as usize] != layer[b.triangle as usize]
        {
            return true;
        }
        self.make_pieces();
        sides::apart(&self.pieces[i], &self.pieces[j])
    }

    /// The regions around the first triangle in which the i-th is to be tested.
    pub(super) fn regions(&mut self, i: usize) -> u32 {
        let (first, one) = (self.order[0].place as usize, self.order[i].place as usize);
        if self.is_flat
            && let Some(regions) = self.flat[first].regions(&self.flat[one])
        {
            return regions;
        }
        self.make_pieces();
        sides::regions(&self.pieces[first], &self.pieces[one])
    }
}

/// A triangle of the reference, prepared for tests.
pub(super) fn piece(reference: &Reference, triangle: u32) -> Piece {
    let vertices = reference.triangles[triangle as usize];
    let line = reference.primary.line();
    Piece::new(line, vertices, reference.corners(triangle as usize))
}
