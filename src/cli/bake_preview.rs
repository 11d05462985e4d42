//! `bake --preview`: the detailed model, the simple one, the simple one with what was baked, and how the last differs from the
//! first, side by side under one light.

use super::device::Device;
use super::recovery::renderer;
use invertex::Result;
use invertex::measure::{Picture, Region, difference_image, in_grey};
use invertex::output::encode_png;
use invertex::render::{
    Camera, Correspond, Options, Output, Projection, Renderer, reference_sphere, stage,
};
use invertex::scene::Scene;

/// Pixels along each side of one of the four pictures.
const SIDE: u32 = 512;
/// Where it is looked at from, degrees.
const VIEW: [f64; 2] = [30.0, 15.0];
/// What is behind.
const GROUND: [f32; 3] = [24.0, 25.0, 28.0];

/// The four pictures in a row, as PNG.
pub(super) fn preview(device: &Device, high: &Scene, low: &Scene, baked: &[u8]) -> Result<Vec<u8>> {
    let baked = Scene::from_bytes("baked.glb", baked, None)?;
    let (centre, radius) = reference_sphere(high)?;
    let [azimuth, elevation] = VIEW;
    let camera = Camera::framed(
        centre,
        radius,
        azimuth,
        elevation,
        Projection::Perspective,
        SIDE,
        SIDE,
    )?;
    let coloured = baked
        .materials
        .iter()
        .any(|m| m.base_color_texture.is_some());
    // Where no colours were baked, shapes are what is to be compared.
    let draw = |scene: &Scene| match coloured {
        true => picture(device, scene, &camera),
        false => picture(device, &in_grey(scene), &camera),
    };
    let (rich, plain, again) = (draw(high)?, draw(low)?, draw(&baked)?);
    let differ = difference_image(&rich, &again, Region::Foreground, ["high", "baked"])?;
    encode_png(4 * SIDE, SIDE, &row([&rich, &plain, &again, &differ]))
}

fn picture(device: &Device, scene: &Scene, camera: &Camera) -> Result<Picture> {
    let (staged, _) = stage(scene, &[], Correspond::Reference, true)?;
    let renderer: Renderer = renderer(device, staged)?;
    let options = Options {
        output: Output::Lit,
        samples: 4,
        ..Options::default()
    };
    let drawn = renderer.draw(camera, &options)?;
    Ok(Picture {
        width: SIDE,
        height: SIDE,
        rgba: drawn.rgba8.as_chunks::<4>().0.to_vec(),
        has_alpha: true,
    })
}

/// Pictures side by side, opaque.
fn row(pictures: [&Picture; 4]) -> Vec<u8> {
    let side = SIDE as usize;
    let mut out = Vec::with_capacity(4 * side * side * 4);
    for y in 0..side {
        for picture in pictures {
            for [r, g, b, a] in &picture.rgba[y * side..(y + 1) * side] {
                let share = f32::from(*a) / 255.0;
                let over = |c: u8, k: usize| {
                    (f32::from(c) * share + GROUND[k] * (1.0 - share)).round() as u8
                };
                out.extend([over(*r, 0), over(*g, 1), over(*b, 2), 255]);
            }
        }
    }
    out
}
