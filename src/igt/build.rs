//! The CPU build: every pass in plain Rust on all cores. The GPU build (`gpu/`) gives the same bytes.
//!
//! In: a [`Reference`], LoDs, options. Out: [`Tables`].

use super::cover::{SEVERAL_OCTANTS, TexelBox, Toucher, boxes};
use super::gutter::{self, Needs};
use super::{BuildOptions, Reference, Tables, finish};
use crate::error::{Error, Result};
use crate::param::projection::{GridTriangle, Line};
use rayon::prelude::*;

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
    let lists = lists_of(&cover_all(reference, bits), bits)?;
    let gutter = gutter::fill(reference, bits, &lists, needs);
    finish::tables(reference, options, &lists, &gutter)
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

/// Calls `visit` once with the index of every texel that `triangle` touches.
pub(super) fn for_each_texel(
    line: Line,
    bits: u32,
    triangle: &GridTriangle,
    mut visit: impl FnMut(u32),
) {
    let (boxes, count) = boxes(line, bits, triangle);
    if count == 1 && is_alone(&boxes[0]) {
        // The commonest case at coarse resolutions: nothing to test.
        return visit(boxes[0].texel(bits, 0));
    }
    let toucher = Toucher::new(line, bits, triangle);
    if count == 1 {
        return touched(&toucher, bits, &boxes[0], visit);
    }
    // Octants share the texels on their borders.
    let mut texels = Vec::new();
    for one in &boxes[..count] {
        touched(&toucher, bits, one, |texel| texels.push(texel));
    }
    texels.sort_unstable();
    texels.dedup();
    texels.into_iter().for_each(visit);
}

/// Whether a box is a triangle's only texel.
fn is_alone(one: &TexelBox) -> bool {
    one.area() == 1 && one.octant & SEVERAL_OCTANTS == 0
}

fn touched(toucher: &Toucher<'_>, bits: u32, one: &TexelBox, mut visit: impl FnMut(u32)) {
    for tile in (0..one.tiles()).map(|i| one.tile(i)) {
        let mut mask = toucher.touched(&tile);
        while mask != 0 {
            visit(tile.texel(bits, mask.trailing_zeros()));
            mask &= mask - 1;
        }
    }
}

/// (texel, triangle) pairs of a block of triangles, by the band of texels they lie in; triangles ascend in each band.
pub(super) type Block = Vec<Vec<[u32; 2]>>;

/// log2 of the texels in a band: few enough that one worker's counters stay in its cache, and at most 256 bands.
fn band_bits(bits: u32) -> u32 {
    (2 * bits)
        .saturating_sub(8)
        .clamp(14.min(2 * bits), 2 * bits)
}

/// All (texel, triangle) pairs, in blocks of ascending triangles.
pub(super) fn cover_all(reference: &Reference, bits: u32) -> Vec<Block> {
    let line = reference.primary.line();
    let count = reference.triangles.len();
    let size = (count / (rayon::current_num_threads() * 8)).max(1024);
    let shift = band_bits(bits);
    (0..count.div_ceil(size))
        .into_par_iter()
        .map(|block| {
            let mut bands = vec![Vec::new(); 1 << (2 * bits - shift)];
            for triangle in block * size..((block + 1) * size).min(count) {
                for_each_texel(line, bits, &reference.corners(triangle), |texel| {
                    bands[(texel >> shift) as usize].push([texel, triangle as u32])
                });
            }
            bands
        })
        .collect()
}

/// Sorts pairs into lists: band by band a counting sort by texel; within a texel triangles stay ascending.
pub(super) fn lists_of(blocks: &[Block], bits: u32) -> Result<Lists> {
    let entries: u64 = blocks.iter().flatten().map(|band| band.len() as u64).sum();
    if entries > u32::MAX as u64 / 2 {
        return Err(Error::Capacity {
            what: "list entries".into(),
            need: entries,
            have: u32::MAX as u64 / 2,
        });
    }
    let (texels, band) = (1usize << (2 * bits), 1usize << band_bits(bits));
    let mut start = vec![0u32; texels + 1];
    start[texels] = entries as u32;
    let mut items = vec![0u32; entries as usize];
    let (mut rest, mut before) = (items.as_mut_slice(), 0);
    let mut bands = Vec::with_capacity(texels / band);
    for (i, start) in start[..texels].chunks_mut(band).enumerate() {
        let length: usize = blocks.iter().map(|block| block[i].len()).sum();
        let (mine, others) = rest.split_at_mut(length);
        bands.push((start, mine, before));
        rest = others;
        before += length as u32;
    }
    bands
        .into_par_iter()
        .enumerate()
        .for_each(|(i, (start, items, before))| {
            sort_band(blocks.iter().map(|block| &block[i]), start, items);
            start.iter_mut().for_each(|s| *s += before);
        });
    Ok(Lists { start, items })
}

/// The counting sort of one band: `start` and `items` are its own, and count from its first texel and entry.
fn sort_band<'a>(
    pairs: impl Iterator<Item = &'a Vec<[u32; 2]>> + Clone,
    start: &mut [u32],
    items: &mut [u32],
) {
    let within = start.len() - 1;
    for [texel, _] in pairs.clone().flatten() {
        start[*texel as usize & within] += 1;
    }
    let mut sum = 0;
    for s in start.iter_mut() {
        sum += std::mem::replace(s, sum);
    }
    let mut next = start.to_vec();
    for [texel, triangle] in pairs.flatten() {
        let at = &mut next[*texel as usize & within];
        items[*at as usize] = *triangle;
        *at += 1;
    }
}
