//! The profile's figures: what is counted is what the pictures say, on every processor alike. No test asks how long
//! anything took.

mod cli_support;
mod glb;

use cli_support::{Ball, Folder, invertex};
use invertex::asset::{Built, Model, Processor};
use invertex::measure::{
    Bench, Drawing, FetchCounts, ProfileSettings, Ranges, Run, Sitter, Sweep, Variant,
    chrome_trace, fetches_of_uv, plan,
};
use invertex::render::{Correspond, FrameBudget, Options, Rendered, Renderer, stage, subjects};
use serde_json::Value;

/// A built ball, and the folder that holds it.
fn ball(more: &[&str]) -> (Folder, String) {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let out = folder.at("built.glb");
    let arguments = [
        "build", &model, "-o", &out, "--device", "cpu", "--lods", "0.5,0.2",
    ];
    invertex(&[&arguments, more].concat()).ok();
    (folder, out)
}

fn load(path: &str) -> Built {
    match Model::load(path.as_ref()).unwrap() {
        Model::Built(built) => *built,
        Model::Plain(_) => panic!("{path} is not built"),
    }
}

fn settings() -> ProfileSettings {
    ProfileSettings {
        size: [96, 64],
        budget: FrameBudget {
            warm_up: 1,
            frames: 2,
            seconds: None,
        },
        bake_size: 64,
        ..ProfileSettings::default()
    }
}

fn profile(built: &Built, processor: Processor<'_>, sweeps: &[Sweep]) -> Vec<Run> {
    let settings = settings();
    let sitter = Sitter::new("built.glb", "ball", built.clone(), settings.lit).unwrap();
    let bench = Bench {
        processor,
        settings: &settings,
    };
    let ranges = Ranges {
        hashes: vec![16, 64],
        distances: vec![1.0, 4.0],
    };
    let drawings: Vec<Drawing> = plan(built, 1, sweeps, &ranges);
    let runs = drawings.iter().map(|d| bench.runs(&sitter, d).unwrap());
    runs.flatten().collect()
}

/// The image that the row of variant `lod+igt` counts, drawn by other means.
fn image(built: &Built) -> (Rendered, invertex::render::Picture) {
    let subjects = subjects(built, 1);
    let (picture, _) = stage(&built.scene, &subjects, Correspond::Inverse, true).unwrap();
    let sitter = Sitter::new("", "", built.clone(), true).unwrap();
    let camera = sitter.camera(&settings(), 1.0).unwrap();
    let image = Renderer::cpu(picture.clone()).draw(&camera, &Options::default());
    (image.unwrap(), picture)
}

/// Everything that is counted of a row.
fn counted(run: &Run) -> (Vec<u64>, u64, u64, u32, u32, [f64; 3]) {
    (
        run.histogram.clone(),
        run.covered_pixels,
        run.unmapped_pixels,
        run.p99_fetches,
        run.max_fetches,
        [
            run.mean_fetches,
            run.mean_fetches_with_uv,
            run.mean_texture_fetches,
        ],
    )
}

#[test]
fn counts_are_the_sums_of_the_pictures_own_pixels() {
    let (_folder, path) = ball(&["--primary", "sphere"]);
    let built = load(&path);
    let runs = profile(&built, Processor::Cpu, &[]);
    let run = &runs[1];
    assert_eq!(run.variant, Variant::Inverse);
    let (image, picture) = image(&built);
    let covered = |k: &usize| image.draw[*k] != u32::MAX;
    let pixels: Vec<usize> = (0..image.draw.len()).filter(covered).collect();
    let sum: u64 = pixels.iter().map(|&k| u64::from(image.fetches[k])).sum();
    assert_eq!(run.covered_pixels, pixels.len() as u64);
    assert_eq!(run.histogram.iter().sum::<u64>(), run.covered_pixels);
    assert_eq!(run.mean_fetches, sum as f64 / pixels.len() as f64);
    let most = pixels.iter().map(|&k| image.fetches[k]).max().unwrap();
    assert_eq!(run.max_fetches, most);
    assert!(run.p99_fetches <= most && f64::from(most) >= run.mean_fetches);
    // Every pixel of the ball is mapped, so each one pays for the uv: one record.
    assert_eq!(run.unmapped_pixels, 0);
    assert!((run.mean_fetches_with_uv - run.mean_fetches - 1.0).abs() < 1e-12);
    let one = pixels[0];
    let uv = fetches_of_uv(&picture, image.draw[one], image.triangle[one]);
    assert_eq!(uv, 1);
    // The negative control: one pixel that took one load more is seen.
    let mut other = image.clone();
    other.fetches[pixels[0]] += 1;
    let (a, b) = (
        FetchCounts::of(&image, &picture),
        FetchCounts::of(&other, &picture),
    );
    assert_eq!(a.histogram, run.histogram);
    assert!(a.histogram != b.histogram && a.mean < b.mean);
}

#[test]
fn rows_without_tables_fetch_nothing_and_are_drawn_from_one_place() {
    let (_folder, path) = ball(&["--primary", "sphere"]);
    let built = load(&path);
    let runs = profile(&built, Processor::Cpu, &[]);
    let variants: Vec<&str> = runs.iter().map(|run| run.variant.name()).collect();
    assert_eq!(variants, ["reference", "lod+igt", "lod+baked", "lod+plain"]);
    for run in &runs {
        let looks_up = run.variant == Variant::Inverse;
        assert_eq!(run.mean_fetches > 0.0, looks_up, "{}", run.variant.name());
        assert_eq!(run.layout.is_some(), looks_up);
        assert_eq!(run.tables_bytes > 0, looks_up);
        assert_eq!(run.lookup_ns_median.is_some(), looks_up);
        assert_eq!((run.frames, run.times.len()), (2, 2));
        let of_lod = run.triangles == built.meshes[0].lods[0].triangles.len() as u32;
        assert_eq!(of_lod, run.variant != Variant::Reference);
    }
    let tables = &built.meshes[0].tables;
    assert_eq!(runs[1].tables_bytes, tables.bytes().iter().sum::<u64>());
    assert_eq!(runs[1].mean_list, Some(tables.stats.mean_list));
    // The baked LoD covers what the LoD covers, and reads its two textures.
    assert_eq!(runs[2].covered_pixels, runs[1].covered_pixels);
    assert_eq!(runs[2].mean_texture_fetches, 2.0);
}

#[cfg(feature = "gpu")]
#[test]
fn devices_and_the_processor_count_alike() {
    use invertex::gpu::{Context, ContextOptions, DeviceChoice, devices};
    let (_folder, path) = ball(&["--primary", "sphere"]);
    let built = load(&path);
    let cpu = profile(&built, Processor::Cpu, &[Sweep::Layout]);
    let found = devices().unwrap_or_default();
    for device in found.iter().filter(|d| d.usable) {
        let options = ContextOptions {
            device: DeviceChoice::Index(device.index),
            validation: true,
        };
        let context = Context::new(&options).unwrap();
        let runs = profile(&built, Processor::Device(&context), &[Sweep::Layout]);
        for (a, b) in cpu.iter().zip(&runs) {
            assert_eq!(
                counted(a),
                counted(b),
                "{} {}",
                device.name,
                a.variant.name()
            );
            assert_eq!((a.triangles, a.tables_bytes), (b.triangles, b.tables_bytes));
        }
        // The two layouts differ, so that alike means something.
        assert_ne!(counted(&runs[4]).0, counted(&runs[5]).0);
        let passes: Vec<&str> = runs[1].passes.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(passes, ["render_project", "render_raster", "render_shade"]);
        assert_eq!(context.validation_messages(), Vec::<String>::new());
    }
}

#[test]
fn sweeps_vary_what_they_say_and_nothing_else() {
    let (_folder, path) = ball(&["--primary", "sphere", "--hash", "64"]);
    let built = load(&path);
    let all = [Sweep::Hash, Sweep::Layout, Sweep::Lod, Sweep::Distance];
    let runs = profile(&built, Processor::Cpu, &all);
    let of = |sweep| -> Vec<&Run> { runs.iter().filter(|r| r.sweep == Some(sweep)).collect() };
    let hash = of(Sweep::Hash);
    assert_eq!([hash[0].hash, hash[1].hash], [Some(16), Some(64)]);
    assert!(
        hash[0].mean_list > hash[1].mean_list,
        "coarser texels have longer lists"
    );
    assert_eq!(
        counted(hash[1]),
        counted(&runs[1]),
        "the file's own tables, built again"
    );
    let layout = of(Sweep::Layout);
    assert_eq!(counted(layout[0]), counted(&runs[1]));
    let of_uv = layout[1].mean_fetches_with_uv - layout[1].mean_fetches;
    assert!((of_uv - 3.0).abs() < 1e-12, "the paper's attribute texture");
    assert!(
        layout[1].mean_fetches > layout[0].mean_fetches,
        "the paper's costs more"
    );
    // The reference, and two levels in three variants.
    assert_eq!((of(Sweep::Lod).len(), of(Sweep::Distance).len()), (7, 14));
    let near_far = of(Sweep::Distance);
    for pair in near_far.chunks(2) {
        assert_eq!([pair[0].distance, pair[1].distance], [1.0, 4.0]);
        let ratio = pair[0].covered_pixels as f64 / pair[1].covered_pixels as f64;
        assert!(
            (13.0..20.0).contains(&ratio),
            "16 times the area, not {ratio}"
        );
    }
}

#[test]
fn a_trace_has_a_track_for_each_pass_and_its_frames_do_not_overlap() {
    let (_folder, path) = ball(&["--primary", "sphere"]);
    let runs = profile(&load(&path), Processor::Cpu, &[]);
    let trace = chrome_trace(&runs);
    let events = trace["traceEvents"].as_array().unwrap();
    let of = |kind: &str, process: u64| -> Vec<&Value> {
        let wanted = |e: &&Value| e["ph"] == kind && e["pid"] == process;
        events.iter().filter(wanted).collect()
    };
    for (k, run) in runs.iter().enumerate() {
        let names = of("M", k as u64 + 1);
        assert_eq!(names.len(), 2 + run.passes.len(), "process, frame, passes");
        let spans = of("X", k as u64 + 1);
        assert_eq!(spans.len(), run.times.len() * (1 + run.passes.len()));
        for track in 0..=run.passes.len() {
            let on = spans.iter().filter(|e| e["tid"] == track);
            let mut end = 0.0;
            for span in on {
                assert!(span["ts"].as_f64().unwrap() >= end - 1e-6);
                end = span["ts"].as_f64().unwrap() + span["dur"].as_f64().unwrap();
            }
            assert!(end > 0.0);
        }
    }
}
