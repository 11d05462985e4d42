//! Where nothing is promised of displacements: folds of a primary, and what lies beyond its rims.

use invertex::asset::{Built, BuiltMesh};
use invertex::igt::Ambiguous;
use invertex::mesh::{Mesh, Weld};
use invertex::param::projection::orientation;
use std::collections::{HashMap, HashSet};

/// What is known of a mesh; nothing of one without tables.
#[derive(Default)]
pub(crate) struct Unpromised {
    /// Triangles that share a place of T3 with another of their layer, and those that touch one: a triangle of a cut that stands for
    /// them stands for a fold.
    pub(crate) folds: HashSet<u32>,
    /// For each triangle which of its edges, each opposite of a corner, no other triangle has in T3, and which of its corners
    /// are ends of such an edge of any.
    rims: Vec<([bool; 3], [bool; 3])>,
}

impl Unpromised {
    /// Whether a point lies on a rim: the nearest to what lies beyond does, and next to nothing else.
    pub(crate) fn is_on_rim(&self, triangle: u32, [b1, b2]: [f32; 2]) -> bool {
        let Some((edges, corners)) = self.rims.get(triangle as usize) else {
            return false;
        };
        let is_none = [1.0 - b1 - b2, b1, b2].map(|share: f32| share.abs() < 1e-5);
        let at = |k: usize| is_none[(k + 1) % 3] && is_none[(k + 2) % 3];
        (0..3).any(|k| edges[k] && is_none[k] || corners[k] && at(k))
    }
}

/// For each mesh of the scene.
pub(crate) fn of(built: &Built) -> Vec<Unpromised> {
    let meshes = built.scene.meshes.iter().enumerate();
    let of = |(m, mesh)| match built.of_mesh(m) {
        None => Unpromised::default(),
        Some(b) => Unpromised {
            folds: folds(mesh, b),
            rims: rims(mesh, b),
        },
    };
    meshes.map(of).collect()
}

fn folds(mesh: &Mesh, built: &BuiltMesh) -> HashSet<u32> {
    let primary = &built.tables.primary;
    let of = Ambiguous::of(mesh, primary, &built.triangle_layer).unwrap();
    let weld = Weld::by_position(&mesh.positions);
    let places = |t: u32| mesh.triangles[t as usize].map(|v| weld.of[v as usize]);
    let folded: HashSet<u32> = of.triangles.iter().flat_map(|&t| places(t)).collect();
    let touches = |t: &u32| places(*t).iter().any(|place| folded.contains(place));
    (0..mesh.triangles.len() as u32).filter(touches).collect()
}

fn rims(mesh: &Mesh, built: &BuiltMesh) -> Vec<([bool; 3], [bool; 3])> {
    let primary = &built.tables.primary;
    let place = Weld::by_position(&mesh.positions).of;
    let key = |v: u32| {
        (
            place[v as usize],
            primary.to_grid(primary.t3_of(mesh, v as usize)),
        )
    };
    let edge = |t: &[u32; 3], k: usize| {
        let (a, b) = (key(t[(k + 1) % 3]), key(t[(k + 2) % 3]));
        if a <= b { (a, b) } else { (b, a) }
    };
    let mut count: HashMap<_, u32> = HashMap::new();
    // One without area in T3 is nowhere: what it lies between has a rim there.
    let on_grid = |t: &[u32; 3]| t.map(|v| primary.to_grid(primary.t3_of(mesh, v as usize)));
    let is_there = |t: &&[u32; 3]| orientation(primary.line(), &on_grid(t)) != 0;
    for t in mesh.triangles.iter().filter(is_there) {
        (0..3).for_each(|k| *count.entry(edge(t, k)).or_default() += 1);
    }
    let rims = count.iter().filter(|(_, count)| **count == 1);
    let ends: HashSet<_> = rims.flat_map(|((a, b), _)| [*a, *b]).collect();
    let of = |t: &[u32; 3]| {
        let edges = [0, 1, 2].map(|k| count.get(&edge(t, k)) == Some(&1));
        (edges, t.map(|v| ends.contains(&key(v))))
    };
    mesh.triangles.iter().map(of).collect()
}
