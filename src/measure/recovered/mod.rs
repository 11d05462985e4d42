//! How good a correspondence between two surfaces is: the four measures of Tarini, Cignoni and Scopigno, *Visibility Based
//! Methods and Assessment for Detail-Recovery* (IEEE Visualization 2003), section 4.
//!
//! In: a detailed scene, a simple one, mappings. Out: a [`Rating`] for each. With p a point of the simple surface, seen along a
//! ray of a view, F(p) its point of the reference, q the reference's point on the same ray:
//!
//! | measure | of a ray |
//! |---|---|
//! | object space (4.1) | the distance from F(p) to q; rays that miss either surface say nothing |
//! | image space (4.2) | the distance from F(p) to the ray |
//! | normalised (4.2.1) | that, divided by the distance from p to F(p): the sine of the angle between ray and step |
//! | sampling uniformity (4.3) | of neighbouring texels: how far the ratio of their distances, F(p) to p, is from 1 |
//!
//! The paper draws pictures and reads points from a texture, in 16 bits a coordinate. Here rays are cast and F is asked at the
//! very points they meet: nothing is rounded to texels or pixels, so that what is measured is the mapping alone. Views are
//! parallel, spread evenly, and none of the probes that visibility comes from.

mod heat;
mod uniformity;
mod views;

pub use heat::Heat;

use crate::asset::Progress;
use crate::recover::{
    Draw, Field, Fields, Finder, High, Laid, Mapping, Misses, Recovery, UvLayout,
    cage_is_asked_for, lay, meet, reach,
};
use crate::scene::Scene;
use crate::{Error, Result};
use heat::Gathering;
use std::sync::Arc;
use views::Sums;

/// What is rated, and how finely.
#[derive(Clone, Debug, PartialEq)]
pub struct AssessSettings {
    /// The mappings, each once.
    pub mappings: Vec<Mapping>,
    /// How points are looked for. Misses other than [`Misses::Proximity`] say nothing about any ray or pair of texels.
    pub recovery: Recovery,
    /// Where texture coordinates come from.
    pub layout: UvLayout,
    /// Directions of view, 1 to 65536.
    pub views: u32,
    /// Rays along each side of a view, 8 to 2048.
    pub rays: u32,
    /// Texels along each side, for sampling uniformity and for visibility per texel, 16 to 8192.
    pub size: u32,
    /// Texels along each side of maps that say where rays went wrong; none are made at 0.
    pub heat: u32,
}

impl Default for AssessSettings {
    fn default() -> Self {
        AssessSettings {
            mappings: Mapping::OF_TWO_SURFACES.to_vec(),
            recovery: Recovery {
                misses: Misses::Blank,
                ..Recovery::default()
            },
            layout: UvLayout::default(),
            views: 512,
            rays: 128,
            size: 1024,
            heat: 0,
        }
    }
}

/// The measures of a mapping; smaller is better in all. Distances are in percent of the diagonal of the reference's box.
#[derive(Clone, Debug)]
pub struct Rating {
    /// Which mapping.
    pub mapping: Mapping,
    /// View-dependent distance in object space, the mean over rays.
    pub object_space: f64,
    /// The same as root of the mean square.
    pub object_space_rms: f64,
    /// Distance in image space, the mean over rays.
    pub image_space: f64,
    /// Distance in image space by the length of the step, the mean over rays: 0..1.
    pub image_space_normalized: f64,
    /// The mean change of distances between neighbouring texels; 0.2 is 20 %.
    pub sampling_uniformity: f64,
    /// Rays that met the simple surface where the mapping found nothing, of all that met it.
    pub missed_fraction: f64,
    /// Rays that were measured in image space.
    pub rays: u64,
    /// Where rays went wrong, for each mesh of the simple model; as asked for.
    pub heat: Vec<Heat>,
}

/// Ratings, and what they are of.
#[derive(Clone, Debug)]
pub struct Assessment {
    /// In the order of the settings.
    pub ratings: Vec<Rating>,
    /// The diagonal of the reference's box, in the unit of the world.
    pub diagonal: f64,
    /// How far rays of mappings went, the farthest of all meshes, in diagonals.
    pub reach: f64,
    /// What was made up on the way.
    pub warnings: Vec<String>,
}

/// Rates `settings.mappings` between two scenes. `draw` makes the renderer of the probes.
///
/// # Errors
/// [`Error::Option`] for settings out of range; as [`Pair::new`](crate::recover::Pair::new) for models that cannot be held
/// against each other; [`Error::Cancelled`].
pub fn assess(
    high_scene: &Scene,
    low_scene: &Scene,
    settings: &AssessSettings,
    draw: Draw,
    progress: &dyn Progress,
) -> Result<Assessment> {
    assess_in_cage((high_scene, low_scene, None), settings, draw, progress)
}

/// Likewise, with a scene whose meshes are cages, as [`Pair::in_cage`](crate::recover::Pair::in_cage) has them.
///
/// # Errors
/// As [`assess`]; [`Error::Option`] for a cage that none of the mappings asks for, [`Error::Input`] for one whose triangles are
/// others.
pub fn assess_in_cage(
    (high_scene, low_scene, cage): (&Scene, &Scene, Option<&Scene>),
    settings: &AssessSettings,
    draw: Draw,
    progress: &dyn Progress,
) -> Result<Assessment> {
    check(settings)?;
    if cage.is_some() {
        cage_is_asked_for(&settings.mappings)?;
    }
    let lows = lay(low_scene, cage, settings.layout, settings.size)?;
    let high = High::new(high_scene, None)?;
    meet(high_scene, &high, low_scene, &lows)?;
    let all: Vec<&Laid> = lows.iter().collect();
    let reaches: Vec<f32> = lows
        .iter()
        .map(|low| reach(&high, low, &settings.recovery))
        .collect();
    let (both, recovery) = ((&high, all.as_slice()), &settings.recovery);
    let mut fields = Fields::new(both, recovery, &reaches, settings.size, draw);
    let mut prepared: Vec<Vec<Option<Arc<Field>>>> = Vec::new();
    for (k, mapping) in settings.mappings.iter().enumerate() {
        progress.at("probes", mapping.name(), k, settings.mappings.len());
        if progress.cancelled() {
            return Err(Error::Cancelled);
        }
        prepared.push(fields.of(*mapping)?);
    }
    let finders: Vec<Vec<Finder>> = settings
        .mappings
        .iter()
        .zip(&prepared)
        .map(|(mapping, fields)| {
            let finder = |k: usize| {
                let field = fields[k].as_deref();
                Finder::new(
                    (&high, all[k]),
                    *mapping,
                    &settings.recovery,
                    reaches[k],
                    field,
                )
            };
            (0..all.len()).map(finder).collect()
        })
        .collect();
    let diagonal = f64::from(high.tree.diagonal());
    let heat: Vec<Gathering> = finders
        .iter()
        .map(|_| Gathering::new(all.len(), settings.heat, diagonal))
        .collect();
    let sums = views::measure(&high, &all, &finders, settings, &heat, progress)?;
    let mut ratings = Vec::new();
    for (k, ((of, sums), heat)) in finders.iter().zip(sums).zip(heat).enumerate() {
        let mapping = settings.mappings[k];
        progress.at("texels", mapping.name(), k, settings.mappings.len());
        let uniformity = uniformity::measure(&all, of, settings.size);
        ratings.push(rating(mapping, &sums, uniformity, diagonal, heat.finish()));
    }
    let reach = reaches.iter().fold(0.0f32, |m, r| m.max(*r));
    Ok(Assessment {
        ratings,
        diagonal,
        reach: f64::from(reach) / diagonal,
        warnings: lows
            .iter()
            .flat_map(|l| l.warnings.iter().cloned())
            .collect(),
    })
}

fn rating(
    mapping: Mapping,
    sums: &Sums,
    uniformity: f64,
    diagonal: f64,
    heat: Vec<Heat>,
) -> Rating {
    let mean = |sum: f64, count: u64| sum / count.max(1) as f64;
    let percent = 100.0 / diagonal;
    Rating {
        mapping,
        object_space: mean(sums.object, sums.both) * percent,
        object_space_rms: mean(sums.object_squared, sums.both).sqrt() * percent,
        image_space: mean(sums.image, sums.rays) * percent,
        image_space_normalized: mean(sums.normalized, sums.steps),
        sampling_uniformity: uniformity,
        missed_fraction: mean(sums.missed as f64, sums.missed + sums.rays),
        rays: sums.rays,
        heat,
    }
}

fn check(settings: &AssessSettings) -> Result<()> {
    settings.recovery.check()?;
    let wrong = |option, reason: String| Err(Error::Option { option, reason });
    let within = |option, value: u32, from: u32, to: u32| match (from..=to).contains(&value) {
        true => Ok(()),
        false => wrong(option, format!("{value} is outside {from} to {to}")),
    };
    within("--views", settings.views, 1, 65_536)?;
    within("--rays", settings.rays, 8, 2048)?;
    within("--size", settings.size, 16, 8192)?;
    if settings.mappings.is_empty() {
        return wrong("--maps", "none is named".into());
    }
    if settings.mappings.contains(&Mapping::UvMatch) {
        let reason = "uv-match is of the inverse textures of a built file, not of two models";
        return wrong("--maps", reason.into());
    }
    Ok(())
}
