//! `demo`: build, draw, compare and report, on the bundled model or on one's own.

use std::path::{Path, PathBuf};

use invertex::Result;
use invertex::asset::{self, BuildOutcome, BuildSettings, Built, Model};
use invertex::measure::{Comparison, Picture, Region, TimeStatistics, compare};
use invertex::output::{encode_png, make_folder, report, write_bytes};
use invertex::render::{Camera, Projection, Rendered, Renderer};
use invertex::scene::Scene;
use serde::Serialize;
use std::time::Instant;

use super::device::Device;
use super::drawing::{self, DrawPath, Mode, Shading, Wish};
use super::progress::Bar;
use super::{Common, build, demo_report, note, print};

/// The bundled model: an amphora, made by tools/make_asset.
const AMPHORA: &[u8] = include_bytes!("../../assets/amphora.glb");
/// Levels of detail, as shares of the reference's triangles.
const LODS: [f32; 4] = [0.2, 0.1, 0.05, 0.02];
/// The level beside the reference at the top of the report.
const SHOWCASE: usize = 2;
/// Repetitions of each timed frame.
const FRAMES: usize = 3;

/// Do all of it on the bundled model, ending with an HTML report.
///
/// Builds the inverse geometric textures, draws the reference and every LoD with and without them, compares the pictures
/// and writes one self-contained report.html that opens in any browser.
#[derive(clap::Args)]
#[command(after_help = "\
JSON: report, built, device, images[]: path, what, lod, triangles, flip_mean (against the reference; null where it is not compared);
seconds.

Examples:
  invertex demo                          into invertex-demo/
  invertex demo /tmp/report --device cpu
  invertex demo helmet/ --model helmet.glb --view 160,10")]
pub(super) struct Demo {
    /// The folder to write into; made if it is missing.
    #[arg(default_value = "invertex-demo")]
    folder: PathBuf,
    /// Another model instead of the bundled one.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Side of the pictures, in pixels.
    #[arg(long, value_name = "N", default_value_t = 640, value_parser = clap::value_parser!(u32).range(64..=4096))]
    size: u32,
    /// Direction to look from, in degrees: azimuth, elevation.
    #[arg(
        long,
        value_name = "AZIMUTH,ELEVATION",
        default_value = "25,15",
        allow_hyphen_values = true
    )]
    view: super::view::Angles,
}

#[derive(Serialize)]
struct Report {
    report: String,
    built: String,
    device: String,
    images: Vec<ImageReport>,
    seconds: f64,
}

#[derive(Serialize)]
struct ImageReport {
    path: String,
    what: &'static str,
    lod: usize,
    triangles: u32,
    flip_mean: Option<f64>,
}

/// One picture of the report.
pub(super) struct Shown {
    pub(super) png: Vec<u8>,
    pub(super) triangles: u32,
    pub(super) mean_fetches: f64,
    pub(super) against_reference: Option<Comparison>,
}

/// What the report says of one level.
pub(super) struct Level {
    pub(super) inverse: Shown,
    pub(super) plain: Shown,
    pub(super) wireframe: Shown,
    pub(super) fetches: Shown,
    pub(super) frame: Option<TimeStatistics>,
}

/// Everything the report is made from.
pub(super) struct Findings {
    pub(super) name: String,
    pub(super) outcome: BuildOutcome,
    pub(super) reference: Shown,
    pub(super) reference_frame: Option<TimeStatistics>,
    pub(super) levels: Vec<Level>,
    pub(super) file_bytes: u64,
    pub(super) device: String,
    pub(super) showcase: usize,
}

impl Demo {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        let start = Instant::now();
        make_folder(&self.folder)?;
        let (name, scene) = self.scene()?;
        let device = Device::open(common)?;
        let bar = Bar::new(common, 0);
        let settings = BuildSettings {
            lods: LODS.to_vec(),
            ..BuildSettings::default()
        };
        let outcome = asset::build(scene, &settings, device.processor(), &bar)?;
        let path = self.folder.join(format!("{name}.built.glb"));
        write_bytes(&path, &asset::to_bytes(&outcome.built)?)?;
        // Drawn from the file, as anybody else would.
        let model = Model::load(&path)?;
        let studio = Studio {
            demo: self,
            camera: self.camera(&model)?,
            model,
            device,
            bar,
        };
        let (findings, images) = studio.shoot(name, outcome, &path)?;
        drop(studio.bar);
        let report_path = self.folder.join("report.html");
        write_bytes(
            &report_path,
            report::render(&demo_report::of(&findings)).as_bytes(),
        )?;
        studio.device.check();
        let result = Report {
            report: report_path.display().to_string(),
            built: path.display().to_string(),
            device: findings.device,
            images,
            seconds: (start.elapsed().as_secs_f64() * 100.0).round() / 100.0,
        };
        if common.json {
            return print::json(&result);
        }
        note(
            common,
            &format!(
                "{} pictures and {} in {:.1} s",
                result.images.len(),
                result.built,
                result.seconds
            ),
        );
        print::text(&format!("{}\n", result.report))
    }

    fn scene(&self) -> Result<(String, Scene)> {
        match &self.model {
            None => Ok((
                "amphora".to_owned(),
                Scene::from_bytes("amphora.glb", AMPHORA, None)?,
            )),
            Some(path) => {
                let name = path
                    .file_stem()
                    .map_or("model".into(), |stem| stem.to_string_lossy().into_owned());
                Ok((name, build::load_original(path)?))
            }
        }
    }

    fn camera(&self, model: &Model) -> Result<Camera> {
        let (centre, radius) = drawing::reference_sphere(model)?;
        let super::view::Angles(azimuth, elevation) = self.view;
        Camera::framed(
            centre,
            radius,
            azimuth,
            elevation,
            Projection::Perspective,
            self.size,
            self.size,
        )
    }
}

/// A model, a camera and a device.
struct Studio<'a> {
    demo: &'a Demo,
    model: Model,
    camera: Camera,
    device: Device,
    bar: Bar,
}

impl Studio<'_> {
    fn shoot(
        &self,
        name: String,
        outcome: BuildOutcome,
        path: &Path,
    ) -> Result<(Findings, Vec<ImageReport>)> {
        let mut images = Vec::new();
        let reference = self.picture(0, Mode::Reference, None, &mut images)?;
        let original = Picture::decode(&reference.0.png, "reference")?;
        let count = levels(&outcome.built);
        let mut found = Vec::new();
        for lod in 1..=count {
            let mut shot = |mode| self.picture(lod, mode, Some(&original), &mut images);
            let (inverse, renderer) = shot(Mode::Igt)?;
            found.push(Level {
                inverse,
                plain: shot(Mode::Plain)?.0,
                wireframe: shot(Mode::Wireframe)?.0,
                fetches: shot(Mode::Fetches)?.0,
                frame: self.frames(&renderer)?,
            });
        }
        let findings = Findings {
            name,
            outcome,
            reference_frame: self.frames(&reference.1)?,
            reference: reference.0,
            showcase: SHOWCASE.min(count.saturating_sub(1)),
            levels: found,
            file_bytes: std::fs::metadata(path).map_or(0, |meta| meta.len()),
            device: self.device.name(),
        };
        Ok((findings, images))
    }

    /// Draws, writes and compares one picture.
    fn picture(
        &self,
        lod: usize,
        mode: Mode,
        original: Option<&Picture>,
        images: &mut Vec<ImageReport>,
    ) -> Result<(Shown, Renderer)> {
        let what = match mode {
            Mode::Reference => "reference",
            Mode::Igt => "inverse",
            Mode::Plain => "plain",
            Mode::Wireframe => "wireframe",
            Mode::Fetches => "fetches",
            Mode::Normals => "normals",
        };
        let of = 1 + LODS.len() * 4;
        self.bar.at(
            &format!("picture: LoD {lod}, {what}"),
            images.len() as u64,
            of as u64,
        );
        let wish = Wish {
            shown: None,
            level: lod,
            mode,
            shading: Shading::Lit,
            path: DrawPath::Deferred,
            shader_lod: false,
        };
        let rest = self.model.scene().rest();
        let (staged, _) = drawing::Staged::new(&self.model, wish, &rest, &self.device)?;
        let renderer = staged.renderer;
        let image = renderer.draw(&self.camera, &drawing::options(mode, Shading::Lit, 4))?;
        let shown = shown(
            &renderer,
            &image,
            original.filter(|_| matches!(mode, Mode::Igt | Mode::Plain)),
        )?;
        let file = if lod == 0 {
            format!("{what}.png")
        } else {
            format!("lod{lod}-{what}.png")
        };
        let path = self.demo.folder.join(file);
        write_bytes(&path, &shown.png)?;
        images.push(ImageReport {
            path: path.display().to_string(),
            what,
            lod,
            triangles: shown.triangles,
            flip_mean: shown.against_reference.as_ref().map(|c| c.flip_mean),
        });
        Ok((shown, renderer))
    }

    /// Times of whole frames, one sample a pixel; the first is not counted, drivers compile then.
    fn frames(&self, renderer: &Renderer) -> Result<Option<TimeStatistics>> {
        let options = drawing::options(Mode::Igt, Shading::Lit, 1);
        let mut times = Vec::new();
        for k in 0..=FRAMES {
            let image = renderer.draw(&self.camera, &options)?;
            if k > 0 {
                times.push(
                    image
                        .passes
                        .iter()
                        .map(|(_, nanoseconds)| nanoseconds)
                        .sum(),
                );
            }
        }
        Ok(TimeStatistics::of(&times))
    }
}

fn levels(built: &Built) -> usize {
    invertex::render::levels(built) - 1
}

fn shown(renderer: &Renderer, image: &Rendered, original: Option<&Picture>) -> Result<Shown> {
    let png = encode_png(image.width, image.height, &image.rgba8)?;
    let against_reference = match original {
        Some(original) => {
            let picture = Picture::decode(&png, "picture")?;
            Some(compare(
                original,
                &picture,
                Region::Foreground,
                ["reference", "picture"],
            )?)
        }
        None => None,
    };
    Ok(Shown {
        png,
        triangles: renderer.picture().triangle_count(),
        mean_fetches: image.mean_fetches,
        against_reference,
    })
}
