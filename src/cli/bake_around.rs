//! Options of attributes that depend on what lies round a point of the reference.

use invertex::Result;
use invertex::recover::AroundOptions;

use super::bad_option;

/// How surroundings are looked at.
#[derive(Clone, clap::Args)]
#[command(next_help_heading = "Attribute")]
pub(super) struct Surroundings {
    /// Rays of each sample for bent-normal and thickness. Default: 64.
    #[arg(long, value_name = "N")]
    rays: Option<u32>,
    /// How far they reach, in diagonals of the reference's box. Default: 0.5.
    #[arg(long, value_name = "DIAGONALS", allow_negative_numbers = true)]
    ray_reach: Option<f32>,
    /// The radius of the ball whose curvature is white in PNG, in diagonals of the reference's box. Default: 0.02.
    #[arg(long, value_name = "DIAGONALS", allow_negative_numbers = true)]
    curvature_radius: Option<f32>,
    /// The direction towards the light of shading and shadow. Default: -0.4,0.55,0.75.
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    light: Vec<f32>,
}

impl Surroundings {
    pub(super) fn options(&self) -> Result<AroundOptions> {
        let usual = AroundOptions::default();
        let light = match self.light.as_slice() {
            [] => usual.light,
            &[x, y, z] => [x, y, z],
            _ => return Err(bad_option("--light", "needs a direction such as 0,1,0.5")),
        };
        Ok(AroundOptions {
            rays: self.rays.unwrap_or(usual.rays),
            reach: self.ray_reach.unwrap_or(usual.reach),
            curvature_radius: self.curvature_radius.unwrap_or(usual.curvature_radius),
            light,
        })
    }
}
