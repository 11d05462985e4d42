//! Meshes for maps to be computed of, and what is asked of every map.

#![allow(dead_code, reason = "each test binary uses its part")]

use crate::glb::container;
use invertex::igt::Ambiguous;
use invertex::mesh::{Mesh, shapes, smooth_normals};
use invertex::param::{Computed, Map};
use invertex::scene::Scene;
use serde_json::json;

pub(crate) fn computed(mesh: &Mesh, map: Map) -> (Computed, Mesh) {
    let computed = map
        .compute(mesh)
        .unwrap_or_else(|e| panic!("{}: {e}", mesh.name));
    assert_eq!(computed.embedding.fault(mesh), None, "{}", mesh.name);
    let open = computed.embedding.cut_open(mesh);
    open.validate().unwrap();
    (computed, open)
}

/// Triangles that share a place with another, all charts in one layer: exact, on the tables' own grid.
pub(crate) fn shared(computed: &Computed, open: &Mesh) -> Vec<u32> {
    Ambiguous::of(open, &computed.primary(), &vec![0; open.triangles.len()])
        .unwrap()
        .triangles
}

/// A mesh of positions and triangles alone.
pub(crate) fn bare(name: &str, positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        name: name.into(),
        normals: smooth_normals(&positions, &triangles),
        triangle_material: vec![0; triangles.len()],
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// A ball with dents, so that nothing about it is regular.
pub(crate) fn dented() -> Mesh {
    dented_ball(4)
}

/// The same of an icosahedron divided so many times.
pub(crate) fn dented_ball(times: u32) -> Mesh {
    let mut mesh = shapes::icosphere(times);
    for p in &mut mesh.positions {
        let dent =
            1.0 + 0.3 * (5.0 * p[0]).sin() * (4.0 * p[1] + 1.0).cos() + 0.1 * (9.0 * p[2]).sin();
        *p = p.map(|x| x * dent);
    }
    mesh
}

/// A strip with half a turn: no way round is its outside.
pub(crate) fn moebius() -> Mesh {
    let rounds = 20;
    let positions = (0..rounds)
        .flat_map(|i| {
            let angle = i as f32 / rounds as f32 * std::f32::consts::TAU;
            [-0.3f32, 0.3].map(|s| {
                let radius = 1.0 + s * (angle / 2.0).cos();
                [
                    radius * angle.cos(),
                    radius * angle.sin(),
                    s * (angle / 2.0).sin(),
                ]
            })
        })
        .collect();
    let triangles = (0..rounds)
        .flat_map(|i| {
            let [a, b] = [2 * i, 2 * i + 1];
            let last = i == rounds - 1;
            let [c, d] = if last { [1, 0] } else { [2 * i + 2, 2 * i + 3] };
            [[a, c, b], [b, c, d]]
        })
        .map(|t| t.map(|v| v as u32))
        .collect();
    bare("moebius", positions, triangles)
}

/// A corkscrew: seen from no point and from no line whole, but without a handle.
pub(crate) fn corkscrew() -> Mesh {
    let mut mesh = shapes::icosphere(4);
    for p in &mut mesh.positions {
        let angle = p[0] * 1.6 * std::f32::consts::PI;
        let radius = 1.0 + 0.3 * p[1];
        *p = [
            radius * angle.sin(),
            radius * angle.cos(),
            0.3 * p[2] + 0.9 * p[0],
        ];
    }
    mesh
}

/// A mesh as a scene of its own, read from bytes.
pub(crate) fn scene(mesh: &Mesh) -> Scene {
    let positions: &[u8] = bytemuck::cast_slice(&mesh.positions);
    let indices: &[u8] = bytemuck::cast_slice(&mesh.triangles);
    let document = json!({
        "asset": { "version": "2.0" }, "nodes": [{ "mesh": 0 }], "scenes": [{ "nodes": [0] }], "scene": 0,
        "meshes": [{ "name": "ball", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": mesh.positions.len(), "type": "VEC3",
              "min": [-2, -2, -2], "max": [2, 2, 2] },
            { "bufferView": 1, "componentType": 5125, "count": 3 * mesh.triangles.len(), "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": positions.len() },
            { "buffer": 0, "byteOffset": positions.len(), "byteLength": indices.len() }
        ],
        "buffers": [{ "byteLength": positions.len() + indices.len() }]
    });
    Scene::from_bytes(
        "ball",
        &container(&document.to_string(), &[positions, indices].concat()),
        None,
    )
    .unwrap()
}
