//! What is shown in place of the material's base colour: `--attribute` and what goes with it.
//!
//! In: the options. Out: a [`Shown`], made ready for the model at hand.

use std::path::PathBuf;

use invertex::Result;
use invertex::attribute::{Attribute, OcclusionOptions, Procedural, Shown, ShownOptions, Volume};
use invertex::scene::Scene;

use super::drawing::Mode;
use super::progress::Bar;
use super::{Common, bad_option};

/// Options of attributes.
#[derive(clap::Args)]
pub(super) struct Showing {
    /// Show this in place of the material's base colour: base-color, emissive, color (COLOR_0), triangle-color, material,
    /// part; wood, marble, cellular, checker3d, volume (--volume), procedural (--procedural); or data, never lit: normal,
    /// normal-map, metallic-roughness, occlusion-map, occlusion (cast here), a custom attribute of the file as _NAME or
    /// _NAME:LOW..HIGH. `flat:` before color, occlusion or _NAME takes each triangle's first corner. A*B is the product, at
    /// most four.
    #[arg(
        long,
        value_name = "NAME[*NAME..]",
        help_heading = "Attribute",
        allow_hyphen_values = true
    )]
    attribute: Option<String>,
    #[command(flatten)]
    computed: Computed,
    /// The function of the attribute procedural: GLSL with vec3 igt_procedural(vec3 position, vec3 normal, float time),
    /// position of the reference at rest in the file's unit, time in seconds, a linear colour. Needs a device.
    #[arg(
        long,
        value_name = "FILE.glsl",
        requires = "attribute",
        help_heading = "Attribute"
    )]
    procedural: Option<PathBuf>,
}

/// How attributes that have to be computed are.
#[derive(Clone, clap::Args)]
pub(super) struct Computed {
    /// Rays of each vertex for the attribute occlusion. Default: 128.
    #[arg(long, value_name = "N", help_heading = "Attribute")]
    occlusion_samples: Option<u32>,
    /// How far they reach, in diagonals of the model. Default: 0.5.
    #[arg(
        long,
        value_name = "X",
        help_heading = "Attribute",
        allow_hyphen_values = true
    )]
    occlusion_reach: Option<f32>,
    /// How many times as fine wood, marble, cellular, checker3d and volume are. Default: 1, where a volume is as large as the
    /// model.
    #[arg(
        long,
        value_name = "X",
        help_heading = "Attribute",
        allow_hyphen_values = true
    )]
    solid_scale: Option<f32>,
    /// The 3-D image of the attribute volume: a picture of square slices one below the other, or a folder of slices. Slice 0
    /// is where z is least, y is up.
    #[arg(long, value_name = "FILE|FOLDER", help_heading = "Attribute")]
    volume: Option<PathBuf>,
}

impl Computed {
    /// The first of these options that is given.
    fn given(&self) -> Option<&'static str> {
        let all = [
            (self.occlusion_samples.is_some(), "--occlusion-samples"),
            (self.occlusion_reach.is_some(), "--occlusion-reach"),
            (self.solid_scale.is_some(), "--solid-scale"),
            (self.volume.is_some(), "--volume"),
        ];
        all.iter()
            .find(|(given, _)| *given)
            .map(|(_, option)| *option)
    }

    /// As options.
    ///
    /// # Errors
    /// Those of [`Volume::load`].
    pub(super) fn options(&self) -> Result<ShownOptions> {
        let usual = OcclusionOptions::default();
        Ok(ShownOptions {
            occlusion: OcclusionOptions {
                samples: self.occlusion_samples.unwrap_or(usual.samples),
                reach: self.occlusion_reach.unwrap_or(usual.reach),
            },
            scale: self.solid_scale.unwrap_or(1.0),
            still: false,
            volume: self.volume.as_deref().map(Volume::load).transpose()?,
            procedural: None,
        })
    }
}

impl Showing {
    /// The attribute, if one is asked for and `mode` shows any.
    ///
    /// # Errors
    /// [`invertex::Error::Option`] for one that does not exist, or a mode that shows none.
    pub(super) fn attribute(&self, mode: Mode) -> Result<Option<Attribute>> {
        let attribute: Option<Attribute> = self.attribute.as_deref().map(str::parse).transpose()?;
        if let (None, Some(option)) = (&attribute, self.computed.given()) {
            return Err(bad_option(
                option,
                "says how an attribute is computed: give --attribute",
            ));
        }
        match (&attribute, mode) {
            (None, _) | (_, Mode::Reference | Mode::Igt) => Ok(attribute),
            (Some(shown), Mode::Wireframe) if !shown.is_data() => Ok(attribute),
            (Some(shown), Mode::Wireframe) => {
                let reason = format!("{shown} is data, which --mode wireframe does not draw over");
                Err(bad_option("--attribute", reason))
            }
            _ => Err(bad_option(
                "--attribute",
                "is shown by --mode reference, igt and wireframe",
            )),
        }
    }

    /// `attribute` made ready for `scene`, with a bar where it takes long. `animated`: whether time is an animation's; solid
    /// textures then stand still.
    ///
    /// # Errors
    /// Those of [`Shown::new`].
    pub(super) fn shown(
        &self,
        attribute: Option<&Attribute>,
        scene: &Scene,
        animated: bool,
        common: &Common,
    ) -> Result<Option<Shown>> {
        let Some(attribute) = attribute else {
            return Ok(None);
        };
        let options = ShownOptions {
            procedural: self
                .procedural
                .as_deref()
                .map(Procedural::load)
                .transpose()?,
            still: animated,
            ..self.computed.options()?
        };
        let bar = Bar::new(common, 1);
        let heard = |done: usize, of: usize| bar.at("occlusion", done as u64, of as u64);
        Shown::new(scene, attribute, &options, &heard).map(Some)
    }
}
