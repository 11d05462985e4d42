//! What a picture may be off by: what cuts are asked for.

use crate::error::{Error, Result};

/// What a picture may be off by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Displacement of any point on the screen, in pixels.
    pub pixels: f64,
    /// Difference of colour, in the unit of the model's colour deviations; none judges by pixels alone.
    pub colour: Option<f64>,
    /// Whether the pixels limit only how far the surface moves, the part of a displacement along the normal: what simplifiers
    /// keep to that know no texture. What the surface shows then moves as far as it may. To compare with; not with `colour`.
    pub surface: bool,
    /// What is finer becomes coarser only below this share of the limits, between 0 and 1: at 1 there is no hysteresis.
    pub hysteresis: f64,
    /// Whether what no pixel shows stays fine (the paper's way: the camera may turn fast) or may be as coarse as can be.
    pub outside: bool,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            pixels: 0.5,
            colour: None,
            surface: false,
            hysteresis: 1.0,
            outside: true,
        }
    }
}

impl Limits {
    /// Whether the numbers are ones that a picture can be off by.
    ///
    /// # Errors
    /// [`Error::Option`] naming `--lod` for a limit that is negative or not a number, a limit of colour where the surface alone
    /// counts, or a hysteresis outside of 0 to 1.
    pub fn check(&self) -> Result<()> {
        let wrong = |reason: String| Error::Option {
            option: "--lod",
            reason,
        };
        for (name, limit) in [("pixels", Some(self.pixels)), ("colour", self.colour)] {
            if let Some(limit) = limit.filter(|x| !(x.is_finite() && *x >= 0.0)) {
                return Err(wrong(format!(
                    "{name}:{limit} is no limit; 0 or more, such as {name}:0.5"
                )));
            }
        }
        if self.surface && self.colour.is_some() {
            let reason = "where only the surface counts there is no limit of colour";
            return Err(wrong(reason.into()));
        }
        match self.hysteresis {
            h if h > 0.0 && h <= 1.0 => Ok(()),
            h => Err(wrong(format!("hysteresis {h} is not above 0 and up to 1"))),
        }
    }
}
