//! The surface that textures are baked for: a LoD cut along its atlas.
//!
//! In: a LoD, its atlas. Out: a mesh with texture coordinates and tangents; and its frame, to bring normals into.

use super::atlas::Atlas;
use crate::attribute::arithmetic::{V3, cross3, dot3, unit3, weighted};
use crate::lod::Lod;
use crate::mesh::{Mesh, MorphTarget};
use std::collections::HashMap;

/// Rows of no transform at all.
pub(super) const ROWS: [[f32; 4]; 3] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
];
/// The same for normals: the fourth of the first row is the handedness.
pub(super) const UPRIGHT: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 1.0], ROWS[1], ROWS[2]];

/// The LoD as a mesh whose vertices are split where charts meet, with tangents along its texture coordinates. Triangles
/// keep their numbers.
pub(super) fn unwrapped(reference: &Mesh, lod: &Lod, atlas: &Atlas) -> Mesh {
    let mut out = Mesh {
        name: reference.name.clone(),
        uv_sets: vec![Vec::new()],
        triangle_material: vec![0; lod.triangles.len()],
        targets: vec![MorphTarget::default(); lod.targets.len()],
        target_weights: reference.target_weights.clone(),
        ..Mesh::default()
    };
    let mut known: HashMap<(u32, u32), u32> = HashMap::new();
    for (t, triangle) in lod.triangles.iter().enumerate() {
        let corners = [0, 1, 2].map(|k| {
            let v = triangle[k];
            *known.entry((v, atlas.chart[t])).or_insert_with(|| {
                out.positions.push(lod.positions[v as usize]);
                out.normals.push(lod.normals[v as usize]);
                out.joints.extend(lod.joints.get(v as usize));
                out.weights.extend(lod.weights.get(v as usize));
                for (to, from) in out.targets.iter_mut().zip(&lod.targets) {
                    to.positions.extend(from.positions.get(v as usize));
                    to.normals.extend(from.normals.get(v as usize));
                }
                out.uv_sets[0].push(atlas.uv[t][k]);
                out.positions.len() as u32 - 1
            })
        });
        out.triangles.push(corners);
    }
    out.tangents = vec![[0.0; 4]; out.positions.len()];
    out.generate_tangents(&vec![Some(0); out.triangles.len()]);
    out
}

/// What a triangle of that surface has at its corners.
#[derive(Default)]
pub(super) struct Corners {
    pub(super) positions: [V3; 3],
    pub(super) normals: [V3; 3],
    tangents: [V3; 3],
    /// On which side of normal and tangent the bitangent lies: 1 or -1.
    side: f32,
}

impl Corners {
    pub(super) fn of(low: &Mesh, t: usize) -> Corners {
        let corners = low.triangles[t].map(|v| v as usize);
        Corners {
            positions: corners.map(|v| low.positions[v]),
            normals: corners.map(|v| low.normals[v]),
            tangents: corners.map(|v| {
                let [x, y, z, _] = low.tangents[v];
                [x, y, z]
            }),
            side: low.tangents[corners[0]][3],
        }
    }

    /// `normal` (object space) as a tangent-space normal at barycentrics `b`: what undoes the shading.
    pub(super) fn in_frame(&self, b: [f32; 3], normal: V3) -> V3 {
        let n = unit3(weighted(&self.normals, b), normal);
        let t = unit3(weighted(&self.tangents, b), cross3(n, [0.0, 1.0, 0.0]));
        let bitangent = cross3(n, t).map(|c| c * self.side);
        // The shading does not make tangent and normal perpendicular, so what undoes it solves for both at once.
        let (leaning, along_t, along_n) = (dot3(t, n), dot3(normal, t), dot3(normal, n));
        let left = (1.0 - leaning * leaning).max(1e-6);
        let tilted = [
            (along_t - leaning * along_n) / left,
            dot3(normal, bitangent) / dot3(bitangent, bitangent).max(1e-6),
            (along_n - leaning * along_t) / left,
        ];
        unit3(tilted, [0.0, 0.0, 1.0])
    }
}
