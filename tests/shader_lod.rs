//! The shader LoD: what was filtered beforehand is never farther from the lookup than it says, whatever the distance, and
//! has the same bytes on every processor.

#[path = "render/mod.rs"]
mod render;

mod cli_support;
mod glb;
mod painted;

use invertex::asset::{BuildSettings, Built, Processor, Progress, build, read, to_bytes};
use invertex::recover::prefilter;
use invertex::render::{
    Camera, Correspond, Options, Output, Picture, Projection, Rendered, Renderer, reference_sphere,
    stage, subjects_prefiltered,
};
use invertex::scene::Scene;
use invertex::{Error, attribute::Prefiltered};
use painted::Painted;
use std::sync::atomic::{AtomicUsize, Ordering};

fn built(scene: Scene, primary: &str, size: u32) -> Built {
    let settings = BuildSettings {
        primary: primary.parse().unwrap(),
        lods: vec![0.3],
        ..BuildSettings::default()
    };
    let mut built = build(scene, &settings, Processor::Cpu, &()).unwrap().built;
    prefilter(&mut built, size, &()).unwrap();
    built
}

/// Painted figures, looked up through a cylinder.
fn amphora(size: u32) -> Built {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/amphora.glb");
    built(Scene::load(path.as_ref()).unwrap(), "cylinder:y", size)
}

/// Two balls with textures, normal and occlusion maps, in one chart each.
fn painted(primary: &str, size: u32) -> Built {
    let bytes = Painted::default().glb();
    built(
        Scene::from_bytes("painted.glb", &bytes, None).unwrap(),
        primary,
        size,
    )
}

fn staged(built: &Built, lit: bool) -> Picture {
    let subjects = subjects_prefiltered(built, 1);
    let staged = stage(&built.scene, &subjects, Correspond::Inverse, lit);
    staged.unwrap().0
}

fn camera(built: &Built, distance: f64, side: u32) -> Camera {
    let (centre, radius) = reference_sphere(&built.scene).unwrap();
    let angles = [30.0, 20.0];
    let projection = Projection::Perspective;
    Camera::framed_from(distance, centre, radius, angles, projection, [side, side]).unwrap()
}

fn options(lit: bool, shader_lod: f32) -> Options {
    Options {
        output: if lit { Output::Lit } else { Output::Unlit },
        shader_lod,
        ..Options::default()
    }
}

/// Steps of 8 bits that each covered pixel differs by, sorted.
fn steps(a: &Rendered, b: &Rendered) -> Vec<u8> {
    let pixels = a.rgba8.chunks_exact(4).zip(b.rgba8.chunks_exact(4));
    let far = |(a, b): (&[u8], &[u8])| (0..4).map(|i| a[i].abs_diff(b[i])).max().unwrap();
    let mut all: Vec<u8> = pixels.filter(|(a, _)| a[3] > 0).map(far).collect();
    all.sort_unstable();
    all
}

/// Pixels that were not looked up.
fn alone(image: &Rendered) -> usize {
    let pixels = image.draw.iter().zip(&image.triangle);
    pixels
        .filter(|&(&draw, &triangle)| draw != u32::MAX && triangle == u32::MAX)
        .count()
}

#[test]
fn no_pixel_is_farther_from_the_lookup_than_the_bound() {
    for (name, built) in [
        ("charts", painted("uv0", 128)),
        ("cylinder", amphora(128)),
        ("sphere", painted("sphere", 128)),
    ] {
        for lit in [false, true] {
            let renderer = Renderer::cpu(staged(&built, lit));
            for bound in [1.0, 16.0] {
                let (mut all, mut shown, mut careless) = (Vec::new(), 0, 0);
                for distance in [1.0, 3.0, 9.0, 27.0] {
                    let camera = camera(&built, distance, 160);
                    let draw = |bound| renderer.draw(&camera, &options(lit, bound)).unwrap();
                    let (full, near) = (draw(0.0), draw(bound));
                    all.extend(steps(&full, &near));
                    shown += alone(&near);
                    careless += steps(&full, &draw(63.75))
                        .iter()
                        .filter(|&&s| f32::from(s) > bound + 1.0)
                        .count();
                }
                let over = |by: f32| all.iter().filter(|&&s| f32::from(s) > by).count();
                let beyond = over(bound + 1.0);
                println!(
                    "{name} lit {lit} bound {bound}: {shown} of {} pixels, {beyond} beyond, at most {:?}",
                    all.len(),
                    all.iter().max()
                );
                assert!(beyond * 500 <= all.len(), "{name} {lit} {bound}: {beyond}");
                assert!(
                    over(4.0 * bound + 4.0) * 5000 <= all.len(),
                    "{name} {lit} {bound}"
                );
                assert!(
                    careless > 4 * beyond,
                    "{name}: a bound that is none is seen"
                );
            }
        }
    }
}

#[test]
fn a_zoom_of_120_pictures_has_no_pop() {
    let built = amphora(256);
    let renderer = Renderer::cpu(staged(&built, false));
    let bound = 16.0;
    let (mut most, mut shares) = (0, Vec::new());
    for k in 0..120 {
        let distance = 40f64.powf(f64::from(k) / 119.0);
        let camera = camera(&built, distance, 128);
        let full = renderer.draw(&camera, &options(false, 0.0)).unwrap();
        let near = renderer.draw(&camera, &options(false, bound)).unwrap();
        most = most.max(steps(&full, &near).last().copied().unwrap_or(0));
        shares.push(alone(&near) as f64 / near.covered_pixels as f64);
    }
    println!("at most {most} steps; shares {shares:.2?}");
    // Footprints more than four times as long as wide are not measured beforehand.
    assert!(f32::from(most) <= bound + 3.0, "{most} steps");
    assert!(shares.iter().any(|&s| s > 0.02), "{shares:?}");
}

#[test]
fn bytes_are_the_same_on_every_processor() {
    for (name, built) in [
        ("charts", painted("uv0", 64)),
        ("cylinder", amphora(64)),
        ("sphere", painted("sphere", 64)),
    ] {
        let here = Renderer::cpu(staged(&built, true));
        let camera = camera(&built, 4.0, 96);
        let wish = options(true, 60.0);
        let expected = here.draw(&camera, &wish).unwrap();
        assert!(
            alone(&expected) > 0,
            "{name}: some pixels are not looked up"
        );
        for context in render::contexts() {
            let deferred = Renderer::on(&context, staged(&built, true)).unwrap();
            let image = deferred.draw(&camera, &wish).unwrap();
            assert_eq!(render::differences(&expected, &image), [0; 6], "{name}");
            if name != "charts" {
                continue;
            }
            let forward = Renderer::forward(&context, staged(&built, true)).unwrap();
            let image = forward.draw(&camera, &wish).unwrap();
            let flip = render::flip(&expected, &image);
            assert!(flip < 0.01, "{name} forward: {flip}");
        }
    }
}

#[test]
fn a_file_gives_it_back() {
    let built = painted("uv0", 32);
    let bytes = to_bytes(&built).unwrap();
    let back = read("back.glb", &bytes).unwrap();
    assert_eq!(back.meshes[0].prefiltered, built.meshes[0].prefiltered);
    assert_eq!(to_bytes(&back).unwrap(), bytes);
    let again = painted("uv0", 32);
    assert_eq!(again, built, "the same on every run");
}

#[test]
fn a_damaged_file_is_refused() {
    let built = painted("uv0", 32);
    let bytes = to_bytes(&built).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json = std::str::from_utf8(&bytes[20..20 + length]).unwrap();
    for (from, to) in [
        ("\"size\":32", "\"size\":64"),
        ("\"size\":32", "\"size\":33"),
        ("\"size\":32", "\"size\":99999999"),
    ] {
        assert!(json.contains(from));
        let changed = json.replacen(from, to, 1);
        let damaged = glb::container(&changed, &bytes[20 + length + 8..]);
        let error = read("damaged.glb", &damaged).unwrap_err().to_string();
        assert!(error.contains("prefiltered"), "{to}: {error}");
    }
}

#[test]
fn sizes_and_cancelling_are_errors() {
    let mut built = painted("uv0", 32);
    for size in [0, 16, 100, 8192] {
        let error = prefilter(&mut built, size, &()).unwrap_err();
        assert!(matches!(error, Error::Option { .. }), "{size}: {error}");
    }
    struct Impatient(AtomicUsize);
    impl Progress for Impatient {
        fn cancelled(&self) -> bool {
            self.0.fetch_add(1, Ordering::Relaxed) > 2
        }
    }
    let stopped = prefilter(&mut built, 64, &Impatient(AtomicUsize::new(0)));
    assert!(matches!(stopped, Err(Error::Cancelled)));
    let kept = built.meshes[0].prefiltered.as_ref().map(Prefiltered::size);
    assert_eq!(kept, Some(32), "what was there stays");
}

#[test]
fn the_command_line_builds_draws_and_explains() {
    use cli_support::{Folder, invertex};
    let folder = Folder::new();
    let model = folder.write("painted.glb", &Painted::default().glb());
    let [plain, built] = ["plain.glb", "built.glb"].map(|name| folder.at(name));
    let build = [
        "build", &model, "--device", "cpu", "--lods", "0.5,0.2", "-o",
    ];
    invertex(&[&build[..], &[&plain]].concat()).ok();
    let report = invertex(&[&build[..], &[&built, "--shader-lod", "64", "--json"]].concat()).json();
    assert!(report["build_ms"]["shader_lod"].as_f64() > Some(0.0));
    let image = folder.at("far.png");
    let draw = |file: &str, more: &[&str]| {
        let fixed = ["render", file, "-o", &image, "--device", "cpu", "--json"];
        invertex(&[&fixed[..], more].concat())
    };
    let far = [
        "--mode",
        "igt",
        "--shading",
        "unlit",
        "--size",
        "64",
        "--distance",
        "6",
        "--shader-lod",
    ];
    let report = draw(&built, &[&far[..], &["60"]].concat()).json();
    assert!(report["images"][0]["prefiltered_pixels"].as_u64() > Some(10));
    let wrong = |file: &str, more: &[&str], code, words: &[&str]| {
        draw(file, more).fails(code, words);
    };
    wrong(
        &plain,
        &[&far[..], &["1"]].concat(),
        3,
        &["build it with --shader-lod"],
    );
    for steps in ["0", "-1", "nan", "64"] {
        wrong(&built, &[&far[..], &[steps]].concat(), 2, &["--shader-lod"]);
    }
    wrong(&built, &["--shader-lod", "1"], 2, &["--mode igt"]);
    let shown = [
        "--mode",
        "igt",
        "--shader-lod",
        "1",
        "--attribute",
        "occlusion",
    ];
    wrong(&built, &shown, 2, &["--attribute"]);
    invertex(&[&build[..], &[&built, "--shader-lod", "100"]].concat()).fails(2, &["power of two"]);
}

#[test]
fn a_sequence_moves_away_and_blends_levels() {
    use cli_support::{Folder, invertex};
    let folder = Folder::new();
    let model = folder.write("painted.glb", &Painted::default().glb());
    let (built, frames) = (folder.at("built.glb"), folder.at("frames"));
    invertex(&[
        "build", &model, "-o", &built, "--device", "cpu", "--lods", "0.5,0.2",
    ])
    .ok();
    let fixed = [
        "render", &built, "-o", &frames, "--device", "cpu", "--json", "--mode", "igt", "--size",
        "48",
    ];
    let away = [
        "--lod",
        "pixels:0.3",
        "--distance",
        "1..60",
        "--frames",
        "24",
        "--blend",
        "3",
    ];
    let report = invertex(&[&fixed[..], &away].concat()).json();
    let images = report["images"].as_array().unwrap();
    assert_eq!(images.len(), 24);
    let levels: Vec<u64> = images.iter().map(|i| i["lod"].as_u64().unwrap()).collect();
    assert!(levels.is_sorted() && levels[0] < levels[23], "{levels:?}");
    let leaving = images.iter().filter(|i| i["leaving"].is_object());
    let shares: Vec<f64> = leaving
        .map(|i| i["leaving"]["share"].as_f64().unwrap())
        .collect();
    assert!(
        shares.len().is_multiple_of(3) && shares.starts_with(&[0.25, 0.5, 0.75]),
        "{shares:?}"
    );
    let covered = |k: usize| images[k]["covered_pixels"].as_u64().unwrap();
    assert!(covered(0) > 20 * covered(23));
    let refused = |more: &[&str], words: &[&str]| {
        invertex(&[&fixed[..], more].concat()).fails(2, words);
    };
    refused(&["--blend", "3"], &["--lod pixels"]);
    refused(
        &["--blend", "3", "--lod", "1", "--distance", "1..9"],
        &["--lod pixels"],
    );
    for distance in ["0", "2..nan"] {
        let run = invertex(&[&fixed[..], &["--distance", distance]].concat());
        assert!(run.code == 2 && run.stderr.contains("is not a distance"));
    }
}
