//! Attributes in place of base colour: the same bits on every processor, the value of the reference's own point whatever
//! level is drawn, and clear words about what is not there.

mod glb;
mod painted;
#[cfg(feature = "gpu")]
mod render;

use invertex::attribute::{OcclusionOptions, Shown, ShownOptions, attributes_showing};
#[cfg(feature = "gpu")]
use invertex::render::Renderer;
use invertex::render::{Camera, Correspond, Options, Output, Projection, Rendered, stage_with};
use painted::Painted;
use painted::pictures::*;
#[cfg(feature = "gpu")]
use render::{differences, flip};

/// All of them, several in a product where that takes nothing from any: pipelines are dear.
#[cfg(feature = "gpu")]
const ALL: [&str; 11] = [
    "emissive*base-color",
    "normal-map*occlusion-map*normal",
    "metallic-roughness",
    "flat:color*occlusion*_HEAT:5..35*flat:_TAG",
    "triangle-color*material*part",
    "wood",
    "marble",
    "cellular",
    "checker3d",
    "volume",
    "color*occlusion*base-color*_TAG",
];

/// Those that are drawn of the reference too, and by the forward path: one of each kind.
#[cfg(feature = "gpu")]
const OF_EACH_KIND: [&str; 4] = [
    "triangle-color*material*part",
    "wood",
    "volume",
    "color*occlusion*base-color*_TAG",
];

#[test]
#[cfg(feature = "gpu")]
fn every_attribute_has_the_same_bits_on_every_processor_and_looks_the_same_forward() {
    let built = built();
    let view = camera([0.5, 0.0, 0.0], 1.7, 48);
    let later = Options {
        time: 1.375,
        ..raw()
    };
    for context in render::contexts() {
        let name = &context.info().name;
        let same = |attribute: &str, level, options: &Options| {
            let here = drawn(picture(&built, level, attribute), &view, options);
            let there = Renderer::on(&context, picture(&built, level, attribute)).unwrap();
            let there = there.draw(&view, options).unwrap();
            let differing = differences(&here, &there);
            assert_eq!(differing, [0; 6], "{attribute} {level:?} {name}");
            here
        };
        for attribute in ALL {
            let lit = same(attribute, Some(2), &Options::default());
            if !OF_EACH_KIND.contains(&attribute) {
                continue;
            }
            same(attribute, None, &later);
            let forward = Renderer::forward(&context, picture(&built, Some(2), attribute)).unwrap();
            let forward = forward.draw(&view, &Options::default()).unwrap();
            let flip = flip(&lit, &forward);
            assert!(flip < 0.02, "{attribute} {name}: FLIP {flip}");
        }
        assert_eq!(context.validation_messages(), Vec::<String>::new());
    }
}

#[test]
fn vertex_attributes_are_those_of_the_reference_point_on_every_level() {
    let built = built();
    let mesh = &built.scene.meshes[0];
    let heat = &mesh
        .custom
        .iter()
        .find(|c| c.name == "_HEAT")
        .unwrap()
        .values;
    let view = camera([0.5, 0.0, 0.0], 1.7, 96);
    for level in [None, Some(0), Some(1), Some(2)] {
        let image = drawn(picture(&built, level, "_HEAT"), &view, &raw());
        let ranged = drawn(picture(&built, level, "_HEAT:5..35"), &view, &raw());
        let flat = drawn(picture(&built, level, "flat:_HEAT"), &view, &raw());
        for k in covered(&image) {
            let want = at_point(mesh, &image, k, |v| heat[v]);
            assert!((image.linear[k][0] - want).abs() < 1e-4, "{level:?} {k}");
            assert!((ranged.linear[k][2] - (want - 5.0) / 30.0).abs() < 1e-5);
            let first = mesh.triangles[image.triangle[k] as usize][0];
            assert_eq!(flat.linear[k][1], heat[first as usize]);
        }
        let tags = drawn(picture(&built, level, "_TAG"), &view, &raw());
        let k = covered(&tags)[700];
        let want = at_point(mesh, &tags, k, |v| (v % (13 * 25) % 256) as f32 / 255.0);
        assert!((tags.linear[k][0] - want).abs() < 1e-5 && tags.linear[k][2] == 0.0);
    }
}

/// Pixels whose colour is not that of their triangle as every other pixel of that triangle shows it.
fn not_flat(image: &Rendered) -> usize {
    let mut known = std::collections::HashMap::new();
    let pixels = image.rgba8.as_chunks::<4>().0;
    let mut other = |&k: &usize| *known.entry(image.triangle[k]).or_insert(pixels[k]) != pixels[k];
    covered(image).iter().filter(|&k| other(k)).count()
}

#[test]
fn flat_attributes_keep_sharp_boundaries_at_any_magnification() {
    let built = built();
    let mesh = &built.scene.meshes[0];
    let unlit = Options {
        output: Output::Unlit,
        ..Options::default()
    };
    // On a LoD's surface, before a vertex of the reference, where six triangles meet.
    let vertex = mesh.positions[5 * 25 + 4];
    for zoom in [1.0, 30.0, 1000.0] {
        let view = camera(vertex.map(f64::from), 1.0 / zoom, 96);
        // Nearer than the LoD's deviation the reference's own geometry stands there; it asks the tables all the same.
        let level = Some(if zoom > 100.0 { 0 } else { 2 });
        for attribute in [
            "triangle-color",
            "flat:color",
            "flat:_HEAT:5..35",
            "material",
            "part",
        ] {
            let image = drawn(picture(&built, level, attribute), &view, &unlit);
            assert!(image.covered_pixels > 4000, "{attribute} x{zoom}");
            assert_eq!(not_flat(&image), 0, "{attribute} x{zoom}");
        }
        let smooth = drawn(picture(&built, level, "color"), &view, &unlit);
        assert!(
            zoom > 30.0 || not_flat(&smooth) > 1000,
            "interpolated colours are not flat"
        );
        let ids = drawn(picture(&built, level, "triangle-color"), &view, &unlit);
        let colours = |image: &Rendered| {
            let all = image.rgba8.as_chunks::<4>().0.iter().filter(|p| p[3] != 0);
            all.collect::<std::collections::HashSet<_>>().len()
        };
        let triangles: std::collections::HashSet<u32> =
            covered(&ids).iter().map(|&k| ids.triangle[k]).collect();
        assert!(
            zoom < 2.0 || (2..40).contains(&triangles.len()),
            "{}",
            triangles.len()
        );
        // Of hundreds of colours a few are one after rounding to 8 bits.
        let apart = colours(&ids);
        assert!(apart <= triangles.len(), "x{zoom}: no blends");
        assert!(
            apart >= triangles.len() - triangles.len() / 50,
            "x{zoom}: no two alike"
        );
    }
}

#[test]
fn parts_and_materials_are_told_apart() {
    let built = built();
    let view = camera([0.5, 0.0, 0.0], 1.7, 64);
    for attribute in ["part", "material"] {
        let image = drawn(picture(&built, Some(1), attribute), &view, &raw());
        let mesh = &built.scene.meshes[0];
        let of = |second: bool| {
            let mine = |k: &usize| {
                let triangle = image.triangle[*k] as usize;
                (mesh.triangle_material[triangle] == 1) == second
            };
            let all = covered(&image).into_iter().filter(mine);
            let colours = all.map(|k| image.linear[k].map(f32::to_bits));
            colours.collect::<std::collections::HashSet<_>>()
        };
        assert_eq!((of(false).len(), of(true).len()), (1, 1), "{attribute}");
        assert!(of(false).is_disjoint(&of(true)));
    }
}

#[test]
fn occlusion_is_one_in_the_open_and_less_between_the_balls() {
    let scene = scene(Painted::default());
    let mesh = &scene.meshes[0];
    let shown = Shown::new(
        &scene,
        &"occlusion".parse().unwrap(),
        &options(),
        &|_, _| (),
    )
    .unwrap();
    let (attributes, _) = attributes_showing(&scene, false, &shown).unwrap();
    let picture = stage_with(
        attributes,
        &scene,
        &[],
        Correspond::Reference,
        &scene.rest(),
    )
    .unwrap();
    let right = Camera::framed(
        [0.5, 0.0, 0.0],
        1.7,
        40.0,
        0.0,
        Projection::Perspective,
        128,
        128,
    );
    let image = drawn(picture, &right.unwrap(), &raw());
    let (mut open, mut hidden) = (f32::NEG_INFINITY, f32::INFINITY);
    for k in covered(&image) {
        let x = at_point(mesh, &image, k, |v| mesh.positions[v][0]);
        let value = image.linear[k][0];
        if x < -0.1 {
            assert!(
                value > 0.999_999,
                "nothing stands before the far half of the large ball"
            );
        }
        open = open.max(value);
        hidden = hidden.min(value);
    }
    assert!(
        (open - 1.0).abs() < 1e-6 && (0.2..0.8).contains(&hidden),
        "{open} {hidden}"
    );
    let mut steps = std::cell::Cell::new(0);
    let heard = |done: usize, of: usize| steps.set(steps.get() + usize::from(done <= of));
    Shown::new(&scene, &"occlusion".parse().unwrap(), &options(), &heard).unwrap();
    assert!(*steps.get_mut() >= 2);
}

#[test]
fn what_is_not_there_is_named_with_what_is() {
    let bare = Painted {
        uv: false,
        colors: false,
        custom: false,
        maps: false,
        ..Painted::default()
    };
    let with_uv = Painted { uv: true, ..bare };
    for (painted, attribute, words) in [
        (with_uv, "color", "COLOR_0"),
        (with_uv, "_HEAT", "no custom attributes"),
        (with_uv, "procedural", "--procedural FILE.glsl"),
        (Painted::default(), "_HEAP", "_HEAT, _TAG"),
        (
            with_uv,
            "normal-map",
            "no material of the model has a normal map",
        ),
        (with_uv, "occlusion-map", "occlusion map"),
        (
            bare,
            "base-color",
            "mesh \"balls\": has no TEXCOORD_0, which the base colour texture of material \"painted\"",
        ),
    ] {
        let scene = scene(painted);
        let error = Shown::new(&scene, &attribute.parse().unwrap(), &options(), &|_, _| ());
        let message = error.unwrap_err().to_string();
        assert!(message.contains(words), "{attribute}: {message}");
    }
    for (samples, reach, option) in [
        (0, 1.0, "--occlusion-samples"),
        (8, 0.0, "--occlusion-reach"),
        (8, f32::NAN, "--occlusion-reach"),
    ] {
        let options = ShownOptions {
            occlusion: OcclusionOptions { samples, reach },
            ..options()
        };
        let error = Shown::new(
            &scene(bare),
            &"occlusion".parse().unwrap(),
            &options,
            &|_, _| (),
        );
        assert!(error.unwrap_err().to_string().starts_with(option));
    }
    let (_, warnings) = invertex::attribute::attributes_of(&scene(bare), true).unwrap();
    assert!(
        warnings.iter().any(|w| w.contains("has no TEXCOORD_0")),
        "{warnings:?}"
    );
}
