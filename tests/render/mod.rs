//! Pictures that the rendering tests draw, and how they are looked at.

#![allow(dead_code)]

pub mod model;

use invertex::attribute::{AttributeSet, Material, Pixels, Sampler, SlotBinding, TextureSet};
use invertex::mesh::Mesh;
use invertex::render::{Camera, Picture, Projection};

/// A checkerboard of 8-bit colours that differ everywhere, `n` x `n` texels.
pub fn board(n: u32) -> Vec<u8> {
    (0..n * n)
        .flat_map(|i| {
            let (x, y) = (i % n, i / n);
            let light = if (x / 8 + y / 8) % 2 == 0 { 200 } else { 40 };
            [
                (light + x % 56) as u8,
                (light + y % 56) as u8,
                (x * y % 251) as u8,
                255,
            ]
        })
        .collect()
}

/// A bumpy tangent-space normal map, `n` x `n` texels.
pub fn bumps(n: u32) -> Vec<u8> {
    (0..n * n)
        .flat_map(|i| {
            let wave = |k: u32| (128 + (k % 16) * 5 - 40) as u8;
            [wave(i % n), wave(i / n), 240, 255]
        })
        .collect()
}

/// A material with a textured colour and normal map.
pub fn textured() -> (TextureSet, Vec<Material>) {
    let mut textures = TextureSet::default();
    let (colour, normal) = (board(64), bumps(32));
    let pixels = |width, rgba| Pixels {
        width,
        height: width,
        rgba,
    };
    let slot = |texture| SlotBinding {
        texture,
        uv_set: 0,
        transform: [[3.0, 0.0, 0.1], [0.0, 2.0, -0.2]],
    };
    let base = textures
        .add(0, true, Sampler::default(), || Ok(pixels(64, &colour)))
        .unwrap();
    let bump = textures
        .add(1, false, Sampler::default(), || Ok(pixels(32, &normal)))
        .unwrap();
    let material = Material {
        metallic: 0.2,
        roughness: 0.5,
        slots: [Some(slot(base)), None, Some(slot(bump)), None, None],
        ..Material::default()
    };
    (textures, vec![material])
}

/// A picture of reference meshes, each drawn where `world` says.
pub fn picture(meshes: &[(&Mesh, glam::DMat4)]) -> Picture {
    let (textures, materials) = textured();
    let mut attributes = AttributeSet::new(textures, &materials, 1);
    let bases: Vec<u32> = meshes
        .iter()
        .map(|(mesh, _)| attributes.push_mesh(mesh).unwrap())
        .collect();
    let mut picture = Picture::new(attributes);
    for ((mesh, world), base) in meshes.iter().zip(bases) {
        let geometry = picture
            .add_geometry(&mesh.positions, &mesh.triangles, &[], &[])
            .unwrap();
        picture.draw(geometry, base, None, *world).unwrap();
    }
    picture
}

/// The camera that frames a picture.
pub fn camera(picture: &Picture, azimuth: f64, elevation: f64, width: u32, height: u32) -> Camera {
    let (centre, radius) = picture.bounding_sphere();
    Camera::framed(
        centre,
        radius,
        azimuth,
        elevation,
        Projection::Perspective,
        width,
        height,
    )
    .unwrap()
}

/// A shape with tangents along its uv set.
pub fn tangents(mut mesh: Mesh) -> Mesh {
    let sets = vec![Some(0); mesh.triangles.len()];
    mesh.tangents = vec![[0.0; 4]; mesh.positions.len()];
    mesh.generate_tangents(&sets);
    mesh
}
