//! The last step of both builds: lists and gutter in, [`Tables`] out.
//!
//! Texels are worked on in bands, one worker a band. It runs on the host for the device's build as well: what it decides
//! in floating point ([`weigh`]) is then the same everywhere.

mod ambiguous;
mod arrange;
mod bent;
mod classic;
mod divide;
mod estimate;
mod flat;
mod near;
mod packed;
mod ranked;
mod sides;
mod weigh;

pub(super) use ambiguous::ambiguous;
pub(super) use arrange::MAX_BITS;

use super::build::Lists;
use super::gutter::Gutter;
use super::layout::{self, Window};
use super::{BuildOptions, Layout, Reference, Stats, Tables};
use crate::error::Result;
use rayon::prelude::*;

/// Texels of a band.
const BAND: usize = 1 << 12;

/// The words of hash and lists, and what is known of them.
struct Words {
    window: Window,
    hash: Vec<u32>,
    list: Vec<u32>,
    divided_texels: u64,
    overlapping_lists: u64,
    row_waste: u64,
}

/// Lays the lists out in words.
pub(super) fn tables(
    reference: &Reference,
    options: BuildOptions,
    lists: &Lists,
    gutter: &Gutter,
) -> Result<Tables> {
    let figures = Figures::of(lists, gutter);
    let mut words = match options.layout {
        Layout::Packed => packed::words(reference, options.bits()?, lists, gutter)?,
        Layout::Classic => {
            let window = Window::whole(options.hash);
            classic::words(window, lists, gutter, figures.longest, &reference.layer)?
        }
    };
    // Shaders read 128-bit words.
    words.list.resize(words.list.len().next_multiple_of(4), 0);
    let entries = lists.items.len() as u64 + gutter.items.len() as u64;
    let stats = Stats {
        entries,
        gutter_entries: gutter.items.len() as u64,
        gutter_width: gutter.width,
        unreached_texels: gutter.unreached,
        mean_list: entries as f64 / figures.filled.max(1) as f64,
        max_list: figures.longest,
        collapsed_triangles: collapsed(reference),
        divided_texels: words.divided_texels,
        overlapping_lists: words.overlapping_lists,
        row_waste: words.row_waste,
    };
    let format = reference.format;
    let flat = layout::is_flat(&reference.primary);
    let count = reference.triangles.len();
    let triangle = format.record.table(count, |t| reference.corners(t), flat);
    Ok(Tables {
        layout: options.layout,
        format,
        hash_size: [options.hash; 2],
        window: words.window,
        primary: reference.primary,
        hash: words.hash.into(),
        list: words.list.into(),
        triangle: triangle.into(),
        stats,
    })
}

/// The bands of a table.
fn bands(lists: &Lists) -> impl IndexedParallelIterator<Item = usize> {
    (0..(lists.start.len() - 1).div_ceil(BAND)).into_par_iter()
}

/// The texels of a band: number, list, gutter entries.
fn texels<'a>(
    lists: &'a Lists,
    gutter: &'a Gutter,
    band: usize,
) -> impl Iterator<Item = (usize, &'a [u32], &'a [u32])> {
    let range = band * BAND..((band + 1) * BAND).min(lists.start.len() - 1);
    let mut beyond = gutter.from(range.start);
    range.map(move |texel| (texel, lists.of(texel), beyond.of(texel)))
}

/// Figures of all lists.
#[derive(Default)]
struct Figures {
    filled: u64,
    longest: u32,
}

impl Figures {
    fn of(lists: &Lists, gutter: &Gutter) -> Self {
        let of_band = |band| {
            let mut figures = Figures::default();
            for (_, own, more) in texels(lists, gutter, band) {
                let length = (own.len() + more.len()) as u32;
                figures.filled += u64::from(length > 0);
                figures.longest = figures.longest.max(length);
            }
            figures
        };
        let both = |a: Figures, b: Figures| Figures {
            filled: a.filled + b.filled,
            longest: a.longest.max(b.longest),
        };
        bands(lists).map(of_band).reduce(Figures::default, both)
    }
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
