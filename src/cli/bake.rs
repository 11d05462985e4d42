//! `bake`: attributes of a reference as textures of a simpler surface.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::attribute::Computed;
use super::bake_around::Surroundings;
use super::bake_batch as batch;
use super::bake_files::{Files, Finished, Target, stems};
use super::bake_preview::preview;
use super::bake_report::Report;
use super::device::Device;
use super::progress::Bar;
use super::recovery::{Recovering, renderer, scene};
use super::view::Size;
use super::{Common, mesh_named, note, print};
use invertex::asset::{Built, Model};
use invertex::recover::{Baker, Pair};
use invertex::{Error, Result};

/// Resample attributes of a reference into textures of a simpler surface.
///
/// With two models, LOW's textures take for each texel a point of HIGH that `--map` chooses; the models need share nothing but
/// the space they stand in. With one, a file that `build` made, the mapping uv-match takes each texel's point of the LoD through
/// the inverse texture to the reference. Either way the surface comes with its textures, as baked.glb.
#[derive(Clone, clap::Args)]
#[command(after_help = "\
Mappings between two models: proximity (the closest point), normal (the first along the normal, outwards before inwards),
visibility-face, visibility-vertex, visibility-texel (along the mean direction that LOW is seen from), hybrid-vertex,
hybrid-texel (between the two by how much directions vary), cage (along the normal from outside, inwards), auto (the best of
them for each texel, by what probes see of HIGH). `invertex assess` rates them for a pair.

Attributes: normal (tangent space, +Y up), object-normal, position, height (over the surface along its normal; PNG reaches
as far as rays), mapping (triangle.id, whole numbers, and barycentric.x .y .z: --format exr), color (base colour, vertex colours
included), vertex-color (COLOR_0), and all that `render --attribute` knows: occlusion, metallic-roughness, emissive, triangle-color,
material, part, _NAME, wood, ... and products of them. From what lies round a point of HIGH: bent-normal (the mean direction of open
sky, tangent space), object-bent-normal, curvature (mean, 1 / unit; PNG: half is flat, lighter bulges), thickness (the mean way
through the body; PNG: white where it is as far as --ray-reach), shadow (1 where --light reaches), shading (the cosine to it).

Texture coordinates in several unit squares are tiles (UDIM): MESH_ATTRIBUTE.1001.png, .1002.png, ...; of a triangle that reaches
out of its own the model is refused.

Many pairs: HIGH as a folder bakes every NAME_low.glb in it with NAME_high.glb (also _lp, _hp, .gltf; NAME_cage.glb is its cage) to
OUT/NAME; HIGH as a manifest, {\"jobs\": [{\"high\", \"low\", \"output\"?, \"cage\"?, \"map\"?, \"attributes\"?: [..], \"size\"?,
\"by_name\"?}]} with files relative to it, bakes each job to OUT/output, options given here holding where it says nothing. A job that
fails is told and the others are done; the exit code is then the first one's.

Files in OUT: MESH_ATTRIBUTE.png, MESH_mask.png (white: a point of the reference; light grey: the closest one, for a ray that
missed; grey: a neighbour's value; black: the mean), baked.glb.

JSON: mapping, low, over, size, samples, padding, filled_fraction (texels with a point of the reference, of all texels),
missed_fraction (texels on the surface whose point was not found, of those on it), meshes[]: name, triangles,
tile?, filled_fraction, missed_fraction; textures[]: mesh, attribute, path, sha256; files[]; ms{}; warnings[]. Of many pairs: jobs[]: name and
all that, or error.

Examples:
  invertex bake statue.glb statue_low.glb -o textures/ --map hybrid-vertex --attributes normal,color --size 2048 --preview
  invertex bake scan.glb low.glb -o textures/ --map proximity --attributes normal,occlusion --misses fill
  invertex bake built.glb -o textures/ --lod 2 --attributes color,normal,metallic-roughness --size 2048
  invertex bake built.glb -o textures/ --attributes occlusion,_HEAT:0..100 --format exr
  invertex bake built.glb -o wood/ --lod 3 --attributes 'wood*occlusion' --samples 4
  invertex bake scan.glb low.glb -o textures/ --attributes bent-normal,curvature,thickness --bits 16
  invertex bake car_high.glb car_low.glb -o textures/ --attributes normal --by-name --cage car_cage.glb
  invertex bake models/ -o textures/ --attributes normal,occlusion --size 2048
  invertex bake built.glb -o square/ --over primary --attributes color,object-normal,position")]
pub(super) struct Bake {
    /// The model whose detail is wanted; alone, a file that `build` made; or many pairs: a folder or a manifest (.json).
    pub(super) high: PathBuf,
    /// The model to bake for.
    pub(super) low: Option<PathBuf>,
    /// The folder for all files.
    #[arg(short, long, value_name = "OUT")]
    pub(super) output: PathBuf,
    /// Which point of the reference a texel stands for. Default: normal for two models, uv-match for a built file.
    #[arg(long, value_name = "MAPPING")]
    pub(super) map: Option<String>,
    /// What textures of a built file are laid out over: a LoD, or the primary parameterization's square of addresses, for all
    /// LoDs. Default: lod.
    #[arg(long, value_enum)]
    pub(super) over: Option<Layout>,
    /// The level of detail of a built file; 0 is the reference's own geometry. Default: 1.
    #[arg(long, value_name = "N")]
    pub(super) lod: Option<usize>,
    /// What is baked, one texture for each.
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', required = true)]
    pub(super) attributes: Vec<String>,
    /// Texels along each side.
    #[arg(long, value_name = "N", default_value = "1024")]
    pub(super) size: Size,
    /// Samples along each side of a texel. Default: 2 for a built file, 1 for two models.
    #[arg(long, value_name = "N")]
    pub(super) samples: Option<u32>,
    /// Texels that borders grow by.
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub(super) padding: u32,
    /// MiB of texels that are made at once, at 16 bytes each; at least one texture is. Less is slower, the files are the same.
    #[arg(long, value_name = "MIB", default_value_t = 1024)]
    pub(super) memory: u64,
    /// PNG, or also linear floats.
    #[arg(long, value_enum, default_value_t = Format::Png)]
    pub(super) format: Format,
    /// Bits of a channel of PNG; textures within baked.glb have 8.
    #[arg(long, value_parser = clap::builder::PossibleValuesParser::new(["8", "16"]), default_value = "8")]
    pub(super) bits: String,
    /// Bake this mesh alone.
    #[arg(long, value_name = "NAME")]
    pub(super) mesh: Option<String>,
    /// What texels get whose ray met nothing. Default: proximity.
    #[arg(long, value_enum, help_heading = "Two models")]
    pub(super) misses: Option<Missed>,
    /// Also write preview.png: HIGH, LOW, LOW with its textures, and how that differs from HIGH.
    #[arg(long, help_heading = "Two models")]
    pub(super) preview: bool,
    /// Take a mesh's detail from meshes of the same name only; of wheel_low also from wheel_high, wheel_high_bolts, wheel_hp.001
    /// and wheel.
    #[arg(long, help_heading = "Two models")]
    pub(super) by_name: bool,
    /// For --map cage (which it implies) and auto: LOW with its vertices moved outwards, triangles in LOW's order. Rays run from
    /// it to LOW and on, as far as --reach. Without it the cage lies --reach outside of LOW.
    #[arg(long, value_name = "FILE", help_heading = "Two models")]
    pub(super) cage: Option<PathBuf>,
    #[command(flatten)]
    pub(super) recovering: Recovering,
    #[command(flatten)]
    pub(super) computed: Computed,
    #[command(flatten)]
    pub(super) surroundings: Surroundings,
}

/// What stands in for a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Missed {
    /// Nothing: the texel is transparent.
    Blank,
    /// The closest point.
    Proximity,
    /// What neighbours have.
    Fill,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Layout {
    /// A LoD, cut along an atlas of its own (over a uv primary: the artist's).
    Lod,
    /// The primary parameterization.
    Primary,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Format {
    /// Colours as sRGB, data as it is, directions from -1..1.
    Png,
    /// Those, and linear floats of 32 bits beside them.
    Exr,
    /// Those, and linear floats of 16 bits beside them.
    Exr16,
}

/// When work began, and was prepared.
struct Stages {
    start: Instant,
    prepared: Duration,
}

impl Bake {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        match batch::jobs(self)? {
            Some(jobs) => batch::run(self, &jobs, common),
            None => self.bake(common)?.print(common),
        }
    }

    /// Bakes one pair, or one built file.
    pub(super) fn bake(&self, common: &Common) -> Result<Report> {
        match &self.low {
            None => self.bake_built(common),
            Some(low) => self.bake_pair(common, low),
        }
    }

    fn bake_built(&self, common: &Common) -> Result<Report> {
        let settings = self.settings()?;
        let Model::Built(built) = Model::load(&self.high)? else {
            let reason = "this model has no inverse textures; run `invertex build` first, or name a second model to bake for";
            let file = self.high.display().to_string();
            return Err(Error::input(file, "extensions", reason));
        };
        let chosen = self.chosen(&built)?;
        let heard = Bar::new(common, 1);
        let start = Instant::now();
        let mut baker = Baker::new(&built, &settings, &heard)?;
        let prepared = start.elapsed();
        let name = |k: usize| built.scene.meshes[built.meshes[k].mesh].name.as_str();
        let stems = stems((0..built.meshes.len()).map(|k| (built.meshes[k].mesh, name(k))));
        let instances = built.scene.instances();
        let mut report = Report::new(self.high.display().to_string(), &settings);
        report.warnings = baker.warnings.clone();
        let (files, mut all) = (self.files(), Vec::new());
        for &k in &chosen {
            let own = instances.iter().filter(|i| i.mesh == built.meshes[k].mesh);
            let target = Target {
                name: name(k).to_owned(),
                stem: stems[k].clone(),
                tile: None,
                places: own.map(|i| i.world.as_mat4().to_cols_array_2d()).collect(),
            };
            all.push(files.bake(target, &mut report, |taker| {
                baker.mesh_each(k, &heard, taker)
            })?);
        }
        let stages = Stages { start, prepared };
        drop(heard);
        self.finish(common, &all, report, &stages, &|_| Ok(None))
    }

    fn bake_pair(&self, common: &Common, low: &std::path::Path) -> Result<Report> {
        let settings = self.pair_settings()?;
        let (high_scene, low_scene) = (scene(&self.high)?, scene(low)?);
        let cage = self.cage.as_deref().map(scene).transpose()?;
        let device = Device::open(common)?;
        let heard = Bar::new(common, 1);
        let start = Instant::now();
        let draw = |picture| renderer(&device, picture);
        let models = (&high_scene, &low_scene, cage.as_ref());
        let mut pair = Pair::in_cage(models, &settings, &draw, &heard)?;
        let prepared = start.elapsed();
        let name = |k: usize| (pair.number(k), pair.name(k));
        let stems = stems((0..pair.count()).map(name));
        let chosen = self.surfaces(&low_scene.name, &pair)?;
        let models = [&self.high, &low.to_path_buf()].map(|f| f.display().to_string());
        let mut report = Report::of_pair(models, &device.name(), &settings);
        report.warnings = pair.warnings.clone();
        let (files, mut all) = (self.files(), Vec::new());
        for k in chosen {
            let target = Target {
                name: pair.name(k).to_owned(),
                stem: stems[k].clone(),
                tile: pair.tile(k),
                places: vec![pair.place(k)],
            };
            all.push(files.bake(target, &mut report, |taker| {
                pair.bake_each(k, &heard, taker)
            })?);
        }
        let stages = Stages { start, prepared };
        drop(heard);
        let picture = |baked: &[u8]| match self.preview {
            true => preview(&device, &high_scene, &low_scene, baked).map(Some),
            false => Ok(None),
        };
        let report = self.finish(common, &all, report, &stages, &picture)?;
        device.check();
        Ok(report)
    }

    /// Where files go.
    fn files(&self) -> Files {
        let Size(size, _) = self.size;
        Files {
            folder: self.output.clone(),
            size,
            bits: if self.bits == "16" { 16 } else { 8 },
            floats: match self.format {
                Format::Png => None,
                Format::Exr => Some(32),
                Format::Exr16 => Some(16),
            },
        }
    }

    /// Writes what belongs to all textures and says what there is. `picture` makes a preview of the surfaces' file.
    fn finish(
        &self,
        common: &Common,
        all: &[Finished],
        mut report: Report,
        stages: &Stages,
        picture: &dyn Fn(&[u8]) -> Result<Option<Vec<u8>>>,
    ) -> Result<Report> {
        let resampled = stages.start.elapsed() - stages.prepared - report.writing;
        if self.over != Some(Layout::Primary) {
            let glb = self.files().write_glb(all, &mut report)?;
            if let Some(png) = picture(&glb)? {
                report.file(&self.output.join("preview.png"), &png)?;
            }
        }
        report.warn_of_misses();
        let ms = |d: Duration| d.as_secs_f64() * 1e3;
        report.ms = vec![
            ("prepare", ms(stages.prepared)),
            ("resample", ms(resampled)),
            ("write", ms(report.writing)),
        ];
        report
            .warnings
            .iter()
            .for_each(|warning| note(common, warning));
        Ok(report)
    }

    /// The surfaces of LOW that are baked.
    fn surfaces(&self, file: &str, pair: &Pair) -> Result<Vec<usize>> {
        let all = 0..pair.count();
        let Some(name) = &self.mesh else {
            return Ok(all.collect());
        };
        mesh_named(file, all.clone().map(|k| pair.name(k)), name)?;
        Ok(all.filter(|&k| pair.name(k) == name).collect())
    }

    /// The built meshes that are baked.
    fn chosen(&self, built: &Built) -> Result<Vec<usize>> {
        let Some(name) = &self.mesh else {
            return Ok((0..built.meshes.len()).collect());
        };
        let names = built
            .meshes
            .iter()
            .map(|m| built.scene.meshes[m.mesh].name.as_str());
        Ok(vec![mesh_named(&built.scene.name, names, name)?])
    }
}

impl Report {
    fn print(&self, common: &Common) -> Result<()> {
        if common.json {
            print::json(self)
        } else {
            print::text(&self.text())
        }
    }
}
