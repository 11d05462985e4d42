//! Tables from a file are untrusted: every index a lookup would follow is checked before anything reads them.

use super::finish::MAX_BITS;
use super::layout::classic::LONG;
use super::layout::packed::{self, HEAD_WORDS, Head, Rest, Run};
use super::layout::{self, Format, Window};
use super::{BuildOptions, Layout, Tables};
use rayon::prelude::*;

impl Tables {
    /// Checks that every lookup stays inside the tables and names triangles of a mesh with `triangles` triangles.
    /// The error is the element and the reason.
    pub fn validate(&self, triangles: usize) -> Result<(), (String, String)> {
        let refuse = |element: &str, reason: String| Err((element.to_owned(), reason));
        let [width, height] = self.hash_size;
        if width != height
            || (BuildOptions {
                hash: width,
                layout: self.layout,
            })
            .bits()
            .is_err()
        {
            return refuse(
                "hash_size",
                format!("{width} x {height} is not a square power of two from 4 to 8192"),
            );
        }
        let frame = self.primary.frame;
        if !(frame.scale > 0.0
            && frame.scale.is_finite()
            && frame.origin.iter().all(|x| x.is_finite()))
        {
            return refuse(
                "primary.frame",
                "origin or scale is not a finite number".into(),
            );
        }
        let flat = layout::is_flat(&self.primary);
        if let Some(reason) = self.format.fault(self.layout, flat, triangles) {
            return refuse("format", reason);
        }
        let whole = self.window == Window::whole(width);
        if !(self.window.fits(width) && (whole || self.layout == Layout::Packed)) {
            return refuse("window", "does not lie in the hash texture".into());
        }
        let words = layout::hash_words(self.layout);
        let (have, want) = (self.hash.len(), self.window.texels() * words);
        let divided = self.layout == Layout::Packed && have > want && have % HEAD_WORDS == 0;
        if have != want && !divided {
            return refuse("hash", format!("{have} words where {want} belong"));
        }
        if let Some((element, reason)) = self.format.record.fault(&self.triangle, triangles) {
            return refuse(&element, reason);
        }
        let fault = match self.layout {
            Layout::Packed => self.packed_fault(triangles),
            Layout::Classic => self.classic_fault(triangles),
        };
        fault.map_or(Ok(()), |(element, reason)| refuse(&element, reason))
    }

    /// Every head is looked at, and its list as far as that is short; heads may share blocks, and a file may say that all
    /// share one long list, so those that are long are looked at together, every block once.
    fn packed_fault(&self, triangles: usize) -> Option<(String, String)> {
        let lists =
            [false, true].map(|mixed| Lists::new(&self.list, self.format, mixed, triangles));
        let rests: Vec<Rests> = self
            .hash
            .par_chunks(HEADS * HEAD_WORDS)
            .enumerate()
            .map(|(chunk, words)| Rests::of(&lists, chunk * HEADS, words))
            .collect();
        let faults = rests.iter().filter_map(|rests| rests.fault);
        let parts = || rests.iter().flat_map(|rests| &rests.divided);
        let long = || rests.iter().flat_map(|rests| &rests.long);
        let fault = faults
            .chain(self.lost_part(parts()))
            .chain([false, true].iter().filter_map(|mixed| {
                let mut of_kind = long().filter(|(_, _, kind)| kind == mixed).peekable();
                of_kind.peek()?;
                let fit = lists[usize::from(*mixed)].blocks_that_fit();
                of_kind
                    .find(|(_, block, _)| !fit[*block])
                    .map(|(at, ..)| *at)
            }))
            .min()?;
        Some((
            format!("hash[{fault}]"),
            "its triangle or its list does not exist".into(),
        ))
    }

    /// The first divided texel whose parts do not exist, come before it, or are too small.
    fn lost_part<'a>(
        &self,
        mut divided: impl Iterator<Item = &'a (usize, usize, u32)>,
    ) -> Option<usize> {
        let heads = self.hash.len() / HEAD_WORDS;
        // log2 of the resolution at which a divided texel's children lie.
        let mut depth = vec![self.bits() as u8; heads];
        let lost = divided.find(|(at, first, by)| {
            let parts = *first..first.saturating_add(1 << (2 * by));
            let below = depth[*at] + *by as u8;
            // Children come after their texel: no way leads back.
            let fits = parts.end <= heads && first > at && *by > 0 && u32::from(below) <= MAX_BITS;
            if fits {
                let children = &mut depth[parts];
                children.iter_mut().for_each(|d| *d = below.max(*d));
            }
            !fits
        });
        lost.map(|(at, ..)| *at)
    }

    fn classic_fault(&self, triangles: usize) -> Option<(String, String)> {
        // How many words before each place name no triangle (lengths of long lists may): every list is then one
        // subtraction, however many texels share it.
        let mut strange = Vec::with_capacity(self.list.len() + 1);
        strange.push(0u32);
        for word in self.list.iter() {
            let is_strange = (word & 0xff_ffff) as usize >= triangles;
            strange.push(strange[strange.len() - 1] + u32::from(is_strange));
        }
        let fault = self.hash.par_iter().position_first(|word| {
            let (mut start, mut length) = ((word & 0xff_ffff) as usize, (word >> 24) as usize);
            if length == LONG as usize {
                let Some(stored) = self.list.get(start) else {
                    return true;
                };
                (start, length) = (start + 1, *stored as usize);
            }
            // An empty list must lie inside as well: a lookup takes the slice before it looks at its length.
            match strange.get(start.saturating_add(length)) {
                Some(end) => *end != strange[start],
                None => true,
            }
        });
        fault.map(|t| {
            (
                format!("hash[{t}]"),
                "its list or a triangle in it does not exist".into(),
            )
        })
    }
}

/// Heads that one worker looks at.
const HEADS: usize = 1 << 13;
/// Blocks of a list that are looked at with its head.
const FEW_BLOCKS: usize = 4;

/// What remains of some heads to be looked at.
#[derive(Default)]
struct Rests {
    /// The first head whose triangle or list does not exist.
    fault: Option<usize>,
    /// Divided texels: head, first part, log2 of the parts along a side.
    divided: Vec<(usize, usize, u32)>,
    /// Long lists: head, the 128-bit unit where more of it is, whether it is mixed.
    long: Vec<(usize, usize, bool)>,
}

impl Rests {
    /// Looks at heads, the first of which is the one numbered `first`.
    fn of(lists: &[Lists<'_>; 2], first: usize, words: &[u32]) -> Self {
        let mut rests = Rests::default();
        for (i, words) in words.chunks_exact(HEAD_WORDS).enumerate() {
            let at = first + i;
            let fits = match packed::head([words[0], words[1]]) {
                Head::Empty => true,
                Head::List { run, rest, kind } => {
                    let lists = &lists[usize::from(kind.mixed)];
                    lists.head_fits(run)
                        && match rest {
                            Rest::None => true,
                            Rest::Half(unit) => lists.half_fits(unit),
                            Rest::Full(unit) => {
                                let (fits, more) = lists.few_blocks_fit(unit);
                                rests.long.extend(more.map(|unit| (at, unit, kind.mixed)));
                                fits
                            }
                        }
                }
                Head::Divided { first, by } => {
                    rests.divided.push((at, first, by));
                    true
                }
            };
            if !fits {
                rests.fault = Some(at);
                break;
            }
        }
        rests
    }
}

/// The entries of a block, all at once: each stands below its mask's bits, which take up a carry.
struct Fields {
    count: u32,
    /// All bits of the entries; bit 0 of each; the bit above each.
    entries: u128,
    ones: u128,
    above: u128,
    /// What carries into the bit above an entry that is not less than the limit.
    beyond: u128,
}

impl Fields {
    fn new(bits: u32, count: u32, limit: u128) -> Self {
        let stride = bits + packed::MASK_BITS;
        let each = |field: u128| (0..count).fold(0, |all, k| all | field << (k * stride));
        let end = 1u128 << bits;
        Fields {
            count,
            entries: each(end - 1),
            ones: each(1),
            above: each(end),
            beyond: each(end.saturating_sub(limit)),
        }
    }

    /// Whether it is certain that every entry is less than the limit, or an end mark: all ones.
    #[inline]
    fn surely_fit(&self, window: u128) -> bool {
        let entries = window & self.entries;
        let lost = entries.wrapping_add(self.beyond) & self.above;
        let ends = entries.wrapping_add(self.ones) & self.above;
        lost == ends
    }
}

/// What has been seen of some entries.
#[derive(Default)]
struct Seen {
    ended: bool,
    lost: bool,
}

impl Seen {
    /// The next entry, in the low bits of a word.
    #[inline]
    fn entry(&mut self, lists: &Lists<'_>, word: u32) {
        let end = packed::end(lists.bits);
        let entry = word & end;
        self.ended |= entry == end;
        self.lost |= !self.ended & (entry >> lists.layer_bits >= lists.triangles);
    }
}

/// Packed lists of one kind.
struct Lists<'a> {
    list: &'a [u32],
    triangles: u32,
    /// Of an entry.
    bits: u32,
    /// The entries of a half block and of a full one.
    half: Fields,
    full: Fields,
    /// Of an entry's layer.
    layer_bits: u32,
    /// Whether lists of this kind can be.
    exist: bool,
}

impl<'a> Lists<'a> {
    fn new(list: &'a [u32], format: Format, mixed: bool, triangles: usize) -> Self {
        let bits = format.entry_bits(mixed);
        let layer_bits = if mixed { format.layer_bits } else { 0 };
        let limit = (triangles as u128) << layer_bits;
        Lists {
            list,
            // Numbers have up to 31 bits: more triangles than that have all of them.
            triangles: triangles.min(u32::MAX as usize) as u32,
            bits,
            half: Fields::new(bits, packed::in_half(bits), limit),
            full: Fields::new(bits, packed::in_full(bits), limit),
            layer_bits,
            exist: !mixed || format.layer_bits > 0,
        }
    }

    /// Whether the entries in a head name triangles that exist. No branch depends on an entry, here and below.
    #[inline]
    fn head_fits(&self, run: Run) -> bool {
        let mut window = run.window as u64;
        let mut seen = Seen::default();
        for _ in 0..run.count {
            seen.entry(self, window as u32);
            window >>= self.bits;
        }
        !seen.lost
    }

    /// Whether the entries of a block do, up to its end mark.
    #[inline]
    fn block_of_fits(&self, window: u128, fields: &Fields) -> bool {
        fields.surely_fit(window) || self.fits_to_its_end(window, fields.count)
    }

    #[cold]
    fn fits_to_its_end(&self, mut window: u128, count: u32) -> bool {
        let mut seen = Seen::default();
        for _ in 0..count {
            seen.entry(self, window as u32);
            window >>= self.bits + packed::MASK_BITS;
        }
        !seen.lost
    }

    #[inline]
    fn half_fits(&self, unit: usize) -> bool {
        let words = self.list.get(2 * unit..2 * unit + 2);
        self.exist
            && words.is_some_and(|w| {
                let window = u64::from(w[0]) | u64::from(w[1]) << 32;
                self.block_of_fits(window.into(), &self.half)
            })
    }

    /// Whether a full block exists and fits, and whether it is a list's last.
    #[inline]
    fn block_fits(&self, block: usize) -> (bool, bool) {
        match self.list.get(4 * block..4 * block + 4) {
            Some(w) if self.exist => {
                let two = |i: usize| u64::from(w[i]) | u64::from(w[i + 1]) << 32;
                let window = u128::from(two(0)) | u128::from(two(2)) << 64;
                // Bit 127 is no part of an entry, and of no mask that a carry reaches.
                (
                    self.block_of_fits(window, &self.full),
                    w[3] & packed::LAST != 0,
                )
            }
            _ => (false, true),
        }
    }

    /// Whether the first blocks of a list fit, and the block that has more of it.
    fn few_blocks_fit(&self, unit: usize) -> (bool, Option<usize>) {
        if !unit.is_multiple_of(2) {
            return (false, None);
        }
        for block in unit / 2..unit / 2 + FEW_BLOCKS {
            let (fits, last) = self.block_fits(block);
            if !fits || last {
                return (fits, None);
            }
        }
        (true, Some(unit / 2 + FEW_BLOCKS))
    }

    /// For each 128-bit unit, and one behind them: whether a full block there fits, and all that follow up to a last one.
    fn blocks_that_fit(&self) -> Vec<bool> {
        let count = self.list.len() / 4;
        let own: Vec<(bool, bool)> = (0..count)
            .into_par_iter()
            .map(|block| self.block_fits(block))
            .collect();
        let mut follows = false;
        let mut all = vec![false; count + 1];
        for (fits, (own_fits, last)) in all.iter_mut().zip(&own).rev() {
            follows = *own_fits && (*last || follows);
            *fits = follows;
        }
        all
    }
}
