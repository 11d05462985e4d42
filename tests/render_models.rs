//! Shared models: with the reference as its own LoD the inverse texture finds the very triangle the reference draws.

mod render;

use invertex::igt::Layout;
use invertex::param::PrimaryRequest;
use invertex::render::{Camera, Correspond, Options, Projection, Rendered, Renderer, stage};
use invertex::scene::Scene;
use render::model::{self, Built};

/// Peak signal-to-noise ratio of two images, in dB.
fn psnr(a: &Rendered, b: &Rendered) -> f64 {
    let squared: f64 = a
        .rgba8
        .iter()
        .zip(&b.rgba8)
        .map(|(&p, &q)| (f64::from(p) - f64::from(q)).powi(2))
        .sum();
    10.0 * (255.0f64.powi(2) * a.rgba8.len() as f64 / squared.max(1e-9)).log10()
}

fn draw(built: &Built, level: usize, correspond: Correspond, camera: &Camera) -> Rendered {
    let (picture, warnings) =
        stage(&built.scene, &built.subjects(level), correspond, true).unwrap();
    assert_eq!(warnings, Vec::<String>::new());
    Renderer::cpu(picture)
        .draw(camera, &Options::default())
        .unwrap()
}

/// Pixels whose triangle differs although the sample is well inside; and whose colour differs by more than one step.
fn faults(reference: &Rendered, level_zero: &Rendered) -> (usize, usize) {
    let mut out = (0, 0);
    for at in 0..reference.triangle.len() {
        let [b1, b2] = reference.barycentric[at];
        if b1.min(b2).min(1.0 - b1 - b2) <= 1e-3 || reference.triangle[at] == u32::MAX {
            continue;
        }
        let step = |i: usize| reference.rgba8[at * 4 + i].abs_diff(level_zero.rgba8[at * 4 + i]);
        out.0 += usize::from(reference.triangle[at] != level_zero.triangle[at]);
        out.1 += usize::from((0..4).any(|i| step(i) > 1));
    }
    out
}

fn check(name: &str, request: &str) {
    let Some(path) = model::path(name) else {
        return;
    };
    let scene = Scene::load(&path).unwrap();
    let built = model::build(
        scene,
        &request.parse::<PrimaryRequest>().unwrap(),
        128,
        Layout::Packed,
        &[0.1],
    );
    let (picture, _) = stage(&built.scene, &[], Correspond::Reference, false).unwrap();
    let (centre, radius) = picture.bounding_sphere();
    for (azimuth, elevation) in [(30.0, 20.0), (200.0, -35.0)] {
        let camera = Camera::framed(
            centre,
            radius,
            azimuth,
            elevation,
            Projection::Perspective,
            256,
            256,
        )
        .unwrap();
        let reference = draw(&built, 0, Correspond::Reference, &camera);
        let zero = draw(&built, 0, Correspond::Inverse, &camera);
        let db = psnr(&reference, &zero);
        let (triangles, colours) = faults(&reference, &zero);
        println!("{name}: {triangles} triangles, {colours} colours, PSNR {db:.1} dB");
        assert_eq!((triangles, colours), (0, 0), "{name}");
        assert!(db > 60.0, "{name}: {db}");
        // A coarse LoD: no pixel without a reference point, and a picture that is close, through tables.
        let coarse = draw(&built, 1, Correspond::Inverse, &camera);
        let unknown = coarse
            .triangle
            .iter()
            .zip(&coarse.draw)
            .filter(|(t, d)| **t == u32::MAX && **d != u32::MAX);
        assert_eq!(unknown.count(), 0, "{name}");
        assert!(
            coarse.mean_fetches > 1.0 && psnr(&reference, &coarse) > 15.0,
            "{name}"
        );
        // Negative control: the faults are seen where there are some.
        assert!(faults(&reference, &coarse).0 > 0, "{name}");
    }
}

#[test]
fn spot_by_its_charts() {
    check("spot/spot.glb", "uv0");
}

#[test]
fn the_boat_by_a_sphere() {
    check("boat/boat.glb", "sphere");
}

#[test]
fn the_fox_at_rest() {
    check("fox/fox.glb", "uv0");
}
