//! The steps of a build: what they are called, how long they take, who hears of them.
//!
//! In: settings, a scene. Out: what each step makes, and milliseconds of each stage.

use super::build::Prepared;
use super::colours_of;
use super::hierarchy::{LEAST, stands_still};
use super::motion::{places, shapes};
use super::settings::{BuildSettings, Multiresolution, Progress};
use crate::lod::multiresolution::{Hierarchy, StepColours};
use crate::lod::progressive::colour::colour_deviations;
use crate::lod::progressive::{Cost, Progressive};
use crate::lod::{self, Lod, LodInput, Shape, Simplifier};
use crate::param::{Chosen, Parts};
use crate::scene::Scene;
use crate::{Error, Result};
use std::time::Instant;

/// Steps, their times, and the one who listens.
pub(super) struct Work<'a> {
    names: Vec<String>,
    settings: &'a BuildSettings,
    progress: &'a dyn Progress,
    done: usize,
    of: usize,
    /// Of each stage, in order.
    pub(super) milliseconds: Vec<(&'static str, f64)>,
    /// What was found on the way.
    pub(super) notes: Vec<String>,
}

impl<'a> Work<'a> {
    pub(super) fn new(
        scene: &Scene,
        meshes: usize,
        settings: &'a BuildSettings,
        progress: &'a dyn Progress,
    ) -> Self {
        let of_each = match settings.multiresolution {
            Multiresolution::None => 5,
            Multiresolution::Geometry => 6,
            Multiresolution::Colours(_) => 7,
        };
        Work {
            names: scene.meshes.iter().map(|mesh| mesh.name.clone()).collect(),
            settings,
            progress,
            done: 0,
            of: meshes * of_each + 1,
            milliseconds: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// One step of `stage`.
    fn step<T>(
        &mut self,
        stage: &'static str,
        subject: &str,
        work: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        if self.progress.cancelled() {
            return Err(Error::Cancelled);
        }
        self.progress.at(stage, subject, self.done, self.of);
        let start = Instant::now();
        let result = work()?;
        let spent = start.elapsed().as_secs_f64() * 1e3;
        match self
            .milliseconds
            .iter_mut()
            .find(|(name, _)| *name == stage)
        {
            Some((_, total)) => *total += spent,
            None => self.milliseconds.push((stage, spent)),
        }
        self.done += 1;
        Ok(result)
    }

    /// A step for each mesh of the scene.
    pub(super) fn each<T>(
        &mut self,
        stage: &'static str,
        meshes: &[usize],
        work: impl Fn(usize) -> Result<T>,
    ) -> Result<Vec<T>> {
        meshes
            .iter()
            .map(|&m| {
                let name = self.names[m].clone();
                self.step(stage, &name, || work(m))
            })
            .collect()
    }

    /// A step for each mesh that is on its way.
    pub(super) fn with_prepared<T>(
        &mut self,
        stage: &'static str,
        prepared: &[Prepared],
        work: impl Fn(&Prepared) -> Result<T>,
    ) -> Result<Vec<T>> {
        prepared
            .iter()
            .map(|p| {
                let name = self.names[p.mesh].clone();
                self.step(stage, &name, || work(p))
            })
            .collect()
    }

    /// The LoDs of all meshes, simplified together, and the histories that views will cut.
    pub(super) fn chains(
        &mut self,
        scene: &Scene,
        meshes: &[usize],
        chosen: &[Chosen],
        parts: &[Parts],
    ) -> Result<(Vec<Vec<Lod>>, Vec<Option<Hierarchy>>)> {
        let fractions = &self.settings.lods;
        let places = places(scene);
        let inputs: Vec<LodInput> = meshes
            .iter()
            .zip(chosen)
            .zip(parts)
            .map(|((&m, chosen), parts)| LodInput {
                mesh: &scene.meshes[m],
                primary: &chosen.primary,
                parts,
                world: places[m],
            })
            .collect();
        let histories = self.histories(&inputs)?;
        let simplifier = self.settings.simplifier;
        let chains = self.step("lods", "", || match simplifier {
            Simplifier::Meshopt => {
                let shapes: Vec<Vec<Shape>> = meshes.iter().map(|&m| shapes(scene, m)).collect();
                lod::chains_in_motion(&inputs, &shapes, fractions)
            }
            Simplifier::Progressive(cost) => {
                lod::nested_chains(&inputs, &histories, cost, fractions)
            }
        })?;
        let hierarchy = |(input, history): (&LodInput<'_>, Option<Progressive>)| {
            let hierarchy = history.map(|history| self.hierarchy(scene, input, history));
            hierarchy.transpose()
        };
        let hierarchies = inputs.iter().zip(histories).map(hierarchy);
        Ok((chains, hierarchies.collect::<Result<_>>()?))
    }

    /// For each mesh the history that views will cut: of those that stand still, where it is wanted.
    fn histories(&mut self, inputs: &[LodInput<'_>]) -> Result<Vec<Option<Progressive>>> {
        if self.settings.multiresolution == Multiresolution::None {
            return Ok(vec![None; inputs.len()]);
        }
        let cost = match self.settings.simplifier {
            Simplifier::Progressive(cost) => cost,
            Simplifier::Meshopt => Cost::default(),
        };
        let history = |input: &LodInput<'_>| match self.stands_still(input) {
            true => {
                let history = || Ok(Progressive::new(input, cost, LEAST));
                self.step("multiresolution", &input.mesh.name, history)
                    .map(Some)
            }
            false => Ok(None),
        };
        inputs.iter().map(history).collect()
    }

    fn stands_still(&mut self, input: &LodInput<'_>) -> bool {
        let still = stands_still(input.mesh);
        if !still {
            self.notes.push(format!(
                "mesh \"{}\" is deformed by skins or morph targets: it goes without a multiresolution model",
                input.mesh.name
            ));
        }
        still
    }

    /// What views will cut: a history, and what it does to colours.
    fn hierarchy(
        &mut self,
        scene: &Scene,
        input: &LodInput<'_>,
        history: Progressive,
    ) -> Result<Hierarchy> {
        let (mesh, settings) = (input.mesh, self.settings);
        let colours = match settings.multiresolution {
            Multiresolution::Colours(distance) => {
                let (colours, words) = colours_of(scene, mesh);
                self.notes.extend(words);
                let measure = || match colours {
                    Some(colours) => {
                        let off = colour_deviations(input, &history, &colours, distance)?;
                        Ok(Some(StepColours::of(&history, &off, distance)))
                    }
                    None => Ok(None),
                };
                self.step("colours", &mesh.name, measure)?
            }
            _ => None,
        };
        Ok(Hierarchy::new(history, &mesh.positions, colours))
    }
}
