//! A history beside the model that views cut.
//!
//! In: a mesh, its steps and colours, found or read from a file. Out: [`Hierarchy`]: cuts, as levels of detail that are drawn
//! like any other.

use super::{Cut, Multiresolution, StepColours};
use crate::lod::progressive::{Progressive, Steps};
use crate::lod::source::Source;
use crate::lod::{Lod, LodInput};

/// A history, and the model that views cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Hierarchy {
    /// Every triangle, with its deviation.
    pub history: Progressive,
    /// What views cut.
    pub model: Multiresolution,
    /// What the colours of each collapse's triangles are off by; none: cuts go by pixels alone.
    pub colours: Option<StepColours>,
}

impl Hierarchy {
    /// Of a history of the mesh whose vertices lie at `positions`. `colours` fit ([`StepColours::fits`]). Prices of collapses
    /// become what steps alone tell: the largest deviation so far.
    pub fn new(
        mut history: Progressive,
        positions: &[[f32; 3]],
        colours: Option<StepColours>,
    ) -> Self {
        history.price_by_deviation();
        Hierarchy {
            model: Multiresolution::new(&history, positions, colours.as_ref()),
            history,
            colours,
        }
    }

    /// Made again from steps, as they stand in a file.
    ///
    /// # Errors
    /// What is wrong, in words: as [`Progressive::replay`]; colours that are not one row for each step.
    pub fn replay(
        input: &LodInput<'_>,
        steps: &Steps,
        colours: Option<StepColours>,
    ) -> Result<Self, String> {
        let history = Progressive::replay(input, steps)?;
        if let Some(colours) = &colours
            && !colours.fits(history.collapses.len())
        {
            return Err(format!(
                "its colours are not {} rows of up to 16 levels",
                history.collapses.len()
            ));
        }
        Ok(Self::new(history, &input.mesh.positions, colours))
    }

    /// The level of detail that a cut is: of `input`, whose history it is.
    pub fn lod(&self, input: &LodInput<'_>, cut: &Cut) -> Lod {
        let triangle = |&f: &u32| &self.history.triangles[self.model.of[f as usize] as usize];
        let lod = Source::new(input, &self.history).lod(cut.faces.iter().map(triangle));
        Lod {
            reached: true,
            ..lod
        }
    }
}
