//! Options of detail recovery between two models, what reads them, and what draws their probes.

use std::path::Path;

use invertex::Result;
use invertex::asset::Model;
use invertex::recover::{Misses, Probes, Recovery, UvLayout};
use invertex::render::{Picture, Renderer};
use invertex::scene::Scene;

use super::bad_option;
use super::device::Device;
use super::drawing::{self, DrawPath};

/// How points of HIGH are looked for.
#[derive(Clone, clap::Args)]
#[command(next_help_heading = "Two models")]
pub(super) struct Recovering {
    /// How far rays go either way, in diagonals of HIGH's box. Default: twice as far as LOW lies from HIGH anywhere.
    #[arg(long, value_name = "DIAGONALS", allow_negative_numbers = true)]
    reach: Option<f32>,
    /// Let triangles count that look away from LOW.
    #[arg(long)]
    any_side: bool,
    /// Directions that visibility is gathered from. Default: 29.
    #[arg(long, value_name = "N")]
    probes: Option<u32>,
    /// Pixels along each side of a probe's picture. Default: 1024.
    #[arg(long, value_name = "N")]
    probe_size: Option<u32>,
    /// This way is up and the model is mostly looked at from the side: probes count by their squared cosine to the ground.
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    upright: Vec<f32>,
    /// Where texture coordinates of LOW come from. Default: auto.
    #[arg(long, value_enum)]
    uv: Option<Uv>,
}

/// Layouts of LOW.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Uv {
    /// TEXCOORD_0, or charts where there is none.
    Auto,
    /// TEXCOORD_0.
    Uv0,
    /// Charts of triangles that face one way.
    Charts,
    /// Each triangle by itself.
    Triangles,
}

impl Recovering {
    /// Whether any of these was asked for.
    pub(super) fn is_given(&self) -> bool {
        self.reach.is_some()
            || self.any_side
            || self.probes.is_some()
            || self.probe_size.is_some()
            || !self.upright.is_empty()
            || self.uv.is_some()
    }

    pub(super) fn settings(&self, misses: Misses) -> Result<Recovery> {
        let upright = match self.upright.as_slice() {
            [] => None,
            &[x, y, z] if x * x + y * y + z * z > 0.0 => Some([x, y, z]),
            _ => return Err(bad_option("--upright", "needs a direction such as 0,1,0")),
        };
        let usual = Probes::default();
        Ok(Recovery {
            reach: self.reach,
            facing: !self.any_side,
            misses,
            probes: Probes {
                directions: self.probes.unwrap_or(usual.directions),
                size: self.probe_size.unwrap_or(usual.size),
                upright,
            },
        })
    }

    pub(super) fn layout(&self) -> UvLayout {
        match self.uv {
            None | Some(Uv::Auto) => UvLayout::Auto,
            Some(Uv::Uv0) => UvLayout::Uv0,
            Some(Uv::Charts) => UvLayout::Charts,
            Some(Uv::Triangles) => UvLayout::Triangles,
        }
    }
}

/// A renderer of `picture` on `device`, for probes and previews.
pub(super) fn renderer(device: &Device, picture: Picture) -> Result<Renderer> {
    drawing::renderer(picture, DrawPath::Deferred, device)
}

/// Any model as its scene.
pub(super) fn scene(path: &Path) -> Result<Scene> {
    Ok(match Model::load(path)? {
        Model::Plain(scene) => *scene,
        Model::Built(built) => built.scene,
    })
}
