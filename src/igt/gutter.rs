//! The gutter: entries for points of LoDs that lie outside the reference's charts.
//!
//! In: base lists and the [`Needs`]: which (texel, layer) pairs the LoDs touch. Out: for each needed pair whose texel has no
//! triangle of that layer, up to [`MOST`] triangles of the layer from the nearest ring of texels that has some; the
//! lookup then picks the nearest point among them. Integers only. Twin of `glsl/igt/gutter.comp`.
//!
//! The work of one pair is bounded ([`REACH`], [`PER_TEXEL`]) for the device's sake: llvmpipe ends the loops of a shader
//! invocation after 65535 iterations in total, silently.

use super::Reference;
use super::build::{Lists, for_each_texel};
use crate::param::projection::Line;
use rayon::prelude::*;

/// The most gutter entries of a (texel, layer) pair.
pub(super) const MOST: usize = 8;
/// The farthest ring of texels searched.
pub(super) const REACH: u32 = 48;
/// How many entries of one texel's list are considered.
pub(super) const PER_TEXEL: usize = 16;

/// The (texel, layer) pairs that LoDs touch, ascending: `texel << 8 | layer`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// The pairs.
    pub pairs: Vec<u64>,
}

/// A mesh on the vertex grid that will ask the tables: a LoD.
#[derive(Clone, Copy, Debug)]
pub struct Asking<'a> {
    /// Vertex-grid coordinates of the vertices.
    pub t3: &'a [[i32; 3]],
    /// Vertex indices.
    pub triangles: &'a [[u32; 3]],
    /// The layer of each triangle.
    pub layer: &'a [u8],
}

impl Needs {
    /// What `lods` touch in tables of the given hash resolution (log2).
    pub fn of(reference: &Reference, lods: &[Asking<'_>], bits: u32) -> Self {
        let line = reference.primary.line();
        let mut pairs: Vec<u64> = lods
            .par_iter()
            .flat_map_iter(|lod| {
                let mut touched = Vec::new();
                for (triangle, layer) in lod.triangles.iter().zip(lod.layer) {
                    let corners = triangle.map(|v| lod.t3[v as usize]);
                    for_each_texel(line, bits, &corners, |texel| {
                        touched.push((texel as u64) << 8 | *layer as u64)
                    });
                }
                touched.sort_unstable();
                touched.dedup();
                touched
            })
            .collect();
        pairs.par_sort_unstable();
        pairs.dedup();
        Needs { pairs }
    }
}

/// Gutter entries by texel: texel `t`'s are `items[start[i]..start[i + 1]]` for its place `i` in `texels`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Gutter {
    texels: Vec<u32>,
    start: Vec<u32>,
    pub(super) items: Vec<u32>,
    pub(super) width: u32,
    pub(super) unreached: u64,
}

impl Gutter {
    /// A walk over texels in ascending order, the first of them at least `texel`.
    pub(super) fn from(&self, texel: usize) -> Walk<'_> {
        Walk {
            gutter: self,
            at: self.texels.partition_point(|t| (*t as usize) < texel),
        }
    }

    /// Gathers what was found for the pairs that need something, in ascending order of pairs.
    pub(super) fn from_found(found: impl Iterator<Item = (u64, Found)>) -> Self {
        let mut gutter = Gutter::default();
        for (pair, found) in found {
            let texel = (pair >> 8) as u32;
            match found.ring {
                UNREACHED => gutter.unreached += 1,
                ring => gutter.width = gutter.width.max(ring),
            }
            if gutter.texels.last() != Some(&texel) && found.count > 0 {
                gutter.texels.push(texel);
                gutter.start.push(gutter.items.len() as u32);
            }
            gutter
                .items
                .extend(&found.triangles[..found.count as usize]);
        }
        gutter.start.push(gutter.items.len() as u32);
        gutter
    }
}

/// A walk over the gutter's texels.
pub(super) struct Walk<'a> {
    gutter: &'a Gutter,
    at: usize,
}

impl<'a> Walk<'a> {
    /// The entries of a texel. Texels ascend from call to call, and none that has entries is left out.
    pub(super) fn of(&mut self, texel: usize) -> &'a [u32] {
        if self.gutter.texels.get(self.at) != Some(&(texel as u32)) {
            return &[];
        }
        let range = self.gutter.start[self.at] as usize..self.gutter.start[self.at + 1] as usize;
        self.at += 1;
        &self.gutter.items[range]
    }
}

/// Ring of a pair without any triangle of the layer in reach.
pub(super) const UNREACHED: u32 = u32::MAX;

/// What the search found for a pair whose texel has no triangle of the layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) ring: u32,
    pub(super) count: u32,
    pub(super) triangles: [u32; MOST],
}

/// Searches for every needed pair.
pub(super) fn fill(reference: &Reference, bits: u32, lists: &Lists, needs: &Needs) -> Gutter {
    let line = reference.primary.line();
    let found: Vec<(u64, Found)> = needs
        .pairs
        .par_iter()
        .filter_map(|pair| {
            let found = search(line, bits, lists, &reference.layer, *pair)?;
            Some((*pair, found))
        })
        .collect();
    Gutter::from_found(found.into_iter())
}

/// What a pair gets; nothing where its texel has a triangle of the layer already.
fn search(line: Line, bits: u32, lists: &Lists, layer: &[u8], pair: u64) -> Option<Found> {
    let (texel, wanted) = ((pair >> 8) as u32, (pair & 255) as u8);
    let at = [(texel & ((1 << bits) - 1)) as i32, (texel >> bits) as i32];
    let has = |t: u32| {
        lists
            .of(t as usize)
            .iter()
            .any(|i| layer[*i as usize] == wanted)
    };
    let mut found = Found {
        ring: UNREACHED,
        count: 0,
        triangles: [0; MOST],
    };
    if has(texel) {
        return None;
    }
    let Some(ring) = (1..=REACH.min(1 << bits))
        .find(|r| ring_any(*r, |d| neighbour(line, bits, at, d).is_some_and(has)))
    else {
        return Some(found);
    };
    found.ring = ring;
    let distance = |d: [i32; 2]| (d[0] * d[0] + d[1] * d[1]) as u64;
    let mut nearest = u64::MAX;
    ring_any(ring, |d| {
        if neighbour(line, bits, at, d).is_some_and(has) {
            nearest = nearest.min(distance(d));
        }
        false
    });
    let mut keys = [u64::MAX; MOST];
    ring_any(ring, |d| {
        // A triangle that comes nearest need not lie in the nearest texel: take in those about half a texel farther.
        if distance(d) <= nearest + ring as u64
            && let Some(t) = neighbour(line, bits, at, d)
        {
            for i in lists
                .of(t as usize)
                .iter()
                .take(PER_TEXEL)
                .filter(|i| layer[**i as usize] == wanted)
            {
                keep(&mut keys, distance(d) << 32 | *i as u64);
            }
        }
        false
    });
    for (slot, key) in found.triangles.iter_mut().zip(keys) {
        if key != u64::MAX {
            *slot = key as u32;
            found.count += 1;
        }
    }
    Some(found)
}

/// Visits the texel offsets at Chebyshev distance `r` until `stop` says so; whether it did.
fn ring_any(r: u32, mut stop: impl FnMut([i32; 2]) -> bool) -> bool {
    let r = r as i32;
    (-r..=r).any(|x| stop([x, -r]) || stop([x, r]))
        || (1 - r..r).any(|y| stop([-r, y]) || stop([r, y]))
}

/// Keeps the smallest keys in ascending order, one for each triangle.
fn keep(keys: &mut [u64; MOST], key: u64) {
    let triangle = key as u32;
    let present = keys
        .iter()
        .position(|k| *k != u64::MAX && *k as u32 == triangle);
    let mut at = match present {
        Some(i) if keys[i] <= key => return,
        Some(i) => i,
        None if keys[MOST - 1] <= key => return,
        None => MOST - 1,
    };
    while at > 0 && keys[at - 1] > key {
        keys[at] = keys[at - 1];
        at -= 1;
    }
    keys[at] = key;
}

/// The texel at an offset: charts and planes end at the border, a cylinder closes in its columns, the octahedral map
/// continues mirrored beyond each side.
fn neighbour(line: Line, bits: u32, at: [i32; 2], offset: [i32; 2]) -> Option<u32> {
    let width = 1i32 << bits;
    let inside = |x: i32| (0..width).contains(&x);
    let (mut x, mut y) = (at[0] + offset[0], at[1] + offset[1]);
    match line {
        Line::Parallel => {}
        Line::Cylinder => x &= width - 1,
        Line::Sphere => {
            if !inside(x) {
                (x, y) = (
                    if x < 0 { -1 - x } else { 2 * width - 1 - x },
                    width - 1 - y,
                );
            }
            if !inside(y) {
                (x, y) = (
                    width - 1 - x,
                    if y < 0 { -1 - y } else { 2 * width - 1 - y },
                );
            }
        }
    }
    (inside(x) && inside(y)).then_some(((y << bits) | x) as u32)
}
