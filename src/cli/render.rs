//! `render`: images of a model or of one of its LoDs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use invertex::asset::Model;
use invertex::output::{check_target, make_folder, write_bytes};
use invertex::render::{Camera, Projection, Renderer, View, parse_views};
use invertex::scene::read_file;
use invertex::{Error, Result};
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::device::Device;
use super::drawing::{self, Background, DrawPath, Format, Mode, Shading, Wish};
use super::lod_choice::LodChoice;
use super::print::{self, Table, thousands};
use super::progress::Bar;
use super::{Common, bad_option, note};

/// Draw a model, or a LoD of it that looks like the original.
///
/// Any glTF file can be drawn as its own reference; LoDs need a file that `build` made. PNG is 8-bit sRGB with alpha =
/// coverage; EXR is linear float.
#[derive(clap::Args)]
#[command(after_help = "\
A camera file: {\"width\": W, \"height\": H, \"views\": [{\"name\": \"front.png\", \"view\": [[4x4, row-major, world to
camera, which looks down -Z, +Y up]], \"projection_vulkan\": [[4x4, clip z 0..1, y down]]}, ..]}

JSON: device, images[]: path, width, height, lod, triangles, covered_pixels, mean_fetches, sha256 (of the file),
passes[] (nanoseconds of each); warnings[].

EXR layers with --aov: triangle.id (of the reference, in its own mesh; -1 outside), barycentric.x .y .z, fetches.count,
depth.Z.

Examples:
  invertex render model.glb -o reference.png
  invertex render built.glb -o lod2.png --mode igt --lod 2
  invertex render built.glb -o plain.png --mode plain --lod triangles:500 --shading unlit
  invertex render built.glb -o views/ --camera cameras.json --mode igt --lod pixels:0.5
  invertex render built.glb -o lod1.exr --aov --mode igt --lod 1 --view 30,15 --ortho
  invertex render built.glb -o edges.png --mode wireframe --lod 3 --background '#202020' --size 1600x1200")]
pub(super) struct Render {
    /// The model: .glb or .gltf.
    file: PathBuf,
    /// The image to write (.png or .exr), or with --camera the folder for all views.
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
    /// (the coarsest that deviates less than X pixels). Default: 1 where LoDs are drawn.
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
    /// Samples a pixel.
    #[arg(long, value_name = "1|4", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4))]
    samples: u32,
    /// Also write what lies under each pixel, as layers of an EXR.
    #[arg(long)]
    aov: bool,
    /// Draw this mesh alone.
    #[arg(long, value_name = "NAME")]
    mesh: Option<String>,
}

#[derive(Clone, Copy)]
struct Size(u32, u32);

impl std::str::FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let side = |side: &str| side.parse::<u32>().ok().filter(|&n| n > 0);
        let (width, height) = text.split_once(['x', 'X']).unwrap_or((text, text));
        match (side(width), side(height)) {
            (Some(width), Some(height)) => Ok(Size(width, height)),
            _ => Err(format!("\"{text}\" is not a size such as 640x480 or 512")),
        }
    }
}

#[derive(Clone, Copy)]
pub(super) struct Angles(pub(super) f64, pub(super) f64);

impl std::str::FromStr for Angles {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let angle = |text: &str| text.trim().parse::<f64>().ok().filter(|a| a.is_finite());
        let both = text
            .split_once(',')
            .and_then(|(a, e)| Some(Angles(angle(a)?, angle(e)?)));
        both.ok_or_else(|| format!("\"{text}\" is not two angles such as 30,20"))
    }
}

#[derive(Serialize)]
struct Report {
    file: String,
    device: String,
    images: Vec<ImageReport>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct ImageReport {
    path: String,
    width: u32,
    height: u32,
    lod: usize,
    triangles: u32,
    covered_pixels: u64,
    mean_fetches: f64,
    sha256: String,
    passes: Vec<Pass>,
}

#[derive(Serialize)]
struct Pass {
    name: String,
    nanoseconds: u64,
}

impl Render {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
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
        let device = Device::open(common)?;
        let mut stages = Stages {
            render: self,
            model: &model,
            device: &device,
            ready: BTreeMap::new(),
            warnings: vec![],
        };
        let sphere = drawing::reference_sphere(&model)?;
        let views = match views {
            Some(views) => views,
            None => vec![View {
                name: String::new(),
                camera: self.framed(sphere)?,
            }],
        };
        let bar = Bar::new(common, views.len() as u64);
        let mut images = Vec::new();
        for (k, view) in views.iter().enumerate() {
            bar.at(&view.name, k as u64, views.len() as u64);
            images.push(self.draw(&mut stages, view, sphere)?);
        }
        drop(bar);
        device.check();
        let warnings = stages.warnings;
        warnings.iter().for_each(|warning| note(common, warning));
        let report = Report {
            file: self.file.display().to_string(),
            device: device.name(),
            images,
            warnings,
        };
        if common.json {
            print::json(&report)
        } else {
            print::text(&table(&report).text())
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
        if self.samples != 1 && self.samples != 4 {
            return Err(bad_option(
                "--samples",
                format!("{} is not 1 or 4", self.samples),
            ));
        }
        let Some(camera) = &self.camera else {
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
            return Ok(None);
        };
        let size = self.size.map(|Size(width, height)| (width, height));
        let mut views = parse_views(&camera.display().to_string(), &read_file(camera)?, size)?;
        for view in &mut views {
            if Format::of(Path::new(&view.name)).is_none() {
                view.name += if self.aov { ".exr" } else { ".png" };
            }
        }
        make_folder(&self.output)?;
        Ok(Some(views))
    }

    fn framed(&self, (centre, radius): ([f64; 3], f64)) -> Result<Camera> {
        let Size(width, height) = self.size.unwrap_or(Size(1024, 1024));
        let projection = if self.ortho {
            Projection::Orthographic
        } else {
            Projection::Perspective
        };
        Camera::framed(
            centre,
            radius,
            self.view.0,
            self.view.1,
            projection,
            width,
            height,
        )
    }

    fn draw(
        &self,
        stages: &mut Stages,
        view: &View,
        sphere: ([f64; 3], f64),
    ) -> Result<ImageReport> {
        let lod = self.level(stages.model, &view.camera, sphere)?;
        let options = drawing::options(self.mode, self.shading, self.samples);
        let renderer = stages.at(lod)?;
        let mut image = renderer.draw(&view.camera, &options)?;
        let triangles = renderer.picture().triangle_count();
        if let Some(background) = self.background {
            background.under(&mut image);
        }
        let path = if self.camera.is_some() {
            self.output.join(&view.name)
        } else {
            self.output.clone()
        };
        let format = Format::of(&path).unwrap_or(Format::Png);
        let bytes = drawing::encode(&image, format, self.aov)?;
        write_bytes(&path, &bytes)?;
        let pass = |(name, nanoseconds)| Pass { name, nanoseconds };
        Ok(ImageReport {
            path: path.display().to_string(),
            width: image.width,
            height: image.height,
            lod,
            triangles,
            covered_pixels: image.covered_pixels,
            mean_fetches: image.mean_fetches,
            sha256: Sha256::digest(&bytes)
                .iter()
                .map(|byte| format!("{byte:02x}"))
                .collect(),
            passes: image.passes.into_iter().map(pass).collect(),
        })
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

/// The model made ready at each level that is asked for.
struct Stages<'a> {
    render: &'a Render,
    model: &'a Model,
    device: &'a Device,
    ready: BTreeMap<usize, Renderer>,
    warnings: Vec<String>,
}

impl Stages<'_> {
    fn at(&mut self, level: usize) -> Result<&Renderer> {
        if !self.ready.contains_key(&level) {
            let Render {
                mode,
                shading,
                path,
                ..
            } = *self.render;
            let (renderer, warnings) = drawing::renderer(
                self.model,
                Wish {
                    level,
                    mode,
                    shading,
                    path,
                },
                self.device,
            )?;
            if self.ready.is_empty() {
                self.warnings = warnings;
            }
            self.ready.insert(level, renderer);
        }
        Ok(&self.ready[&level])
    }
}

fn table(report: &Report) -> Table {
    let mut table = Table::new(&[
        "image",
        "size",
        "LoD",
        "triangles",
        "covered pixels",
        "fetches",
        "sha256",
    ]);
    for image in &report.images {
        table.row([
            image.path.clone(),
            format!("{}x{}", image.width, image.height),
            image.lod.to_string(),
            thousands(image.triangles.into()),
            thousands(image.covered_pixels),
            format!("{:.2}", image.mean_fetches),
            image.sha256[..16].to_owned(),
        ]);
    }
    table
}
