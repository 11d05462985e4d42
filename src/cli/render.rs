//! `render`: images of a model or of one of its LoDs.

use std::path::{Path, PathBuf};

use super::attribute::Showing;
use super::device::Device;
use super::drawing::{self, Background, DrawPath, FilterChoice, Format, Mode, Shading, Wish};
use super::lod_choice::LodChoice;
use super::motion::{self, Frame, Motion};
use super::print;
use super::progress::Bar;
use super::render_report::{ImageReport, Report};
use super::render_stages::Stages;
use super::view::{Angles, Size};
use super::{Common, bad_option, note};
use invertex::asset::Model;
use invertex::attribute::Attribute;
use invertex::output::{check_target, make_folder, write_bytes};
use invertex::render::{Camera, Output, Projection, Switching, View, parse_views};
use invertex::scene::read_file;
use invertex::{Error, Result};

const NO_FILTER: &str =
    "--filter changes nothing here: this mode looks no point up; --samples 4 does";

/// Draw a model, or a LoD of it that looks like the original.
///
/// Any glTF file can be drawn as its own reference; LoDs need a file that `build` made. PNG is 8-bit sRGB with alpha =
/// coverage; EXR is linear float. An animation poses reference and LoD alike; all its moments are framed alike too.
#[derive(clap::Args)]
#[command(after_help = "\
A camera file: {\"width\": W, \"height\": H, \"views\": [{\"name\": \"front.png\", \"view\": [[4x4, row-major, world to
camera, which looks down -Z, +Y up]], \"projection_vulkan\": [[4x4, clip z 0..1, y down]]}, ..]}

JSON: device, animation (its name), attribute, images[]: path, time (seconds into the animation), width, height, lod, cut {pixels, colour, surface, bound_pixels (no detail that faces the eye is displaced by more), asked, changed, selection_ms} (with a multiresolution model), leaving {lod, share} (while --blend goes on), triangles,
covered_pixels, mean_fetches, prefiltered_pixels (with --shader-lod: shown without a lookup), sha256 (of the file), passes[] (nanoseconds of each); warnings[].

EXR layers with --aov: triangle.id (of the reference, in its own mesh; -1 outside), barycentric.x .y .z, fetches.count,
depth.Z.

Examples:
  invertex render model.glb -o reference.png
  invertex render built.glb -o lod2.png --mode igt --lod 2
  invertex render built.glb -o plain.png --mode plain --lod triangles:500 --shading unlit
  invertex render built.glb -o views/ --camera cameras.json --mode igt --lod pixels:0.5
  invertex render mrm.glb -o view.png --mode igt --lod pixels:0.5,colour:2
  invertex render built.glb -o far.png --mode igt --lod 3 --shader-lod 1
  invertex render built.glb -o lod1.exr --aov --mode igt --lod 1 --view 30,15 --ortho
  invertex render built.glb -o occlusion.png --mode igt --lod 2 --attribute occlusion
  invertex render built.glb -o wood/ --mode igt --attribute wood --time 0..4 --fps 10
  invertex render built.glb -o mine.png --mode igt --attribute 'procedural*occlusion' --procedural mine.glsl
  invertex render built.glb -o ids.png --mode igt --attribute triangle-color --shading unlit
  invertex render fox.glb -o walk.png --animation Walk --time 0.35
  invertex render fox.built.glb -o run/ --mode igt --lod 1 --animation Run --time 0..1.15 --fps 24
  invertex render built.glb -o round/ --mode igt --turntable 36
  invertex render built.glb -o away/ --mode igt --lod pixels:0.5 --distance 1..30 --frames 120 --blend 6 --shader-lod 1
  invertex render built.glb -o edges.png --mode wireframe --lod 3 --background '#202020' --size 1600x1200")]
pub(super) struct Render {
    /// The model: .glb or .gltf.
    file: PathBuf,
    /// The image to write (.png or .exr); with --camera, or for a sequence, the folder for all of them.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// What is drawn.
    #[arg(long, value_enum, default_value_t = Mode::Reference)]
    mode: Mode,
    /// How it is drawn: ids first and then all shading in one compute pass, the same bytes on every device; or all in the
    /// fragment shader, as an engine would.
    #[arg(long, value_enum, default_value_t = DrawPath::Deferred)]
    path: DrawPath,
    /// The level of detail: N (0 is the reference's own geometry), triangles:N (the finest with at most N), or pixels:X
    /// (the coarsest that deviates less than X pixels; of a model made with `build --mrm` the triangles that this view needs,
    /// of any age), with ,colour:Y where they may move farther if no colour changes by more; surface:X where only the surface must keep its
    /// place, whatever the texture does. Default: 1 where LoDs are drawn.
    #[arg(long, value_name = "LEVEL", allow_hyphen_values = true)]
    lod: Option<LodChoice>,
    /// How light falls.
    #[arg(long, value_enum, default_value_t = Shading::Lit)]
    shading: Shading,
    /// Size of the image; overrides a camera file's. Default: 1024x1024.
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Direction to look from, in degrees: azimuth about +Y (0 is +Z, 90 is +X), elevation above the horizon.
    #[arg(
        long,
        value_name = "AZIMUTH,ELEVATION",
        default_value = "30,20",
        allow_hyphen_values = true
    )]
    view: Angles,
    /// Many views from a file.
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["view", "ortho"])]
    camera: Option<PathBuf>,
    /// Parallel projection instead of perspective.
    #[arg(long)]
    ortho: bool,
    /// Lay the picture over this colour; without it the background is transparent.
    #[arg(long, value_name = "#RRGGBB")]
    background: Option<Background>,
    /// How a LoD gathers the reference over a pixel.
    #[arg(long, value_enum, default_value_t = FilterChoice::Nearest)]
    filter: FilterChoice,
    /// Show what `build --shader-lod` filtered beforehand where it lies within so many steps of 8 bits of the lookup (0.25
    /// to 63.75): one fetch there; up to twice as far it gives way to the lookup.
    #[arg(long, value_name = "STEPS", allow_hyphen_values = true)]
    shader_lod: Option<f32>,
    /// Samples a pixel; 64 is near the truth and takes as many times as long.
    #[arg(long, value_name = "1|4|16|64", default_value_t = 1)]
    samples: u32,
    /// Also write what lies under each pixel, as layers of an EXR.
    #[arg(long)]
    aov: bool,
    /// Draw this mesh alone.
    #[arg(long, value_name = "NAME")]
    mesh: Option<String>,
    #[command(flatten)]
    showing: Showing,
    #[command(flatten)]
    motion: Motion,
}

impl Render {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        let attribute = self.showing.attribute(self.mode)?;
        let frames = self
            .motion
            .frames(attribute.as_ref().is_some_and(Attribute::varies))?;
        let views = self.check()?;
        let mut model = Model::load(&self.file)?;
        if let Some(name) = &self.mesh {
            drawing::only(&mut model, name)?;
        }
        if let (Model::Plain(_), true) = (&model, self.mode.needs_tables()) {
            let reason = "this model has no inverse textures; run `invertex build` first, or use --mode reference";
            return Err(Error::input(
                self.file.display().to_string(),
                "extensions",
                reason,
            ));
        }
        if let (Some(_), Model::Built(built)) = (self.shader_lod, &model)
            && built.meshes.iter().all(|mesh| mesh.prefiltered.is_none())
        {
            let reason = "nothing was filtered beforehand; build it with --shader-lod 256";
            return Err(Error::input(
                self.file.display().to_string(),
                "prefiltered",
                reason,
            ));
        }
        let animation = self.motion.animation(model.scene())?;
        let sphere = match animation {
            Some(animation) => drawing::moving_sphere(&model, animation)?,
            None => drawing::reference_sphere(&model)?,
        };
        let device = Device::open(common)?;
        let shown = self.showing.shown(
            attribute.as_ref(),
            model.scene(),
            animation.is_some(),
            common,
        )?;
        let wish = Wish {
            level: 0,
            mode: self.mode,
            shading: self.shading,
            path: self.path,
            shown: shown.as_ref(),
            shader_lod: self.shader_lod.is_some(),
        };
        let switching = Switching::new(self.motion.blend);
        let mut stages = Stages::new(&model, wish, &device, animation, switching);
        stages.check_cuts(self.lod, self.motion.blend)?;
        let shots = self.shots(views, &frames, sphere)?;
        let bar = Bar::new(common, shots.len() as u64);
        let mut images = Vec::new();
        for (k, shot) in shots.iter().enumerate() {
            let name = shot.path.file_name().unwrap_or_default();
            bar.at(&name.to_string_lossy(), k as u64, shots.len() as u64);
            images.push(self.draw(&mut stages, shot, sphere)?);
        }
        drop(bar);
        device.check();
        let mut warnings = stages.warnings;
        let looked_up = !matches!(self.mode, Mode::Reference | Mode::Plain);
        if self.filter != FilterChoice::Nearest && !looked_up {
            warnings.push(NO_FILTER.into());
        }
        warnings.iter().for_each(|warning| note(common, warning));
        let report = Report {
            file: self.file.display().to_string(),
            device: device.name(),
            animation: animation.map(|a| model.scene().animations[a].name.clone()),
            attribute: attribute.map(|a| a.to_string()),
            images,
            warnings,
        };
        if common.json {
            print::json(&report)
        } else {
            print::text(&report.table().text())
        }
    }

    /// Everything that can be said before the model is read; the views of a camera file.
    fn check(&self) -> Result<Option<Vec<View>>> {
        if self.mode == Mode::Reference && !matches!(self.lod, None | Some(LodChoice::Level(0))) {
            return Err(bad_option(
                "--lod",
                "the mode reference draws the original; use --mode igt or plain for a LoD",
            ));
        }
        if ![1, 4, 16, 64].contains(&self.samples) {
            let reason = format!("{} is not 1, 4, 16 or 64", self.samples);
            return Err(bad_option("--samples", reason));
        }
        self.check_shader_lod()?;
        let switches = matches!(self.lod, Some(LodChoice::Cut { .. }));
        let coloured = !matches!(self.mode, Mode::Normals | Mode::Fetches);
        self.motion.check_blend(switches, coloured)?;
        if let Some(camera) = &self.camera {
            if self.motion.is_sequence() {
                let reason = "draws one moment; --time A..B makes a sequence from one view";
                return Err(bad_option("--camera", reason));
            }
            let size = self.size.map(|Size(width, height)| (width, height));
            let views = parse_views(&camera.display().to_string(), &read_file(camera)?, size)?;
            make_folder(&self.output)?;
            return Ok(Some(views));
        }
        if self.motion.is_sequence() {
            make_folder(&self.output)?;
            return Ok(None);
        }
        let format = Format::of(&self.output).ok_or_else(|| {
            bad_option(
                "-o",
                format!(
                    "{}: the file's name must end in .png or .exr",
                    self.output.display()
                ),
            )
        })?;
        if self.aov && format != Format::Exr {
            return Err(bad_option(
                "--aov",
                "needs an .exr: layers have no place in a PNG",
            ));
        }
        check_target(&self.output)?;
        Ok(None)
    }

    fn check_shader_lod(&self) -> Result<()> {
        let Some(steps) = self.shader_lod else {
            return Ok(());
        };
        if !(0.25..=63.75).contains(&steps) {
            let reason = format!("{steps} is not from 0.25 to 63.75 steps of 8 bits");
            return Err(bad_option("--shader-lod", reason));
        }
        if matches!(self.mode, Mode::Reference | Mode::Plain) {
            let reason = "this mode looks no point up; use --mode igt";
            return Err(bad_option("--shader-lod", reason));
        }
        if self.showing.attribute(self.mode)?.is_some() {
            let reason = "what was filtered beforehand are the materials; not with --attribute";
            return Err(bad_option("--shader-lod", reason));
        }
        Ok(())
    }

    /// All images that are to be drawn.
    fn shots(
        &self,
        views: Option<Vec<View>>,
        frames: &[Frame],
        sphere: ([f64; 3], f64),
    ) -> Result<Vec<Shot>> {
        if let Some(views) = views {
            let time = frames.first().and_then(|frame| frame.time);
            let shot = |view: View| Shot {
                path: self.output.join(self.with_format(view.name)),
                camera: view.camera,
                time,
            };
            return Ok(views.into_iter().map(shot).collect());
        }
        let sequence = self.motion.is_sequence();
        let shot = |(k, frame): (usize, &Frame)| {
            let numbered = || self.output.join(self.with_format(format!("frame_{k:04}")));
            Ok(Shot {
                path: if sequence {
                    numbered()
                } else {
                    self.output.clone()
                },
                camera: self.framed(sphere, frame)?,
                time: frame.time,
            })
        };
        frames.iter().enumerate().map(shot).collect()
    }

    /// A file's name that says its format.
    fn with_format(&self, name: String) -> String {
        match Format::of(Path::new(&name)) {
            Some(_) => name,
            None => name + if self.aov { ".exr" } else { ".png" },
        }
    }

    fn framed(&self, (centre, radius): ([f64; 3], f64), frame: &Frame) -> Result<Camera> {
        let Size(width, height) = self.size.unwrap_or(Size(1024, 1024));
        let projection = if self.ortho {
            Projection::Orthographic
        } else {
            Projection::Perspective
        };
        Camera::framed_from(
            frame.distance,
            centre,
            radius,
            [self.view.0 + frame.turn, self.view.1],
            projection,
            [width, height],
        )
    }

    fn draw(
        &self,
        stages: &mut Stages,
        shot: &Shot,
        sphere: ([f64; 3], f64),
    ) -> Result<ImageReport> {
        let wanted = self.level(stages.model, &shot.camera, sphere)?;
        let time = motion::shown(stages.model.scene(), stages.animation, shot.time);
        let moment = time.or(shot.time);
        let mut options = drawing::options(self.mode, self.shading, self.samples);
        options.filter = self.filter.into();
        options.shader_lod = self.shader_lod.unwrap_or(0.0);
        if stages.wish.shown.is_some_and(|s| s.attribute().is_data()) {
            options.output = Output::Data;
        }
        options.time = shot.time.unwrap_or(0.0) as f32;
        let limits = self
            .lod
            .and_then(|lod| lod.limits(self.motion.is_sequence()));
        let cut = match &limits {
            Some(limits) => stages.draw_cut((limits, wanted), &shot.camera, &options, time)?,
            None => None,
        };
        let mut drawn = match cut {
            Some(drawn) => drawn,
            None => stages.draw(wanted, &shot.camera, &options, time)?,
        };
        if let Some(background) = self.background {
            background.under(&mut drawn.image);
        }
        let format = Format::of(&shot.path).unwrap_or(Format::Png);
        let bytes = drawing::encode(&drawn.image, format, self.aov)?;
        write_bytes(&shot.path, &bytes)?;
        let path = shot.path.display().to_string();
        Ok(ImageReport::new(
            path,
            &bytes,
            drawn,
            moment,
            self.shader_lod.is_some(),
        ))
    }

    fn level(&self, model: &Model, camera: &Camera, sphere: ([f64; 3], f64)) -> Result<usize> {
        match (model, self.mode, self.lod) {
            (_, Mode::Reference, _) => Ok(0),
            (Model::Built(built), _, choice) => choice
                .unwrap_or(LodChoice::Level(1))
                .level(built, camera, sphere),
            (Model::Plain(_), _, None | Some(LodChoice::Level(0))) => Ok(0),
            (Model::Plain(_), ..) => Err(bad_option(
                "--lod",
                "this model has no LoDs; run `invertex build` first",
            )),
        }
    }
}

/// One image to draw.
struct Shot {
    path: PathBuf,
    camera: Camera,
    /// Seconds into the animation, as asked for.
    time: Option<f64>,
}
