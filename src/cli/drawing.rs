//! From a model to pictures: what `render` and `demo` share.
//!
//! In: a model, a mode, a level. Out: a [`Renderer`] that holds the staged picture, and images as files' bytes.

use invertex::asset::Model;
use invertex::attribute::{Shown, attributes_of, attributes_showing};
use invertex::output::{Aov, encode_exr, encode_png};
use invertex::render::{
    Correspond, Filter, Options, Output, Picture, Rendered, Renderer, Subject, keep_only,
    stage_posed, stage_with, subjects, subjects_prefiltered,
};
use invertex::scene::{Material, Pose, Scene};
use invertex::{Error, Result};

use super::device::Device;

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Mode {
    /// The original model.
    Reference,
    /// A LoD with the inverse texture: all of the reference's appearance.
    Igt,
    /// The same LoD with texture coordinates at its corners, as an ordinary renderer would.
    Plain,
    /// World-space normals as colours (of a LoD, through the inverse texture).
    Normals,
    /// Like igt, with the drawn triangles' edges over it.
    Wireframe,
    /// Table fetches of each pixel in false colour.
    Fetches,
}

/// How light falls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Shading {
    /// Base colour alone.
    Unlit,
    /// One directional light and an ambient one.
    Lit,
}

impl Mode {
    /// Whether a model without inverse textures cannot be drawn so.
    pub(super) fn needs_tables(self) -> bool {
        matches!(self, Mode::Igt | Mode::Plain | Mode::Fetches)
    }

    pub(super) fn correspond(self, built: bool) -> Correspond {
        match self {
            Mode::Reference => Correspond::Reference,
            Mode::Plain => Correspond::Plain,
            _ if built => Correspond::Inverse,
            _ => Correspond::Reference,
        }
    }
}

/// How a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum DrawPath {
    /// Ids first, then all shading in one compute pass: the same bytes on every device.
    Deferred,
    /// All in the fragment shader, as an engine would; needs a device.
    Forward,
}

/// How a LoD gathers the reference over a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum FilterChoice {
    /// One point; its textures filtered as a plain renderer does.
    Nearest,
    /// The mean of five points (the paper's).
    Five,
    /// One point for each reference triangle under the pixel; textures filtered anisotropically over it.
    Footprint,
}

impl From<FilterChoice> for Filter {
    fn from(choice: FilterChoice) -> Self {
        match choice {
            FilterChoice::Nearest => Filter::Nearest,
            FilterChoice::Five => Filter::Five,
            FilterChoice::Footprint => Filter::Footprint,
        }
    }
}

/// What a renderer is made for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wish<'a> {
    /// The level of detail.
    pub(super) level: usize,
    /// What is drawn.
    pub(super) mode: Mode,
    /// How light falls.
    pub(super) shading: Shading,
    /// How it is drawn.
    pub(super) path: DrawPath,
    /// What is shown in place of base colour.
    pub(super) shown: Option<&'a Shown>,
    /// Whether what was filtered beforehand is drawn where it will do.
    pub(super) shader_lod: bool,
}

/// The renderer's options for a mode.
pub(super) fn options(mode: Mode, shading: Shading, samples: u32) -> Options {
    let output = match (mode, shading) {
        (Mode::Normals, _) => Output::Normals,
        (Mode::Fetches, _) => Output::Fetches,
        (_, Shading::Lit) => Output::Lit,
        (_, Shading::Unlit) => Output::Unlit,
    };
    Options {
        output,
        wireframe: mode == Mode::Wireframe,
        samples,
        ..Options::default()
    }
}

/// A model staged at one level, ready to be drawn in one pose after the other.
pub(super) struct Staged<'a> {
    scene: &'a Scene,
    subjects: Vec<Subject<'a>>,
    correspond: Correspond,
    pub(super) renderer: Renderer,
}

impl<'a> Staged<'a> {
    /// Stages `model` in `pose` as `wish` says and makes it ready on `device`; also what was replaced on the way.
    pub(super) fn new(
        model: &'a Model,
        wish: Wish,
        pose: &Pose,
        device: &Device,
    ) -> Result<(Self, Vec<String>)> {
        let (subjects, correspond) = match model {
            Model::Plain(_) => (Vec::new(), Correspond::Reference),
            Model::Built(built) if wish.shader_lod => (
                subjects_prefiltered(built, wish.level),
                wish.mode.correspond(true),
            ),
            Model::Built(built) => (subjects(built, wish.level), wish.mode.correspond(true)),
        };
        let scene = model.scene();
        let (renderer, warnings) = staged(scene, &subjects, correspond, (wish, pose), device)?;
        let staged = Staged {
            scene,
            subjects,
            correspond,
            renderer,
        };
        Ok((staged, warnings))
    }

    /// Draws `pose` from now on.
    pub(super) fn repose(&mut self, pose: &Pose) -> Result<()> {
        self.renderer
            .repose(self.scene, &self.subjects, self.correspond, pose)
    }
}

/// A renderer of `subjects` in a pose, as `wish` says; also what was replaced on the way.
pub(super) fn staged(
    scene: &Scene,
    subjects: &[Subject],
    correspond: Correspond,
    (wish, pose): (Wish, &Pose),
    device: &Device,
) -> Result<(Renderer, Vec<String>)> {
    let lit = wish.shading == Shading::Lit || wish.mode == Mode::Normals;
    let (attributes, warnings) = match wish.shown {
        Some(shown) => attributes_showing(scene, lit, shown)?,
        None => attributes_of(scene, lit)?,
    };
    let picture = stage_with(attributes, scene, subjects, correspond, pose)?;
    Ok((renderer(picture, wish.path, device)?, warnings))
}

/// A renderer of `picture` on `device`.
pub(super) fn renderer(picture: Picture, path: DrawPath, device: &Device) -> Result<Renderer> {
    Ok(match (device, path) {
        (Device::Cpu, DrawPath::Deferred) => Renderer::cpu(picture),
        (Device::Cpu, DrawPath::Forward) => {
            let reason = "--path forward is drawn by a device only; see `invertex doctor`, or use --path deferred".to_owned();
            return Err(Error::NoDevice { reason });
        }
        #[cfg(feature = "gpu")]
        (Device::Gpu(context) | Device::Found(context), DrawPath::Deferred) => {
            Renderer::on(context, picture)?
        }
        #[cfg(feature = "gpu")]
        (Device::Gpu(context) | Device::Found(context), DrawPath::Forward) => {
            Renderer::forward(context, picture)?
        }
    })
}

/// Centre and radius of a sphere round the reference as it stands in the world, so that every level is framed alike.
pub(super) fn reference_sphere(model: &Model) -> Result<([f64; 3], f64)> {
    let bare = bare(model);
    posed_sphere(&bare, &bare.rest())
}

/// The same round all that animation `animation` does with it, so that every moment is framed alike.
pub(super) fn moving_sphere(model: &Model, animation: usize) -> Result<([f64; 3], f64)> {
    let bare = bare(model);
    let duration = bare.animations[animation].duration();
    let at = |k: u32| {
        let time = duration * f64::from(k) / f64::from(MOMENTS);
        posed_sphere(&bare, &bare.pose(animation, time)?)
    };
    let spheres = (0..=MOMENTS).map(at).collect::<Result<Vec<_>>>()?;
    let side = |k: usize, sign: f64| {
        let ends = spheres.iter().map(|(c, r)| sign * c[k] + r);
        sign * ends.fold(f64::NEG_INFINITY, f64::max)
    };
    let centre = [0, 1, 2].map(|k| (side(k, 1.0) + side(k, -1.0)) / 2.0);
    let reach = |(c, r): &([f64; 3], f64)| {
        let squared: f64 = (0..3).map(|k| (c[k] - centre[k]).powi(2)).sum();
        squared.sqrt() + r
    };
    Ok((centre, spheres.iter().map(reach).fold(0.0, f64::max)))
}

/// Moments of an animation that its pictures are framed by, one less.
const MOMENTS: u32 = 16;

/// The scene without textures: they have no extent, and nothing needs to be decoded.
fn bare(model: &Model) -> Scene {
    let mut bare = model.scene().clone();
    bare.materials = vec![Material::default(); bare.materials.len()];
    bare
}

fn posed_sphere(scene: &Scene, pose: &Pose) -> Result<([f64; 3], f64)> {
    let (picture, _) = stage_posed(scene, &[], Correspond::Reference, false, pose)?;
    Ok(picture.bounding_sphere())
}

/// The format of an image file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// 8-bit sRGB.
    Png,
    /// Linear float.
    Exr,
}

impl Format {
    /// By the end of a file's name.
    pub(super) fn of(name: &std::path::Path) -> Option<Self> {
        match name.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(Format::Png),
            "exr" => Some(Format::Exr),
            _ => None,
        }
    }
}

/// An image as a file's bytes.
pub(super) fn encode(image: &Rendered, format: Format, aov: bool) -> Result<Vec<u8>> {
    if format == Format::Png {
        return encode_png(image.width, image.height, &image.rgba8);
    }
    let nothing = |k: usize| image.triangle[k] == u32::MAX;
    let full = |(k, b): (usize, &[f32; 2])| {
        if nothing(k) {
            [0.0; 3]
        } else {
            [1.0 - b[0] - b[1], b[0], b[1]]
        }
    };
    let barycentric: Vec<[f32; 3]> = image.barycentric.iter().enumerate().map(full).collect();
    let layers = Aov {
        triangle: &image.triangle,
        barycentric: &barycentric,
        fetches: &image.fetches,
        depth: &image.depth,
    };
    encode_exr(
        image.width,
        image.height,
        &image.linear,
        aov.then_some(layers),
    )
}

/// A colour to lay pictures over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Background([u8; 3]);

impl std::str::FromStr for Background {
    type Err = String;

    /// `#rrggbb`.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let digits = text.strip_prefix('#').unwrap_or(text);
        let number = u32::from_str_radix(digits, 16)
            .ok()
            .filter(|_| digits.len() == 6 && digits.is_ascii());
        let [_, r, g, b] = number
            .ok_or_else(|| format!("\"{text}\" is not a colour #rrggbb"))?
            .to_be_bytes();
        Ok(Background([r, g, b]))
    }
}

/// Dark, as pages and heat maps are.
pub(super) const GROUND: Background = Background([24, 25, 28]);

impl Background {
    /// Lays `image` over the colour: every pixel becomes opaque.
    pub(super) fn under(self, image: &mut Rendered) {
        for pixel in image.rgba8.chunks_exact_mut(4) {
            let alpha = u32::from(pixel[3]);
            for k in 0..3 {
                let over = u32::from(pixel[k]) * alpha + u32::from(self.0[k]) * (255 - alpha);
                pixel[k] = ((over + 127) / 255) as u8;
            }
            pixel[3] = 255;
        }
        let linear = self.0.map(|c| linear(f32::from(c) / 255.0));
        for pixel in &mut image.linear {
            let alpha = pixel[3];
            for k in 0..3 {
                pixel[k] = pixel[k] * alpha + linear[k] * (1.0 - alpha);
            }
            pixel[3] = 1.0;
        }
    }
}

/// sRGB to linear (IEC 61966-2-1).
fn linear(x: f32) -> f32 {
    if x <= 0.040_45 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

/// A model with everything but the mesh called `name` left out.
///
/// # Errors
/// [`Error::Input`] listing the meshes there are.
pub(super) fn only(model: &mut Model, name: &str) -> Result<()> {
    let scene = match model {
        Model::Plain(scene) => scene.as_mut(),
        Model::Built(built) => &mut built.scene,
    };
    let keep = super::mesh_named(
        &scene.name,
        scene.meshes.iter().map(|m| m.name.as_str()),
        name,
    )?;
    keep_only(scene, keep)?;
    if let Model::Built(built) = model {
        built.meshes.retain(|mesh| mesh.mesh == keep);
    }
    Ok(())
}
