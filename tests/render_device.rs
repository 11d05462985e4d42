//! The deferred path on every device here: the same bytes as on the CPU, and no complaint from validation.
#![cfg(feature = "gpu")]

mod render;

use glam::{DMat4, DVec3};
use invertex::igt::Layout;
use invertex::mesh::shapes;
use invertex::render::{Camera, Filter, Light, Options, Output, Picture, Projection, Renderer};
use render::{camera, contexts, differences, inverse, picture, tangents};

fn outputs() -> Vec<Options> {
    let light = Light {
        direction: Some([0.3, 1.0, -0.2]),
        ..Light::default()
    };
    vec![
        Options {
            light,
            wireframe: true,
            ..Options::default()
        },
        Options {
            output: Output::Unlit,
            samples: 4,
            ..Options::default()
        },
        Options {
            filter: Filter::Five,
            ..Options::default()
        },
        Options {
            filter: Filter::Footprint,
            ..Options::default()
        },
        Options {
            output: Output::Normals,
            ..Options::default()
        },
        Options {
            output: Output::Fetches,
            fetches_top: 9,
            ..Options::default()
        },
    ]
}

/// References: several draws, a mirrored one, the eye inside, triangles that cross the image's border, nothing.
fn references() -> Vec<(&'static str, Picture, Camera)> {
    let ball = tangents(shapes::icosphere(3));
    let tube = tangents(shapes::tube(24, 9));
    let far = DMat4::from_translation(DVec3::new(0.9, 0.2, -0.4));
    let mirrored = DMat4::from_scale(DVec3::new(-0.6, 0.9, 0.5)) * DMat4::from_rotation_x(0.4);
    let several = || picture(&[(&ball, DMat4::IDENTITY), (&tube, far), (&ball, mirrored)]);
    let mut out = Vec::new();
    for (name, azimuth, elevation, width, height) in [
        ("several", 30.0, 20.0, 131, 93),
        ("above", 10.0, 90.0, 48, 48),
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
        67,
        35,
    )
    .unwrap();
    out.push(("inside", several(), inside));
    let parallel = Camera::framed(
        [0.0; 3],
        0.4,
        200.0,
        -30.0,
        Projection::Orthographic,
        70,
        47,
    )
    .unwrap();
    out.push(("parallel, wider than the image", several(), parallel));
    let empty = picture(&[]);
    let view = camera(&empty, 0.0, 0.0, 33, 9);
    out.push(("nothing", empty, view));
    out
}

/// LoDs through inverse textures: every kind of projection line, both layouts, several tables in one picture.
fn inverses() -> Vec<(&'static str, Picture, Camera)> {
    let mut out = Vec::new();
    for (name, layout) in [("packed", Layout::Packed), ("classic", Layout::Classic)] {
        let sphere = inverse::build(tangents(shapes::icosphere(3)), "sphere", layout, 0.2);
        let tube = inverse::build(tangents(shapes::tube(24, 9)), "cylinder:z", layout, 0.3);
        let flat = inverse::build(tangents(shapes::grid(12)), "uv0", layout, 0.2);
        let picture = inverse::picture(&[&sphere, &tube, &flat]);
        let camera = camera(&picture, 25.0, 30.0, 140, 70);
        out.push((name, picture, camera));
    }
    out
}

#[test]
fn every_device_draws_the_bytes_that_the_cpu_draws() {
    let mut drawn_through_tables = 0.0;
    for context in contexts() {
        for (name, picture, camera) in references().into_iter().chain(inverses()) {
            let cpu = Renderer::cpu(picture.clone());
            let device = Renderer::on(&context, picture).unwrap();
            for options in outputs() {
                let want = cpu.draw(&camera, &options).unwrap();
                let got = device.draw(&camera, &options).unwrap();
                let what = format!("{} {name} {options:?}", context.info().name);
                assert_eq!(differences(&want, &got), [0; 6], "{what}");
                drawn_through_tables += want.mean_fetches;
            }
            let again = |r: &Renderer| r.draw(&camera, &outputs()[0]).unwrap();
            assert_eq!(
                differences(&again(&device), &again(&device)),
                [0; 6],
                "{name}: run to run"
            );
        }
        assert!(drawn_through_tables > 0.0);
        assert_eq!(context.validation_messages(), Vec::<String>::new());
    }
}

#[test]
fn a_picture_too_large_for_a_buffer_is_drawn_in_bands_without_a_seam() {
    let ball = tangents(shapes::icosphere(3));
    let picture = || picture(&[(&ball, DMat4::IDENTITY)]);
    // 192 MB of a device's 128.
    let view = camera(&picture(), 30.0, 20.0, 4096, 2048);
    let options = Options {
        output: Output::Normals,
        ..Options::default()
    };
    let cpu = Renderer::cpu(picture()).draw(&view, &options).unwrap();
    for x in (0..4096).step_by(61) {
        let column: Vec<usize> = (0..2048)
            .filter(|y| cpu.triangle[y * 4096 + x] != u32::MAX)
            .collect();
        if let (Some(first), Some(last)) = (column.first(), column.last()) {
            assert_eq!(last - first + 1, column.len(), "column {x} has a hole");
        }
    }
    for context in contexts() {
        let device = Renderer::on(&context, picture()).unwrap();
        let got = device.draw(&view, &options).unwrap();
        assert_eq!(differences(&cpu, &got), [0; 6], "{}", context.info().name);
    }
    // A picture of one band says the same as the first band's part of a larger one, up to a step of the pixel grid.
    let whole = camera(&picture(), 30.0, 20.0, 2048, 2048);
    let fine = Options {
        samples: 4,
        ..options
    };
    let small = Renderer::cpu(picture()).draw(&whole, &options).unwrap();
    let resolved = Renderer::cpu(picture()).draw(&whole, &fine).unwrap();
    let apart = small.triangle.iter().zip(&resolved.triangle);
    let apart = apart.filter(|(a, b)| a != b).count();
    assert!(apart < small.triangle.len() / 100, "{apart}");
}

#[test]
fn the_comparison_sees_one_changed_bit_and_one_moved_vertex() {
    let (name, picture, camera) = references().remove(0);
    let options = Options::default();
    let base = Renderer::cpu(picture).draw(&camera, &options).unwrap();
    assert_eq!(differences(&base, &base.clone()), [0; 6], "{name}");
    let mut ball = tangents(shapes::icosphere(3));
    ball.positions[7][1] += 0.05;
    let moved = render::picture(&[(&ball, DMat4::IDENTITY)]);
    let other = Renderer::cpu(moved).draw(&camera, &options).unwrap();
    assert!(differences(&base, &other)[..5].iter().all(|&d| d > 0));
    let mut changed = base.clone();
    changed.rgba8[4 * (93 / 2 * 131 + 65)] ^= 1;
    changed.depth[0] = f32::from_bits(changed.depth[0].to_bits() ^ 1);
    assert_eq!(differences(&base, &changed), [1, 0, 0, 1, 0, 0]);
}

#[test]
fn no_float_operation_of_the_deferred_path_may_be_contracted_or_reordered() {
    // SPIR-V: an arithmetic result without NoContraction is one that a driver may fuse. Ours all carry it.
    for pass in ["project.comp", "raster.vert", "raster.frag"] {
        let path = format!("{}/spirv/render_{pass}.spv", env!("CARGO_MANIFEST_DIR"));
        let bytes = std::fs::read(&path).unwrap();
        let (free, held) = float_operations(&bytes);
        assert!(held > 0, "{pass}");
        assert_eq!(
            free,
            0,
            "{pass}: {free} of {} float operations lack `precise`",
            free + held
        );
    }
}

/// Float additions, multiplications and the like of a SPIR-V module: without NoContraction, and with it.
fn float_operations(bytes: &[u8]) -> (usize, usize) {
    let words: Vec<u32> = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .map(|w| u32::from_le_bytes(*w))
        .collect();
    let (mut at, mut held, mut operations) = (5, std::collections::HashSet::new(), Vec::new());
    while at < words.len() {
        let (opcode, length) = (words[at] & 0xffff, (words[at] >> 16).max(1) as usize);
        match opcode {
            // OpDecorate target NoContraction
            71 if words[at + 2] == 42 => drop(held.insert(words[at + 1])),
            // OpFAdd, OpFSub, OpFMul, OpFDiv, OpVectorTimesScalar .. OpDot
            129 | 131 | 133 | 136 | 142..=148 => operations.push(words[at + 2]),
            _ => {}
        }
        at += length;
    }
    let with = operations.iter().filter(|id| held.contains(id)).count();
    (operations.len() - with, with)
}
