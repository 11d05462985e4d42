//! How fast detail is recovered: closest points and rays a second, and whole bakes.
//!
//! ```text
//! cargo bench --bench recover -- HIGH.glb LOW.glb                  on the processor
//! cargo bench --bench recover -- HIGH.glb LOW.glb --device all     and on every Vulkan device
//! cargo bench --bench recover -- HIGH.glb LOW.glb --archive        also writes benches/runs/<date>-recover-HIGH.{json,txt}
//! ```
//!
//! In: a pair of models. Out: the time of the tree; of four million questions in the order of the texels of LOW's layout (first
//! hits of rays that begin a little outside along the normal and look inwards; closest points, each texel once); of a bake of
//! tangent-space normals, one sample a texel, for each mapping: everything but reading and writing files. Medians of the
//! runs. Rays and points are asked as `score/ray_bench.py` asks Embree's.

mod shared;

use clap::Parser;
use invertex::asset::Progress;
use invertex::recover::{Ask, BakeAttribute, Mapping, Pair, PairSettings, Question, Triangles};
use invertex::render::Renderer;
use invertex::scene::Scene;
use serde_json::{Value, json};
use shared::{Failure, archive, contexts, median};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Rays of the harness.
const RAYS: usize = 4_000_000;

#[derive(Parser)]
#[command(about = "Times detail recovery")]
struct Arguments {
    /// The detailed model.
    high: PathBuf,
    /// The simple one.
    low: PathBuf,
    /// Texels along a side.
    #[arg(long, default_value_t = 2048)]
    size: u32,
    /// Timed runs of each case, after one that is not counted.
    #[arg(long, default_value_t = 3)]
    runs: usize,
    /// `cpu`; `all`, an index or part of a device's name: that one as well.
    #[arg(long, default_value = "cpu")]
    device: String,
    /// Keep the numbers in benches/runs/.
    #[arg(long)]
    archive: bool,
    /// What `cargo bench` adds.
    #[arg(long, hide = true)]
    bench: bool,
}

struct Quiet;

impl Progress for Quiet {
    fn at(&self, _: &'static str, _: &str, _: usize, _: usize) {}
}

/// The median milliseconds of `work`.
fn time<T>(runs: usize, mut work: impl FnMut() -> Result<T, Failure>) -> Result<(f64, T), Failure> {
    let mut last = work()?;
    let mut all = Vec::new();
    for _ in 0..runs.max(1) {
        let start = Instant::now();
        last = work()?;
        all.push(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok((median(&all), last))
}

/// Points and normals of a model's surface under the texels of its layout.
fn surface(low: &Scene, size: u32) -> Result<Vec<[[f32; 3]; 2]>, Failure> {
    let itself = PairSettings {
        mapping: Mapping::Proximity,
        attributes: vec![BakeAttribute::Position, BakeAttribute::ObjectNormal],
        size,
        padding: 0,
        ..PairSettings::default()
    };
    let draw = |picture| Ok(Renderer::cpu(picture));
    let baked = Pair::new(low, low, &itself, &draw, &Quiet)?.bake(0, &Quiet)?;
    let [points, normals] = [0, 1].map(|k| &baked.textures[k].values);
    let on = (0..points.len()).filter(|&k| baked.mask[k] == 255);
    let first = |v: &[f32; 4]| [v[0], v[1], v[2]];
    Ok(on
        .map(|k| [first(&points[k]), first(&normals[k])])
        .collect())
}

fn throughput(
    high: &Scene,
    low: &Scene,
    arguments: &Arguments,
    say: &mut dyn FnMut(Value),
) -> Result<(), Failure> {
    let corners: Vec<[[f32; 3]; 3]> = high
        .meshes
        .iter()
        .flat_map(|mesh| (0..mesh.triangles.len()).map(|t| mesh.corners(t)))
        .collect();
    let runs = arguments.runs;
    let (ms, triangles) = time(runs, || Ok(Triangles::new(&corners)))?;
    say(json!({"job": "tree", "triangles": corners.len(), "ms": ms}));
    let texels = surface(low, arguments.size)?;
    let (least, most) =
        corners
            .as_flattened()
            .iter()
            .fold(([f32::MAX; 3], [f32::MIN; 3]), |(a, b), p| {
                (
                    [0, 1, 2].map(|k| a[k].min(p[k])),
                    [0, 1, 2].map(|k| b[k].max(p[k])),
                )
            });
    let diagonal = (0..3)
        .map(|k| (most[k] - least[k]).powi(2))
        .sum::<f32>()
        .sqrt();
    let points: Vec<Question> = texels.iter().map(|[p, _]| Question::closest(*p)).collect();
    let ray = |[p, n]: &[[f32; 3]; 2]| {
        let begin = [0, 1, 2].map(|k| p[k] + n[k] * 0.02 * diagonal);
        Question::ray(begin, n.map(|c| -c), f32::INFINITY)
    };
    let rays: Vec<Question> = texels.iter().cycle().take(RAYS).map(ray).collect();
    debug_assert!(rays.iter().all(|r| r.ask == Ask::Ray));
    let mut told = |device: &str, job: &str, questions: &[Question], ms: f64| {
        let rate = questions.len() as f64 / ms / 1e3;
        say(
            json!({"job": job, "device": device, "count": questions.len(), "ms": ms, "m_per_s": rate}),
        );
    };
    for (job, questions) in [("closest", &points), ("rays", &rays)] {
        let (ms, answers) = time(runs, || Ok(triangles.ask(questions)))?;
        told("cpu", job, questions, ms);
        if arguments.device == "cpu" {
            continue;
        }
        for context in contexts(&arguments.device)? {
            let (ms, theirs) = time(runs, || Ok(triangles.ask_on(&context, questions)?))?;
            assert!(
                theirs == answers,
                "{} answers otherwise",
                context.info().name
            );
            told(&context.info().name, job, questions, ms);
        }
    }
    Ok(())
}

fn bakes(
    high: &Scene,
    low: &Scene,
    arguments: &Arguments,
    say: &mut dyn FnMut(Value),
) -> Result<(), Failure> {
    for mapping in Mapping::OF_TWO_SURFACES {
        for padding in [0, 16] {
            let settings = PairSettings {
                mapping,
                size: arguments.size,
                padding,
                ..PairSettings::default()
            };
            let draw = |picture| Ok(Renderer::cpu(picture));
            let (ms, baked) = time(arguments.runs, || {
                Ok(Pair::new(high, low, &settings, &draw, &Quiet)?.bake(0, &Quiet)?)
            })?;
            let texels = f64::from(arguments.size) * f64::from(arguments.size);
            say(json!({
                "job": "bake", "mapping": mapping.name(), "size": arguments.size, "padding": padding, "ms": ms,
                "filled_of_all": baked.filled as f64 / texels, "missed": baked.missed,
            }));
        }
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    let load = |path: &Path| Scene::load(path);
    let (high, low) = (load(&arguments.high)?, load(&arguments.low)?);
    let (mut lines, mut text) = (Vec::new(), String::new());
    let mut say = |line: Value| {
        println!("{line}");
        text += &format!("{line}\n");
        lines.push(line);
    };
    throughput(&high, &low, &arguments, &mut say)?;
    bakes(&high, &low, &arguments, &mut say)?;
    if arguments.archive {
        let stem = arguments.high.file_stem().unwrap_or_default();
        let name = format!("recover-{}", stem.to_string_lossy());
        let file = |path: &Path| {
            path.file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned()
        };
        let command = format!(
            "cargo bench --bench recover -- {} {} --size {} --runs {} --device {} --archive",
            file(&arguments.high),
            file(&arguments.low),
            arguments.size,
            arguments.runs,
            arguments.device
        );
        archive(&name, "txt", &command, &text, &lines)?;
    }
    Ok(())
}
