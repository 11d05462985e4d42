//! `profile`: where fetches and time go.

use std::path::PathBuf;

use invertex::asset::{Built, Model};
use invertex::measure::{
    Bench, CutRanges, Drawing, MemoryRow, ProfileSettings, Ranges, Sitter, Sweep, WHOLE,
    at_equal_flip, chrome_trace, memory, plan,
};
use invertex::output::{check_target, make_folder, write_bytes};
use invertex::render::{FrameBudget, level_near};
use invertex::{Error, Result};
use serde::Serialize;

use super::device::Device;
use super::drawing::{DrawPath, Shading};
use super::lod_choice::LodChoice;
use super::print;
use super::profile_found::{Report, SweepChoice};
use super::progress::Bar;
use super::view::{Angles, Size};
use super::{Common, bad_option, mesh_named, profile_cuts, profile_report, profile_table};

/// Share of the reference's triangles that the level of detail is near where --lod does not say.
const SHARE: f64 = 0.1;
/// Frames timed where --frames does not say, and the most seconds that they may take for one row.
const FRAMES: u32 = 200;
const SECONDS: f64 = 1.0;

/// Say where fetches and time go: how many loads each pixel takes, and how long each pass.
///
/// Draws each mesh, and a model of several meshes as a whole (named *), as: reference (the reference itself), lod+igt (a
/// LoD with its inverse texture), lod+baked (the same LoD with colour and normals baked into an atlas of its own) and
/// lod+plain (the same LoD with the artist's uv at its corners). Counting and timing are never one run. A fetch is one
/// load of at most 128 bits.
#[derive(clap::Args)]
#[command(after_help = "\
JSON: device, clock, path, shading, size[], frames, warm_up, runs[]: file, mesh, variant, sweep, filter, lod, distance, layout, hash,
triangles, mean_list, mean_fetches, mean_fetches_with_uv, p99_fetches, max_fetches, mean_texture_fetches, tables_bytes,
texture_bytes, covered_pixels, unmapped_pixels, frame_ns_median, frame_ns_p95, frame_ns_p99, lookup_ns_median,
lookup_ns_p95, frames, clock, passes[]: name,
median_ns, p95_ns, p99_ns; histogram[] (pixels by number of fetches), tests_histogram[] (by triangles tested), mean_tests; memory[]: file, mesh, triangles, primary, layout, hash,
mean_list, bytes{hash, list, triangle, attribute, total}, bytes_per_triangle; cuts[] (--sweep cuts): file, mesh, criterion (surface,
pixels, pixels+colour), pixels, colour, distance, triangles, reference_triangles, asked (collapses and blocks of them),
selection_ns_median, selection_ns_p95 (one core), device_selection_ns_median (its time stamps), bound_pixels (no detail that
faces the eye is displaced by more), displaced {pixels, mean, p99, max} (as measured), compared_pixels, flip_mean, flip_max
(against the reference, both unlit); equal_flip[]: file, mesh, distance, pixels, flip, triangles, and those that give the same
FLIP by other criteria: surface, colours[] {colour, triangles}, null where no limit gives it; outputs[]; warnings[].

Examples:
  invertex profile built.glb
  invertex profile built.glb -o report/ --sweep hash,layout        HTML with plots, heat maps as PNG
  invertex profile built.glb --sweep distance --path forward       frame time by distance, all levels of detail
  invertex profile mrm.glb -o report/ --sweep cuts --distances 1,4      triangles over FLIP by what decides them
  invertex profile mrm.glb --sweep cuts --pixels .5,1,2 --colours 1,5   (mrm.glb: of `build --mrm`)
  invertex profile built.glb --mesh Hose_low --lod 2 --trace hose.json --frames 500
  invertex profile built.glb --device cpu --size 256 --json
  invertex profile *.glb --table1                                  memory by table, nothing is drawn")]
pub(super) struct Profile {
    /// Files that `build` made.
    #[arg(required = true)]
    built: Vec<PathBuf>,
    /// Only this mesh; * for a model of several meshes as a whole.
    #[arg(long, value_name = "NAME")]
    mesh: Option<String>,
    /// The level of detail: N, triangles:N or pixels:X as in render. Default: the one nearest to a tenth of the triangles.
    #[arg(long, value_name = "LEVEL", allow_hyphen_values = true)]
    lod: Option<LodChoice>,
    /// Size of the picture.
    #[arg(long, value_name = "WxH", default_value = "1024x768")]
    size: Size,
    /// Direction to look from, in degrees: azimuth, elevation.
    #[arg(
        long,
        value_name = "AZIMUTH,ELEVATION",
        default_value = "30,20",
        allow_hyphen_values = true
    )]
    view: Angles,
    /// Frames timed for each row. Default: 200, or as many as a second allows (software devices, the processor) and never
    /// fewer than 3; each row says how many.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    frames: Option<u32>,
    /// Frames drawn before them.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    warm_up: u32,
    /// How frames are timed; fetches are counted on the deferred path either way.
    #[arg(long, value_enum, default_value_t = DrawPath::Deferred)]
    path: DrawPath,
    /// How light falls.
    #[arg(long, value_enum, default_value_t = Shading::Lit)]
    shading: Shading,
    /// Side of the textures that lod+baked carries.
    #[arg(long, value_name = "N", default_value_t = 1024)]
    bake_size: u32,
    /// More rows: hash (the tables at other resolutions), layout (packed beside classic), lod (every level), distance (every
    /// level by distance), filter (one point a pixel, five, the footprint), cuts (of a multiresolution model: triangles,
    /// selection, bounds and FLIP for every limit, by what decides).
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WHAT")]
    sweep: Vec<SweepChoice>,
    /// Resolutions of --sweep hash.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "N,..",
        default_value = "128,256,512,1024"
    )]
    hashes: Vec<u32>,
    /// Distances of --sweep distance and cuts; at 1 the model fills the view.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "X,..",
        default_value = "1,2,4,8,16"
    )]
    distances: Vec<f64>,
    /// Limits in pixels of --sweep cuts. Default: 0.0625 to 8 by factors of two.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "X,..",
        allow_hyphen_values = true
    )]
    pixels: Option<Vec<f64>>,
    /// Limits in colour of --sweep cuts, each beside all limits in pixels. Default: 2,5 where the model knows what colours are
    /// off by.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "Y,..",
        allow_hyphen_values = true
    )]
    colours: Option<Vec<f64>>,
    /// Only the memory of the tables; nothing is drawn.
    #[arg(long, conflicts_with_all = ["sweep", "trace", "output", "lod"])]
    table1: bool,
    /// Write every timed pass as a Chrome trace, which ui.perfetto.dev opens.
    #[arg(long, value_name = "FILE.json")]
    trace: Option<PathBuf>,
    /// Write an HTML page and heat maps into this folder; made if it is missing.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

impl Profile {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        self.check()?;
        let models = self.load()?;
        let memory = models
            .iter()
            .flat_map(|(file, built)| memory(file, built))
            .collect();
        if self.table1 {
            return self.only_memory(common, memory);
        }
        let device = Device::open(common)?;
        let settings = self.settings();
        let bench = Bench {
            processor: device.processor(),
            settings: &settings,
        };
        let mut report = self.report(&device, &bench, memory);
        self.measure(common, &bench, models, &mut report)?;
        device.check();
        report.remark(common);
        self.write(&mut report)?;
        if common.json {
            return print::json(&report);
        }
        print::text(&profile_table::runs(report.runs.iter()).text())?;
        print::text(&profile_cuts::text(&report))
    }

    /// Everything that can be said before a model is read.
    fn check(&self) -> Result<()> {
        for hash in &self.hashes {
            if !hash.is_power_of_two() || !(4..=8192).contains(hash) {
                let reason = format!("{hash} is not a power of two from 4 to 8192");
                return Err(bad_option("--hashes", reason));
            }
        }
        for (option, limits) in [("--pixels", &self.pixels), ("--colours", &self.colours)] {
            profile_cuts::check(option, limits.as_deref().unwrap_or_default())?;
        }
        if let Some(bad) = self.distances.iter().find(|d| !(0.01..=1e4).contains(*d)) {
            return Err(bad_option(
                "--distances",
                format!("{bad} is outside 0.01 to 10000"),
            ));
        }
        if !(16..=8192).contains(&self.bake_size) {
            let reason = format!("{} is outside 16 to 8192", self.bake_size);
            return Err(bad_option("--bake-size", reason));
        }
        let Size(width, height) = self.size;
        let most = invertex::render::MAX_SIDE;
        if width.max(height) > most {
            let reason = format!("{width}x{height} is outside 1x1 to {most}x{most}");
            return Err(bad_option("--size", reason));
        }
        if let Some(trace) = &self.trace {
            check_target(trace)?;
        }
        self.output.as_deref().map_or(Ok(()), make_folder)
    }

    fn load(&self) -> Result<Vec<(String, Built)>> {
        let built = |path: &PathBuf| match Model::load(path)? {
            Model::Built(built) => {
                let file = path.display().to_string();
                if self.sweep.contains(&SweepChoice::Cuts) {
                    profile_cuts::check_model(&file, &built, self.colours.is_some())?;
                }
                Ok((file, *built))
            }
            Model::Plain(_) => {
                let reason = "this model has no inverse textures; run `invertex build` first";
                Err(Error::input(
                    path.display().to_string(),
                    "extensions",
                    reason,
                ))
            }
        };
        self.built.iter().map(built).collect()
    }

    fn settings(&self) -> ProfileSettings {
        ProfileSettings {
            size: [self.size.0, self.size.1],
            view: [self.view.0, self.view.1],
            budget: FrameBudget {
                warm_up: self.warm_up,
                frames: self.frames.unwrap_or(FRAMES),
                seconds: self.frames.is_none().then_some(SECONDS),
            },
            forward: self.path == DrawPath::Forward,
            lit: self.shading == Shading::Lit,
            bake_size: self.bake_size,
        }
    }

    fn report(&self, device: &Device, bench: &Bench, memory: Vec<MemoryRow>) -> Report {
        Report {
            device: device.name(),
            clock: None,
            path: match self.path {
                DrawPath::Deferred => "deferred",
                DrawPath::Forward => "forward",
            },
            shading: match self.shading {
                Shading::Lit => "lit",
                Shading::Unlit => "unlit",
            },
            size: [self.size.0, self.size.1],
            frames: bench.settings.budget.frames,
            warm_up: self.warm_up,
            runs: Vec::new(),
            memory,
            cuts: Vec::new(),
            equal_flip: Vec::new(),
            outputs: Vec::new(),
            warnings: Vec::new(),
        }
    }

    fn measure(
        &self,
        common: &Common,
        bench: &Bench,
        models: Vec<(String, Built)>,
        report: &mut Report,
    ) -> Result<()> {
        let bar = Bar::new(common, 0);
        for (file, built) in models {
            for (mesh, built) in self.sitters(&file, built)? {
                bar.at(&format!("{mesh}: textures"), 0, 1);
                let sitter = Sitter::new(&file, &mesh, built, bench.settings.lit)?;
                let drawings = self.drawings(bench, &sitter)?;
                for (done, drawing) in drawings.iter().enumerate() {
                    let what = format!("{mesh}: {}", drawing.variant.name());
                    bar.at(&what, done as u64, drawings.len() as u64);
                    report.runs.extend(bench.runs(&sitter, drawing)?);
                }
                if let Some(ranges) = self.cut_ranges() {
                    let at = |done: usize, of: usize| {
                        bar.at(&format!("{mesh}: cuts"), done as u64, of as u64);
                    };
                    report.cuts.extend(bench.cuts(&sitter, &ranges, &at)?);
                }
                report.warnings.extend(sitter.warnings);
            }
        }
        report.clock = report.runs.first().map(|run| run.clock);
        report.equal_flip = at_equal_flip(&report.cuts);
        Ok(())
    }

    /// What cuts are made within, where they are asked for.
    fn cut_ranges(&self) -> Option<CutRanges> {
        let usual = CutRanges::default();
        self.sweep.contains(&SweepChoice::Cuts).then(|| CutRanges {
            pixels: self.pixels.clone().unwrap_or(usual.pixels),
            colours: self.colours.clone().unwrap_or(usual.colours),
            distances: self.distances.clone(),
        })
    }

    /// What is drawn of a file: each mesh alone, then, of several, the whole.
    fn sitters(&self, file: &str, built: Built) -> Result<Vec<(String, Built)>> {
        let standing: Vec<usize> = built.scene.instances().iter().map(|i| i.mesh).collect();
        let meshes: Vec<usize> = built
            .meshes
            .iter()
            .map(|mesh| mesh.mesh)
            .filter(|mesh| standing.contains(mesh))
            .collect();
        let name = |mesh: usize| built.scene.meshes[mesh].name.clone();
        let alone = |mesh: usize| Ok((name(mesh), built.only(mesh)?));
        match self.mesh.as_deref() {
            Some(WHOLE) => Ok(vec![(WHOLE.to_owned(), built)]),
            Some(wanted) => {
                let names: Vec<String> = built.meshes.iter().map(|m| name(m.mesh)).collect();
                let at = mesh_named(file, names.iter().map(String::as_str), wanted)?;
                Ok(vec![alone(built.meshes[at].mesh)?])
            }
            None if meshes.len() == 1 => Ok(vec![alone(meshes[0])?]),
            None => {
                let each = meshes.iter().map(|&mesh| alone(mesh));
                let mut all = each.collect::<Result<Vec<_>>>()?;
                all.push((WHOLE.to_owned(), built));
                Ok(all)
            }
        }
    }

    fn drawings(&self, bench: &Bench, sitter: &Sitter) -> Result<Vec<Drawing>> {
        let level = match self.lod {
            Some(choice) => {
                let camera = sitter.camera(bench.settings, 1.0)?;
                choice.level(&sitter.built, &camera, sitter.sphere())?
            }
            None => level_near(&sitter.built, SHARE),
        };
        let sweeps = self.sweep.iter().filter_map(|choice| choice.sweep());
        let sweeps: Vec<Sweep> = sweeps.collect();
        let ranges = Ranges {
            hashes: self.hashes.clone(),
            distances: self.distances.clone(),
        };
        Ok(plan(&sitter.built, level, &sweeps, &ranges))
    }

    fn write(&self, report: &mut Report) -> Result<()> {
        if let Some(path) = &self.trace {
            let trace = chrome_trace(&report.runs).to_string();
            write_bytes(path, trace.as_bytes())?;
            report.outputs.push(path.display().to_string());
        }
        if let Some(folder) = &self.output {
            let written = profile_report::write(folder, report)?;
            report.outputs.extend(written);
        }
        Ok(())
    }

    fn only_memory(&self, common: &Common, memory: Vec<MemoryRow>) -> Result<()> {
        #[derive(Serialize)]
        struct Memory {
            runs: [(); 0],
            memory: Vec<MemoryRow>,
        }
        if common.json {
            return print::json(&Memory { runs: [], memory });
        }
        print::text(&profile_table::memory(&memory).text())
    }
}
