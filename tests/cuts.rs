//! Cuts of built models on the screen: no detail of the reference stands farther from its place than the limit; written and
//! read again they are the same; one mesh in two places gets one cut that will do for both.

mod cli_support;
mod glb;
mod unpromised;

use cli_support::Ball;
use glam::{DVec3, DVec4};
use invertex::asset::{self, BuildSettings, Built, Multiresolution, Processor, build};
use invertex::lod::multiresolution::{Limits, Memory};
use invertex::render::{
    Camera, Correspond, Cuts, Cutter, Options, Output, Projection, Rendered, Renderer,
    reference_sphere, stage,
};
use invertex::scene::Scene;
use unpromised::Unpromised;

fn built(file: &str, bytes: &[u8], primary: &str) -> Built {
    let settings = BuildSettings {
        primary: primary.parse().unwrap(),
        lods: vec![0.3],
        multiresolution: Multiresolution::Geometry,
        ..BuildSettings::default()
    };
    let scene = Scene::from_bytes(file, bytes, None).unwrap();
    build(scene, &settings, Processor::Cpu, &()).unwrap().built
}

fn ball(rings: u32, primary: &str) -> Built {
    let ball = Ball {
        rings,
        ..Ball::default()
    };
    built("ball.glb", &ball.glb(), primary)
}

/// The `i`th of views from all around, near and far.
fn camera(built: &Built, i: u32, side: u32) -> Camera {
    let (centre, radius) = reference_sphere(&built.scene).unwrap();
    let turn = f64::from(i) * 137.5;
    let angles = [turn % 360.0, (f64::from(i) * 53.0) % 160.0 - 80.0];
    let distance = 0.6 * 1.09f64.powi((i % 40) as i32);
    let projection = match i % 4 {
        0 => Projection::Orthographic,
        _ => Projection::Perspective,
    };
    Camera::framed_from(distance, centre, radius, angles, projection, [side, side]).unwrap()
}

fn drawn(built: &Built, cutter: &Cutter, cuts: &Cuts, camera: &Camera) -> Rendered {
    let subjects = cutter.subjects(cuts, 1);
    let (picture, _) = stage(&built.scene, &subjects, Correspond::Inverse, false).unwrap();
    let options = Options {
        output: Output::Unlit,
        ..Options::default()
    };
    Renderer::cpu(picture).draw(camera, &options).unwrap()
}

/// What stands how far from its place: pixels that were measured, and the worst of them, in pixels. Points that turn their
/// backs to the eye are left out, and what lies beyond a rim or in a fold: nothing is said of them.
fn displaced(
    (built, unpromised): (&Built, &[Unpromised]),
    camera: &Camera,
    image: &Rendered,
) -> (usize, f64) {
    let instances = built.scene.instances();
    let eye = camera.view.inverse().transform_point3(DVec3::ZERO);
    let perspective = camera.projection.z_axis.w != 0.0;
    let back = camera.view.inverse().transform_vector3(DVec3::Z);
    let (mut measured, mut worst) = (0, 0.0f64);
    for (k, (&triangle, b)) in image.triangle.iter().zip(&image.barycentric).enumerate() {
        let Some(instance) = instances.get(image.draw[k] as usize) else {
            continue;
        };
        let unpromised = &unpromised[instance.mesh];
        if unpromised.is_on_rim(triangle, *b) || unpromised.folds.contains(&triangle) {
            continue;
        }
        let corners = built.scene.meshes[instance.mesh].corners(triangle as usize);
        let world = |p: [f32; 3]| {
            instance
                .world
                .transform_point3(DVec3::from(p.map(f64::from)))
        };
        let [p, q, r] = corners.map(world);
        let (b1, b2) = (f64::from(b[0]), f64::from(b[1]));
        let point = p * (1.0 - b1 - b2) + q * b1 + r * b2;
        let to_eye = if perspective { eye - point } else { back };
        if (q - p).cross(r - p).dot(to_eye) <= 0.0 {
            continue;
        }
        let clip: DVec4 = camera.projection * camera.view * point.extend(1.0);
        let at = clip.truncate() / clip.w;
        let size = [f64::from(camera.width), f64::from(camera.height)];
        let x = (at.x * 0.5 + 0.5) * size[0] - (k % camera.width as usize) as f64 - 0.5;
        let y = (at.y * 0.5 + 0.5) * size[1] - (k / camera.width as usize) as f64 - 0.5;
        measured += 1;
        worst = worst.max(x.hypot(y));
    }
    (measured, worst)
}

/// Corners are rounded to a sixteenth of a pixel: a point moves by half of one each way, at most.
const RASTER: f64 = 0.045;

#[test]
fn no_detail_stands_farther_from_its_place_than_the_limit() {
    for primary in ["sphere", "uv0"] {
        let built = ball(40, primary);
        within_limits(&built);
    }
}

fn within_limits(built: &Built) {
    let mut cutter = Cutter::new(built).unwrap();
    let unpromised = unpromised::of(built);
    let (mut pixels, mut nearest, mut sizes) = (0, 0.0f64, Vec::new());
    for i in 0..200 {
        let camera = camera(built, i, 64);
        let limits = Limits {
            pixels: [0.5, 2.0][(i / 4 % 2) as usize],
            ..Limits::default()
        };
        let cuts = cutter.cut(&camera, &limits).unwrap();
        let image = drawn(built, &cutter, &cuts, &camera);
        let (measured, worst) = displaced((built, &unpromised), &camera, &image);
        assert!(
            worst <= limits.pixels + RASTER,
            "view {i}: {worst} of {}",
            limits.pixels
        );
        pixels += measured;
        nearest = nearest.max(worst / limits.pixels);
        sizes.push(cuts.triangles);
    }
    assert!(pixels > 100_000, "{pixels}");
    // The bound is no idle one, and cuts are not all of one size.
    assert!(nearest > 0.5, "{nearest}");
    assert!(
        sizes.iter().min().unwrap() * 8 < *sizes.iter().max().unwrap(),
        "{sizes:?}"
    );
}

#[test]
fn a_limit_that_is_not_kept_is_seen() {
    // The negative control of the test above: the cut for half the picture's size, seen whole.
    let built = ball(40, "uv0");
    let mut cutter = Cutter::new(&built).unwrap();
    let unpromised = unpromised::of(&built);
    let found = (0..20).any(|i| {
        let far = camera(&built, i, 24);
        let cuts = cutter.cut(&far, &Limits::default()).unwrap();
        let near = camera(&built, i, 96);
        let image = drawn(&built, &cutter, &cuts, &near);
        displaced((&built, &unpromised), &near, &image).1 > 0.5 + RASTER
    });
    assert!(found);
}

#[test]
fn written_and_read_again_the_cuts_are_the_same() {
    let built = ball(40, "uv0");
    let bytes = asset::to_bytes(&built).unwrap();
    let back = asset::read("ball", &bytes).unwrap();
    assert!(back.meshes[0].hierarchy == built.meshes[0].hierarchy);
    assert!(asset::to_bytes(&back).unwrap() == bytes);
    let camera = camera(&built, 9, 64);
    let cut = |built: &Built| {
        let hierarchy = built.meshes[0].hierarchy.as_ref().unwrap();
        let seen = invertex::lod::multiresolution::Seen {
            object_to_view: camera.view,
            projection: camera.projection,
            size: [64, 64],
            double_sided: true,
        };
        let view = hierarchy.model.view(&seen, &Limits::default()).unwrap();
        hierarchy.model.select(&[view], &mut Memory::default())
    };
    assert_eq!(cut(&built), cut(&back));
}

#[test]
fn what_a_file_says_of_steps_is_checked() {
    let bytes = asset::to_bytes(&ball(12, "sphere")).unwrap();
    let document = Scene::from_bytes("ball", &bytes, None).unwrap().document;
    let json = &document.json["meshes"][0]["extensions"][asset::EXTENSION]["hierarchy"];
    let view = |what: &str| {
        let view = &document.json["bufferViews"][json[what].as_u64().unwrap() as usize];
        let first = view["byteOffset"].as_u64().unwrap() as usize;
        first..first + view["byteLength"].as_u64().unwrap() as usize
    };
    let binary = bytes.len() - document.binary.len().next_multiple_of(4);
    let broken = |what: &str, at: usize, value: u32| {
        let mut bytes = bytes.clone();
        let first = binary + view(what).start + at * 4;
        bytes[first..first + 4].copy_from_slice(&value.to_le_bytes());
        let error = asset::read("ball", &bytes).unwrap_err();
        assert_eq!(error.exit_code(), 3);
        error.to_string()
    };
    assert!(broken("steps", 0, u32::MAX).contains("no such place"));
    assert!(broken("steps", 1, 7).contains("collapse 0"));
    assert!(broken("deviations", 30, f32::NAN.to_bits()).contains("not a distance"));
    assert!(broken("deviations", 31, (-1.0f32).to_bits()).contains("not a distance"));
}
