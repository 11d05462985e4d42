//! `profile`: where fetches and time go.

use std::path::PathBuf;

use invertex::asset::{Built, Model};
use invertex::measure::{
    Bench, Drawing, MemoryRow, ProfileSettings, Ranges, Run, Sitter, Sweep, WHOLE, chrome_trace,
    memory, plan,
};
use invertex::output::{check_target, make_folder, write_bytes};
use invertex::render::{Clock, FrameBudget, level_near};
use invertex::{Error, Result};
use serde::Serialize;

use super::device::Device;
use super::drawing::{DrawPath, Shading};
use super::lod_choice::LodChoice;
use super::print;
use super::progress::Bar;
use super::view::{Angles, Size};
use super::{Common, bad_option, mesh_named, note, profile_report, profile_table};

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
mean_list, bytes{hash, list, triangle, attribute, total}, bytes_per_triangle; outputs[]; warnings[].

Examples:
  invertex profile built.glb
  invertex profile built.glb -o report/ --sweep hash,layout        HTML with plots, heat maps as PNG
  invertex profile built.glb --sweep distance --path forward       frame time by distance, all levels of detail
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
    /// level by distance), filter (one point a pixel, five, the footprint).
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
    /// Distances of --sweep distance; at 1 the model fills the view.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "X,..",
        default_value = "1,2,4,8,16"
    )]
    distances: Vec<f64>,
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

/// A [`Sweep`], as a flag's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum SweepChoice {
    Hash,
    Layout,
    Lod,
    Distance,
    Filter,
}

impl From<SweepChoice> for Sweep {
    fn from(choice: SweepChoice) -> Self {
        match choice {
            SweepChoice::Hash => Sweep::Hash,
            SweepChoice::Layout => Sweep::Layout,
            SweepChoice::Lod => Sweep::Lod,
            SweepChoice::Distance => Sweep::Distance,
            SweepChoice::Filter => Sweep::Filter,
        }
    }
}

/// Everything a profile found.
#[derive(Serialize)]
pub(super) struct Report {
    pub(super) device: String,
    pub(super) clock: Option<Clock>,
    pub(super) path: &'static str,
    pub(super) shading: &'static str,
    pub(super) size: [u32; 2],
    pub(super) frames: u32,
    pub(super) warm_up: u32,
    pub(super) runs: Vec<Run>,
    pub(super) memory: Vec<MemoryRow>,
    pub(super) outputs: Vec<String>,
    pub(super) warnings: Vec<String>,
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
        self.remark(common, &report);
        self.write(&mut report)?;
        if common.json {
            return print::json(&report);
        }
        print::text(&profile_table::runs(report.runs.iter()).text())
    }

    /// Everything that can be said before a model is read.
    fn check(&self) -> Result<()> {
        for hash in &self.hashes {
            if !hash.is_power_of_two() || !(4..=8192).contains(hash) {
                let reason = format!("{hash} is not a power of two from 4 to 8192");
                return Err(bad_option("--hashes", reason));
            }
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
            Model::Built(built) => Ok((path.display().to_string(), *built)),
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
                report.warnings.extend(sitter.warnings);
            }
        }
        report.clock = report.runs.first().map(|run| run.clock);
        Ok(())
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
        let sweeps: Vec<Sweep> = self.sweep.iter().map(|&choice| choice.into()).collect();
        let ranges = Ranges {
            hashes: self.hashes.clone(),
            distances: self.distances.clone(),
        };
        Ok(plan(&sitter.built, level, &sweeps, &ranges))
    }

    /// What a reader of the numbers should know.
    fn remark(&self, common: &Common, report: &Report) {
        for warning in &report.warnings {
            note(common, warning);
        }
        if report.clock == Some(Clock::Wall) {
            let text = "times are the host's wall clock, not a device's time stamps";
            note(common, text);
        }
        let fewest = report.runs.iter().map(|run| run.frames).min().unwrap_or(0);
        if fewest < report.frames as usize {
            let text = format!(
                "{fewest} frames of some rows instead of {}: they would have taken more than a second; --frames N \
                 draws N whatever they take",
                report.frames
            );
            note(common, &text);
        }
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
