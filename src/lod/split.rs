//! From the simplified joint mesh back to one LoD per mesh.
//!
//! In: the simplified mesh and a mesh's number. Out: its [`Lod`]: object space, T3 on the grid, layers, skin, normals, in an
//! order that is kind to vertex caches.

use super::carry::{self, Carry};
use super::joint::{Joint, carried, t3_of};
use super::simplify::Simplified;
use super::{Lod, LodInput};
use crate::mesh::smooth_normals;
use crate::param::PrimaryKind;
use crate::param::fit_surface::t3_facing;
use glam::{DMat4, DVec3};

/// Mesh `m`'s share of `simplified`.
pub(super) fn split(
    meshes: &[LodInput<'_>],
    joint: &Joint,
    simplified: &Simplified,
    m: usize,
    carry: Option<&Carry>,
) -> Lod {
    let triangles: Vec<[u32; 3]> = simplified
        .indices
        .as_chunks::<3>()
        .0
        .iter()
        .copied()
        .filter(|t| {
            joint.origins[t[0] as usize].mesh == m as u32
                && has_area(t.map(|v| simplified.positions[v as usize]))
        })
        .collect();
    let (triangles, vertices) = cache_order(&triangles, joint.positions.len());
    let mut lod = Lod {
        triangle_layer: triangles
            .iter()
            .map(|t| joint.origins[vertices[t[0] as usize] as usize].layer)
            .collect(),
        triangles,
        error: error(joint, simplified, m),
        reached: simplified.reached,
        ..Lod::default()
    };
    let undo = joint.worlds[m].inverse();
    let mut sides = carry::Sides::new();
    for &v in &vertices {
        push_vertex(&mut lod, &meshes[m], joint, simplified, v as usize, undo);
        if let (Some(carry), Some(&position)) = (carry, lod.positions.last()) {
            let origin = &joint.origins[v as usize];
            carry.push(&mut lod, &mut sides, (origin.vertex, origin.part), position);
        }
    }
    lod.normals = smooth_normals(&lod.positions, &lod.triangles);
    lod.turned = turned(&lod, &meshes[m], |v| {
        joint.origins[vertices[v as usize] as usize].part
    });
    lod
}

/// Whether a triangle with these corners has area.
pub(super) fn has_area(corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(|p| DVec3::from(p.map(f64::from)));
    (b - a).cross(c - a) != DVec3::ZERO
}

/// Triangles in vertex-cache order over vertices in the order of their first use, and the old numbers of those.
pub(super) fn cache_order(
    triangles: &[[u32; 3]],
    vertex_count: usize,
) -> (Vec<[u32; 3]>, Vec<u32>) {
    if triangles.is_empty() {
        return (vec![], vec![]);
    }
    let (local, used) = compact(triangles.as_flattened(), vertex_count);
    let ordered = meshopt::optimize_vertex_cache(&local, used.len());
    let (fetch, first) = compact(&ordered, used.len());
    let vertices = first.iter().map(|&v| used[v as usize]).collect();
    (fetch.as_chunks::<3>().0.to_vec(), vertices)
}

/// Indices renumbered by first use, and the old number of each new one (the vertex-fetch order).
fn compact(indices: &[u32], vertex_count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut number = vec![u32::MAX; vertex_count];
    let mut used = vec![];
    let renumbered = indices
        .iter()
        .map(|&v| {
            let slot = &mut number[v as usize];
            if *slot == u32::MAX {
                *slot = used.len() as u32;
                used.push(v);
            }
            *slot
        })
        .collect();
    (renumbered, used)
}

fn push_vertex(
    lod: &mut Lod,
    input: &LodInput<'_>,
    joint: &Joint,
    simplified: &Simplified,
    v: usize,
    undo: glam::DMat4,
) {
    let (mesh, primary) = (input.mesh, input.primary);
    let origin = joint.origins[v].vertex as usize;
    let moved = undo
        .transform_point3(DVec3::from(simplified.positions[v].map(f64::from)))
        .as_vec3();
    // A vertex that stayed is the reference's own, bit by bit; so is one thrown out of the numbers' range.
    let stayed = simplified.positions[v] == joint.positions[v] || !moved.is_finite();
    let position = if stayed {
        mesh.positions[origin]
    } else {
        moved.to_array()
    };
    let place = t3_of(joint, &simplified.attributes, v);
    let same_place =
        place == t3_of(joint, &joint.attributes, v) || !place.iter().all(|x| x.is_finite());
    let t3 = match (carried(primary.kind), primary.kind) {
        (true, _) if same_place => primary.t3_of(mesh, origin),
        (true, PrimaryKind::Computed(map)) => map.onto(place),
        (true, _) => place,
        (false, _) => primary.t3_of_position(position.map(f64::from)),
    };
    lod.positions.push(position);
    lod.t3.push(primary.to_grid(t3));
}

/// The simplifier's error in object units of mesh `m`; finite.
fn error(joint: &Joint, simplified: &Simplified, m: usize) -> f32 {
    let error = f64::from(simplified.error) / per_object_unit(&joint.worlds[m]);
    if error.is_nan() {
        f32::MAX
    } else {
        (error as f32).min(f32::MAX)
    }
}

/// How many units of the world a unit of an object is.
pub(super) fn per_object_unit(world: &DMat4) -> f64 {
    world.determinant().abs().cbrt()
}

/// Counts triangles whose T3 orientation is not the reference's: of their chart for a uv set, of the mesh otherwise. `part`
/// is that of each vertex of the LoD.
pub(super) fn turned(lod: &Lod, input: &LodInput<'_>, part: impl Fn(u32) -> u32) -> u32 {
    let by_chart = !input.primary.is_seamless();
    let slot = |part: u32| if by_chart { part as usize } else { 0 };
    let kind = input.primary.kind;
    let mut sums = vec![0.0; if by_chart { input.parts.part_count } else { 1 }];
    let origin = input.primary.frame.origin;
    for (t, triangle) in input.mesh.triangles.iter().enumerate() {
        let corners = triangle.map(|v| {
            let p = input.primary.t3_of(input.mesh, v as usize);
            [0, 1, 2].map(|k| p[k] - origin[k])
        });
        sums[slot(input.parts.triangle_part[t])] += t3_facing(kind, &corners).1;
    }
    let is_turned = |t: &&[u32; 3]| {
        let corners = t.map(|v| lod.t3[v as usize].map(f64::from));
        t3_facing(kind, &corners).0 * sums[slot(part(t[0]))] < 0.0
    };
    lod.triangles.iter().filter(is_turned).count() as u32
}
