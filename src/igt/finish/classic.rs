//! Hash and lists of the classic layout, see [`layout::classic`](super::super::layout::classic).

use super::super::build::Lists;
use super::super::gutter::Gutter;
use super::super::layout::Window;
use super::super::layout::classic::{LONG, row};
use super::{BAND, Words, texels};
use crate::error::{Error, Result};
use rayon::prelude::*;

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

pub(super) fn words(
    window: Window,
    lists: &Lists,
    gutter: &Gutter,
    longest: u32,
    layer: &[u8],
) -> Result<Words> {
    let (hash, ends, row_waste) = hash_words(lists, gutter, longest)?;
    let mut list = vec![0; ends.last().copied().unwrap_or(0)];
    let lengths = ends
        .iter()
        .scan(0, |before, end| Some(end - std::mem::replace(before, *end)));
    let entry = |i: &u32| i | (layer[*i as usize] as u32) << 24;
    hash.par_chunks(BAND)
        .zip(parts(&mut list, lengths))
        .enumerate()
        .for_each(|(band, (hash, (begin, list)))| {
            for (texel, (_, own, more)) in hash.iter().zip(texels(lists, gutter, band)) {
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
    Ok(Words {
        window,
        hash,
        list,
        divided_texels: 0,
        overlapping_lists: 0,
        row_waste,
    })
}

/// The hash texture, after each band how many words the lists take so far, and the words that rows waste.
fn hash_words(lists: &Lists, gutter: &Gutter, longest: u32) -> Result<(Vec<u32>, Vec<usize>, u64)> {
    let row = row(longest) as usize;
    let count = lists.start.len() - 1;
    let (mut hash, mut ends) = (vec![0u32; count], Vec::new());
    let (mut at, mut waste) = (0, 0);
    for (band, hash) in hash.chunks_mut(BAND).enumerate() {
        for (texel, (_, own, more)) in hash.iter_mut().zip(texels(lists, gutter, band)) {
            let length = own.len() + more.len();
            if length == 0 {
                continue;
            }
            let words = length + usize::from(length >= LONG as usize);
            let column = at % row;
            if column + words > row {
                // Lists never straddle a row: move to the beginning of the next one (section 2.3).
                at += row - column;
                waste += (row - column) as u64;
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
    Ok((hash, ends, waste))
}
