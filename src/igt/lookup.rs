//! The lookup: from a T3 point to the reference point it stands for. Twin of `glsl/common/igt.glsl`.
//!
//! In: [`Tables`], a query-grid point, the layer of the LoD triangle that asks. Out: [`Found`].
//!
//! Among several hits (the surface overlaps itself in T3) the policy is: the same layer first (*same part*), then the hit
//! closest to the query (*closest*, the paper's), then the lowest triangle id. Without a hit the nearest point of the
//! same layer's listed triangles (the gutter), then a hit of another layer, then the nearest point of any.
//! Source: Inverse Geometric Textures, sections 2.2 and 5.

use super::layout::{self, EMPTY, LAST, LONG};
use super::{Layout, Tables};
use crate::param::projection::{self, GridTriangle};

/// Offsets are scaled by this before float arithmetic, so that no product leaves f32's range.
const OFFSET_SCALE: f32 = 1.0 / (1 << 20) as f32;

/// The answer of a lookup.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The reference triangle.
    pub triangle: u32,
    /// Barycentric coordinates in it.
    pub barycentric: [f32; 3],
    /// Load instructions (up to 128 bits each) that the answer took.
    pub fetches: u32,
    /// Whether the projection line meets the triangle (`false`: the nearest point, outside every chart).
    pub hit: bool,
}

#[derive(Clone, Copy)]
struct Candidate {
    rank: u32,
    distance: f32,
    triangle: u32,
    barycentric: [f32; 3],
}

impl Candidate {
    const NONE: Candidate = Candidate {
        rank: 4,
        distance: 0.0,
        triangle: u32::MAX,
        barycentric: [0.0; 3],
    };

    fn better_than(&self, other: &Candidate) -> bool {
        (self.rank, self.distance, self.triangle) < (other.rank, other.distance, other.triangle)
    }
}

impl Tables {
    /// The reference point that `query` (query grid of [`Tables::primary`]) stands for. `layer`: the part of the LoD
    /// triangle that asks, `None` for any. `nearest`: whether points outside every chart get the nearest listed one.
    pub fn lookup(&self, query: [i32; 3], layer: Option<u8>, nearest: bool) -> Option<Found> {
        let mut fetches = 0;
        let mut best = self.scan(query, layer, false, Candidate::NONE, &mut fetches);
        if nearest && best.rank > 0 {
            best = self.scan(query, layer, true, best, &mut fetches);
        }
        (best.rank < 4).then_some(Found {
            triangle: best.triangle,
            barycentric: best.barycentric,
            fetches,
            hit: best.rank & 1 == 0,
        })
    }

    /// Loads of a lookup that finds nothing: the hash texel and its list.
    pub fn fetches_of_miss(&self, query: [i32; 3]) -> u32 {
        let mut fetches = 0;
        self.scan(query, None, false, Candidate::NONE, &mut fetches);
        fetches
    }

    /// One walk over the texel's list: hits (ranks 0 and 2), or nearest points (ranks 1 and 3).
    fn scan(
        &self,
        query: [i32; 3],
        layer: Option<u8>,
        nearest: bool,
        mut best: Candidate,
        fetches: &mut u32,
    ) -> Candidate {
        let line = self.primary.line();
        self.for_each_entry(query, fetches, |triangle, corners, of_layer| {
            let other = u32::from(layer.is_some_and(|l| l != of_layer)) * 2;
            let w = corners.map(|v| projection::offset(v, query).map(|x| x as f32 * OFFSET_SCALE));
            let candidate = if nearest {
                let (barycentric, distance) = projection::nearest(w);
                Candidate {
                    rank: other + 1,
                    distance,
                    triangle,
                    barycentric,
                }
            } else {
                let Some(hit) = projection::hit(line, query, &corners) else {
                    return;
                };
                let barycentric = hit.barycentric();
                let distance = projection::squared_length(projection::combine(barycentric, w));
                Candidate {
                    rank: other,
                    distance,
                    triangle,
                    barycentric,
                }
            };
            if candidate.better_than(&best) {
                best = candidate;
            }
        });
        best
    }

    fn for_each_entry(
        &self,
        query: [i32; 3],
        fetches: &mut u32,
        mut visit: impl FnMut(u32, GridTriangle, u8),
    ) {
        let flat = layout::is_flat(&self.primary);
        let bits = self.bits();
        let [x, y] = self.primary.line().texel(bits, query);
        let texel = (y << bits | x) as usize;
        let words = layout::triangle_words(self.layout, &self.primary);
        let mut read = |triangle: u32, layer: Option<u8>, fetches: &mut u32| {
            *fetches += layout::triangle_fetches(self.layout, &self.primary);
            let record = &self.triangle[triangle as usize * words..][..words];
            let (corners, stored) = layout::decode_triangle(self.layout, flat, record);
            visit(triangle, corners, layer.unwrap_or(stored));
        };
        *fetches += 1;
        match self.layout {
            Layout::Packed => {
                let (mut entry, mut next) =
                    (self.hash[2 * texel], self.hash[2 * texel + 1] as usize);
                if entry == EMPTY {
                    return;
                }
                loop {
                    read(entry & !LAST, None, fetches);
                    if entry & LAST != 0 {
                        return;
                    }
                    entry = self.list[next];
                    next += 1;
                    *fetches += 1;
                }
            }
            Layout::Classic => {
                let word = self.hash[texel];
                let (mut start, mut length) = ((word & 0xff_ffff) as usize, word >> 24);
                if length == LONG {
                    length = self.list[start];
                    start += 1;
                    *fetches += 1;
                }
                for entry in &self.list[start..start + length as usize] {
                    *fetches += 1;
                    read(entry & 0xff_ffff, Some((entry >> 24) as u8), fetches);
                }
            }
        }
    }
}
