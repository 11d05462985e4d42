//! Models made of single meshes, for tests of what lies between two surfaces.
#![allow(dead_code, reason = "each test file uses a part")]

use invertex::asset::Progress;
use invertex::mesh::{Mesh, shapes};
use invertex::output::{TexturedMesh, encode_glb};
use invertex::recover::{BakeAttribute, Mapping, Misses, PairSettings};
use invertex::scene::Scene;

const UPRIGHT: [[f32; 4]; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// Nobody who hears how work goes.
pub(crate) struct Quiet;

impl Progress for Quiet {
    fn at(&self, _: &'static str, _: &str, _: usize, _: usize) {}
}

/// A scene of one mesh.
pub(crate) fn scene(name: &str, mesh: &Mesh) -> Scene {
    placed(name, mesh, UPRIGHT)
}

/// Likewise, put somewhere: four columns.
pub(crate) fn placed(name: &str, mesh: &Mesh, place: [[f32; 4]; 4]) -> Scene {
    let one = TexturedMesh {
        mesh,
        textures: vec![],
        places: vec![place],
    };
    Scene::from_bytes(name, &encode_glb(&[one]).unwrap(), None).unwrap()
}

/// The unit square in the plane z = `z` as n x n squares, uv = xy shrunk by `inset` on each side.
pub(crate) fn plane(n: u32, z: f32, inset: f32) -> Mesh {
    let mut mesh = shapes::grid(n);
    for (p, uv) in mesh.positions.iter_mut().zip(&mut mesh.uv_sets[0]) {
        p[2] = z;
        *uv = [p[0], p[1]].map(|c| inset + c * (1.0 - 2.0 * inset));
    }
    mesh
}

/// Positions that a mapping finds, 64 texels a side; blank where it finds none.
pub(crate) fn positions(mapping: Mapping) -> PairSettings {
    let mut settings = PairSettings {
        mapping,
        attributes: vec![BakeAttribute::Position],
        size: 64,
        padding: 0,
        ..PairSettings::default()
    };
    settings.recovery.probes.size = 64;
    settings.recovery.misses = Misses::Blank;
    settings
}
