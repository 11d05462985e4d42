//! Pictures that the rendering tests draw, and how they are looked at.

#![allow(dead_code)]

pub(crate) mod inverse;
pub(crate) mod model;

use invertex::attribute::{AttributeSet, Material, Pixels, Sampler, SlotBinding, TextureSet};
use invertex::measure::{self, Region};
use invertex::mesh::Mesh;
use invertex::render::{Camera, Picture, Projection, Rendered};

/// A checkerboard of 8-bit colours that differ everywhere, `n` x `n` texels.
pub(crate) fn board(n: u32) -> Vec<u8> {
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
pub(crate) fn bumps(n: u32) -> Vec<u8> {
    let wave = |k: u32| (128 + (k % 16) * 5 - 40) as u8;
    (0..n * n)
        .flat_map(|i| [wave(i % n), wave(i / n), 240, 255])
        .collect()
}

/// A material with a textured colour and normal map.
pub(crate) fn textured() -> (TextureSet, Vec<Material>) {
    let mut textures = TextureSet::default();
    let (colour, normal) = (board(64), bumps(32));
    let pixels = |width, rgba| Pixels {
        width,
        height: width,
        rgba,
    };
    let transform = [[3.0, 0.0, 0.1], [0.0, 2.0, -0.2]];
    let slot = |texture| SlotBinding {
        texture,
        uv_set: 0,
        transform,
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
pub(crate) fn picture(meshes: &[(&Mesh, glam::DMat4)]) -> Picture {
    let (textures, materials) = textured();
    let mut attributes = AttributeSet::new(textures, &materials, 1);
    let bases: Vec<u32> = meshes
        .iter()
        .map(|(mesh, _)| attributes.push_mesh(mesh).unwrap())
        .collect();
    let mut picture = Picture::new(attributes);
    for ((mesh, world), base) in meshes.iter().zip(bases) {
        let geometry = picture
            .add_geometry(&mesh.positions, &mesh.triangles, &[], &[], 0.0)
            .unwrap();
        picture.draw(geometry, base, None, *world).unwrap();
    }
    picture
}

/// The camera that frames a picture.
pub(crate) fn camera(
    picture: &Picture,
    azimuth: f64,
    elevation: f64,
    width: u32,
    height: u32,
) -> Camera {
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
pub(crate) fn tangents(mut mesh: Mesh) -> Mesh {
    let sets = vec![Some(0); mesh.triangles.len()];
    mesh.tangents = vec![[0.0; 4]; mesh.positions.len()];
    mesh.generate_tangents(&sets);
    mesh
}

/// How two images differ, bit for bit: pixels of colour, of linear colour, triangles, depths, barycentrics, fetches.
pub(crate) fn differences(a: &Rendered, b: &Rendered) -> [usize; 6] {
    fn count<T, B: PartialEq>(a: &[T], b: &[T], bits: impl Fn(&T) -> B) -> usize {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).filter(|(p, q)| bits(p) != bits(q)).count()
    }
    let (pixels, other) = (a.rgba8.as_chunks::<4>().0, b.rgba8.as_chunks::<4>().0);
    [
        count(pixels, other, |p| *p),
        count(&a.linear, &b.linear, |p| p.map(f32::to_bits)),
        count(&a.triangle, &b.triangle, |t| *t),
        count(&a.depth, &b.depth, |d| d.to_bits()),
        count(&a.barycentric, &b.barycentric, |c| c.map(f32::to_bits)),
        count(&a.fetches, &b.fetches, |f| *f),
    ]
}

/// A context for each usable device; says loudly where there is none.
#[cfg(feature = "gpu")]
pub(crate) fn contexts() -> Vec<invertex::gpu::Context> {
    use invertex::gpu::{Context, ContextOptions, DeviceChoice, devices};
    let found = devices().unwrap_or_default();
    let usable = found.iter().filter(|d| d.usable);
    let options = |index| ContextOptions {
        device: DeviceChoice::Index(index),
        validation: true,
    };
    let out: Vec<Context> = usable
        .map(|d| Context::new(&options(d.index)).unwrap())
        .collect();
    if out.is_empty() {
        eprintln!("SKIPPED: no usable Vulkan device");
    }
    out
}

/// Mean FLIP of a forward picture against the deferred one.
pub(crate) fn flip(deferred: &Rendered, forward: &Rendered) -> f64 {
    let picture = |r: &Rendered| measure::Picture {
        width: r.width,
        height: r.height,
        rgba: r.rgba8.as_chunks::<4>().0.to_vec(),
        has_alpha: true,
    };
    let (pictures, names) = (
        [picture(deferred), picture(forward)],
        ["deferred", "forward"],
    );
    measure::compare(&pictures[0], &pictures[1], Region::Foreground, names)
        .unwrap()
        .flip_mean
}
