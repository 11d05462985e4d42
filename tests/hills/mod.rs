//! Small meshes with hills, over every kind of primary.
#![allow(dead_code, reason = "each test file uses a part")]

use super::parted::Model;
use invertex::mesh::{Mesh, shapes};
use invertex::param::{Axis, PrimaryKind};

pub(crate) fn computed(mesh: &Mesh, request: &str) -> Model {
    Model::with(mesh, &request.parse().unwrap())
}

/// A ball with hills.
pub(crate) fn hilly(subdivisions: u32) -> Mesh {
    let mut mesh = shapes::icosphere(subdivisions);
    for p in &mut mesh.positions {
        let wave = |x: f32, y: f32| (5.0 * x + 1.0).sin() * (4.0 * y).cos();
        let r = 1.0 + 0.12 * wave(p[0], p[1]) + 0.07 * wave(p[2], p[0] + 2.0);
        *p = p.map(|x| x * r);
    }
    mesh
}

/// A sheet with hills, whose uv is squeezed towards one side.
pub(crate) fn squeezed(n: u32) -> Mesh {
    let mut mesh = shapes::grid(n);
    for (p, uv) in mesh.positions.iter_mut().zip(&mut mesh.uv_sets[0]) {
        p[2] += 0.1 * (4.0 * p[0]).sin() * (3.0 * p[1]).cos();
        uv[0] = uv[0] * uv[0] * 0.6 + 0.3 * uv[0];
    }
    mesh
}

/// A tube whose radius varies.
pub(crate) fn bellied(segments: u32, rings: u32) -> Mesh {
    let mut mesh = shapes::tube(segments, rings);
    let axis = 2;
    for p in &mut mesh.positions {
        let r = 1.0 + 0.25 * (3.0 * p[axis]).sin();
        (p[0], p[1]) = (p[0] * r, p[1] * r);
    }
    mesh
}

/// A tube round an arc: only a computed map takes it to a cylinder.
pub(crate) fn bent(segments: u32, rings: u32) -> Mesh {
    let mut mesh = bellied(segments, rings);
    for p in &mut mesh.positions {
        let (sin, cos) = (0.5 * p[2]).sin_cos();
        *p = [(4.0 + p[0]) * cos, p[1], (4.0 + p[0]) * sin];
    }
    mesh
}

/// A sheet in two, the upper part higher, that fit into each other like jaws: a chord from tooth to tooth of one part lies over
/// the other. `n` is a multiple of 16.
pub(crate) fn jaws(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for (gap, height) in [(0.0, 0.0), (0.02, 0.4)] {
        let first = mesh.positions.len() as u32;
        for j in 0..=n {
            for i in 0..=n {
                let [x, along] = [i, j].map(|k| k as f32 / n as f32);
                let tooth = (8.0 * x).fract();
                let border = 0.45 + 0.1 * tooth.min(1.0 - tooth) + gap;
                let y = match gap > 0.0 {
                    true => border + (1.0 - border) * along,
                    false => border * along,
                };
                mesh.positions.push([x, y, height + 0.03 * (7.0 * x).sin()]);
            }
        }
        for j in 0..n {
            for i in 0..n {
                let a = first + j * (n + 1) + i;
                let (b, c) = (a + 1, a + n + 1);
                mesh.triangles.extend([[a, b, c], [b, c + 1, c]]);
            }
        }
    }
    mesh
}

pub(crate) fn models() -> Vec<(&'static str, Model)> {
    vec![
        ("sphere", Model::new(hilly(3), PrimaryKind::Sphere)),
        ("sphere:map", computed(&hilly(2), "sphere:map")),
        (
            "plane",
            Model::new(squeezed(20), PrimaryKind::Plane(Axis::Z)),
        ),
        ("uv", Model::new(squeezed(20), PrimaryKind::UvSet(0))),
        (
            "uv seam",
            Model::new(bellied(24, 12), PrimaryKind::UvSet(0)),
        ),
        (
            "cylinder",
            Model::new(bellied(24, 12), PrimaryKind::Cylinder(Axis::Z)),
        ),
        ("bent tube", computed(&bent(24, 12), "cylinder:map")),
        ("jaws", Model::new(jaws(16), PrimaryKind::Plane(Axis::Z))),
        ("charts", computed(&hilly(3), "lscm")),
    ]
}
