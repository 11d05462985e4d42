//! The deferred path on every device here: the same bytes as on the CPU, and no complaint from validation.
#![cfg(feature = "gpu")]

mod render;

use glam::{DMat4, DVec3};
use invertex::gpu::{Context, ContextOptions, DeviceChoice, devices};
use invertex::mesh::shapes;
use invertex::render::{Camera, Options, Output, Picture, Projection, Rendered, Renderer};
use render::{camera, picture, tangents};

/// A context for each usable device; says loudly where there is none.
fn contexts() -> Vec<Context> {
    let found = devices().unwrap_or_default();
    let usable = found.iter().filter(|d| d.usable);
    let out: Vec<Context> = usable
        .map(|d| {
            let device = DeviceChoice::Index(d.index);
            Context::new(&ContextOptions {
                device,
                validation: true,
            })
            .unwrap()
        })
        .collect();
    if out.is_empty() {
        eprintln!("SKIPPED: no usable Vulkan device");
    }
    out
}

/// How two images differ: pixels in colour, and values in each AOV, bit for bit.
fn differences(a: &Rendered, b: &Rendered) -> [usize; 5] {
    let pixels = a
        .rgba8
        .chunks(4)
        .zip(b.rgba8.chunks(4))
        .filter(|(p, q)| p != q)
        .count();
    let linear = a
        .linear
        .iter()
        .zip(&b.linear)
        .filter(|(p, q)| p.map(f32::to_bits) != q.map(f32::to_bits))
        .count();
    let triangles = a
        .triangle
        .iter()
        .zip(&b.triangle)
        .filter(|(p, q)| p != q)
        .count();
    let depth = a
        .depth
        .iter()
        .zip(&b.depth)
        .filter(|(p, q)| p.to_bits() != q.to_bits())
        .count();
    let inside = |p: &[f32; 2], q: &[f32; 2]| p.map(f32::to_bits) != q.map(f32::to_bits);
    let barycentric = a
        .barycentric
        .iter()
        .zip(&b.barycentric)
        .filter(|(p, q)| inside(p, q))
        .count();
    [pixels, linear, triangles, depth, barycentric]
}

fn outputs() -> Vec<Options> {
    [Output::Lit, Output::Unlit, Output::Normals, Output::Fetches]
        .into_iter()
        .flat_map(|output| {
            [false, true].map(|wireframe| Options {
                output,
                wireframe,
                ..Options::default()
            })
        })
        .collect()
}

fn pictures() -> Vec<(&'static str, Picture, Camera)> {
    let ball = tangents(shapes::icosphere(4));
    let tube = tangents(shapes::tube(24, 9));
    let far = DMat4::from_translation(DVec3::new(0.9, 0.2, -0.4));
    let mirrored = DMat4::from_scale(DVec3::new(-0.6, 0.9, 0.5)) * DMat4::from_rotation_x(0.4);
    let mut out = Vec::new();
    let several = || picture(&[(&ball, DMat4::IDENTITY), (&tube, far), (&ball, mirrored)]);
    for (name, azimuth, elevation, width, height) in [
        ("several", 30.0, 20.0, 201, 143),
        ("above", 10.0, 90.0, 64, 64),
        ("one pixel", 0.0, 0.0, 1, 1),
    ] {
        let picture = several();
        let camera = camera(&picture, azimuth, elevation, width, height);
        out.push((name, picture, camera));
    }
    let inside = Camera::framed(
        [0.1, 0.2, 0.1],
        0.3,
        70.0,
        10.0,
        Projection::Perspective,
        97,
        55,
    )
    .unwrap();
    out.push(("inside", several(), inside));
    let parallel = Camera::framed(
        [0.0; 3],
        0.4,
        200.0,
        -30.0,
        Projection::Orthographic,
        130,
        77,
    )
    .unwrap();
    out.push(("parallel, wider than the image", several(), parallel));
    let empty = picture(&[]);
    let view = camera(&empty, 0.0, 0.0, 33, 9);
    out.push(("nothing", empty, view));
    out
}

#[test]
fn every_device_draws_the_bytes_that_the_cpu_draws() {
    for context in contexts() {
        for (name, picture, camera) in pictures() {
            let cpu = Renderer::cpu(picture.clone());
            let device = Renderer::on(&context, picture).unwrap();
            for options in outputs() {
                let want = cpu.draw(&camera, &options).unwrap();
                let got = device.draw(&camera, &options).unwrap();
                let what = format!("{} {name} {options:?}", context.info().name);
                assert_eq!(differences(&want, &got), [0; 5], "{what}");
                assert_eq!(want.fetches, got.fetches, "{what}");
                assert_eq!(
                    device.draw(&camera, &options).unwrap().rgba8,
                    got.rgba8,
                    "{what}: run to run"
                );
            }
        }
        assert_eq!(context.validation_messages(), Vec::<String>::new());
    }
}

#[test]
fn the_comparison_sees_one_changed_texel_and_one_moved_vertex() {
    let (name, picture, camera) = pictures().remove(0);
    let options = Options::default();
    let base = Renderer::cpu(picture).draw(&camera, &options).unwrap();
    assert_eq!(differences(&base, &base.clone()), [0; 5], "{name}");
    let mut ball = tangents(shapes::icosphere(4));
    ball.positions[7][1] += 0.05;
    let moved = render::picture(&[(&ball, DMat4::IDENTITY)]);
    let other = Renderer::cpu(moved).draw(&camera, &options).unwrap();
    assert!(differences(&base, &other).iter().all(|&d| d > 0));
    let mut changed = base.clone();
    changed.rgba8[4 * (143 / 2 * 201 + 100)] ^= 1;
    assert_eq!(differences(&base, &changed), [1, 0, 0, 0, 0]);
}
