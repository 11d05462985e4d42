//! What tables cost at every size: building them on the processor and on a device, a lookup, and their bytes, for each
//! triangle, from ten thousand to ten million; and opening a built file's tables in place.
//!
//! ```text
//! cargo bench --bench scale --features compile-shaders -- --most 10000000 --device llvmpipe
//! cargo bench --bench scale -- --archive             also writes benches/runs/<date>-scale.{json,md}
//! ```
//!
//! In: wrinkled sheets, the hash resolution that `build` would take. Out: a table in Markdown.

mod shared;

use clap::Parser;
use invertex::asset::{self, BuildSettings, Processor, hash_for, open_tables};
use invertex::gpu::Context;
use invertex::igt::{self, BuildOptions, Layout, Needs, Reference, Tables};
use invertex::param::{Primary, PrimaryKind, PrimaryRequest};
use invertex::scene::Scene;
use serde_json::{Value, json};
use shared::{Failure, archive, contexts, median, processor_milliseconds, sheet};
use std::time::Instant;

#[derive(Parser)]
#[command(about = "What tables cost at every size")]
struct Arguments {
    /// `cpu`, an index or part of a device's name.
    #[arg(long, default_value = "cpu")]
    device: String,
    /// Triangles of the smallest and the largest mesh.
    #[arg(long, default_value_t = 10_000)]
    least: u32,
    #[arg(long, default_value_t = 10_000_000)]
    most: u32,
    /// Timed runs, after one that is not counted; one alone above four million.
    #[arg(long, default_value_t = 3)]
    runs: usize,
    /// Open a built file of so many triangles in place; 0 for none.
    #[arg(long, default_value_t = 1_000_000)]
    open: u32,
    /// Keep the numbers in benches/runs/.
    #[arg(long)]
    archive: bool,
    /// What `cargo bench` adds.
    #[arg(long, hide = true)]
    bench: bool,
}

/// The median of some runs, in seconds, and the last result.
fn timed<T>(
    runs: usize,
    mut work: impl FnMut() -> Result<T, Failure>,
) -> Result<(f64, T), Failure> {
    let mut last = work()?;
    let mut seconds = Vec::new();
    for _ in 0..runs {
        let start = Instant::now();
        last = work()?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    Ok((median(&seconds), last))
}

/// Points of the query grid over the sheet.
fn points(count: usize) -> Vec<[i32; 3]> {
    let at = |i: usize, salt| (shared::jitter(i, salt) * 0.49 * (1u32 << 30) as f32) as i32;
    (0..count).map(|i| [at(i, 7), at(i, 8), 0]).collect()
}

/// Nanoseconds of a lookup on one core, and its mean loads.
fn lookups(tables: &Tables) -> Result<[f64; 2], Failure> {
    let points = points(200_000);
    let (seconds, fetches) = timed(3, || {
        let one = |q: &[i32; 3]| u64::from(tables.lookup_with_cost(*q, Some(0), false).1.fetches);
        Ok(points.iter().map(one).sum::<u64>())
    })?;
    let count = points.len() as f64;
    Ok([seconds * 1e9 / count, fetches as f64 / count])
}

fn row(triangles: u32, runs: usize, context: Option<&Context>) -> Result<(String, Value), Failure> {
    let options = BuildOptions {
        hash: hash_for(triangles as usize),
        layout: Layout::Packed,
    };
    let reference = {
        let mesh = sheet(triangles);
        let primary = Primary::centred(PrimaryKind::UvSet(0), &mesh)?;
        Reference::new(
            &mesh,
            &primary,
            &vec![0; mesh.triangles.len()],
            options.layout,
        )?
    };
    let runs = if triangles > 4_000_000 { 1 } else { runs };
    let count = reference.triangles.len() as f64;
    let needs = Needs::default();
    let build = || Ok(igt::build_cpu(&reference, &needs, options)?);
    let (cpu, tables) = timed(runs, build)?;
    let [lookup, fetches] = lookups(&tables)?;
    let (bytes, sha256) = (tables.bytes().iter().sum::<u64>() as f64, tables.sha256());
    let mean_list = tables.stats.mean_list;
    drop(tables);
    let on_device = context.map(|context| -> Result<f64, Failure> {
        let build = || Ok(igt::gpu::build(context, &reference, &needs, options)?.tables);
        let (seconds, tables) = timed(runs, build)?;
        if tables.sha256() != sha256 {
            return Err("the device built other tables".into());
        }
        Ok(seconds)
    });
    let device = on_device.transpose()?;
    let ns = |seconds: f64| seconds * 1e9 / count;
    let text = format!(
        "| {count} | {} | {mean_list:.2} | {:.0} | {} | {lookup:.0} | {fetches:.2} | {:.1} |",
        options.hash,
        ns(cpu),
        device.map_or("-".into(), |seconds| format!("{:.0}", ns(seconds))),
        bytes / count
    );
    let value = json!({
        "triangles": count, "hash": options.hash, "mean_list": mean_list, "cpu_ns_per_triangle": ns(cpu),
        "device_ns_per_triangle": device.map(ns), "lookup_ns": lookup, "fetches": fetches,
        "bytes_per_triangle": bytes / count, "sha256": sha256,
    });
    Ok((text, value))
}

/// How often a file is opened.
const OPENED: usize = 60;

/// A built file's tables, opened in place; and read with all the rest of the file, for comparison.
fn opening(triangles: u32, context: Option<&Context>) -> Result<(String, Value), Failure> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("built.glb");
    let scene = Scene::from_bytes("sheet", &shared::glb(&sheet(triangles)), None)?;
    let settings = BuildSettings {
        primary: PrimaryRequest::UvSet(0),
        lods: vec![0.01],
        ..BuildSettings::default()
    };
    let built = asset::build(scene, &settings, Processor::Cpu, &())?;
    asset::write(&built.built, &path)?;
    drop(built);
    let before = processor_milliseconds();
    let (open, file) = timed(OPENED, || Ok(open_tables(&path)?))?;
    let worked = (processor_milliseconds() - before) / (OPENED + 1) as f64;
    let tables = &file.meshes[0].tables;
    let upload = context.map(|context| {
        timed(3, || {
            for words in [&tables.hash, &tables.list, &tables.triangle] {
                context.upload("table", words)?;
            }
            Ok(())
        })
    });
    let upload = upload.transpose()?.map(|(seconds, ())| seconds * 1e3);
    let (read, _) = timed(1, || Ok(asset::Model::load(&path)?))?;
    let mib = tables.bytes().iter().sum::<u64>() as f64 / f64::from(1 << 20);
    let text = format!(
        "\nA built file of {} triangles ({mib:.0} MiB of tables): opened and validated in place in {:.2} ms \
         ({worked:.1} ms of the processors), uploaded in {} ms; the whole file read, decoded and compared with its checksums in {:.0} ms.",
        file.meshes[0].triangles,
        open * 1e3,
        upload.map_or("-".into(), |ms| format!("{ms:.1}")),
        read * 1e3
    );
    let value = json!({ "opened_triangles": file.meshes[0].triangles, "tables_mib": mib, "open_ms": open * 1e3, "open_processor_ms": worked, "upload_ms": upload, "read_ms": read * 1e3 });
    Ok((text, value))
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    let contexts = contexts(&arguments.device)?;
    let context = contexts.first();
    let name = context.map_or("no device".to_owned(), |c| c.info().name.clone());
    let mut text = format!(
        "| triangles | hash | mean list | build, processor (ns a triangle) | build, {name} (ns a triangle) | lookup, one core (ns) \
         | loads | bytes a triangle |\n|---|---|---|---|---|---|---|---|\n"
    );
    print!("{text}");
    let mut results = Vec::new();
    let sizes = [1, 3]
        .into_iter()
        .flat_map(|k| (0..8).map(move |e| k * 10u32.pow(e)));
    let mut sizes: Vec<u32> = sizes
        .filter(|n| (arguments.least..=arguments.most).contains(n))
        .collect();
    sizes.sort_unstable();
    let mut report = |(line, value): (String, Value)| {
        println!("{line}");
        text += &(line + "\n");
        results.push(value);
    };
    for triangles in sizes {
        report(row(triangles, arguments.runs, context)?);
    }
    if arguments.open > 0 {
        report(opening(arguments.open, context)?);
    }
    if arguments.archive {
        let command = format!(
            "cargo bench --bench scale -- --least {} --most {} --runs {} --device {} --open {} --archive",
            arguments.least, arguments.most, arguments.runs, arguments.device, arguments.open
        );
        archive("scale", "md", &command, &text, &results)?;
    }
    Ok(())
}
