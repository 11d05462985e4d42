//! The last step of both builds: lists and gutter in, [`Tables`] out.
//!
//! Words are laid out in bands of texels, one worker a band; where a band's words begin is known from its lengths.

use super::build::Lists;
use super::gutter::Gutter;
use super::layout::{self, EMPTY, LAST, LONG};
use super::{BuildOptions, Layout, Reference, Stats, Tables};
use crate::error::{Error, Result};
use rayon::prelude::*;

/// Texels of a band.
const BAND: usize = 1 << 12;

/// Lays the lists out in words.
pub(super) fn tables(
    reference: &Reference,
    options: BuildOptions,
    lists: &Lists,
    gutter: &Gutter,
) -> Result<Tables> {
    let texels = lists.start.len() - 1;
    let bands: Vec<Band> = (0..texels.div_ceil(BAND))
        .into_par_iter()
        .map(|band| Band::measure(lists, gutter, band))
        .collect();
    let filled: u64 = bands.iter().map(|band| band.filled).sum();
    let longest = bands.iter().map(|band| band.longest).max().unwrap_or(0);
    let entries = lists.items.len() as u64 + gutter.items.len() as u64;
    let (hash, list) = match options.layout {
        Layout::Packed => packed_lists(lists, gutter, &bands),
        Layout::Classic => classic_lists(lists, gutter, longest, &reference.layer)?,
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

/// The lists of a band's texels, each with its gutter entries.
fn texels<'a>(
    lists: &'a Lists,
    gutter: &'a Gutter,
    band: usize,
) -> impl Iterator<Item = (&'a [u32], &'a [u32])> {
    let range = band * BAND..((band + 1) * BAND).min(lists.start.len() - 1);
    let mut beyond = gutter.from(range.start);
    range.map(move |texel| (lists.of(texel), beyond.of(texel)))
}

/// Figures of a band.
struct Band {
    entries: u64,
    filled: u64,
    longest: u32,
}

impl Band {
    fn measure(lists: &Lists, gutter: &Gutter, band: usize) -> Self {
        let mut figures = Band {
            entries: 0,
            filled: 0,
            longest: 0,
        };
        for (own, more) in texels(lists, gutter, band) {
            let length = (own.len() + more.len()) as u32;
            figures.entries += u64::from(length);
            figures.filled += u64::from(length > 0);
            figures.longest = figures.longest.max(length);
        }
        figures
    }
}

/// Cuts a list into the bands' parts, each with where it begins.
fn parts(list: &mut [u32], lengths: impl Iterator<Item = usize>) -> Vec<(u32, &mut [u32])> {
    let (mut rest, mut begin) = (list, 0);
    lengths
        .map(|length| {
            let (part, others) = std::mem::take(&mut rest).split_at_mut(length);
            rest = others;
            let part = (begin, part);
            begin += length as u32;
            part
        })
        .collect()
}

fn packed_lists(lists: &Lists, gutter: &Gutter, bands: &[Band]) -> (Vec<u32>, Vec<u32>) {
    // Each list's first entry stands in the hash.
    let words = |band: &Band| (band.entries - band.filled) as usize;
    let mut hash = vec![0; 2 * (lists.start.len() - 1)];
    let mut list = vec![0; bands.iter().map(words).sum()];
    hash.par_chunks_mut(2 * BAND)
        .zip(parts(&mut list, bands.iter().map(words)))
        .enumerate()
        .for_each(|(band, (hash, (begin, list)))| {
            let mut at = 0;
            for (texel, (own, more)) in hash.chunks_exact_mut(2).zip(texels(lists, gutter, band)) {
                let mut all = own.iter().chain(more).copied();
                let Some(first) = all.next() else {
                    texel.fill(EMPTY);
                    continue;
                };
                let rest = own.len() + more.len() - 1;
                let words = &mut list[at..at + rest];
                words.iter_mut().zip(all).for_each(|(word, x)| *word = x);
                texel[0] = first;
                texel[1] = begin + at as u32;
                *words.last_mut().unwrap_or(&mut texel[0]) |= LAST;
                at += rest;
            }
        });
    (hash, list)
}

fn classic_lists(
    lists: &Lists,
    gutter: &Gutter,
    longest: u32,
    layer: &[u8],
) -> Result<(Vec<u32>, Vec<u32>)> {
    let (hash, ends) = classic_hash(lists, gutter, longest)?;
    let mut list = vec![0; ends.last().copied().unwrap_or(0)];
    let lengths = ends
        .iter()
        .scan(0, |before, end| Some(end - std::mem::replace(before, *end)));
    let entry = |i: &u32| i | (layer[*i as usize] as u32) << 24;
    hash.par_chunks(BAND)
        .zip(parts(&mut list, lengths))
        .enumerate()
        .for_each(|(band, (hash, (begin, list)))| {
            for (texel, (own, more)) in hash.iter().zip(texels(lists, gutter, band)) {
                let length = own.len() + more.len();
                if length == 0 {
                    continue;
                }
                let mut words = &mut list[((texel & 0xff_ffff) - begin) as usize..];
                if length >= LONG as usize {
                    words[0] = length as u32;
                    words = &mut words[1..];
                }
                let all = own.iter().chain(more).map(entry);
                words.iter_mut().zip(all).for_each(|(word, x)| *word = x);
            }
        });
    Ok((hash, list))
}

/// The classic hash texture, and after each band how many words the lists take so far.
fn classic_hash(lists: &Lists, gutter: &Gutter, longest: u32) -> Result<(Vec<u32>, Vec<usize>)> {
    let row = layout::classic_row(longest) as usize;
    let count = lists.start.len() - 1;
    let (mut hash, mut ends) = (vec![0u32; count], Vec::new());
    let mut at = 0;
    for (band, hash) in hash.chunks_mut(BAND).enumerate() {
        for (texel, (own, more)) in hash.iter_mut().zip(texels(lists, gutter, band)) {
            let length = own.len() + more.len();
            if length == 0 {
                continue;
            }
            let words = length + usize::from(length >= LONG as usize);
            let column = at % row;
            if column + words > row {
                // Lists never straddle a row: move to the beginning of the next one (section 2.3).
                at += row - column;
            }
            *texel = at as u32 | (length as u32).min(LONG) << 24;
            at += words;
            if at > 1 << 24 {
                return Err(Error::Capacity {
                    what:
                        "list entries of the classic layout (3-byte addresses; use --layout packed)"
                            .into(),
                    need: lists.items.len() as u64,
                    have: 1 << 24,
                });
            }
        }
        ends.push(at);
    }
    Ok((hash, ends))
}

/// The triangle table.
fn triangle_table(reference: &Reference) -> Vec<u32> {
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
