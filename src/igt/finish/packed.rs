//! Hash and lists of the packed layout, see [`layout::packed`](super::super::layout::packed).
//!
//! Each band lays its lists out from address zero on; then all are put one after the other and the heads moved.

use super::super::Reference;
use super::super::build::Lists;
use super::super::gutter::Gutter;
use super::super::layout::packed::{self as bits_of, Kind, Masked};
use super::super::layout::{Format, Window};
use super::arrange::{Arranger, Texel};
use super::{Words, bands, texels};
use crate::error::{Error, Result};
use rayon::prelude::*;

/// The words of a band's texels, addresses from zero on.
#[derive(Default)]
pub(super) struct Band {
    heads: Vec<u64>,
    children: Vec<u64>,
    half: Vec<u64>,
    full: Vec<[u32; 4]>,
    divided: u64,
    overlapping: u64,
}

/// Where a band's words begin among those of all bands.
#[derive(Clone, Copy, Default)]
struct Base {
    children: u64,
    half: u64,
    full: u64,
}

/// Lays out all lists.
pub(super) fn words(
    reference: &Reference,
    bits: u32,
    lists: &Lists,
    gutter: &Gutter,
) -> Result<Words> {
    let window = window(bits, lists, gutter);
    let laid_out: Vec<Band> = bands(lists)
        .map(|band| {
            let mut out = Band::default();
            let mut arranger = Arranger::new(reference);
            for (number, own, more) in texels(lists, gutter, band) {
                let texel = Texel::new(bits, number);
                if window.index(texel.place()).is_some() {
                    let head = arranger.texel(texel, own, more, &mut out);
                    out.heads.push(head);
                }
            }
            out
        })
        .collect();
    join(window, &laid_out)
}

/// Around all texels that have a list.
fn window(bits: u32, lists: &Lists, gutter: &Gutter) -> Window {
    let used: Vec<Window> = bands(lists)
        .filter_map(|band| {
            let mut filled = texels(lists, gutter, band)
                .filter(|(_, own, more)| own.len() + more.len() > 0)
                .map(|(number, ..)| Texel::new(bits, number).place())
                .peekable();
            filled.peek()?;
            Some(Window::around(filled))
        })
        .collect();
    let corners = |w: &Window| [w.at, [0, 1].map(|k| w.at[k] + w.size[k] - 1)];
    Window::around(used.iter().flat_map(corners))
}

impl Band {
    /// The head of a single list of one layer that fits it.
    pub(super) fn short(&mut self, format: Format, entries: &[u32]) -> u64 {
        bits_of::inline_head(entries, format.id_bits)
    }

    /// The head of another list; its entries but the first go to blocks.
    pub(super) fn long(&mut self, format: Format, entries: &[Masked], kind: Kind) -> u64 {
        let bits = format.entry_bits(kind.mixed);
        let (first, rest) = entries
            .split_first()
            .map_or((0, entries), |(f, r)| (f.entry, r));
        self.overlapping += u64::from(!kind.single);
        if rest.len() <= bits_of::in_half(bits) as usize {
            let address = self.half.len() as u64;
            self.half.push(bits_of::half_block(rest, bits));
            return bits_of::list_head(first, kind, false, address);
        }
        let address = 2 * self.full.len() as u64;
        let mut blocks = rest.chunks(bits_of::in_full(bits) as usize).peekable();
        while let Some(block) = blocks.next() {
            let last = blocks.peek().is_none();
            self.full.push(bits_of::full_block(block, bits, last));
        }
        bits_of::list_head(first, kind, true, address)
    }

    /// Makes room for the heads of a texel's parts; where they begin.
    pub(super) fn divide(&mut self, parts: usize) -> usize {
        let first = self.children.len();
        self.children.resize(first + parts, bits_of::EMPTY);
        first
    }

    /// Puts words behind these; `head`, whose addresses are theirs, comes back as it is among these.
    pub(super) fn append(&mut self, head: u64, words: Band) -> u64 {
        let base = Base {
            children: self.children.len() as u64,
            half: self.half.len() as u64,
            full: 2 * self.full.len() as u64,
        };
        let moved = |head: u64| bits_of::moved(head, base.half, base.full, base.children);
        self.children.extend(words.children.into_iter().map(moved));
        self.half.extend(words.half);
        self.full.extend(words.full);
        self.divided += words.divided;
        self.overlapping += words.overlapping;
        moved(head)
    }

    pub(super) fn set_child(&mut self, at: usize, head: u64) {
        self.children[at] = head;
    }

    /// The head of a texel whose parts begin at `first`.
    pub(super) fn divided(&mut self, first: usize, by: u32) -> u64 {
        self.divided += 1;
        bits_of::divided_head(first as u64, by)
    }
}

/// Puts the bands' words together: all heads, all children; all full blocks, all half blocks.
fn join(window: Window, bands: &[Band]) -> Result<Words> {
    let texels: u64 = bands.iter().map(|b| b.heads.len() as u64).sum();
    let full: u64 = bands.iter().map(|b| 2 * b.full.len() as u64).sum();
    let mut end = Base {
        children: texels,
        half: full,
        full: 0,
    };
    let bases: Vec<Base> = bands
        .iter()
        .map(|band| {
            let base = end;
            end.children += band.children.len() as u64;
            end.half += band.half.len() as u64;
            end.full += 2 * band.full.len() as u64;
            base
        })
        .collect();
    check("hash texels and their parts", end.children)?;
    check("64-bit units of lists", end.half)?;
    let moved = |(band, base): (&Band, &Base), heads: fn(&Band) -> &Vec<u64>| -> Vec<u64> {
        let by = |head: &u64| bits_of::moved(*head, base.half, base.full, base.children);
        heads(band).iter().map(by).collect()
    };
    let pairs = || bands.par_iter().zip(&bases);
    let split = |words: Vec<u64>| words.into_iter().flat_map(|w| [w as u32, (w >> 32) as u32]);
    let heads = pairs().flat_map_iter(|pair| split(moved(pair, |b| &b.heads)));
    let children = pairs().flat_map_iter(|pair| split(moved(pair, |b| &b.children)));
    let blocks = bands
        .par_iter()
        .flat_map_iter(|b| b.full.iter().flatten().copied());
    let halves = bands.par_iter().flat_map_iter(|b| split(b.half.clone()));
    Ok(Words {
        window,
        hash: heads.chain(children).collect(),
        list: blocks.chain(halves).collect(),
        divided_texels: bands.iter().map(|b| b.divided).sum(),
        overlapping_lists: bands.iter().map(|b| b.overlapping).sum(),
        row_waste: 0,
    })
}

fn check(what: &str, need: u64) -> Result<()> {
    if need <= bits_of::ADDRESSES {
        return Ok(());
    }
    Err(Error::Capacity {
        what: what.into(),
        need,
        have: bits_of::ADDRESSES,
    })
}
