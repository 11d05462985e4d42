//! `fly`: a camera that comes near and goes round, and the cuts that it sees.

use std::path::{Path, PathBuf};

use super::device::Device;
use super::drawing::{self, DrawPath, Mode, Shading, Wish};
use super::fly_report::{self, Flight, Moment, Pictures};
use super::lod_choice::LodChoice;
use super::motion::Distance;
use super::progress::Bar;
use super::render_stages::Stages;
use super::view::{Angles, Size};
use super::{Common, bad_option, print};
use invertex::asset::Model;
use invertex::lod::multiresolution::Limits;
use invertex::measure::displaced;
use invertex::output::{encode_png, heat_map, make_folder, write_bytes};
use invertex::render::{Camera, Projection, Rendered, Switching};
use invertex::{Error, Result};

/// Fly round a model that `build --mrm` made, and see which triangles are drawn.
///
/// Writes for each picture frame_NNNN.png (the model as it looks), frame_NNNN_cut.png (its triangles) and
/// frame_NNNN_displaced.png (how far each pixel's detail stands from its true place), and fly.html with plots over time.
#[derive(clap::Args)]
#[command(after_help = "\
JSON: file, device, limits {pixels, colour, surface, hysteresis, outside}, reference_triangles, frames[]: path, distance, turn, triangles,
asked (collapses and blocks of them), changed (triangles that the picture before did not have), selection_ms, bound_pixels (no
detail that faces the eye is displaced by more, as the model knows it), displaced {pixels,
mean, p99, max}: of the pixels whose point of the reference faces the eye, how far on the screen it stands from its place; page.

Examples:
  invertex build globe.glb -o mrm.glb --mrm
  invertex fly mrm.glb -o flight/
  invertex fly mrm.glb -o flight/ --lod pixels:0.5,colour:2 --frames 240 --size 640x360
  invertex fly mrm.glb -o swims/ --lod surface:0.5                 what is displaced where texture does not count
  invertex fly mrm.glb -o flight/ --distance 0.2..8 --turns 0 --outside coarse --json")]
pub(super) struct Fly {
    /// The model: a GLB that `build --mrm` made.
    file: PathBuf,
    /// The folder to write into.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// What pictures may be off by.
    #[arg(
        long,
        value_name = "pixels:X[,colour:Y]|surface:X",
        default_value = "pixels:0.5"
    )]
    lod: LodChoice,
    /// Pictures.
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    frames: u32,
    /// How far away the camera begins and ends; 1 sees the model whole.
    #[arg(long, value_name = "A..B", default_value = "6..0.7")]
    distance: Distance,
    /// Times round the model.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1.0,
        allow_hyphen_values = true
    )]
    turns: f64,
    /// Direction to begin at, as in `render`.
    #[arg(
        long,
        value_name = "AZIMUTH,ELEVATION",
        default_value = "30,20",
        allow_hyphen_values = true
    )]
    view: Angles,
    /// Size of the pictures.
    #[arg(long, value_name = "WxH", default_value = "512x512")]
    size: Size,
    /// What is finer becomes coarser only below this share of the limits, so that nothing flickers; 1: no such memory.
    #[arg(long, value_name = "SHARE", default_value_t = 0.9)]
    hysteresis: f64,
    /// What becomes of what lies outside of the picture.
    #[arg(long, value_enum, default_value_t = Outside::Fine)]
    outside: Outside,
    /// How light falls.
    #[arg(long, value_enum, default_value_t = Shading::Lit)]
    shading: Shading,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Outside {
    /// It is as fine as if it were seen: the camera may turn fast.
    Fine,
    /// It may be as coarse as can be.
    Coarse,
}

impl Fly {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        let limits = self.limits()?;
        let model = Model::load(&self.file)?;
        let Model::Built(built) = &model else {
            return Err(self.no_model());
        };
        if built.meshes.iter().all(|mesh| mesh.hierarchy.is_none()) {
            return Err(self.no_model());
        }
        make_folder(&self.output)?;
        let sphere = drawing::reference_sphere(&model)?;
        let device = Device::open(common)?;
        let wish = Wish {
            level: 0,
            mode: Mode::Igt,
            shading: self.shading,
            path: DrawPath::Deferred,
            shown: None,
            shader_lod: false,
        };
        let mut stages = Stages::new(&model, wish, &device, None, Switching::new(0));
        stages.check_cuts(Some(self.lod), 0)?;
        let bar = Bar::new(common, self.frames.into());
        let mut flight = Flight::new(&self.file, device.name(), limits, built);
        for k in 0..self.frames {
            bar.at(&format!("frame {k}"), k.into(), self.frames.into());
            let (moment, pictures) = self.frame(k, &mut stages, &limits, sphere)?;
            flight.add(moment, pictures, self.frames);
        }
        drop(bar);
        device.check();
        fly_report::write(&self.output, &mut flight)?;
        if common.json {
            print::json(&flight)
        } else {
            print::text(&flight.table().text())
        }
    }

    fn limits(&self) -> Result<Limits> {
        let Some(limits) = self.lod.limits(true) else {
            return Err(bad_option(
                "--lod",
                "a flight is within pixels:X, pixels:X,colour:Y or surface:X",
            ));
        };
        if !self.turns.is_finite() {
            return Err(bad_option("--turns", "is not a number"));
        }
        let limits = Limits {
            hysteresis: self.hysteresis,
            outside: self.outside == Outside::Fine,
            ..limits
        };
        limits.check().map_err(|e| match e {
            Error::Option { reason, .. } if reason.starts_with("hysteresis") => {
                bad_option("--hysteresis", reason)
            }
            other => other,
        })?;
        Ok(limits)
    }

    fn no_model(&self) -> Error {
        let reason = "has no multiresolution model; run `invertex build --mrm` first";
        Error::input(self.file.display().to_string(), "extensions", reason)
    }

    /// The camera of picture `k`: as much nearer from one to the next, by a factor.
    fn camera(&self, k: u32, (centre, radius): ([f64; 3], f64)) -> Result<(Camera, f64, f64)> {
        let share = f64::from(k) / f64::from(self.frames - 1);
        let Distance(from, to) = self.distance;
        let (distance, turn) = (from * (to / from).powf(share), self.turns * 360.0 * share);
        let angles = [self.view.0 + turn, self.view.1];
        let size = [self.size.0, self.size.1];
        let projection = Projection::Perspective;
        let camera = Camera::framed_from(distance, centre, radius, angles, projection, size)?;
        Ok((camera, distance, turn))
    }

    fn frame(
        &self,
        k: u32,
        stages: &mut Stages,
        limits: &Limits,
        sphere: ([f64; 3], f64),
    ) -> Result<(Moment, Pictures)> {
        let (camera, distance, turn) = self.camera(k, sphere)?;
        let options = drawing::options(Mode::Igt, self.shading, 1);
        let Some(drawn) = stages.draw_cut((limits, 0), &camera, &options, None)? else {
            return Err(self.no_model());
        };
        let wires = drawing::options(Mode::Wireframe, self.shading, 1);
        let wires = stages.again(&camera, &wires)?;
        let off = displaced(stages.model.scene(), &camera, &drawn.image);
        let (width, height, rgba) = heat(&off, &camera, limits.pixels)?;
        let pictures = Pictures {
            shown: png(&drawn.image)?,
            cut: png(&wires)?,
            displaced: encode_png(width, height, &rgba)?,
        };
        let path = self.output.join(format!("frame_{k:04}.png"));
        write_bytes(&path, &pictures.shown)?;
        write_bytes(&beside(&path, "cut"), &pictures.cut)?;
        write_bytes(&beside(&path, "displaced"), &pictures.displaced)?;
        let moment = Moment::new(path.display().to_string(), (distance, turn), &drawn, &off);
        Ok((moment, pictures))
    }
}

/// `frame_0001.png` becomes `frame_0001_WHAT.png`.
fn beside(path: &Path, what: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{what}.png"))
}

fn png(image: &Rendered) -> Result<Vec<u8>> {
    let mut image = image.clone();
    drawing::GROUND.under(&mut image);
    encode_png(image.width, image.height, &image.rgba8)
}

/// Displacements in hundredths of a pixel; the limit is at the top of the scale.
fn heat(off: &[Option<f32>], camera: &Camera, limit: f64) -> Result<(u32, u32, Vec<u8>)> {
    let hundredths: Vec<Option<u32>> = off
        .iter()
        .map(|d| d.map(|d| (d * 100.0).min(1e6) as u32))
        .collect();
    let top = (limit * 100.0).clamp(1.0, 10_000.0) as u32;
    let title = "displaced, hundredths of a pixel";
    heat_map([camera.width, camera.height], &hundredths, top, title)
}
