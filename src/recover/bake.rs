//! The bake of a built model: a texture for each attribute.
//!
//! In: a built model, [`BakeSettings`]. Out: [`Baked`] for each mesh that is asked for.

use super::around::{Around, AroundOptions};
use super::coding::{Coding, number};
use super::mapping::Mapping;
use super::resample::{Fineness, Taker, resample};
use super::source::Source;
use super::surface::{OverLod, OverPrimary};
use super::wanted::BakeAttribute;
use crate::asset::{Built, Progress};
use crate::attribute::ShownOptions;
use crate::mesh::Mesh;
use crate::mesh::bvh::Bvh;
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
    /// Texels along each side, 16 to 16384.
    pub size: u32,
    /// Samples along each side of a texel, 1 to 8: their mean is the texel.
    pub samples: u32,
    /// Texels that borders grow by, 0 to 256.
    pub padding: u32,
    /// Bytes of texels that are made in one walk over the surface, at 16 each; at least one texture is. Where there are more,
    /// another walk makes the next ones: less memory for more time, the same texels.
    pub memory: u64,
    /// Of attributes that are computed.
    pub shown: ShownOptions,
    /// Of attributes that depend on what lies round a point.
    pub around: AroundOptions,
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
            memory: 1 << 30,
            shown: ShownOptions::default(),
            around: AroundOptions::default(),
        }
    }
}

/// The textures of a mesh.
#[derive(Clone, Debug, Default)]
pub struct Baked {
    /// The surface they are laid out over: uv set 0, tangents along it. None over the primary.
    pub low: Option<Mesh>,
    /// In the order of the settings; none where they were handed over one by one.
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
    pub(super) coding: Coding,
}

impl BakedTexture {
    /// The values in 8 bits: colours as sRGB, data as it is, directions from -1..1 to 0..255.
    pub fn rgba8(&self) -> Vec<u8> {
        self.coding.eight(&self.values)
    }

    /// Likewise in 16 bits.
    pub fn rgba16(&self) -> Vec<u16> {
        self.coding.sixteen(&self.values)
    }

    /// Of [`BakeAttribute::Mapping`]: for each texel the number of its triangle, `u32::MAX` where there is none. A float alone
    /// holds no number above 2^24.
    pub fn triangles(&self) -> Option<Vec<u32>> {
        let all = self.values.iter().map(|v| number(*v).unwrap_or(u32::MAX));
        (self.attribute == BakeAttribute::Mapping).then(|| all.collect())
    }
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
            (&settings.shown, &settings.around),
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
        collected(|taker| self.mesh_each(number, progress, taker))
    }

    /// Likewise, each texture handed over as soon as it is finished, so that no more memory is taken than two or three of the
    /// largest need.
    ///
    /// # Errors
    /// As [`Baker::mesh`]; those of `finished`, which end the work.
    pub fn mesh_each(
        &mut self,
        number: usize,
        progress: &dyn Progress,
        finished: &mut dyn FnMut(BakedTexture) -> Result<()>,
    ) -> Result<Baked> {
        let built = &self.built.meshes[number];
        let reference = &self.built.scene.meshes[built.mesh];
        let wanted = &self.settings.attributes;
        let casts = wanted.iter().any(BakeAttribute::asks_around);
        let corners = (0..reference.triangles.len()).filter(|_| casts);
        let tree = Bvh::new(&corners.map(|t| reference.corners(t)).collect::<Vec<_>>());
        let around = Around::new(
            &tree,
            std::iter::once(reference),
            wanted,
            &self.settings.around,
        );
        for source in &mut self.sources {
            source.take(reference, built.mesh)?;
            source.reach(None, &around);
        }
        let (sources, fineness) = (&self.sources, fineness(self.settings));
        match self.settings.over {
            Over::Lod(level) => {
                let surface = OverLod::new(built, reference, level, fineness)?;
                let over = (&surface as _, &around);
                let baked = resample(sources, over, fineness, progress, finished)?;
                Ok(Baked {
                    low: Some(surface.low),
                    ..baked
                })
            }
            Over::Primary => {
                let surface = OverPrimary::new(built, reference, fineness);
                let over = (&surface as _, &around);
                resample(sources, over, fineness, progress, finished)
            }
        }
    }
}

/// What a walk that hands textures over leaves, with the textures.
pub(super) fn collected(walk: impl FnOnce(Taker) -> Result<Baked>) -> Result<Baked> {
    let mut textures = Vec::new();
    let baked = walk(&mut |texture| {
        textures.push(texture);
        Ok(())
    })?;
    Ok(Baked { textures, ..baked })
}

fn fineness(settings: &BakeSettings) -> Fineness {
    Fineness {
        size: settings.size,
        samples: settings.samples,
        padding: settings.padding,
        memory: settings.memory,
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
        Over::Primary => match settings.attributes.iter().find(|a| a.is_tangent()) {
            Some(tangent) => wrong(
                "--attributes",
                format!(
                    "{tangent} needs the tangents of a LoD; over the primary parameterization bake object-{tangent}"
                ),
            ),
            None => Ok(()),
        },
        _ => Ok(()),
    }
}
