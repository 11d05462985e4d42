//! A made model that bends, grows and bulges: a tube on three joints with two morph targets, and pictures of it.
//!
//! In: nothing. Out: a GLB whose animation `bend` has every kind of channel and interpolation, and what the tests draw.

#![allow(dead_code, reason = "each test binary uses its part")]

pub(crate) mod plain;

use invertex::asset::{self, BuildSettings, Built, Processor};
use invertex::mesh::shapes;
use invertex::render::{
    Camera, Correspond, Options, Output, Projection, Rendered, Renderer, Subject, stage_posed,
};
use invertex::scene::{Pose, Scene};
use serde_json::{Value, json};
use std::sync::Arc;

/// Seconds of the animation `bend`.
pub(crate) const SECONDS: f64 = 2.0;

/// A document and its binary while they grow.
#[derive(Default)]
struct Writer {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Writer {
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.push(
            json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() }),
        );
        self.binary.extend(bytes);
        self.views.len() - 1
    }

    fn accessor<T: bytemuck::Pod>(&mut self, values: &[T], component: u32, kind: &str) -> usize {
        let view = self.view(bytemuck::cast_slice(values));
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": values.len(), "type": kind }));
        self.accessors.len() - 1
    }

    /// Zeros but for some elements.
    fn sparse(&mut self, count: usize, at: &[u32], values: &[[f32; 3]]) -> usize {
        let indices = self.view(bytemuck::cast_slice(at));
        let values = self.view(bytemuck::cast_slice(values));
        self.accessors.push(
            json!({ "componentType": 5126, "count": count, "type": "VEC3", "sparse": {
            "count": at.len(), "indices": { "bufferView": indices, "componentType": 5125 },
            "values": { "bufferView": values } } }),
        );
        self.accessors.len() - 1
    }
}

/// How much joint `k` of three, at z = -1, 0 and 1, has to say at height `z`.
fn weight(k: usize, z: f32) -> f32 {
    (1.0 - (z - (k as f32 - 1.0)).abs()).clamp(0.0, 1.0)
}

/// The model as JSON and binary.
pub(crate) fn document() -> (Value, Vec<u8>) {
    let mesh = shapes::tube(32, 16);
    let n = mesh.positions.len();
    let mut w = Writer::default();
    let indices: Vec<u32> = mesh.triangles.as_flattened().to_vec();
    let heights: Vec<f32> = mesh.positions.iter().map(|p| p[2]).collect();
    let colour = |p: &[f32; 3]| [0.5 + 0.5 * p[0], 0.5 + 0.5 * p[1], 0.5 + 0.5 * p[2], 1.0];
    let colours: Vec<[f32; 4]> = mesh.positions.iter().map(colour).collect();
    let weights: Vec<[f32; 4]> = heights
        .iter()
        .map(|&z| [weight(0, z), weight(1, z), weight(2, z), 0.0])
        .collect();
    // A bulge round the middle, with the normals of its slope; and a dent at a few vertices.
    let bulge: Vec<[f32; 3]> = mesh
        .positions
        .iter()
        .map(|p| [p[0], p[1], 0.0].map(|c| 0.4 * c * (1.0 - p[2] * p[2])))
        .collect();
    let slope: Vec<[f32; 3]> = heights.iter().map(|z| [0.0, 0.0, 0.8 * z]).collect();
    let bind: Vec<[f32; 16]> = [1.0, 0.0, -1.0]
        .map(|z| {
            let mut matrix = [0.0f32; 16];
            (0..4).for_each(|k| matrix[k * 5] = 1.0);
            matrix[14] = z;
            matrix
        })
        .to_vec();
    let attributes = json!({
        "POSITION": w.accessor(&mesh.positions, 5126, "VEC3"),
        "NORMAL": w.accessor(&mesh.normals, 5126, "VEC3"),
        "TEXCOORD_0": w.accessor(&mesh.uv_sets[0], 5126, "VEC2"),
        "COLOR_0": w.accessor(&colours, 5126, "VEC4"),
        "JOINTS_0": w.accessor(&vec![[0u16, 1, 2, 0]; n], 5123, "VEC4"),
        "WEIGHTS_0": w.accessor(&weights, 5126, "VEC4"),
    });
    let targets = json!([
        { "POSITION": w.accessor(&bulge, 5126, "VEC3"), "NORMAL": w.accessor(&slope, 5126, "VEC3") },
        { "POSITION": w.sparse(n, &[40, 41, 73], &[[0.0, 0.0, 0.1], [0.05, 0.0, 0.0], [0.0, -0.1, 0.0]]) },
    ]);
    let index = w.accessor(&indices, 5125, "SCALAR");
    let inverse_bind = w.accessor(&bind, 5126, "MAT4");
    let (samplers, channels) = animation(&mut w);
    let document = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "name": "tube", "mesh": 0, "skin": 0, "translation": [9.0, 9.0, 9.0] },
            { "name": "low", "children": [2], "translation": [0.0, 0.0, -1.0] },
            { "name": "middle", "children": [3], "translation": [0.0, 0.0, 1.0] },
            { "name": "high", "translation": [0.0, 0.0, 1.0] },
        ],
        "meshes": [{ "name": "tube", "weights": [0.25, 0.0], "primitives": [{ "attributes": attributes,
            "indices": index, "targets": targets, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "roughnessFactor": 0.6 }, "doubleSided": true }],
        "skins": [{ "joints": [1, 2, 3], "inverseBindMatrices": inverse_bind }],
        "animations": [
            { "name": "still", "samplers": [], "channels": [] },
            { "name": "bend", "samplers": samplers, "channels": channels },
        ],
        "accessors": w.accessors, "bufferViews": w.views, "buffers": [{ "byteLength": w.binary.len() }],
    });
    (document, w.binary)
}

/// Samplers and channels of `bend`: a turn of the middle joint, a spline turn and growth of the upper one, steps of the
/// lower one, weights of the mesh.
fn animation(w: &mut Writer) -> (Value, Value) {
    let times = w.accessor(&[0.0f32, 0.75, 2.0], 5126, "SCALAR");
    let ends = w.accessor(&[0.0f32, 2.0], 5126, "SCALAR");
    let turn = |angle: f32| [(angle / 2.0).sin(), 0.0, 0.0, (angle / 2.0).cos()];
    let still = [0.0f32; 4];
    let lean = [0.0f32, 0.4, 0.0, 0.0];
    let outputs = [
        w.accessor(&[turn(0.0), turn(0.9), turn(-0.7)], 5126, "VEC4"),
        w.accessor(
            &[still, turn(0.0), lean, lean, turn(0.8), still],
            5126,
            "VEC4",
        ),
        w.accessor(
            &[[1.0f32, 1.0, 1.0], [1.3, 0.8, 1.2], [0.7, 1.1, 1.0]],
            5126,
            "VEC3",
        ),
        w.accessor(
            &[[0.0f32, 0.0, -1.0], [0.3, 0.0, -1.1], [0.0; 3]],
            5126,
            "VEC3",
        ),
        w.accessor(&[0.0f32, 0.0, 1.0, 0.5, 0.2, 1.0], 5126, "SCALAR"),
    ];
    let sampler = |k: usize, input: usize, kind: &str| json!({ "input": input, "output": outputs[k], "interpolation": kind });
    let samplers = json!([
        sampler(0, times, "LINEAR"),
        sampler(1, ends, "CUBICSPLINE"),
        sampler(2, times, "LINEAR"),
        sampler(3, times, "STEP"),
        sampler(4, times, "LINEAR"),
    ]);
    let channel = |sampler: usize, node: usize, path: &str| json!({ "sampler": sampler, "target": { "node": node, "path": path } });
    let channels = json!([
        channel(0, 2, "rotation"),
        channel(1, 3, "rotation"),
        channel(2, 3, "scale"),
        channel(3, 1, "translation"),
        channel(4, 0, "weights"),
    ]);
    (samplers, channels)
}

/// A GLB of the document.
pub(crate) fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    crate::glb::container(&document.to_string(), binary)
}

/// The model.
pub(crate) fn scene() -> Scene {
    let (document, binary) = document();
    Scene::from_bytes("bend.glb", &glb(&document, &binary), None).unwrap()
}

/// A scene with LoDs at these fractions.
pub(crate) fn built(scene: Scene, primary: &str, lods: &[f32]) -> Built {
    let settings = BuildSettings {
        primary: primary.parse().unwrap(),
        lods: lods.to_vec(),
        ..BuildSettings::default()
    };
    let built = asset::build(scene, &settings, Processor::Cpu, &());
    built.unwrap().built
}

/// What each mesh is drawn with at `level`, 0 being the reference's own geometry.
pub(crate) fn subjects(built: &Built, level: usize) -> Vec<Subject<'_>> {
    let subject = |mesh: usize| {
        built
            .of_mesh(mesh)
            .map_or_else(Subject::default, |b| Subject {
                tables: Some(Arc::new(b.tables.clone())),
                lod: level.checked_sub(1).map(|k| &b.lods[k]),
                layers: &b.triangle_layer,
                prefiltered: None,
            })
    };
    (0..built.scene.meshes.len()).map(subject).collect()
}

/// A camera that sees the model in every pose.
pub(crate) fn camera(scene: &Scene, pose: &Pose, azimuth: f64, side: u32) -> Camera {
    let (picture, _) = stage_posed(scene, &[], Correspond::Reference, false, pose).unwrap();
    let (centre, radius) = picture.bounding_sphere();
    let projection = Projection::Perspective;
    Camera::framed(centre, radius, azimuth, 15.0, projection, side, side).unwrap()
}

/// One picture, on the CPU.
pub(crate) fn draw(
    built: &Built,
    level: usize,
    correspond: Correspond,
    pose: &Pose,
    camera: &Camera,
    output: Output,
) -> Rendered {
    let (picture, _) = stage_posed(
        &built.scene,
        &subjects(built, level),
        correspond,
        true,
        pose,
    )
    .unwrap();
    let options = Options {
        output,
        ..Options::default()
    };
    Renderer::cpu(picture).draw(camera, &options).unwrap()
}

/// All correspondences.
pub(crate) const EVERY: [Correspond; 3] = [
    Correspond::Reference,
    Correspond::Inverse,
    Correspond::Plain,
];
