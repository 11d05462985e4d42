//! The walk over texels: what each sample stands for, what is fetched there, means, borders, codes.
//!
//! In: a [`Surface`], made-ready [`Source`]s. Out: [`Baked`]. Texels are worked on in bands of rows, all cores at once; the
//! same settings give the same texels on any number of them.

use super::fill;
use super::source::{Low, Source};
use crate::asset::Progress;
use crate::attribute::arithmetic::{srgb_encode, unit_encode};
use crate::attribute::surface::SurfacePoint;
use crate::recover::{Baked, BakedTexture};
use crate::render::{THRESHOLDS_AT, constants};
use crate::{Error, Result};
use rayon::prelude::*;
use std::ops::Range;

/// Rows of texels in a band.
pub(super) const BAND: u32 = 16;
/// The largest texture's side.
const MOST: u32 = 8192;

/// A surface that textures are made for, and the way from it to the reference.
pub(super) trait Surface: Sync {
    /// What messages call it.
    fn name(&self) -> &str;
    /// Samples of some rows of texels, asked for by one core.
    fn band(&self, rows: Range<u32>) -> Box<dyn Band + '_>;
    /// The corners of a triangle of the reference.
    fn corners(&self, triangle: u32) -> [[f32; 3]; 3];
}

/// Samples of a band.
pub(super) trait Band {
    /// The sample in a column and row of the texture times its samples; none off the surface.
    fn sample(&mut self, fine: [u32; 2]) -> Option<Sample<'_>>;
}

/// A sample that lies on the surface.
pub(super) struct Sample<'a> {
    /// Its point of the reference.
    pub(super) point: Option<SurfacePoint>,
    /// Whether what is there, if anything, stands in for what was not found.
    pub(super) missed: bool,
    pub(super) low: Option<Low<'a>>,
}

/// How fine, and what of borders.
#[derive(Clone, Copy)]
pub(super) struct Fineness {
    pub(super) size: u32,
    pub(super) samples: u32,
    pub(super) padding: u32,
    /// Whether texels on the surface without a point take their neighbours' values, as those off it do; else they stay
    /// transparent.
    pub(super) fill: bool,
}

impl Fineness {
    /// Refuses what is out of range.
    pub(super) fn check(&self) -> Result<()> {
        let Fineness {
            size,
            samples,
            padding,
            ..
        } = *self;
        let wrong = |option, reason: String| Err(Error::Option { option, reason });
        if !(16..=MOST).contains(&size) {
            return wrong("--size", format!("{size} is outside 16 to {MOST}"));
        }
        if !(1..=8).contains(&samples) {
            return wrong("--samples", format!("{samples} is outside 1 to 8"));
        }
        if padding > 256 {
            return wrong("--padding", format!("{padding} is outside 0 to 256"));
        }
        Ok(())
    }
}

/// What is known of a texel.
mod state {
    /// It lies off the surface.
    pub(super) const OFF: u8 = 0;
    /// On the surface, without a point.
    pub(super) const EMPTY: u8 = 1;
    /// With a point that stands in for what was not found.
    pub(super) const REPLACED: u8 = 2;
    /// With its point.
    pub(super) const FOUND: u8 = 3;
}

/// Shades of the mask.
pub(super) mod shade {
    pub(crate) const FOUND: u8 = 255;
    pub(crate) const REPLACED: u8 = 192;
    pub(crate) const GROWN: u8 = 128;
}

/// Texels of a band: for each source the values, and what is known of each texel.
struct Texels {
    values: Vec<Vec<Option<[f32; 4]>>>,
    state: Vec<u8>,
}

/// The textures of `sources` over `surface`.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn resample(
    sources: &[Source],
    surface: &dyn Surface,
    fineness: Fineness,
    progress: &dyn Progress,
) -> Result<Baked> {
    let constants = constants();
    let walk = Walk {
        sources,
        surface,
        fineness,
        decode: &constants[..256],
        places: sources.iter().any(Source::asks_for_places),
    };
    let count = fineness.size.div_ceil(BAND);
    let mut bands: Vec<Texels> = Vec::with_capacity(count as usize);
    // Sixteen bands at a time, so that a bar moves and a caller can stop.
    for begin in (0..count).step_by(16) {
        if progress.cancelled() {
            return Err(Error::Cancelled);
        }
        progress.at("resample", surface.name(), begin as usize, count as usize);
        let some = (begin..(begin + 16).min(count)).into_par_iter();
        bands.par_extend(some.map(|band| walk.band(band)));
    }
    let thresholds = &constants[THRESHOLDS_AT..THRESHOLDS_AT + 256];
    Ok(joined(sources, bands, fineness, thresholds))
}

struct Walk<'a> {
    sources: &'a [Source],
    surface: &'a dyn Surface,
    fineness: Fineness,
    decode: &'a [f32],
    /// Whether any source asks where points lie.
    places: bool,
}

impl Walk<'_> {
    /// One band of texels.
    fn band(&self, band: u32) -> Texels {
        let Fineness { size, .. } = self.fineness;
        let rows = band * BAND..((band + 1) * BAND).min(size);
        let texels = rows.len() * size as usize;
        let mut out = Texels {
            values: vec![vec![None; texels]; self.sources.len()],
            state: vec![state::OFF; texels],
        };
        let mut samples = self.surface.band(rows.clone());
        let mut sums = vec![[0.0; 4]; self.sources.len()];
        for k in 0..texels as u32 {
            let at = [k % size, rows.start + k / size];
            sums.fill([0.0; 4]);
            let (found, state) = self.texel(samples.as_mut(), at, &mut sums);
            out.state[k as usize] = state;
            if found > 0 {
                for ((source, sum), values) in self.sources.iter().zip(&sums).zip(&mut out.values) {
                    values[k as usize] = Some(source.mean(*sum, found as f32));
                }
            }
        }
        out
    }

    /// Adds up the samples of a texel: how many have a point, and what is known of it.
    fn texel(&self, band: &mut dyn Band, at: [u32; 2], sums: &mut [[f32; 4]]) -> (u32, u8) {
        let samples = self.fineness.samples;
        let (mut on, mut found, mut missed) = (0, 0, 0);
        for s in 0..samples * samples {
            let fine = [at[0] * samples + s % samples, at[1] * samples + s / samples];
            let Some(sample) = band.sample(fine) else {
                continue;
            };
            on += 1;
            missed += u32::from(sample.missed);
            let Some(point) = &sample.point else { continue };
            found += 1;
            let corners = match self.places {
                true => self.surface.corners(point.triangle),
                false => [[0.0; 3]; 3],
            };
            for (source, sum) in self.sources.iter().zip(sums.iter_mut()) {
                let value = source.at(self.decode, &corners, point, sample.low.as_ref());
                (0..4).for_each(|i| sum[i] += value[i]);
            }
        }
        let state = match (on, found) {
            (0, _) => state::OFF,
            (_, 0) => state::EMPTY,
            // A texel is found where one of its samples is.
            _ if missed == on => state::REPLACED,
            _ => state::FOUND,
        };
        (found, state)
    }
}

/// Bands joined, borders grown, what is left filled with the mean.
fn joined(
    sources: &[Source],
    mut bands: Vec<Texels>,
    fineness: Fineness,
    thresholds: &[f32],
) -> Baked {
    let states: Vec<&[u8]> = bands.iter().map(|b| b.state.as_slice()).collect();
    let state = states.concat();
    let count = |wanted: u8| state.iter().filter(|&&s| s == wanted).count() as u64;
    let mut mask = Vec::new();
    let mut textures = Vec::new();
    for (k, source) in sources.iter().enumerate() {
        let own = bands.iter_mut().map(|b| std::mem::take(&mut b.values[k]));
        let known = own.collect::<Vec<_>>().concat();
        let rounds = fineness.padding;
        let grown = if fineness.fill {
            fill::spread(known, fineness.size, rounds)
        } else {
            let closed = |at: usize| state[at] == state::EMPTY;
            fill::spread_but(known, fineness.size, rounds, &closed)
        };
        if mask.is_empty() {
            let shade = |(s, v): (&u8, &Option<_>)| match (*s, v) {
                (state::FOUND, _) => shade::FOUND,
                (state::REPLACED, _) => shade::REPLACED,
                (_, Some(_)) => shade::GROWN,
                _ => 0,
            };
            mask = state.iter().zip(&grown).map(shade).collect();
        }
        let mean = source.absent(mean(&grown));
        let values: Vec<[f32; 4]> = grown
            .into_par_iter()
            .enumerate()
            .map(|(at, value)| value.unwrap_or_else(|| absent(mean, &state, at, fineness)))
            .collect();
        let coded = values.par_iter().map(|v| encoded(source, *v, thresholds));
        textures.push(BakedTexture {
            attribute: source.attribute.clone(),
            rgba8: coded.collect::<Vec<[u8; 4]>>().into_flattened(),
            values,
        });
    }
    Baked {
        low: None,
        textures,
        mask,
        filled: count(state::FOUND) + count(state::REPLACED),
        missed: count(state::EMPTY) + count(state::REPLACED),
        empty: count(state::EMPTY),
    }
}

/// What a texel without a value gets: the mean; transparent where one was to be and none may stand in.
fn absent(mean: [f32; 4], state: &[u8], at: usize, fineness: Fineness) -> [f32; 4] {
    let [x, y, z, w] = mean;
    let blank = !fineness.fill && state[at] == state::EMPTY;
    [x, y, z, if blank { 0.0 } else { w }]
}

fn encoded(source: &Source, value: [f32; 4], thresholds: &[f32]) -> [u8; 4] {
    let [r, g, b, a] = source.coded(value);
    let [r, g, b] = [r, g, b].map(|c| code(c, source.is_color(), thresholds));
    [r, g, b, unit_encode(a) as u8]
}

/// A channel in 8 bits: light as sRGB, or what it is.
pub(super) fn code(value: f32, is_color: bool, thresholds: &[f32]) -> u8 {
    match is_color {
        true => srgb_encode(thresholds, value) as u8,
        false => unit_encode(value) as u8,
    }
}

/// The mean of what is known; 0 where nothing is.
fn mean(values: &[Option<[f32; 4]>]) -> [f32; 4] {
    let (mut sum, mut count) = ([0.0f64; 4], 0u32);
    for value in values.iter().flatten() {
        (0..4).for_each(|k| sum[k] += f64::from(value[k]));
        count += 1;
    }
    sum.map(|s| (s / f64::from(count.max(1))) as f32)
}
