//! A model made ready at each level that `render` asks for.
//!
//! In: a model, how its levels are drawn. Out: a renderer of a level in a pose, staged when it is first asked for.

use std::collections::BTreeMap;

use invertex::Result;
use invertex::asset::Model;
use invertex::render::{Renderer, Switching};
use invertex::scene::Pose;

use super::device::Device;
use super::drawing::{Staged, Wish};
use super::motion;

/// The model made ready at each level that is asked for, and the moment that it is posed at.
pub(super) struct Stages<'a> {
    /// How levels are drawn; the level it says counts for nothing.
    pub(super) wish: Wish<'a>,
    pub(super) model: &'a Model,
    pub(super) device: &'a Device,
    pub(super) animation: Option<usize>,
    pub(super) switching: Switching,
    ready: BTreeMap<usize, (Staged<'a>, Option<f64>)>,
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
            warnings: Vec::new(),
        }
    }

    /// Draws `level` at a moment of the animation.
    pub(super) fn at(&mut self, level: usize, time: Option<f64>) -> Result<&Renderer> {
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
