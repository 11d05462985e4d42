//! A model made ready at each level, or cut, that `render` asks for.
//!
//! In: a model, how its levels are drawn. Out: images of a level in a pose, staged when it is first asked for, or of the cut
//! that a camera needs.

use std::collections::BTreeMap;

use invertex::Result;
use invertex::asset::Model;
use invertex::lod::multiresolution::{Criterion, Limits};
use invertex::render::{Camera, Cutter, Options, Rendered, Renderer, Switching, blended};
use invertex::scene::Pose;

use super::bad_option;
use super::device::Device;
use super::drawing::{self, Staged, Wish};
use super::lod_choice::LodChoice;
use super::motion;

/// An image, and what it is of.
pub(super) struct Drawn {
    pub(super) image: Rendered,
    pub(super) triangles: u32,
    /// The level; of a cut the one that meshes without a multiresolution model have.
    pub(super) level: usize,
    /// The level that is left, and how much of the image is the other one's.
    pub(super) leaving: Option<(usize, f32)>,
    pub(super) cut: Option<CutReport>,
}

/// What is said of a cut.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub(super) struct CutReport {
    /// Its limit on the screen, in pixels.
    pub(super) pixels: f64,
    /// Its limit in colour.
    pub(super) colour: Option<f64>,
    /// Whether the pixels limit the surface alone.
    pub(super) surface: bool,
    /// Pixels that nothing that faces the eye is displaced by more than; null where the eye stands too near to say.
    pub(super) bound_pixels: f64,
    /// Collapses and blocks of them that were asked.
    pub(super) asked: usize,
    /// Triangles that the cut before did not have.
    pub(super) changed: usize,
    /// Milliseconds of the selection.
    pub(super) selection_ms: f64,
}

/// The model made ready at each level that is asked for, and the moment that it is posed at.
pub(super) struct Stages<'a> {
    /// How levels are drawn; the level it says counts for nothing.
    pub(super) wish: Wish<'a>,
    pub(super) model: &'a Model,
    pub(super) device: &'a Device,
    pub(super) animation: Option<usize>,
    pub(super) switching: Switching,
    ready: BTreeMap<usize, (Staged<'a>, Option<f64>)>,
    /// What cuts the model, where something of it can be cut; and the renderer of cuts.
    pub(super) cutter: Option<Cutter<'a>>,
    of_cuts: Option<Renderer>,
    /// What was replaced when the first level was staged.
    pub(super) warnings: Vec<String>,
}

impl<'a> Stages<'a> {
    pub(super) fn new(
        model: &'a Model,
        wish: Wish<'a>,
        device: &'a Device,
        animation: Option<usize>,
        switching: Switching,
    ) -> Self {
        Stages {
            wish,
            model,
            device,
            animation,
            switching,
            ready: BTreeMap::new(),
            cutter: match model {
                Model::Built(built) => Cutter::new(built),
                Model::Plain(_) => None,
            },
            of_cuts: None,
            warnings: Vec::new(),
        }
    }

    /// What a model must have for the limits that are asked for.
    pub(super) fn check_cuts(&self, lod: Option<LodChoice>, blend: u32) -> Result<()> {
        let Some(LodChoice::Cut { criterion, .. }) = lod else {
            return Ok(());
        };
        let (colour, surface) = (
            criterion.colour().is_some(),
            criterion == Criterion::Surface,
        );
        let reason = match &self.cutter {
            None if colour => {
                "colour: this model has no multiresolution model; build it with --mrm"
            }
            None if surface => {
                "surface: this model has no multiresolution model; build it with --mrm"
            }
            Some(cutter) if colour && !cutter.knows_colours() => {
                "colour: the model does not know what colours are off by (no texture, or --mrm=geometry); give pixels:X alone"
            }
            Some(_) if blend > 0 => {
                return Err(bad_option(
                    "--blend",
                    "cuts of a multiresolution model change triangle by triangle: there are no levels to blend",
                ));
            }
            _ => return Ok(()),
        };
        Err(bad_option("--lod", reason))
    }

    /// Draws the level that is due where `wanted` is asked for.
    pub(super) fn draw(
        &mut self,
        wanted: usize,
        camera: &Camera,
        options: &Options,
        time: Option<f64>,
    ) -> Result<Drawn> {
        let step = self.switching.next(wanted);
        let renderer = self.at(step.level, time)?;
        let mut image = renderer.draw(camera, options)?;
        let mut triangles = renderer.picture().triangle_count();
        if let Some((old, share)) = step.leaving {
            let renderer = self.at(old, time)?;
            let from = renderer.draw(camera, options)?;
            triangles += renderer.picture().triangle_count();
            image = blended(&from, &image, share);
        }
        Ok(Drawn {
            image,
            triangles,
            level: step.level,
            leaving: step.leaving,
            cut: None,
        })
    }

    /// Draws the cut within `limits`; meshes that have none at `level`. None where nothing can be cut.
    pub(super) fn draw_cut(
        &mut self,
        (limits, level): (&Limits, usize),
        camera: &Camera,
        options: &Options,
        time: Option<f64>,
    ) -> Result<Option<Drawn>> {
        let Some(cutter) = &mut self.cutter else {
            return Ok(None);
        };
        let cuts = cutter.cut(camera, limits)?;
        let subjects = cutter.subjects(&cuts, level);
        let scene = self.model.scene();
        let pose = motion::pose(scene, self.animation, time)?;
        let correspond = self.wish.mode.correspond(true);
        match &mut self.of_cuts {
            Some(renderer) => renderer.restage(scene, &subjects, correspond, &pose)?,
            None => {
                let (renderer, warnings) = drawing::staged(
                    scene,
                    &subjects,
                    correspond,
                    (self.wish, &pose),
                    self.device,
                )?;
                self.warnings = warnings;
                self.of_cuts = Some(renderer);
            }
        }
        let Some(renderer) = &self.of_cuts else {
            return Ok(None);
        };
        Ok(Some(Drawn {
            image: renderer.draw(camera, options)?,
            triangles: renderer.picture().triangle_count(),
            level,
            leaving: None,
            cut: Some(CutReport {
                pixels: limits.pixels,
                colour: limits.criterion.colour(),
                surface: limits.criterion == Criterion::Surface,
                bound_pixels: cuts.displacement,
                asked: cuts.asked,
                changed: cuts.changed,
                selection_ms: cuts.milliseconds,
            }),
        }))
    }

    /// Draws the last cut once more, in another way.
    pub(super) fn again(&self, camera: &Camera, options: &Options) -> Result<Rendered> {
        match &self.of_cuts {
            Some(renderer) => renderer.draw(camera, options),
            None => Err(bad_option("--lod", "nothing was cut yet")),
        }
    }

    /// Draws `level` at a moment of the animation.
    fn at(&mut self, level: usize, time: Option<f64>) -> Result<&Renderer> {
        let posed = self.ready.get(&level).map(|(_, posed)| *posed);
        if posed != Some(time) {
            let pose = motion::pose(self.model.scene(), self.animation, time)?;
            match self.ready.get_mut(&level) {
                Some((staged, _)) => staged.repose(&pose)?,
                None => self.stage(level, &pose)?,
            }
        }
        match self.ready.get_mut(&level) {
            Some((staged, posed)) => {
                *posed = time;
                Ok(&staged.renderer)
            }
            None => unreachable!("it was staged above"),
        }
    }

    fn stage(&mut self, level: usize, pose: &Pose) -> Result<()> {
        let wish = Wish { level, ..self.wish };
        let (staged, warnings) = Staged::new(self.model, wish, pose, self.device)?;
        if self.ready.is_empty() {
            self.warnings = warnings;
        }
        self.ready.insert(level, (staged, None));
        Ok(())
    }
}
