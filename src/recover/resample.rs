//! The walk over texels: what each sample stands for, what is fetched there, means, borders.
//!
//! In: a [`Surface`], made-ready [`Source`]s. Out: [`Baked`], and each texture as soon as it is finished. Texels are worked on
//! in bands of rows, all cores at once; the same settings give the same texels on any number of them.
//!
//! Memory is bounded whatever is asked for: as many textures are made in one walk as are allowed room for, at least one, and
//! another walk makes the next ones. At 8192 x 8192 texels a texture takes 1 GiB while it is made, and what is known of texels
//! a tenth of that; at 16384 x 16384 four times as much.

use super::around::{Around, Looking};
use super::fill::{Grown, growth};
use super::source::{Low, Source};
use crate::asset::Progress;
use crate::attribute::surface::SurfacePoint;
use crate::recover::{Baked, BakedTexture};
use crate::render::constants;
use crate::{Error, Result};
use rayon::prelude::*;
use std::ops::Range;

/// Rows of texels in a band.
pub(super) const BAND: u32 = 16;
/// Texels that one core works on at a time where they do not depend on others.
const CHUNK: usize = 1 << 16;
/// The largest texture's side.
const MOST: u32 = 16_384;

/// A surface that textures are made for, and the way from it to the reference.
pub(super) trait Surface: Sync {
    /// What messages call it.
    fn name(&self) -> &str;
    /// Samples of some rows of texels, asked for by one core.
    fn band(&self, rows: Range<u32>) -> Box<dyn Band + '_>;
    /// The corners of a triangle of the reference.
    fn corners(&self, triangle: u32) -> [[f32; 3]; 3];
    /// Refuses a texture of which so many texels have a point, and so many on the surface have none.
    fn check(&self, filled: u64, empty: u64) -> Result<()> {
        let _ = (filled, empty);
        Ok(())
    }
}

/// Who takes textures as they are finished.
pub(super) type Taker<'a> = &'a mut dyn FnMut(BakedTexture) -> Result<()>;

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
    /// Bytes of values that are made in one walk, unless one texture takes more.
    pub(super) memory: u64,
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

/// Gives the textures of `sources` over `surface` to `finished`, in their order.
///
/// # Errors
/// [`Error::Cancelled`]; those of [`Surface::check`], before any texture is finished; those of `finished`.
pub(super) fn resample(
    sources: &[Source],
    (surface, around): (&dyn Surface, &Around),
    fineness: Fineness,
    progress: &dyn Progress,
    finished: Taker,
) -> Result<Baked> {
    let constants = constants();
    let texture = u64::from(fineness.size).pow(2) * size_of::<[f32; 4]>() as u64;
    let at_once = (fineness.memory / texture).clamp(1, sources.len().max(1) as u64) as usize;
    let mut baked = Baked::default();
    for sources in sources.chunks(at_once) {
        let walk = Walk {
            sources,
            surface,
            around,
            fineness,
            decode: &constants[..256],
            places: sources.iter().any(Source::asks_for_places),
        };
        let made = walk.all(progress)?;
        made.count(&mut baked);
        surface.check(baked.filled, baked.empty)?;
        let grown = made.grown(fineness);
        baked.mask = made.mask(&grown);
        for (source, values) in sources.iter().zip(made.values) {
            finished(BakedTexture {
                attribute: source.attribute.clone(),
                values: closed(source, values, (&made.state, &grown), fineness),
                coding: source.coding,
            })?;
        }
    }
    Ok(baked)
}

/// Texels on their way: of each source the values, and what is known of each texel.
struct Texels {
    values: Vec<Vec<[f32; 4]>>,
    state: Vec<u8>,
}

/// Those of a band.
struct BandOfTexels<'a> {
    number: u32,
    values: Vec<&'a mut [[f32; 4]]>,
    state: &'a mut [u8],
}

struct Walk<'a> {
    sources: &'a [Source],
    surface: &'a dyn Surface,
    around: &'a Around<'a>,
    fineness: Fineness,
    decode: &'a [f32],
    /// Whether any source asks where points lie.
    places: bool,
}

impl Walk<'_> {
    /// All texels.
    fn all(&self, progress: &dyn Progress) -> Result<Texels> {
        let size = self.fineness.size as usize;
        let mut out = Texels {
            values: vec![vec![[0.0; 4]; size * size]; self.sources.len()],
            state: vec![state::OFF; size * size],
        };
        let rows = BAND as usize * size;
        let mut values: Vec<_> = out.values.iter_mut().map(|v| v.chunks_mut(rows)).collect();
        let band = |(number, state)| BandOfTexels {
            number: number as u32,
            values: values.iter_mut().filter_map(Iterator::next).collect(),
            state,
        };
        let mut bands: Vec<_> = out.state.chunks_mut(rows).enumerate().map(band).collect();
        let count = bands.len();
        // Sixteen bands at a time, so that a bar moves and a caller can stop.
        for some in bands.chunks_mut(16) {
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
            let done = some[0].number as usize;
            progress.at("resample", self.surface.name(), done, count);
            some.par_iter_mut().for_each(|band| self.band(band));
        }
        Ok(out)
    }

    /// One band of texels.
    fn band(&self, out: &mut BandOfTexels) {
        let Fineness { size, .. } = self.fineness;
        let rows = out.number * BAND..((out.number + 1) * BAND).min(size);
        let mut samples = self.surface.band(rows.clone());
        let mut looking = self.around.looking();
        let mut sums = vec![[0.0; 4]; self.sources.len()];
        for k in 0..out.state.len() as u32 {
            let at = [k % size, rows.start + k / size];
            sums.fill([0.0; 4]);
            let (found, state) = self.texel(samples.as_mut(), &mut looking, at, &mut sums);
            out.state[k as usize] = state;
            if found > 0 {
                for ((source, sum), values) in self.sources.iter().zip(&sums).zip(&mut out.values) {
                    values[k as usize] = source.mean(*sum, found as f32);
                }
            }
        }
    }

    /// Adds up the samples of a texel: how many have a point, and what is known of it.
    fn texel(
        &self,
        band: &mut dyn Band,
        looking: &mut Looking,
        at: [u32; 2],
        sums: &mut [[f32; 4]],
    ) -> (u32, u8) {
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
                let low = sample.low.as_ref();
                let value = source.at(self.decode, &corners, point, low, looking);
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

impl Texels {
    /// Tells how many texels are what.
    fn count(&self, baked: &mut Baked) {
        let counted = |states: &[u8]| {
            let mut counts = [0u64; 4];
            states.iter().for_each(|&s| counts[usize::from(s)] += 1);
            counts
        };
        let both = |a: [u64; 4], b: [u64; 4]| [0, 1, 2, 3].map(|k| a[k] + b[k]);
        let counts = self.state.par_chunks(CHUNK).map(counted);
        let counts = counts.reduce(|| [0; 4], both);
        let [empty, replaced, found] =
            [state::EMPTY, state::REPLACED, state::FOUND].map(|s| counts[usize::from(s)]);
        baked.filled = found + replaced;
        baked.missed = empty + replaced;
        baked.empty = empty;
    }

    /// How values spread over borders.
    fn grown(&self, fineness: Fineness) -> Vec<Grown> {
        let known: Vec<bool> = self.state.iter().map(|&s| s >= state::REPLACED).collect();
        let closed = |at: usize| !fineness.fill && self.state[at] == state::EMPTY;
        growth(known, fineness.size, fineness.padding, &closed)
    }

    fn mask(&self, grown: &[Grown]) -> Vec<u8> {
        let shade = |s: &u8| match *s {
            state::FOUND => shade::FOUND,
            state::REPLACED => shade::REPLACED,
            _ => 0,
        };
        let mut mask: Vec<u8> = self.state.iter().map(shade).collect();
        grown
            .iter()
            .for_each(|g| mask[g.at as usize] = shade::GROWN);
        mask
    }
}

/// A texture with its borders grown, the mean where nothing is known; transparent where a value was to be and none may stand
/// in.
fn closed(
    source: &Source,
    mut values: Vec<[f32; 4]>,
    (state, grown): (&[u8], &[Grown]),
    fineness: Fineness,
) -> Vec<[f32; 4]> {
    let mut known: Vec<bool> = state.iter().map(|&s| s >= state::REPLACED).collect();
    for g in grown {
        values[g.at as usize] = values[g.from as usize];
        known[g.at as usize] = true;
    }
    let [x, y, z, w] = source.absent(mean(&values, &known));
    let chunks = values.par_chunks_mut(CHUNK);
    let known = known.par_chunks(CHUNK).zip(state.par_chunks(CHUNK));
    chunks.zip(known).for_each(|(values, (known, state))| {
        let texels = values.iter_mut().zip(known).zip(state);
        for ((value, _), state) in texels.filter(|((_, known), _)| !**known) {
            let blank = !fineness.fill && *state == state::EMPTY;
            *value = [x, y, z, if blank { 0.0 } else { w }];
        }
    });
    values
}

/// The mean of what is known; 0 where nothing is.
fn mean(values: &[[f32; 4]], known: &[bool]) -> [f32; 4] {
    let (mut sum, mut count) = ([0.0f64; 4], 0u32);
    for (value, _) in values.iter().zip(known).filter(|(_, known)| **known) {
        (0..4).for_each(|k| sum[k] += f64::from(value[k]));
        count += 1;
    }
    sum.map(|s| (s / f64::from(count.max(1))) as f32)
}
