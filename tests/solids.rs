//! Solid textures: one pattern in object space, whatever level it is seen on, and functions of the user's.

mod glb;
mod painted;
#[cfg(feature = "compile-shaders")]
mod render;

#[cfg(feature = "compile-shaders")]
use invertex::asset::Built;
use invertex::attribute::{Shown, ShownOptions, attributes_showing};
use invertex::render::{Camera, Correspond, Options, Projection, Rendered, stage_with};
#[cfg(feature = "compile-shaders")]
use invertex::render::{Picture, Renderer, subjects};
use invertex::scene::Scene;
use painted::pictures::*;

const SOLIDS: [&str; 5] = ["wood", "marble", "cellular", "checker3d", "volume"];

#[test]
fn a_solid_is_the_same_pattern_in_object_space_on_every_level() {
    let built = built();
    let mesh = &built.scene.meshes[0];
    // Bounds: -1..2.05 in x, the longest side; -1..1 in y and z.
    let middle = [(-1.0 + 2.05) / 2.0, 0.0, 0.0];
    let view = camera([0.5, 0.0, 0.0], 1.7, 160);
    let mut seen = 0;
    for level in [None, Some(0), Some(1), Some(2)] {
        let image = drawn(picture(&built, level, "checker3d"), &view, &raw());
        for k in covered(&image) {
            let p = position(mesh, &image, k);
            let cells = [0, 1, 2].map(|i| (p[i] - middle[i]) / 3.05 * 8.0);
            if cells.iter().any(|c| (c - c.round()).abs() < 1e-4) {
                continue;
            }
            let light = cells.map(|c| c.floor() as i64).iter().sum::<i64>() % 2 == 0;
            assert_eq!(
                image.linear[k][0],
                if light { 0.8 } else { 0.05 },
                "{level:?} {p:?}"
            );
            seen += 1;
        }
    }
    assert!(seen > 20_000, "{seen}");
}

/// What a point of the reference is told by: triangle and barycentrics, to the bit.
fn point(image: &Rendered, k: usize) -> (u32, [u32; 2]) {
    (image.triangle[k], image.barycentric[k].map(f32::to_bits))
}

#[test]
fn solids_have_the_same_bytes_at_shared_points_of_all_levels() {
    // Flat, so that levels differ in their triangles and not in their points; and seen from so near that a pixel is about a
    // step of the grid of queries, so that levels meet in the same points.
    let sheet = Scene::from_bytes("sheet.glb", &painted::sheet(24), None).unwrap();
    let built = built_of(sheet);
    let level_of = |k: usize| built.meshes[0].lods[k].triangles.len();
    assert!(level_of(1) < level_of(0) && level_of(0) < 2 * 24 * 24);
    let framed = |centre, radius| {
        Camera::framed(centre, radius, 0.0, 0.0, Projection::Orthographic, 128, 128).unwrap()
    };
    let near = framed([0.137, 0.211, 0.0], 1e-6);
    for solid in SOLIDS {
        let at = |level, view: &Camera| drawn(picture(&built, level, solid), view, &raw());
        let mut known = std::collections::HashMap::new();
        let mut met = 0;
        for level in [Some(0), Some(1), Some(2)] {
            let image = at(level, &near);
            let before = known.clone();
            for k in covered(&image) {
                let colour = image.linear[k].map(f32::to_bits);
                met += u32::from(before.contains_key(&point(&image, k)));
                assert_eq!(
                    *known.entry(point(&image, k)).or_insert(colour),
                    colour,
                    "{solid} {level:?}"
                );
            }
        }
        assert!(met > 200, "{solid}: {met} shared points of {}", known.len());
    }
    // The reference drawn as it is has barycentrics of its own rounding: 8 bits show hardly any of it.
    let far = framed([0.0; 3], 1.2);
    for solid in SOLIDS {
        let at = |level, options: &Options| drawn(picture(&built, level, solid), &far, options);
        let reference = at(None, &raw());
        let through = at(Some(0), &raw());
        let pixels = |image: &Rendered| image.rgba8.as_chunks::<4>().0.to_vec();
        let both = pixels(&through).into_iter().zip(pixels(&reference));
        let apart = both.filter(|(a, b)| a != b).count();
        assert!(apart <= 24, "{solid}: {apart} pixels differ");
        let later = at(None, &Options { time: 1.0, ..raw() });
        assert!(
            solid == "volume" || later.rgba8 != reference.rgba8,
            "{solid} moves"
        );
    }
}

#[test]
fn a_solid_that_is_told_to_stand_still_does() {
    let sheet = Scene::from_bytes("sheet.glb", &painted::sheet(8), None).unwrap();
    let view = Camera::framed([0.0; 3], 1.2, 0.0, 0.0, Projection::Orthographic, 48, 48).unwrap();
    let at = |still: bool, time: f32| {
        let options = ShownOptions { still, ..options() };
        let shown = Shown::new(&sheet, &"marble".parse().unwrap(), &options, &|_, _| ()).unwrap();
        let (attributes, _) = attributes_showing(&sheet, false, &shown).unwrap();
        let reference = Correspond::Reference;
        let picture = stage_with(attributes, &sheet, &[], reference, &sheet.rest()).unwrap();
        drawn(picture, &view, &Options { time, ..raw() }).rgba8
    };
    assert_eq!(at(true, 0.0), at(true, 1.0));
    assert_eq!(at(true, 0.0), at(false, 0.0));
    assert_ne!(at(false, 0.0), at(false, 1.0));
}

/// A function that says where it is asked.
#[cfg(feature = "compile-shaders")]
const WHERE: &str = "vec3 igt_procedural(vec3 position, vec3 normal, float time) {\n\
                     \x20   return vec3(position.xy * 0.25 + 0.5, normal.z * 0.25 + 0.25 + time);\n}\n";

#[cfg(feature = "compile-shaders")]
fn showing(built: &Built, level: usize, text: &str) -> Picture {
    let options = ShownOptions {
        procedural: Some(invertex::attribute::Procedural {
            name: "where.glsl".into(),
            text: text.into(),
        }),
        ..options()
    };
    let scene = &built.scene;
    let shown = Shown::new(scene, &"procedural".parse().unwrap(), &options, &|_, _| ()).unwrap();
    let (attributes, _) = attributes_showing(scene, true, &shown).unwrap();
    let subjects = subjects(built, level);
    stage_with(
        attributes,
        scene,
        &subjects,
        Correspond::Inverse,
        &scene.rest(),
    )
    .unwrap()
}

#[test]
#[cfg(feature = "compile-shaders")]
fn a_users_function_gets_points_of_the_reference_on_every_level_and_device() {
    let built = built();
    let mesh = &built.scene.meshes[0];
    let view = camera([0.5, 0.0, 0.0], 1.7, 64);
    let options = Options {
        time: 0.125,
        ..raw()
    };
    for context in render::contexts() {
        let deferred = Renderer::on(&context, showing(&built, 2, WHERE)).unwrap();
        let forward = Renderer::forward(&context, showing(&built, 2, WHERE)).unwrap();
        for renderer in [deferred, forward] {
            let image = renderer.draw(&view, &options).unwrap();
            assert!(image.covered_pixels > 1000);
            for k in covered(&image) {
                let p = position(mesh, &image, k);
                let z = at_point(mesh, &image, k, |v| mesh.normals[v][2]);
                let got = image.linear[k];
                assert!((f64::from(got[0]) - p[0] * 0.25 - 0.5).abs() < 1e-5);
                assert!((f64::from(got[1]) - p[1] * 0.25 - 0.5).abs() < 1e-5);
                assert!((got[2] - z * 0.25 - 0.375).abs() < 0.02);
            }
        }
        let broken = "vec3 igt_procedural(vec3 p, vec3 n, float t) {\n\n  return colour;\n}";
        let error = Renderer::on(&context, showing(&built, 1, broken))
            .err()
            .unwrap();
        let message = error.to_string();
        assert!(
            message.contains("where.glsl:3: error: 'colour'"),
            "{message}"
        );
        let greedy = format!(
            "layout(binding = 77) buffer B {{ float x; }} b;\n{}",
            WHERE.replace("+ time", "+ b.x")
        );
        let error = Renderer::on(&context, showing(&built, 1, &greedy))
            .unwrap()
            .draw(&view, &raw());
        assert!(error.unwrap_err().to_string().contains("binding 77"));
        assert_eq!(context.validation_messages(), Vec::<String>::new());
    }
    let cpu = Renderer::cpu(showing(&built, 1, WHERE)).draw(&view, &raw());
    let message = cpu.unwrap_err().to_string();
    assert!(
        message.starts_with("--procedural") && message.contains("device"),
        "{message}"
    );
}
