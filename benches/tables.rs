//! How fast tables are built: a million triangles at 1024 x 1024, on the CPU and on a device.
//!
//! ```text
//! cargo bench --bench tables                          CPU, then every Vulkan device
//! cargo bench --bench tables -- --device cpu          one of them: cpu, an index or part of a name
//! cargo bench --bench tables -- --archive             also writes benches/runs/<date>-tables.{json,txt}
//! ```
//!
//! In: meshes made here (a wrinkled sheet with uv, a bumpy sphere). Out: the median time of the runs, triangles per
//! second, and on devices the time of each pass. What is timed is the whole build: mesh on the integer grid in,
//! tables in host memory out, uploads and downloads included. Device tables are checked against the CPU's sha256.
//!
//! Beside it stands the processors' time of this process (Linux): all cores together, of a run, so that runs on a busy machine
//! can be compared. For software devices that is the whole work, for others the host's part.

use clap::Parser;
use invertex::gpu::{self, Context, ContextOptions, DeviceChoice, PassTime};
use invertex::igt::{self, Asking, BuildOptions, Layout, Needs, Reference, Tables};
use invertex::mesh::{Mesh, shapes};
use invertex::param::{Primary, PrimaryKind};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::time::Instant;

type Failure = Box<dyn std::error::Error>;

#[derive(Parser)]
#[command(about = "Times the building of tables")]
struct Arguments {
    /// `all`, `cpu`, an index or part of a device's name.
    #[arg(long, default_value = "all")]
    device: String,
    /// Texels along a side of the hash texture.
    #[arg(long, default_value_t = 1024)]
    hash: u32,
    /// Triangles of each mesh, about.
    #[arg(long, default_value_t = 1_000_000)]
    triangles: u32,
    /// Part of the name of the cases to run.
    #[arg(long, default_value = "")]
    case: String,
    /// Timed runs of each case, after one that is not counted.
    #[arg(long, default_value_t = 7)]
    runs: usize,
    /// Keep the numbers in benches/runs/.
    #[arg(long)]
    archive: bool,
    /// What `cargo bench` adds.
    #[arg(long, hide = true)]
    bench: bool,
}

/// A repeatable number in [-1, 1] for each index.
fn jitter(index: usize, salt: u32) -> f32 {
    let mut h = (index as u32).wrapping_mul(0x9e37_79b9) ^ salt.wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 16)).wrapping_mul(0xc2b2_ae35);
    h ^= h >> 13;
    (h & 0xffff) as f32 / 32_767.5 - 1.0
}

/// A unit sheet whose inner uv are moved by up to a quarter of a cell: no two triangles alike.
fn sheet(triangles: u32) -> Mesh {
    let n = ((triangles / 2) as f64).sqrt().round() as u32;
    let mut mesh = shapes::grid(n);
    let cell = 0.25 / n as f32;
    for (i, uv) in mesh.uv_sets[0].iter_mut().enumerate() {
        for (axis, value) in uv.iter_mut().enumerate() {
            if *value > 0.0 && *value < 1.0 {
                *value += cell * jitter(i, axis as u32);
            }
        }
    }
    mesh
}

/// A sphere with bumps of a fifth of its radius.
fn bumpy_sphere(triangles: u32) -> Mesh {
    let rings = ((triangles / 4) as f64).sqrt().round() as u32;
    let mut mesh = shapes::uv_sphere(2 * rings, rings);
    for p in &mut mesh.positions {
        let wave = 0.1 * ((9.0 * p[0]).sin() * (7.0 * p[1]).cos() + (8.0 * p[2]).sin());
        *p = p.map(|c| c * (1.0 + wave));
    }
    mesh
}

struct Case {
    name: &'static str,
    layout: Layout,
    reference: Reference,
    needs: Needs,
}

fn cases(arguments: &Arguments) -> Result<Vec<Case>, Failure> {
    let sheet = sheet(arguments.triangles);
    let sphere = bumpy_sphere(arguments.triangles);
    let uv = Primary::centred(PrimaryKind::UvSet(0), &sheet)?;
    let centre = Primary::new(PrimaryKind::Sphere, &sphere, [0.0; 3])?;
    let mut cases = Vec::new();
    for (name, mesh, primary) in [
        ("sheet, uv", &sheet, uv),
        ("bumpy sphere, sphere", &sphere, centre),
    ] {
        let layer = vec![0; mesh.triangles.len()];
        for layout in [Layout::Packed, Layout::Classic] {
            let reference = Reference::new(mesh, &primary, &layer, layout)?;
            let itself = Asking {
                t3: &reference.t3,
                triangles: &reference.triangles,
                layer: &layer,
            };
            let needs = Needs::of(&reference, &[itself], arguments.hash.trailing_zeros());
            cases.push(Case {
                name,
                layout,
                reference,
                needs,
            });
        }
    }
    Ok(cases)
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// Milliseconds that the processors have worked for this process so far; 0 where the system does not say.
fn processor_milliseconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // After the name in brackets: user and system time are the 12th and 13th, in hundredths of a second.
    let fields = text.rsplit(')').next().unwrap_or_default();
    let ticks = fields.split_whitespace().skip(11).take(2);
    ticks.filter_map(|t| t.parse::<f64>().ok()).sum::<f64>() * 10.0
}

/// Milliseconds of each counted run, and of the processors' work in a run; the tables and the last run's passes.
struct Timed {
    milliseconds: Vec<f64>,
    processors: f64,
    tables: Tables,
    passes: Vec<PassTime>,
}

fn time(
    runs: usize,
    mut build: impl FnMut() -> Result<(Tables, Vec<PassTime>), Failure>,
) -> Result<Timed, Failure> {
    let (mut tables, mut passes) = build()?;
    let mut milliseconds = Vec::new();
    let before = processor_milliseconds();
    for _ in 0..runs {
        let start = Instant::now();
        (tables, passes) = build()?;
        milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(Timed {
        processors: (processor_milliseconds() - before) / runs.max(1) as f64,
        milliseconds,
        tables,
        passes,
    })
}

fn line(case: &Case, device: &str, timed: &Timed) -> (String, Value) {
    let triangles = case.reference.triangles.len();
    let ms = median(&timed.milliseconds);
    let rate = triangles as f64 / ms * 1e3;
    let layout = format!("{:?}", case.layout).to_lowercase();
    let mut text = format!(
        "{:<22} {layout:<8} {device:<44} {ms:>8.1} ms {:>7.2} M triangles/s, processors {:>8.1} ms, {} entries",
        case.name,
        rate / 1e6,
        timed.processors,
        timed.tables.stats.entries
    );
    for pass in &timed.passes {
        let _ = write!(
            text,
            "\n    {:<24} {:>8.2} ms",
            pass.name,
            pass.nanoseconds as f64 / 1e6
        );
    }
    let passes: Vec<Value> = timed
        .passes
        .iter()
        .map(|p| json!({ "pass": p.name, "nanoseconds": p.nanoseconds }))
        .collect();
    let value = json!({
        "case": case.name, "layout": layout, "device": device, "triangles": triangles, "median_ms": ms,
        "triangles_per_second": rate, "runs_ms": timed.milliseconds, "processors_ms": timed.processors, "entries": timed.tables.stats.entries,
        "mean_list": timed.tables.stats.mean_list, "sha256": timed.tables.sha256(), "passes": passes,
    });
    (text, value)
}

fn contexts(wanted: &str) -> Result<Vec<Context>, Failure> {
    let indices: Vec<DeviceChoice> = match wanted {
        "cpu" => Vec::new(),
        "all" => gpu::devices()
            .unwrap_or_default()
            .iter()
            .filter(|d| d.usable)
            .map(|d| DeviceChoice::Index(d.index))
            .collect(),
        other => vec![other.parse()?],
    };
    indices
        .into_iter()
        .map(|device| {
            Ok(Context::new(&ContextOptions {
                device,
                validation: false,
            })?)
        })
        .collect()
}

fn machine() -> Value {
    let first = |file: &str, key: &str| {
        let text = std::fs::read_to_string(file).unwrap_or_default();
        let found = text.lines().find(|l| l.starts_with(key));
        found
            .and_then(|l| l.split([':', '=']).nth(1))
            .unwrap_or("unknown")
            .trim()
            .trim_matches('"')
            .to_owned()
    };
    json!({
        "processor": first("/proc/cpuinfo", "model name"),
        "cores": std::thread::available_parallelism().map_or(0, usize::from),
        "system": first("/etc/os-release", "PRETTY_NAME"),
        // What else ran: the numbers of a busy machine are a lower bound.
        "load_average": std::fs::read_to_string("/proc/loadavg").unwrap_or_default().trim(),
    })
}

fn today() -> String {
    let output = std::process::Command::new("date")
        .args(["-u", "+%Y-%m-%d"])
        .output();
    output.map_or_else(
        |_| "undated".into(),
        |o| String::from_utf8_lossy(&o.stdout).trim().to_owned(),
    )
}

fn archive(command: &str, text: &str, results: &[Value]) -> Result<(), Failure> {
    let base = format!(
        "{}/benches/runs/{}-tables",
        env!("CARGO_MANIFEST_DIR"),
        today()
    );
    let document =
        json!({ "command": command, "date": today(), "machine": machine(), "results": results });
    std::fs::write(
        format!("{base}.json"),
        serde_json::to_string_pretty(&document)? + "\n",
    )?;
    std::fs::write(
        format!("{base}.txt"),
        format!("{command}\n{}\n{}\n\n{text}", today(), machine()),
    )?;
    println!("archived in {base}.json and .txt");
    Ok(())
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    let contexts = contexts(&arguments.device)?;
    let with_cpu = matches!(arguments.device.as_str(), "all" | "cpu");
    let (mut text, mut results) = (String::new(), Vec::new());
    let mut report = |(line, value): (String, Value)| {
        println!("{line}");
        text += &(line + "\n");
        results.push(value);
    };
    for case in cases(&arguments)?
        .iter()
        .filter(|case| case.name.contains(&arguments.case))
    {
        let options = BuildOptions {
            hash: arguments.hash,
            layout: case.layout,
        };
        let runs = if with_cpu { arguments.runs } else { 0 };
        let cpu = time(runs, || {
            Ok((
                igt::build_cpu(&case.reference, &case.needs, options)?,
                Vec::new(),
            ))
        })?;
        let expected = cpu.tables.sha256();
        if with_cpu {
            report(line(case, "cpu", &cpu));
        }
        for context in &contexts {
            let info = context.info();
            let timed = time(arguments.runs, || {
                let built = igt::gpu::build(context, &case.reference, &case.needs, options)?;
                Ok((
                    built.tables,
                    built.timings.into_iter().flat_map(|t| t.passes).collect(),
                ))
            })?;
            if timed.tables.sha256() != expected {
                return Err(format!(
                    "{}: {} built other tables than the CPU",
                    case.name, info.name
                )
                .into());
            }
            report(line(case, &info.name, &timed));
        }
    }
    if arguments.archive {
        let options = format!(
            "--hash {} --triangles {} --runs {} --device {}",
            arguments.hash, arguments.triangles, arguments.runs, arguments.device
        );
        archive(
            &format!("cargo bench --bench tables -- {options} --archive"),
            &text,
            &results,
        )?;
    }
    Ok(())
}
