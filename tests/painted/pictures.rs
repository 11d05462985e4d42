//! Pictures of the small models: staged, drawn, and asked for what lies under a pixel.

use super::Painted;
use invertex::asset::{BuildSettings, Built, Processor, build};
use invertex::attribute::{OcclusionOptions, Shown, ShownOptions, Volume, attributes_showing};
use invertex::mesh::Mesh;
use invertex::render::{
    Camera, Correspond, Options, Output, Picture, Projection, Rendered, Renderer, stage_with,
    subjects,
};
use invertex::scene::Scene;

pub(crate) fn scene(painted: Painted) -> Scene {
    Scene::from_bytes("painted.glb", &painted.glb(), None).unwrap()
}

pub(crate) fn built() -> Built {
    built_of(scene(Painted::default()))
}

pub(crate) fn built_of(scene: Scene) -> Built {
    let settings = BuildSettings {
        primary: "uv0".parse().unwrap(),
        lods: vec![0.5, 0.2],
        ..BuildSettings::default()
    };
    build(scene, &settings, Processor::Cpu, &()).unwrap().built
}

pub(crate) fn options() -> ShownOptions {
    ShownOptions {
        occlusion: OcclusionOptions {
            samples: 24,
            ..OcclusionOptions::default()
        },
        volume: Some(Volume::of_strip("volume.png", &super::strip()).unwrap()),
        ..ShownOptions::default()
    }
}

/// The built model at `level` (none: the reference's own geometry, drawn as it is) showing `attribute`.
pub(crate) fn picture(built: &Built, level: Option<usize>, attribute: &str) -> Picture {
    let scene = &built.scene;
    let shown = Shown::new(scene, &attribute.parse().unwrap(), &options(), &|_, _| ()).unwrap();
    let (attributes, warnings) = attributes_showing(scene, true, &shown).unwrap();
    assert_eq!(warnings, Vec::<String>::new());
    let correspond = level.map_or(Correspond::Reference, |_| Correspond::Inverse);
    let subjects = subjects(built, level.unwrap_or(0));
    stage_with(attributes, scene, &subjects, correspond, &scene.rest()).unwrap()
}

/// Options that write `attribute` as it is.
pub(crate) fn raw() -> Options {
    Options {
        output: Output::Data,
        ..Options::default()
    }
}

/// A camera before `centre`, `radius` of which fill the frame.
pub(crate) fn camera(centre: [f64; 3], radius: f64, side: u32) -> Camera {
    Camera::framed(
        centre,
        radius,
        20.0,
        15.0,
        Projection::Perspective,
        side,
        side,
    )
    .unwrap()
}

pub(crate) fn drawn(picture: Picture, camera: &Camera, options: &Options) -> Rendered {
    Renderer::cpu(picture).draw(camera, options).unwrap()
}

/// `values` at the point of the reference under pixel `k`, and the largest of them.
pub(crate) fn at_point(
    mesh: &Mesh,
    image: &Rendered,
    k: usize,
    values: impl Fn(usize) -> f32,
) -> f32 {
    let corners = mesh.triangles[image.triangle[k] as usize];
    let [b1, b2] = image.barycentric[k];
    let v = corners.map(|v| values(v as usize));
    (1.0 - b1 - b2) * v[0] + b1 * v[1] + b2 * v[2]
}

pub(crate) fn covered(image: &Rendered) -> Vec<usize> {
    (0..image.triangle.len())
        .filter(|&k| image.triangle[k] != u32::MAX)
        .collect()
}

/// Object-space position of the reference's point under pixel `k`.
pub(crate) fn position(mesh: &Mesh, image: &Rendered, k: usize) -> [f64; 3] {
    let corners = mesh.triangles[image.triangle[k] as usize].map(|v| mesh.positions[v as usize]);
    let [b1, b2] = image.barycentric[k].map(f64::from);
    let b = [1.0 - b1 - b2, b1, b2];
    [0, 1, 2].map(|i| (0..3).map(|c| b[c] * f64::from(corners[c][i])).sum())
}
