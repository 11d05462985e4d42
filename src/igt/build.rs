//! The CPU build: every pass in plain Rust on all cores. The GPU build (`gpu/`) gives the same bytes.
//!
//! In: a [`Reference`], LoDs, options. Out: [`Tables`].

use super::cover::{SEVERAL_OCTANTS, Toucher, boxes};
use super::gutter::{self, Needs};
use super::layout::{self, EMPTY, LAST, LONG};
use super::{BuildOptions, Layout, Reference, Stats, Tables};
use crate::error::{Error, Result};
use crate::param::projection::{GridTriangle, Line};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// Lists of triangles, one for each texel: `items[start[t]..start[t + 1]]`, ascending.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lists {
    pub(super) start: Vec<u32>,
    pub(super) items: Vec<u32>,
}

impl Lists {
    pub(super) fn of(&self, texel: usize) -> &[u32] {
        &self.items[self.start[texel] as usize..self.start[texel + 1] as usize]
    }
}

/// Builds the tables on the CPU. `needs` are the texels that LoDs touch, see [`Needs::of`].
///
/// # Errors
/// [`Error::Option`] for a hash resolution out of range, [`Error::Capacity`] where a table cannot hold the lists.
pub fn build_cpu(reference: &Reference, needs: &Needs, options: BuildOptions) -> Result<Tables> {
    let bits = options.bits()?;
    check_layout(reference, options)?;
    let pairs = cover_all(reference, bits);
    let lists = lists_of(&pairs, bits)?;
    let gutter = gutter::fill(reference, bits, &lists, needs);
    finish(reference, options, &lists, &gutter)
}

/// The reference must have been rounded for the layout it is built in.
pub(super) fn check_layout(reference: &Reference, options: BuildOptions) -> Result<()> {
    if reference.layout == options.layout {
        return Ok(());
    }
    Err(Error::Option {
        option: "--layout",
        reason: format!(
            "the reference was rounded for {:?}, not {:?}",
            reference.layout, options.layout
        ),
    })
}

/// Calls `visit` with the index of every texel that `triangle` touches (a texel may come twice).
pub(super) fn for_each_texel(
    line: Line,
    bits: u32,
    triangle: &GridTriangle,
    mut visit: impl FnMut(u32),
) {
    let (boxes, count) = boxes(line, bits, triangle);
    if count == 1 && boxes[0].area() == 1 && boxes[0].octant & SEVERAL_OCTANTS == 0 {
        // The commonest case at coarse resolutions: nothing to test.
        let [x, y] = boxes[0].texel(bits, 0);
        return visit(y << bits | x);
    }
    let toucher = Toucher::new(line, bits, triangle);
    for one in &boxes[..count] {
        for i in 0..one.area() {
            let [x, y] = one.texel(bits, i);
            if toucher.touches([x, y], one.octant) {
                visit(y << bits | x);
            }
        }
    }
}

/// All (texel, triangle) pairs, in blocks of ascending triangles.
fn cover_all(reference: &Reference, bits: u32) -> Vec<Vec<[u32; 2]>> {
    let line = reference.primary.line();
    let block = (reference.triangles.len() / (rayon::current_num_threads() * 8)).max(1024);
    (0..reference.triangles.len().div_ceil(block))
        .into_par_iter()
        .map(|b| {
            let range = b * block..((b + 1) * block).min(reference.triangles.len());
            let mut pairs = Vec::with_capacity(range.len() * 4);
            for triangle in range {
                for_each_texel(line, bits, &reference.corners(triangle), |texel| {
                    pairs.push([texel, triangle as u32])
                });
            }
            pairs
        })
        .collect()
}

/// Sorts pairs into lists: counting sort by texel; within a texel triangles stay ascending and are made unique.
fn lists_of(pairs: &[Vec<[u32; 2]>], bits: u32) -> Result<Lists> {
    let texels = 1usize << (2 * bits);
    let entries: u64 = pairs.iter().map(|block| block.len() as u64).sum();
    if entries > u32::MAX as u64 / 2 {
        return Err(Error::Capacity {
            what: "list entries".into(),
            need: entries,
            have: u32::MAX as u64 / 2,
        });
    }
    let counts: Vec<AtomicU32> = (0..=texels)
        .into_par_iter()
        .map(|_| AtomicU32::new(0))
        .collect();
    pairs.par_iter().for_each(|block| {
        for [texel, _] in block {
            counts[*texel as usize + 1].fetch_add(1, Ordering::Relaxed);
        }
    });
    let mut start: Vec<u32> = counts.into_iter().map(AtomicU32::into_inner).collect();
    for i in 0..texels {
        start[i + 1] += start[i];
    }
    let mut items = vec![0u32; entries as usize];
    scatter(pairs, &start, &mut items);
    Ok(unique(Lists { start, items }))
}

/// Each worker owns a range of texels and walks all pairs in order, so lists come out ascending without a sort.
fn scatter(pairs: &[Vec<[u32; 2]>], start: &[u32], items: &mut [u32]) {
    let texels = start.len() - 1;
    let workers = rayon::current_num_threads().clamp(1, texels);
    let mut rest = items;
    let mut slices = Vec::with_capacity(workers);
    for w in 0..workers {
        let range = texels * w / workers..texels * (w + 1) / workers;
        let (mine, others) = rest.split_at_mut((start[range.end] - start[range.start]) as usize);
        slices.push((range, mine));
        rest = others;
    }
    slices.into_par_iter().for_each(|(range, slice)| {
        let base = start[range.start];
        let mut cursor: Vec<u32> = start[range.clone()].iter().map(|s| s - base).collect();
        for [texel, triangle] in pairs.iter().flatten() {
            if range.contains(&(*texel as usize)) {
                let at = &mut cursor[*texel as usize - range.start];
                slice[*at as usize] = *triangle;
                *at += 1;
            }
        }
    });
}

/// Removes the rare doubles (a triangle that reaches a texel through two octants).
fn unique(lists: Lists) -> Lists {
    let texels = lists.start.len() - 1;
    let has_doubles = (0..texels)
        .into_par_iter()
        .any(|t| lists.of(t).windows(2).any(|w| w[0] == w[1]));
    if !has_doubles {
        return lists;
    }
    let mut out = Lists {
        start: Vec::with_capacity(texels + 1),
        items: Vec::with_capacity(lists.items.len()),
    };
    for t in 0..texels {
        out.start.push(out.items.len() as u32);
        let list = lists.of(t);
        out.items.extend(
            list.iter()
                .enumerate()
                .filter(|(i, x)| *i == 0 || list[i - 1] != **x)
                .map(|(_, x)| *x),
        );
    }
    out.start.push(out.items.len() as u32);
    out
}

/// Lays the lists out in words.
pub(super) fn finish(
    reference: &Reference,
    options: BuildOptions,
    lists: &Lists,
    gutter: &gutter::Gutter,
) -> Result<Tables> {
    let texels = lists.start.len() - 1;
    let length = |t: usize| lists.of(t).len() as u32 + gutter.of(t).len() as u32;
    let longest = (0..texels).into_par_iter().map(length).max().unwrap_or(0);
    let filled = (0..texels)
        .into_par_iter()
        .filter(|t| length(*t) > 0)
        .count();
    let entries = lists.items.len() as u64 + gutter.items.len() as u64;
    let (hash, list) = match options.layout {
        Layout::Packed => packed_lists(texels, lists, gutter),
        Layout::Classic => classic_lists(texels, lists, gutter, longest, &reference.layer)?,
    };
    let stats = Stats {
        entries,
        gutter_entries: gutter.items.len() as u64,
        gutter_width: gutter.width,
        unreached_texels: gutter.unreached,
        mean_list: if filled == 0 {
            0.0
        } else {
            entries as f64 / filled as f64
        },
        max_list: longest,
        collapsed_triangles: collapsed(reference),
    };
    Ok(Tables {
        layout: options.layout,
        hash_size: [options.hash; 2],
        primary: reference.primary,
        hash,
        list,
        triangle: triangle_table(reference),
        stats,
    })
}

fn packed_lists(texels: usize, lists: &Lists, gutter: &gutter::Gutter) -> (Vec<u32>, Vec<u32>) {
    let mut hash = vec![EMPTY; 2 * texels];
    let mut list = Vec::with_capacity(lists.items.len() + gutter.items.len());
    for t in 0..texels {
        let mut all = lists.of(t).iter().chain(gutter.of(t)).copied();
        let Some(first) = all.next() else { continue };
        hash[2 * t + 1] = list.len() as u32;
        let before = list.len();
        list.extend(all);
        if list.len() == before {
            hash[2 * t] = first | LAST;
        } else {
            hash[2 * t] = first;
            *list.last_mut().expect("just extended") |= LAST;
        }
    }
    (hash, list)
}

fn classic_lists(
    texels: usize,
    lists: &Lists,
    gutter: &gutter::Gutter,
    longest: u32,
    layer: &[u8],
) -> Result<(Vec<u32>, Vec<u32>)> {
    let row = layout::classic_row(longest);
    let (mut hash, mut list) = (vec![0u32; texels], Vec::new());
    for t in 0..texels {
        let entries = || {
            lists
                .of(t)
                .iter()
                .chain(gutter.of(t))
                .map(|i| i | (layer[*i as usize] as u32) << 24)
        };
        let length = entries().count() as u32;
        if length == 0 {
            continue;
        }
        let words = length + u32::from(length >= LONG);
        let column = list.len() as u32 % row;
        if column + words > row {
            // Lists never straddle a row: move to the beginning of the next one (section 2.3).
            list.resize(list.len() + (row - column) as usize, 0);
        }
        hash[t] = list.len() as u32 | length.min(LONG) << 24;
        if length >= LONG {
            list.push(length);
        }
        list.extend(entries());
        if list.len() > 1 << 24 {
            return Err(Error::Capacity {
                what: "list entries of the classic layout (3-byte addresses; use --layout packed)"
                    .into(),
                need: lists.items.len() as u64,
                have: 1 << 24,
            });
        }
    }
    Ok((hash, list))
}

/// The triangle table.
pub(super) fn triangle_table(reference: &Reference) -> Vec<u32> {
    let flat = layout::is_flat(&reference.primary);
    let words = layout::triangle_words(reference.layout, &reference.primary);
    let mut table = vec![0u32; reference.triangles.len() * words];
    table
        .par_chunks_mut(words)
        .enumerate()
        .for_each(|(t, out)| {
            layout::encode_triangle(
                reference.layout,
                flat,
                &reference.corners(t),
                reference.layer[t],
                out,
            );
        });
    table
}

/// Triangles without area on the grid.
fn collapsed(reference: &Reference) -> u64 {
    (0..reference.triangles.len())
        .into_par_iter()
        .filter(|t| {
            let c = reference.corners(*t);
            let e = |i: usize| [0, 1, 2].map(|k| c[i][k] as i64 - c[0][k] as i64);
            let (a, b) = (e(1), e(2));
            a[0] * b[1] == a[1] * b[0] && a[1] * b[2] == a[2] * b[1] && a[2] * b[0] == a[0] * b[2]
        })
        .count() as u64
}
