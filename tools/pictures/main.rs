//! Makes the pictures of the documentation from the bundled model: `cargo run --release --example pictures`.
//!
//! In: `assets/amphora.glb`. Out: `assets/attributes.png`, `solids.png`, `bake.png`, `shader-lod.png` and `mappings.png` beside it, the
//! same bytes on every machine, as everything is drawn by the processor's deferred path.

mod relief;

use image::{Rgba, RgbaImage, imageops};
use invertex::asset::{BuildSettings, Built, Processor, build};
use invertex::attribute::{Shown, ShownOptions, attributes_showing};
use invertex::recover::{BakeSettings, Baker, Over, prefilter};
use invertex::render::{
    Camera, Correspond, Options, Output, Projection, Renderer, stage, stage_with, subjects,
    subjects_prefiltered,
};
use invertex::scene::Scene;
use std::error::Error;
use std::path::Path;

/// Sides of one picture.
const WIDTH: u32 = 200;
const HEIGHT: u32 = 260;
/// How much a picture from far away is enlarged.
const ENLARGED: u32 = 4;
/// The level that is drawn: a tenth of the reference's triangles.
const LEVEL: usize = 3;

type Done<T> = Result<T, Box<dyn Error>>;

fn main() -> Done<()> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let scene = Scene::load(&assets.join("amphora.glb"))?;
    let built = build(scene, &BuildSettings::default(), Processor::Cpu, &())?.built;
    let row = |file: &str, attributes: &[&str]| -> Done<()> {
        let drawn = attributes.iter().map(|a| panel(&built, a, LEVEL));
        save(&assets.join(file), &drawn.collect::<Done<Vec<_>>>()?)
    };
    row(
        "attributes.png",
        &[
            "occlusion",
            "normal",
            "metallic-roughness",
            "triangle-color",
        ],
    )?;
    row(
        "solids.png",
        &[
            "wood*occlusion",
            "marble*occlusion",
            "cellular",
            "checker3d",
        ],
    )?;
    let mut panels = vec![panel(&built, "base-color", LEVEL)?];
    panels.extend(textures(&built)?);
    save(&assets.join("bake.png"), &panels)?;
    save(&assets.join("mappings.png"), &relief::panels()?)?;
    let mut filtered = built;
    prefilter(&mut filtered, 512, &())?;
    save(&assets.join("shader-lod.png"), &far_away(&filtered)?)
}

/// The amphora's LoD showing an attribute, as it is or lit.
fn panel(built: &Built, attribute: &str, level: usize) -> Done<RgbaImage> {
    let scene = &built.scene;
    let shown = Shown::new(
        scene,
        &attribute.parse()?,
        &ShownOptions::default(),
        &|_, _| (),
    )?;
    let (attributes, _) = attributes_showing(scene, true, &shown)?;
    let data = attributes.is_data();
    let subjects = subjects(built, level);
    let picture = stage_with(
        attributes,
        scene,
        &subjects,
        Correspond::Inverse,
        &scene.rest(),
    )?;
    let (centre, radius) = picture.bounding_sphere();
    let camera = Camera::framed(
        centre,
        radius * 0.8,
        25.0,
        18.0,
        Projection::Perspective,
        WIDTH,
        HEIGHT,
    )?;
    let options = Options {
        output: if data { Output::Data } else { Output::Lit },
        samples: 4,
        ..Options::default()
    };
    let image = Renderer::cpu(picture).draw(&camera, &options)?;
    RgbaImage::from_raw(WIDTH, HEIGHT, image.rgba8)
        .ok_or_else(|| "a picture of another size".into())
}

/// The amphora far away, enlarged: many samples a pixel; one point of each looked up; filtered beforehand; and the loads of the
/// last one, where a bound of 16 steps is kept.
fn far_away(built: &Built) -> Done<Vec<RgbaImage>> {
    let (width, height) = (WIDTH / ENLARGED, HEIGHT / ENLARGED);
    let subjects = subjects_prefiltered(built, LEVEL);
    let (picture, _) = stage(&built.scene, &subjects, Correspond::Inverse, false)?;
    let (centre, radius) = picture.bounding_sphere();
    let projection = Projection::Perspective;
    let camera = Camera::framed(centre, radius * 0.8, 25.0, 18.0, projection, width, height)?;
    let renderer = Renderer::cpu(picture);
    let panel = |samples, shader_lod, output| -> Done<RgbaImage> {
        let options = Options {
            output,
            samples,
            shader_lod,
            fetches_top: 8,
            ..Options::default()
        };
        let image = renderer.draw(&camera, &options)?;
        let image = RgbaImage::from_raw(width, height, image.rgba8).ok_or("another size")?;
        Ok(imageops::resize(&image, WIDTH, HEIGHT, imageops::Nearest))
    };
    Ok(vec![
        panel(64, 0.0, Output::Unlit)?,
        panel(1, 0.0, Output::Unlit)?,
        panel(1, 63.75, Output::Unlit)?,
        panel(1, 16.0, Output::Fetches)?,
    ])
}

/// Colour, normals and occlusion of the LoD as textures, made small.
fn textures(built: &Built) -> Done<Vec<RgbaImage>> {
    let settings = BakeSettings {
        over: Over::Lod(LEVEL),
        attributes: vec!["color".parse()?, "normal".parse()?, "occlusion".parse()?],
        size: WIDTH * 2,
        ..BakeSettings::default()
    };
    let baked = Baker::new(built, &settings, &())?.mesh(0, &())?;
    let small = |rgba8: Vec<u8>| {
        let image = RgbaImage::from_raw(WIDTH * 2, WIDTH * 2, rgba8);
        let image = image.ok_or("a texture of another size")?;
        Ok(imageops::thumbnail(&image, WIDTH, WIDTH))
    };
    baked
        .textures
        .into_iter()
        .map(|t| small(t.rgba8()))
        .collect()
}

/// Pictures side by side on light grey.
fn save(path: &Path, panels: &[RgbaImage]) -> Done<()> {
    let gap = 8;
    let width = panels.len() as u32 * (WIDTH + gap) - gap;
    let height = panels.iter().map(RgbaImage::height).max().unwrap_or(0);
    let mut row = RgbaImage::from_pixel(width, height, Rgba([232, 232, 232, 255]));
    for (k, panel) in panels.iter().enumerate() {
        let top = (height - panel.height()) / 2;
        imageops::overlay(
            &mut row,
            panel,
            (k as u32 * (WIDTH + gap)).into(),
            top.into(),
        );
    }
    let bytes = invertex::output::encode_png(width, height, row.as_raw())?;
    invertex::output::write_bytes(path, &bytes)?;
    println!("{}", path.display());
    Ok(())
}
