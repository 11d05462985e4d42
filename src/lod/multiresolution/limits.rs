//! What a picture may be off by: what cuts are asked for.

use crate::error::{Error, Result};

/// What of a displacement on the screen is limited.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Criterion {
    /// How far the surface moves, the part along its normal: what simplifiers keep to that know no texture. What the surface
    /// shows then moves as far as it may. To compare with.
    Surface,
    /// How far any point moves.
    #[default]
    Displacement,
    /// How far any point moves, or how far the surface does where colours change by no more than this, in the unit of the
    /// model's colour deviations. For a model without any: [`Criterion::Displacement`].
    Colour(f64),
}

impl Criterion {
    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            Criterion::Surface => "surface",
            Criterion::Displacement => "pixels",
            Criterion::Colour(_) => "pixels+colour",
        }
    }

    /// The limit of colours, where there is one.
    pub fn colour(self) -> Option<f64> {
        match self {
            Criterion::Colour(limit) => Some(limit),
            Criterion::Surface | Criterion::Displacement => None,
        }
    }
}

/// What a picture may be off by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Displacement on the screen, in pixels.
    pub pixels: f64,
    /// What must keep within them.
    pub criterion: Criterion,
    /// What is finer becomes coarser only below this share of the limits, between 0 and 1: at 1 there is no hysteresis.
    pub hysteresis: f64,
    /// Whether what no pixel shows stays fine (the paper's way: the camera may turn fast) or may be as coarse as can be.
    pub outside: bool,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            pixels: 0.5,
            criterion: Criterion::Displacement,
            hysteresis: 1.0,
            outside: true,
        }
    }
}

impl Limits {
    /// Whether the numbers are ones that a picture can be off by.
    ///
    /// # Errors
    /// [`Error::Option`] naming `--lod` for a limit that is negative or not a number, or a hysteresis outside of 0 to 1.
    pub fn check(&self) -> Result<()> {
        let wrong = |reason: String| Error::Option {
            option: "--lod",
            reason,
        };
        for (name, limit) in [
            ("pixels", Some(self.pixels)),
            ("colour", self.criterion.colour()),
        ] {
            if let Some(limit) = limit.filter(|x| !(x.is_finite() && *x >= 0.0)) {
                return Err(wrong(format!(
                    "{name}:{limit} is no limit; 0 or more, such as {name}:0.5"
                )));
            }
        }
        match self.hysteresis {
            h if h > 0.0 && h <= 1.0 => Ok(()),
            h => Err(wrong(format!("hysteresis {h} is not above 0 and up to 1"))),
        }
    }
}
