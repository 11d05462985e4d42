//! Detail recovery between two models that share nothing but space.
//!
//! In: a detailed scene, a simple one, [`PairSettings`]. Out: [`Pair`], whose meshes are baked one after the other.

use super::around::{Around, AroundOptions};
use super::bake::{Baked, BakedTexture, collected, numbers_are_whole};
use super::cage::Cage;
use super::find::Finder;
use super::high::High;
use super::laid::{Laid, Laying, UvLayout};
use super::mapping::{Mapping, Misses, Recovery};
use super::over_low::OverLow;
use super::probe::Draw;
use super::resample::{Fineness, resample};
use super::source::Source;
use super::standing::standing_first;
use super::surface::Tiles;
use super::visible::{Field, Fields};
use super::wanted::BakeAttribute;
use crate::asset::Progress;
use crate::attribute::ShownOptions;
use crate::mesh::Mesh;
use crate::mesh::bvh::NO_HINT;
use crate::scene::Scene;
use crate::{Error, Result};
use rayon::prelude::*;
use std::sync::Arc;

/// How much farther than the largest distance found rays go.
const FARTHER: f32 = 2.0;
/// Points that one core asks about in a run, each search beginning where the last one ended.
const CHUNK: usize = 512;

/// What is baked, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct PairSettings {
    /// Which point of the reference a texel stands for.
    pub mapping: Mapping,
    /// How it is looked for.
    pub recovery: Recovery,
    /// Where texture coordinates come from.
    pub layout: UvLayout,
    /// Whether a mesh takes its detail only from meshes of the same name, `_high` standing for `_low`.
    pub by_name: bool,
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

impl Default for PairSettings {
    fn default() -> Self {
        PairSettings {
            mapping: Mapping::Normal,
            recovery: Recovery::default(),
            layout: UvLayout::default(),
            by_name: false,
            attributes: vec![BakeAttribute::Normal],
            size: 1024,
            samples: 1,
            padding: 8,
            memory: 1 << 30,
            shown: ShownOptions::default(),
            around: AroundOptions::default(),
        }
    }
}

/// Two models made ready.
pub struct Pair<'a> {
    settings: &'a PairSettings,
    sources: Vec<Source>,
    high_scene: &'a Scene,
    /// All of it; by name, the one that the mesh at hand takes its detail from.
    high: High,
    lows: Vec<Laid>,
    fields: Vec<Option<Arc<Field>>>,
    /// What was replaced or made up on the way.
    pub warnings: Vec<String>,
}

/// The surfaces that a scene's meshes are, each where it stands first, in a cage if there is one.
pub(crate) fn lay(
    low: &Scene,
    cage: Option<&Scene>,
    layout: UvLayout,
    size: u32,
) -> Result<Vec<Laid>> {
    let cage = cage.map(Cage::new).transpose()?;
    let standing = standing_first(low)?;
    let laying = Laying {
        file: &low.name,
        layout,
        size,
    };
    let mut lows = Vec::new();
    for (k, stood) in standing.iter().enumerate() {
        let rest = &low.meshes[stood.number];
        let around = cage.as_ref().map(|cage| cage.of(rest, (k, standing.len())));
        lows.extend(Laid::all(
            &laying,
            rest,
            stood,
            &around.transpose()?.unwrap_or_default(),
        )?);
    }
    if lows.is_empty() {
        let reason = "the surface to bake for has no triangles";
        return Err(Error::input(&low.name, "scene", reason));
    }
    Ok(lows)
}

impl<'a> Pair<'a> {
    /// Reads textures, lays out what has no texture coordinates, looks from where surfaces are seen. `draw` makes the
    /// renderer for that: on the processor or on a device.
    ///
    /// # Errors
    /// [`Error::Option`] for settings out of range or an attribute that the reference does not have; [`Error::Input`] for
    /// models without triangles, texture coordinates that cannot be used, models that do not overlap in space.
    pub fn new(
        high_scene: &'a Scene,
        low_scene: &Scene,
        settings: &'a PairSettings,
        draw: Draw,
        progress: &dyn Progress,
    ) -> Result<Pair<'a>> {
        Pair::in_cage((high_scene, low_scene, None), settings, draw, progress)
    }

    /// Likewise, with a scene whose meshes are cages: those of the simple one with their vertices moved outwards, triangles in
    /// the same order. [`Mapping::Cage`] then looks from the cage to the surface and on, as far as rays reach.
    ///
    /// # Errors
    /// As [`Pair::new`]; [`Error::Option`] for a cage that the mapping does not ask for, [`Error::Input`] for one whose
    /// triangles are others.
    pub fn in_cage(
        (high_scene, low_scene, cage): (&'a Scene, &Scene, Option<&Scene>),
        settings: &'a PairSettings,
        draw: Draw,
        progress: &dyn Progress,
    ) -> Result<Pair<'a>> {
        fineness(settings).check()?;
        if cage.is_some() {
            cage_is_asked_for(&[settings.mapping])?;
        }
        settings.recovery.check()?;
        numbers_are_whole(&settings.attributes, settings.samples)?;
        if settings.mapping == Mapping::UvMatch {
            let reason = "uv-match needs the inverse textures of a built file, and no second model";
            return Err(Error::Option {
                option: "--map",
                reason: reason.into(),
            });
        }
        let lows = lay(low_scene, cage, settings.layout, settings.size)?;
        let high = High::new(high_scene, None)?;
        meet(high_scene, &high, low_scene, &lows)?;
        let (mut sources, mut warnings) = Source::all(
            high_scene,
            &settings.attributes,
            (&settings.shown, &settings.around),
            progress,
        )?;
        if !settings.by_name {
            sources
                .iter_mut()
                .try_for_each(|s| s.take_all(&high.meshes))?;
        }
        warnings.extend(lows.iter().flat_map(|low| low.warnings.iter().cloned()));
        progress.at("probes", &low_scene.name, 0, 1);
        let all: Vec<&Laid> = lows.iter().collect();
        let recovery = &settings.recovery;
        let size = settings.size.min(recovery.probes.size * 2);
        let reaches: Vec<f32> = all.iter().map(|low| reach(&high, low, recovery)).collect();
        let both = (&high, all.as_slice());
        let fields = Fields::new(both, recovery, &reaches, size, draw).of(settings.mapping)?;
        Ok(Pair {
            settings,
            sources,
            high_scene,
            high,
            lows,
            fields,
            warnings,
        })
    }

    /// Number of surfaces to bake for: meshes, or tiles of their texture coordinates.
    pub fn count(&self) -> usize {
        self.lows.len()
    }

    /// The name of a mesh to bake for.
    pub fn name(&self, mesh: usize) -> &str {
        &self.lows[mesh].object.name
    }

    /// The number in its scene of the mesh that a surface is, or is a tile of.
    pub fn number(&self, mesh: usize) -> usize {
        self.lows[mesh].number
    }

    /// The UDIM number of the tile that a surface is, where its mesh has several.
    pub fn tile(&self, mesh: usize) -> Option<u32> {
        self.lows[mesh].tile
    }

    /// Where a mesh stands, column-major.
    pub fn place(&self, mesh: usize) -> [[f32; 4]; 4] {
        self.lows[mesh].place.as_mat4().to_cols_array_2d()
    }

    /// How far rays of a mesh go, in the unit of the world: what is asked for, or twice the largest distance from the mesh's
    /// vertices and the middles of its triangles to the reference.
    pub fn reach(&self, mesh: usize) -> f32 {
        reach(&self.high, &self.lows[mesh], &self.settings.recovery)
    }

    /// The mesh of the reference that a triangle of the mapping image belongs to, and its number there.
    pub fn triangle(&self, triangle: u32) -> (&Mesh, u32) {
        self.high.mesh_of(triangle)
    }

    /// The textures of a mesh.
    ///
    /// # Errors
    /// [`Error::Input`] where no texel lies on the mesh, where nothing at all was found, or where no mesh of the reference
    /// has its name; [`Error::Cancelled`].
    pub fn bake(&mut self, mesh: usize, progress: &dyn Progress) -> Result<Baked> {
        collected(|taker| self.bake_each(mesh, progress, taker))
    }

    /// Likewise, each texture handed over as soon as it is finished, so that no more memory is taken than two or three of the
    /// largest need. Faults of the models are told before the first.
    ///
    /// # Errors
    /// As [`Pair::bake`]; those of `finished`, which end the work.
    pub fn bake_each(
        &mut self,
        mesh: usize,
        progress: &dyn Progress,
        finished: &mut dyn FnMut(BakedTexture) -> Result<()>,
    ) -> Result<Baked> {
        if self.settings.by_name {
            self.high = High::new(self.high_scene, Some(&self.lows[mesh].object.name))?;
            for source in &mut self.sources {
                source.take_all(&self.high.meshes)?;
            }
        }
        let reach = self.reach(mesh);
        let around = Around::new(
            &self.high.tree,
            self.high.meshes.iter().map(|m| &m.mesh),
            &self.settings.attributes,
            &self.settings.around,
        );
        let sources = &mut self.sources;
        sources
            .iter_mut()
            .for_each(|s| s.reach(Some(reach), &around));
        let low = &self.lows[mesh];
        let Recovery { misses, .. } = self.settings.recovery;
        let fineness = Fineness {
            fill: misses != Misses::Blank,
            ..fineness(self.settings)
        };
        let surface = OverLow {
            finder: Finder::new(
                (&self.high, low),
                self.settings.mapping,
                &self.settings.recovery,
                reach,
                self.fields[mesh].as_deref(),
            ),
            tiles: Tiles::new(&low.world, fineness),
            gradients: self.sources.iter().any(Source::has_textures),
            reference: &self.high_scene.name,
        };
        let over = (&surface as _, &around);
        let baked = resample(&self.sources, over, fineness, progress, finished)?;
        Ok(Baked {
            low: Some(low.object.clone()),
            ..baked
        })
    }
}

/// Refuses a cage that none of `mappings` looks from.
pub(crate) fn cage_is_asked_for(mappings: &[Mapping]) -> Result<()> {
    if mappings.iter().any(|m| m.looks_from_cage()) {
        return Ok(());
    }
    let names: Vec<&str> = mappings.iter().map(|m| m.name()).collect();
    let reason = format!("says nothing about the mapping {}", names.join(", "));
    Err(Error::Option {
        option: "--cage",
        reason,
    })
}

fn fineness(settings: &PairSettings) -> Fineness {
    Fineness {
        size: settings.size,
        samples: settings.samples,
        padding: settings.padding,
        memory: settings.memory,
        fill: true,
    }
}

/// How far rays go: see [`Pair::reach`].
pub(crate) fn reach(high: &High, low: &Laid, recovery: &Recovery) -> f32 {
    if let Some(diagonals) = recovery.reach {
        return diagonals * high.tree.diagonal();
    }
    let mut corners = low.world.triangles.as_flattened().to_vec();
    corners.sort_unstable();
    corners.dedup();
    let corners = corners.iter().map(|&v| low.world.positions[v as usize]);
    let middle = |t: usize| low.point(t, [1.0 / 3.0; 3]);
    let middles = (0..low.world.triangles.len()).map(middle);
    let points: Vec<_> = corners.chain(middles).collect();
    let farthest = |points: &[[f32; 3]]| {
        let (mut asking, mut most, mut hint) = (high.tree.asking(), 0.0f32, NO_HINT);
        for &p in points {
            if let Some(found) = asking.closest(p, f32::INFINITY, None, hint) {
                (most, hint) = (most.max(found.distance), found.hint);
            }
        }
        most
    };
    let chunks = points.par_chunks(CHUNK).map(farthest);
    let most = chunks.reduce(|| 0.0, f32::max);
    // Two surfaces in one place leave room for rounding.
    (FARTHER * most.sqrt()).max(1e-4 * high.tree.diagonal())
}

/// Refuses models whose boxes are apart by more than a tenth of the reference's diagonal.
pub(crate) fn meet(
    high_scene: &Scene,
    high: &High,
    low_scene: &Scene,
    lows: &[Laid],
) -> Result<()> {
    let (low, far) = high.tree.bounds();
    let gap = |laid: &Laid| {
        let (a, b) = laid.world.bounds().unwrap_or(([0.0; 3], [0.0; 3]));
        let apart = |k: usize| (a[k] - far[k]).max(low[k] - b[k]).max(0.0);
        let [x, y, z] = [apart(0), apart(1), apart(2)];
        (x * x + y * y + z * z).sqrt()
    };
    if lows
        .iter()
        .any(|laid| gap(laid) <= 0.1 * high.tree.diagonal())
    {
        return Ok(());
    }
    let reason = format!(
        "does not overlap {} in space: detail is recovered between models that stand in one place",
        high_scene.name
    );
    Err(Error::input(&low_scene.name, "scene", reason))
}
