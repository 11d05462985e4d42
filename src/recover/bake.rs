//! The bake: a texture for each attribute.
//!
//! In: a built model, [`BakeSettings`]. Out: [`Baked`] for each mesh that is asked for. Texels are worked on in bands of rows,
//! all cores at once; the same settings give the same texels on any number of them.

use super::fill;
use super::source::{BakeAttribute, Source};
use super::surface::{BAND, Surface};
use crate::asset::{Built, Progress};
use crate::attribute::ShownOptions;
use crate::attribute::arithmetic::{srgb_encode, unit_encode};
use crate::mesh::Mesh;
use crate::render::{THRESHOLDS_AT, constants};
use crate::{Error, Result};
use rayon::prelude::*;

/// The largest texture's side.
const MOST: u32 = 8192;

/// Which point of the reference a texel stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mapping {
    /// The one with the same primary parameterization: the inverse geometric texture.
    #[default]
    UvMatch,
}

/// What textures are laid out over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// A level of detail, cut along an atlas of its own; 0 is the reference's own geometry.
    Lod(usize),
    /// The primary parameterization's unit square of addresses: one texture for all levels.
    Primary,
}

/// What is baked, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeSettings {
    /// Which point of the reference a texel stands for.
    pub mapping: Mapping,
    /// What textures are laid out over.
    pub over: Over,
    /// One texture for each.
    pub attributes: Vec<BakeAttribute>,
    /// Texels along each side, 16 to 8192.
    pub size: u32,
    /// Samples along each side of a texel, 1 to 8: their mean is the texel.
    pub samples: u32,
    /// Texels that borders grow by, 0 to 256.
    pub padding: u32,
    /// Of attributes that are computed.
    pub shown: ShownOptions,
}

impl Default for BakeSettings {
    fn default() -> Self {
        BakeSettings {
            mapping: Mapping::UvMatch,
            over: Over::Lod(1),
            attributes: vec![BakeAttribute::Normal],
            size: 1024,
            samples: 2,
            padding: 8,
            shown: ShownOptions::default(),
        }
    }
}

/// The textures of a mesh.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The surface they are laid out over: uv set 0, tangents along it. None over the primary.
    pub low: Option<Mesh>,
    /// In the order of the settings.
    pub textures: Vec<BakedTexture>,
    /// For each texel 255 where it has a point of the reference, 128 where it got its neighbour's value, 0 elsewhere.
    pub mask: Vec<u8>,
    /// Texels with a point of the reference.
    pub filled: u64,
    /// Texels that lie on the surface and have none.
    pub missed: u64,
}

/// One texture.
#[derive(Clone, Debug)]
pub struct BakedTexture {
    /// What it holds.
    pub attribute: BakeAttribute,
    /// Linear values, row after row from v = 0; directions and positions as they are. Texels without a value have the mean.
    pub values: Vec<[f32; 4]>,
    /// The same in 8 bits: colours as sRGB, data as it is, directions from -1..1 to 0..255.
    pub rgba8: Vec<u8>,
}

/// Attributes made ready to be baked for one mesh after the other.
pub struct Baker<'a> {
    built: &'a Built,
    settings: &'a BakeSettings,
    sources: Vec<Source>,
    constants: Vec<f32>,
    /// What was replaced on the way.
    pub warnings: Vec<String>,
}

/// Texels of a band: for each source the values, and whether each texel is filled (2), missed (1) or none (0).
struct Band {
    values: Vec<Vec<Option<[f32; 4]>>>,
    state: Vec<u8>,
}

impl<'a> Baker<'a> {
    /// Reads textures and computes what has to be.
    ///
    /// # Errors
    /// [`Error::Option`] for settings out of range or an attribute that the model does not have; as
    /// [`Shown::new`](crate::attribute::Shown::new).
    pub fn new(
        built: &'a Built,
        settings: &'a BakeSettings,
        progress: &dyn Progress,
    ) -> Result<Baker<'a>> {
        check(built, settings)?;
        let (mut sources, mut warnings) = (Vec::new(), Vec::new());
        for attribute in &settings.attributes {
            let name = attribute.to_string();
            let heard = |done: usize, of: usize| progress.at("attribute", &name, done, of);
            let (source, told) = Source::new(&built.scene, attribute, &settings.shown, &heard)?;
            sources.push(source);
            warnings.extend(told);
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        warnings.sort();
        warnings.dedup();
        Ok(Baker {
            built,
            settings,
            sources,
            constants: constants(),
            warnings,
        })
    }

    /// The textures of built mesh `number` (of [`Built::meshes`]).
    ///
    /// # Errors
    /// [`Error::Capacity`] where the atlas of a LoD does not fit; [`Error::Cancelled`].
    pub fn mesh(&mut self, number: usize, progress: &dyn Progress) -> Result<Baked> {
        let built = &self.built.meshes[number];
        let reference = &self.built.scene.meshes[built.mesh];
        for source in &mut self.sources {
            source.take(reference, built.mesh)?;
        }
        let surface = Surface::new(built, reference, self.settings)?;
        let count = self.settings.size.div_ceil(BAND);
        let mut bands: Vec<Band> = Vec::with_capacity(count as usize);
        // Sixteen bands at a time, so that a bar moves and a caller can stop.
        for begin in (0..count).step_by(16) {
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
            progress.at("resample", &reference.name, begin as usize, count as usize);
            let some = (begin..(begin + 16).min(count)).into_par_iter();
            bands.par_extend(some.map(|band| self.band(&surface, band)));
        }
        Ok(self.joined(bands, surface.low.map(|(low, _)| low)))
    }

    /// One band of texels.
    fn band(&self, surface: &Surface, band: u32) -> Band {
        let BakeSettings { size, samples, .. } = *self.settings;
        let rows = band * BAND..((band + 1) * BAND).min(size);
        let owners = surface.owners(&rows, size, samples);
        let texels = (rows.len() * size as usize) as u32;
        let mut out = Band {
            values: vec![vec![None; texels as usize]; self.sources.len()],
            state: vec![0; texels as usize],
        };
        for k in 0..texels {
            let at = [k % size, rows.start + k / size];
            let (mut sums, mut found, mut lies) = (vec![[0.0; 4]; self.sources.len()], 0, false);
            for s in 0..samples * samples {
                let fine = [at[0] * samples + s % samples, at[1] * samples + s / samples];
                let Some(sample) = surface.sample(fine, size * samples, &rows, samples, &owners)
                else {
                    continue;
                };
                lies = true;
                let Some(point) = &sample.point else { continue };
                found += 1;
                for (source, sum) in self.sources.iter().zip(&mut sums) {
                    let decode = &self.constants[..256];
                    let value = source.at(decode, surface.reference, point, sample.low.as_ref());
                    (0..4).for_each(|i| sum[i] += value[i]);
                }
            }
            out.state[k as usize] = if found > 0 { 2 } else { u8::from(lies) };
            if found > 0 {
                for ((source, sum), values) in self.sources.iter().zip(sums).zip(&mut out.values) {
                    values[k as usize] = Some(source.mean(sum, found as f32));
                }
            }
        }
        out
    }

    /// Bands joined, borders grown, what is left filled with the mean.
    fn joined(&self, bands: Vec<Band>, low: Option<Mesh>) -> Baked {
        let state: Vec<u8> = bands.iter().flat_map(|b| b.state.iter().copied()).collect();
        let count = |wanted: u8| state.iter().filter(|&&s| s == wanted).count() as u64;
        let mut mask = Vec::new();
        let mut textures = Vec::new();
        for (k, source) in self.sources.iter().enumerate() {
            let known: Vec<_> = bands
                .iter()
                .flat_map(|b| b.values[k].iter().copied())
                .collect();
            let grown = fill::spread(known, self.settings.size, self.settings.padding);
            if mask.is_empty() {
                let shade = |(s, v): (&u8, &Option<_>)| match (s, v) {
                    (2, _) => 255,
                    (_, Some(_)) => 128,
                    _ => 0,
                };
                mask = state.iter().zip(&grown).map(shade).collect();
            }
            let mean = mean(&grown);
            let values: Vec<[f32; 4]> = grown.into_iter().map(|v| v.unwrap_or(mean)).collect();
            textures.push(BakedTexture {
                attribute: source.attribute.clone(),
                rgba8: values
                    .iter()
                    .flat_map(|v| self.encoded(source, *v))
                    .collect(),
                values,
            });
        }
        Baked {
            low,
            textures,
            mask,
            filled: count(2),
            missed: count(1),
        }
    }

    fn encoded(&self, source: &Source, value: [f32; 4]) -> [u8; 4] {
        let thresholds = &self.constants[THRESHOLDS_AT..THRESHOLDS_AT + 256];
        let [r, g, b, a] = source.coded(value);
        let code = |c: f32| {
            if source.is_color() {
                srgb_encode(thresholds, c) as u8
            } else {
                unit_encode(c) as u8
            }
        };
        [code(r), code(g), code(b), unit_encode(a) as u8]
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

/// Refuses what cannot be baked, before any work.
fn check(built: &Built, settings: &BakeSettings) -> Result<()> {
    let BakeSettings {
        size,
        samples,
        padding,
        ..
    } = *settings;
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
    if settings.attributes.is_empty() {
        return wrong("--attributes", "none is named".into());
    }
    let levels = built.meshes.iter().map(|m| m.lods.len()).min().unwrap_or(0);
    match settings.over {
        Over::Lod(level) if level > levels => wrong(
            "--lod",
            format!("the model has levels 0 (the reference) to {levels}, not {level}"),
        ),
        Over::Primary if settings.attributes.contains(&BakeAttribute::Normal) => {
            let reason = "normal needs the tangents of a LoD; over the primary parameterization bake object-normal";
            wrong("--attributes", reason.into())
        }
        _ => Ok(()),
    }
}
