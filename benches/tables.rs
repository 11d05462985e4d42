//! How fast tables are built: a million triangles at 1024 x 1024, on the CPU and on a device.
//!
//! ```text
//! cargo bench --bench tables                          CPU, then every Vulkan device
//! cargo bench --bench tables -- --device cpu          one of them: cpu, an index or part of a name
//! cargo bench --bench tables -- --archive             also writes benches/runs/<date>-tables.{json,txt}
//! ```
//!
//! In: meshes made here: a wrinkled sheet with uv, a bumpy sphere; and, as `hard: ..`, a giant triangle among a million, a
//! million slivers, everything in one texel. Out: the median time of the runs, triangles per
//! second, and on devices the time of each pass. What is timed is the whole build: mesh on the integer grid in,
//! tables in host memory out, uploads and downloads included. Device tables are checked against the CPU's sha256.
//!
//! Beside it stands the processors' time of this process (Linux): all cores together, of a run, so that runs on a busy machine
//! can be compared. For software devices that is the whole work, for others the host's part.

mod shared;

use clap::Parser;
use invertex::gpu::PassTime;
use invertex::igt::layout::packed;
use invertex::igt::{self, Asking, BuildOptions, Layout, Needs, Reference, Tables};
use invertex::param::{Primary, PrimaryKind};
use serde_json::{Value, json};
use shared::{
    Failure, archive, bumpy_sphere, contexts, in_one_texel, median, processor_milliseconds, sheet,
    slivers, with_giant,
};
use std::fmt::Write as _;
use std::time::Instant;

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

struct Case {
    name: &'static str,
    layout: Layout,
    reference: Reference,
    needs: Needs,
}

/// The even cases in both layouts, and inputs that are anything but even in ours. The giant triangle lies in a layer of its
/// own, as a build would have it, and in that of all others.
const CASES: [(&str, Layout); 8] = [
    ("sheet, uv", Layout::Packed),
    ("sheet, uv", Layout::Classic),
    ("bumpy sphere, sphere", Layout::Packed),
    ("bumpy sphere, sphere", Layout::Classic),
    ("hard: giant triangle", Layout::Packed),
    ("hard: giant, same layer", Layout::Packed),
    ("hard: slivers", Layout::Packed),
    ("hard: one texel", Layout::Packed),
];

fn case(arguments: &Arguments, name: &'static str, layout: Layout) -> Result<Case, Failure> {
    let (count, hash) = (arguments.triangles, arguments.hash);
    let mesh = match name {
        "sheet, uv" => sheet(count),
        "bumpy sphere, sphere" => bumpy_sphere(count),
        "hard: slivers" => slivers(count),
        "hard: one texel" => in_one_texel(count, hash),
        _ => with_giant(count),
    };
    let primary = if name == "bumpy sphere, sphere" {
        Primary::new(PrimaryKind::Sphere, &mesh, [0.0; 3])?
    } else {
        Primary::centred(PrimaryKind::UvSet(0), &mesh)?
    };
    let mut layer = vec![0; mesh.triangles.len()];
    if name == "hard: giant triangle" {
        layer[mesh.triangles.len() - 1] = 1;
    }
    let reference = Reference::new(&mesh, &primary, &layer, layout)?;
    let itself = Asking {
        t3: &reference.t3,
        triangles: &reference.triangles,
        layer: &layer,
    };
    let needs = Needs::of(&reference, &[itself], hash.trailing_zeros());
    Ok(Case {
        name,
        layout,
        reference,
        needs,
    })
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

/// Entries of all lists as the tables hold them: crowded texels are divided, and their parts' lists are longer together.
fn written(tables: &Tables) -> u64 {
    if tables.layout == Layout::Classic {
        return tables.stats.entries;
    }
    let bits = |mixed| tables.format.entry_bits(mixed);
    let count = |mut run: packed::Run, bits, masked| {
        std::iter::from_fn(|| run.next(bits, masked)).count() as u64
    };
    let mut entries = 0;
    for words in tables.hash.chunks_exact(2) {
        let packed::Head::List {
            run,
            mut rest,
            kind,
        } = packed::head([words[0], words[1]])
        else {
            continue;
        };
        let bits = bits(kind.mixed);
        entries += count(run, bits, false);
        while let packed::Rest::Full(unit) = rest {
            let (run, last) = packed::full_run(&tables.list, unit, bits);
            entries += count(run, bits, true);
            rest = if last {
                packed::Rest::None
            } else {
                packed::Rest::Full(unit + 2)
            };
        }
        if let packed::Rest::Half(unit) = rest {
            entries += count(packed::half_run(&tables.list, unit, bits), bits, true);
        }
    }
    entries
}

fn line(case: &Case, device: &str, timed: &Timed) -> (String, Value) {
    let triangles = case.reference.triangles.len();
    let ms = median(&timed.milliseconds);
    let rate = triangles as f64 / ms * 1e3;
    let layout = format!("{:?}", case.layout).to_lowercase();
    let entries = written(&timed.tables);
    let mut text = format!(
        "{:<22} {layout:<8} {device:<44} {ms:>8.1} ms {:>7.2} M triangles/s, processors {:>8.1} ms, {} entries, {entries} written, {:.0} ns each",
        case.name,
        rate / 1e6,
        timed.processors,
        timed.tables.stats.entries,
        ms * 1e6 / entries.max(1) as f64
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
        "entries_written": entries, "ns_per_entry_written": ms * 1e6 / entries.max(1) as f64,
        "mean_list": timed.tables.stats.mean_list, "sha256": timed.tables.sha256(), "passes": passes,
    });
    (text, value)
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
    for (name, layout) in CASES
        .iter()
        .filter(|(name, _)| name.contains(&arguments.case))
    {
        let case = &case(&arguments, name, *layout)?;
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
        let command = format!("cargo bench --bench tables -- {options} --archive");
        archive("tables", "txt", &command, &text, &results)?;
    }
    Ok(())
}
