//! The bake of a built model: a texture for each attribute.
//!
//! In: a built model, [`BakeSettings`]. Out: [`Baked`] for each mesh that is asked for.

use super::mapping::Mapping;
use super::resample::{Fineness, resample};
use super::source::{BakeAttribute, Source};
use super::surface::{OverLod, OverPrimary};
use crate::asset::{Built, Progress};
use crate::attribute::ShownOptions;
use crate::mesh::Mesh;
use crate::{Error, Result};

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
    /// For each texel 255 where it has its point of the reference, 192 where it has one that stands in for what the mapping
    /// did not find, 128 where it got its neighbour's value, 0 elsewhere.
    pub mask: Vec<u8>,
    /// Texels with a point of the reference, be it one that stands in.
    pub filled: u64,
    /// Texels on the surface for which the mapping found none.
    pub missed: u64,
    /// Texels on the surface that have none at all.
    pub empty: u64,
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
    /// What was replaced on the way.
    pub warnings: Vec<String>,
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
        let (sources, warnings) = Source::all(
            &built.scene,
            &settings.attributes,
            &settings.shown,
            progress,
        )?;
        Ok(Baker {
            built,
            settings,
            sources,
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
        let fineness = fineness(self.settings);
        match self.settings.over {
            Over::Lod(level) => {
                let surface = OverLod::new(built, reference, level, fineness)?;
                let baked = resample(&self.sources, &surface, fineness, progress)?;
                Ok(Baked {
                    low: Some(surface.low),
                    ..baked
                })
            }
            Over::Primary => {
                let surface = OverPrimary::new(built, reference, fineness);
                resample(&self.sources, &surface, fineness, progress)
            }
        }
    }
}

fn fineness(settings: &BakeSettings) -> Fineness {
    Fineness {
        size: settings.size,
        samples: settings.samples,
        padding: settings.padding,
        fill: true,
    }
}

/// Numbers of triangles have no mean.
pub(super) fn numbers_are_whole(attributes: &[BakeAttribute], samples: u32) -> Result<()> {
    if samples == 1 || !attributes.contains(&BakeAttribute::Mapping) {
        return Ok(());
    }
    let reason = "mapping holds numbers of triangles, which have no mean: ask for --samples 1";
    Err(Error::Option {
        option: "--samples",
        reason: reason.into(),
    })
}

/// Refuses what cannot be baked, before any work.
fn check(built: &Built, settings: &BakeSettings) -> Result<()> {
    fineness(settings).check()?;
    numbers_are_whole(&settings.attributes, settings.samples)?;
    let wrong = |option, reason: String| Err(Error::Option { option, reason });
    if settings.mapping != Mapping::UvMatch {
        let reason = format!(
            "{} needs a second model, the surface to bake for",
            settings.mapping
        );
        return wrong("--map", reason);
    }
    let levels = built.meshes.iter().map(|m| m.lods.len()).min().unwrap_or(0);
    match settings.over {
        Over::Lod(level) if level > levels => wrong(
            "--lod",
            format!("the model has levels 0 (the reference) to {levels}, not {level}"),
        ),
        Over::Primary if settings.attributes.contains(&BakeAttribute::Height) => {
            let reason = "height needs the surface of a LoD to be measured from";
            wrong("--attributes", reason.into())
        }
        Over::Primary if settings.attributes.contains(&BakeAttribute::Normal) => {
            let reason = "normal needs the tangents of a LoD; over the primary parameterization bake object-normal";
            wrong("--attributes", reason.into())
        }
        _ => Ok(()),
    }
}
