//! The conventionally baked LoD: it must look like the reference nearly as the inverse texture does, or it would be no
//! opponent; and it must be the same triangles, so that only the way to the colours is compared.

use invertex::asset::{self, BuildSettings, Built, Processor};
use invertex::attribute::attributes_of;
use invertex::measure::{self, Region, compare};
use invertex::recover::stage_baked;
use invertex::render::{
    Camera, Correspond, Options, Output, Picture, Projection, Rendered, Renderer, reference_sphere,
    stage, subjects,
};
use invertex::scene::Scene;

const AMPHORA: &[u8] = include_bytes!("../assets/amphora.glb");

fn amphora() -> Built {
    let scene = Scene::from_bytes("amphora.glb", AMPHORA, None).unwrap();
    let settings = BuildSettings {
        lods: vec![0.05],
        hash: Some(128),
        ..BuildSettings::default()
    };
    asset::build(scene, &settings, Processor::Cpu, &())
        .unwrap()
        .built
}

/// Base colour: metalness and roughness are not baked, so lit pictures differ by more than the way to the texels.
fn draw(built: &Built, picture: Picture) -> Rendered {
    let (centre, radius) = reference_sphere(&built.scene).unwrap();
    let projection = Projection::Perspective;
    let camera = Camera::framed(centre, radius, 30.0, 20.0, projection, 256, 256).unwrap();
    Renderer::cpu(picture)
        .draw(
            &camera,
            &Options {
                output: Output::Unlit,
                ..Options::default()
            },
        )
        .unwrap()
}

/// Mean FLIP of the foreground.
fn flip(a: &Rendered, b: &Rendered) -> f64 {
    let picture = |r: &Rendered| measure::Picture {
        width: r.width,
        height: r.height,
        rgba: r.rgba8.as_chunks::<4>().0.to_vec(),
        has_alpha: true,
    };
    let names = ["a", "b"];
    compare(&picture(a), &picture(b), Region::Foreground, names)
        .unwrap()
        .flip_mean
}

#[test]
fn a_baked_lod_is_the_same_lod_and_looks_like_the_reference() {
    let built = amphora();
    let (attributes, warnings) = attributes_of(&built.scene, true).unwrap();
    assert_eq!(warnings, Vec::<String>::new());
    let lods = subjects(&built, 1);
    let staged = |correspond| stage(&built.scene, &lods, correspond, true).unwrap().0;
    let baked = stage_baked(&attributes, &built.scene, &lods, 1024).unwrap();
    assert_eq!(
        baked.triangle_count() as usize,
        built.meshes[0].lods[0].triangles.len()
    );
    assert!(baked.texture_bytes() > 2 * 4 * 1024 * 1024);
    let reference = draw(&built, staged(Correspond::Reference));
    let inverse = draw(&built, staged(Correspond::Inverse));
    let plain = draw(&built, staged(Correspond::Plain));
    let baked = draw(&built, baked);
    assert_eq!(baked.covered_pixels, inverse.covered_pixels);
    let depths = |image: &Rendered| -> Vec<u32> {
        let bits = image.depth.iter().map(|d| d.to_bits());
        bits.collect()
    };
    assert_eq!(depths(&baked), depths(&inverse));
    let [of_inverse, of_baked, of_plain] = [&inverse, &baked, &plain].map(|i| flip(&reference, i));
    println!("FLIP: inverse {of_inverse:.4}, baked {of_baked:.4}, plain {of_plain:.4}");
    assert!(of_baked < 0.5 * of_plain, "{of_baked} {of_plain}");
    // The negative control: an atlas too coarse for the model is seen.
    let coarse = stage_baked(&attributes, &built.scene, &lods, 256).unwrap();
    let of_coarse = flip(&reference, &draw(&built, coarse));
    println!("FLIP: coarsely baked {of_coarse:.4}");
    assert!(of_coarse > 1.2 * of_baked, "{of_coarse} {of_baked}");
}

#[test]
fn sizes_out_of_range_are_refused() {
    let built = amphora();
    let (attributes, _) = attributes_of(&built.scene, false).unwrap();
    for size in [0, 15, 8193] {
        let refused = stage_baked(&attributes, &built.scene, &subjects(&built, 1), size);
        let text = refused.err().unwrap().to_string();
        assert!(text.contains("--bake-size"), "{text}");
    }
}
