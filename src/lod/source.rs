//! Levels made of a history's triangles, of one age or of several.
//!
//! In: a mesh and its history; triangles that make a whole surface. Out: a [`Lod`] of them, whose vertices are the reference's.

use super::carry::{Carry, Sides};
use super::progressive::{Made, Progressive};
use super::split::{cache_order, has_area, turned};
use super::{Lod, LodInput};
use crate::mesh::smooth_normals;

/// A mesh that levels are made of.
pub(super) struct Source<'a> {
    input: &'a LodInput<'a>,
    history: &'a Progressive,
    carry: Option<Carry<'a>>,
    /// For each vertex of the surface its part.
    part: Vec<u32>,
}

impl<'a> Source<'a> {
    pub(super) fn new(input: &'a LodInput<'a>, history: &'a Progressive) -> Self {
        let mut part = vec![0; input.mesh.positions.len()];
        for (made, t) in history.after(0).zip(&history.reference) {
            let of = input.parts.triangle_part[*t as usize];
            made.corners.iter().for_each(|&v| part[v as usize] = of);
        }
        Source {
            input,
            history,
            carry: Carry::new(input),
            part,
        }
    }

    /// The level of these triangles.
    pub(super) fn lod<'b>(&self, triangles: impl Iterator<Item = &'b Made>) -> Lod {
        let Source { input, part, .. } = self;
        let mesh = input.mesh;
        let position = |v: u32| mesh.positions[self.history.place[v as usize] as usize];
        let made: Vec<&Made> = triangles
            .filter(|t| has_area(t.corners.map(position)))
            .collect();
        let corners: Vec<[u32; 3]> = made.iter().map(|t| t.corners).collect();
        let (triangles, vertices) = cache_order(&corners, mesh.positions.len());
        // A vertex has one layer, as it has one part: parts are welded as the surface is.
        let mut layer = vec![0; mesh.positions.len()];
        for t in &made {
            t.corners.iter().for_each(|&v| layer[v as usize] = t.layer);
        }
        let layer_of = |t: &[u32; 3]| layer[vertices[t[0] as usize] as usize];
        let mut lod = Lod {
            triangle_layer: triangles.iter().map(layer_of).collect(),
            triangles,
            error: made.iter().map(|t| t.deviation.total).fold(0.0, f32::max),
            bounded: true,
            ..Lod::default()
        };
        let mut sides = Sides::new();
        for &v in &vertices {
            lod.positions.push(position(v));
            let t3 = input.primary.t3_of(mesh, v as usize);
            lod.t3.push(input.primary.to_grid(t3));
            if let Some(carry) = &self.carry {
                carry.push(&mut lod, &mut sides, (v, part[v as usize]), position(v));
            }
        }
        lod.normals = smooth_normals(&lod.positions, &lod.triangles);
        lod.turned = turned(&lod, input, |v| part[vertices[v as usize] as usize]);
        lod
    }
}
