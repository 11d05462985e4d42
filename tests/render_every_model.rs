//! Pictures of every shared model, with `INVERTEX_LONG=1`:
//!
//! * with the reference as its own LoD the inverse texture finds the very triangle, and shows the very colour;
//! * deferred pictures have the same bytes on the CPU and on every device;
//! * the forward path shows what the deferred path shows.
#![cfg(feature = "gpu")]

mod identity;
mod long;
mod render;

use invertex::asset::hash_for;
use invertex::gpu::Context;
use invertex::igt::Layout;
use invertex::render::{Camera, Correspond, Options, Output, Picture, Rendered, Renderer, stage};
use invertex::scene::Scene;
use render::flip;
use render::model::{self, Built};

/// LoDs that are drawn: levels 2 and 3 of this chain.
const FRACTIONS: [f32; 3] = [0.2, 0.1, 0.05];
/// Mean FLIP of forward against deferred, at most.
const MOST_FLIP: f64 = 0.01;

/// All three measures; every fault is told before the first fails the test.
fn check(name: &str) {
    let Some(path) = long::model(name) else {
        return;
    };
    let scene = Scene::load(&path).unwrap();
    let prepared = model::prepare(scene, &long::primary(name), &FRACTIONS);
    let built = prepared.built(Layout::Packed, hash_for);
    let contexts = render::contexts();
    let mut faults = identity::faults(name, &built);
    faults.extend(differing(name, &built, &contexts));
    faults.extend(far_apart(name, &built, &contexts));
    for context in &contexts {
        faults.extend(context.validation_messages());
    }
    assert_eq!(faults, Vec::<String>::new(), "{name}");
}

mod shared {
    super::long::on_every_model!(super::check);
}

/// The picture of a level.
fn picture(built: &Built, level: usize, correspond: Correspond) -> Picture {
    stage(&built.scene, &built.subjects(level), correspond, true)
        .unwrap()
        .0
}

/// A camera that frames the reference, as the command line does.
fn camera(built: &Built, view: (f64, f64), side: u32) -> Camera {
    let reference = picture(built, 0, Correspond::Reference);
    render::camera(&reference, view.0, view.1, side, side)
}

fn showing(output: Output) -> Options {
    Options {
        output,
        ..Options::default()
    }
}

/// Deferred pictures whose bytes a device makes otherwise than the CPU.
fn differing(name: &str, built: &Built, contexts: &[Context]) -> Vec<String> {
    let cameras = [(30.0, 20.0), (200.0, -35.0)].map(|view| camera(built, view, 192));
    let (mut faults, mut pictures) = (Vec::new(), 0);
    for (level, correspond, outputs) in [
        (
            0,
            Correspond::Reference,
            [Output::Lit, Output::Normals].as_slice(),
        ),
        (
            2,
            Correspond::Inverse,
            &[Output::Lit, Output::Normals, Output::Fetches],
        ),
        (
            3,
            Correspond::Inverse,
            &[Output::Lit, Output::Normals, Output::Fetches],
        ),
        (2, Correspond::Plain, &[Output::Lit]),
        (3, Correspond::Plain, &[Output::Lit]),
    ] {
        let picture = picture(built, level, correspond);
        let cpu = Renderer::cpu(picture.clone());
        for context in contexts {
            let device = Renderer::on(context, picture.clone()).unwrap();
            for (camera, output) in cameras
                .iter()
                .flat_map(|c| outputs.iter().map(move |o| (c, *o)))
            {
                let want = cpu.draw(camera, &showing(output)).unwrap();
                let got = device.draw(camera, &showing(output)).unwrap();
                pictures += 1;
                assert!(want.covered_pixels > 500, "{name}: hardly a picture");
                let pixels = render::differences(&want, &got);
                if pixels != [0; 6] {
                    let on = &context.info().name;
                    faults.push(format!(
                        "{name} level {level} {correspond:?} {output:?} on {on}: {pixels:?} {}",
                        first_difference(&want, &got)
                    ));
                }
            }
        }
    }
    let equal = pictures - faults.len();
    let numbers =
        format!("{equal} of {pictures} pictures of 192 x 192 equal in every byte and AOV");
    long::proved(name, "deferred: cpu = each device", &numbers);
    faults
}

/// The first pixel that differs, with both its values.
fn first_difference(a: &Rendered, b: &Rendered) -> String {
    let of = |r: &Rendered, at: usize| {
        let colour = r.rgba8[4 * at..4 * at + 4].to_vec();
        (
            colour,
            r.linear[at].map(f32::to_bits),
            r.triangle[at],
            r.draw[at],
            r.depth[at].to_bits(),
            r.fetches[at],
        )
    };
    let at = (0..a.triangle.len())
        .find(|&at| of(a, at) != of(b, at) || a.barycentric[at] != b.barycentric[at]);
    at.map_or_else(String::new, |at| {
        format!("pixel {at}: {:?} {:?}", of(a, at), of(b, at))
    })
}

/// Forward pictures that are further from the deferred ones than [`MOST_FLIP`].
fn far_apart(name: &str, built: &Built, contexts: &[Context]) -> Vec<String> {
    let camera = camera(built, (30.0, 20.0), 512);
    let picture = picture(built, 2, Correspond::Inverse);
    let cpu = Renderer::cpu(picture.clone());
    let mut faults = Vec::new();
    for context in contexts {
        let forward = Renderer::forward(context, picture.clone()).unwrap();
        let means = [Output::Lit, Output::Unlit].map(|output| {
            let deferred = cpu.draw(&camera, &showing(output)).unwrap();
            flip(&deferred, &forward.draw(&camera, &showing(output)).unwrap())
        });
        let device = &context.info().name;
        let numbers = format!(
            "FLIP mean {:.5} lit, {:.5} unlit on {device}",
            means[0], means[1]
        );
        long::proved(name, "forward ~ deferred, 512 px", &numbers);
        if means.iter().any(|mean| *mean >= MOST_FLIP) {
            faults.push(numbers);
        }
    }
    faults
}
