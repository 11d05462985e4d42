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

    /// Every entry of every block is looked at once, and every head once: heads may share blocks, and a file may say
    /// that all share one.
    fn packed_fault(&self, triangles: usize) -> Option<(String, String)> {
        let blocks = |mixed| Blocks::check(&self.list, self.format, mixed, triangles);
        let lists = [blocks(false), blocks(true)];
        let heads = self.hash.len() / HEAD_WORDS;
        // log2 of the resolution at which a divided texel's children lie.
        let mut depth = vec![self.bits() as u8; heads];
        for (at, words) in self.hash.chunks_exact(HEAD_WORDS).enumerate() {
            let fits = match packed::head([words[0], words[1]]) {
                Head::Empty => true,
                Head::List { run, rest, kind } => {
                    let lists = &lists[usize::from(kind.mixed)];
                    lists.run_fits(run, false) && lists.rest_fits(rest)
                }
                Head::Divided { first, by } => {
                    let (below, inside) = (depth[at] + by as u8, first + (1 << (2 * by)) <= heads);
                    // Children come after their texel: no way leads back.
                    let fits = inside && first > at && by > 0 && u32::from(below) <= MAX_BITS;
                    if fits {
                        let children = &mut depth[first..first + (1 << (2 * by))];
                        children.iter_mut().for_each(|d| *d = below.max(*d));
                    }
                    fits
                }
            };
            if !fits {
                return Some((
                    format!("hash[{at}]"),
                    "its triangle or its list does not exist".into(),
                ));
            }
        }
        None
    }

    fn classic_fault(&self, triangles: usize) -> Option<(String, String)> {
        // How many words before each place name no triangle (lengths of long lists may): every list is then one
        // subtraction, however many texels share it.
        let mut strange = Vec::with_capacity(self.list.len() + 1);
        strange.push(0u32);
        for word in &self.list {
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

/// Which blocks may be read as those of packed lists of one kind.
struct Blocks {
    format: Format,
    mixed: bool,
    triangles: usize,
    /// By 64-bit unit: a half block there names triangles that exist.
    half: Vec<bool>,
    /// By 128-bit unit: so does a full block there, and all that follow up to a last one.
    full: Vec<bool>,
}

impl Blocks {
    fn check(list: &[u32], format: Format, mixed: bool, triangles: usize) -> Self {
        let mut blocks = Blocks {
            format,
            mixed,
            triangles,
            half: Vec::new(),
            full: Vec::new(),
        };
        if mixed && format.layer_bits == 0 {
            return blocks;
        }
        let bits = format.entry_bits(mixed);
        blocks.half = (0..list.len() / 2)
            .into_par_iter()
            .map(|unit| blocks.run_fits(packed::half_run(list, unit, bits), true))
            .collect();
        let own: Vec<(bool, bool)> = (0..list.len() / 4)
            .into_par_iter()
            .map(|unit| {
                let (run, last) = packed::full_run(list, 2 * unit, bits);
                (blocks.run_fits(run, true), last)
            })
            .collect();
        let mut follows = false;
        blocks.full = vec![false; own.len()];
        for (fits, (run_fits, last)) in blocks.full.iter_mut().zip(&own).rev() {
            follows = *run_fits && (*last || follows);
            *fits = follows;
        }
        blocks
    }

    fn run_fits(&self, mut run: Run, masked: bool) -> bool {
        while let Some(one) = run.next(self.format.entry_bits(self.mixed), masked) {
            let (triangle, _) = self.format.split(self.mixed, one.entry);
            if triangle as usize >= self.triangles {
                return false;
            }
        }
        true
    }

    fn rest_fits(&self, rest: Rest) -> bool {
        match rest {
            Rest::None => true,
            Rest::Half(unit) => self.half.get(unit) == Some(&true),
            Rest::Full(unit) => unit % 2 == 0 && self.full.get(unit / 2) == Some(&true),
        }
    }
}
