//! A LoD without the inverse texture: what is seen when a simplifier ignores seams.
//!
//! In: a LoD, its reference and tables. Out: a mesh of the LoD's triangles with artist attributes at its corners, looked
//! up once, to be interpolated linearly over each triangle as any ordinary renderer would.
//!
//! Each corner is looked up a little towards its triangle's centroid, so that a corner on a seam reads the chart that
//! its own triangle lies in, as far as one chart can be said to hold it.

use crate::igt::{Asker, Tables};
use crate::lod::Lod;
use crate::mesh::Mesh;
use crate::param::grid::QUERY_SHIFT;

/// One in this many: how far a corner moves towards the centroid.
const PULL: i64 = 64;

/// The LoD's triangles, three vertices each, with attributes of `reference`.
pub(crate) fn mesh(reference: &Mesh, lod: &Lod, tables: &Tables) -> Mesh {
    let mut out = Mesh {
        name: reference.name.clone(),
        ..Mesh::default()
    };
    out.uv_sets = vec![Vec::new(); reference.uv_sets.len()];
    for (t, triangle) in lod.triangles.iter().enumerate() {
        let corners = triangle.map(|v| lod.t3[v as usize]);
        let asker = Asker::of_lod(tables.primary.line(), lod, t);
        let first = out.positions.len() as u32;
        out.triangles.push([first, first + 1, first + 2]);
        let found = [0, 1, 2].map(|k| tables.lookup(pulled(&corners, k), asker, true));
        // The chart and the material are those of the middle, if anything is there.
        let middle = tables.lookup(centroid(&corners), asker, true).or(found[0]);
        let material = middle.map_or(0, |f| reference.triangle_material[f.triangle as usize]);
        out.triangle_material.push(material);
        for k in 0..3 {
            let vertex = triangle[k] as usize;
            out.positions.push(lod.positions[vertex]);
            let at = found[k]
                .or(middle)
                .map(|f| (reference.triangles[f.triangle as usize], f.barycentric));
            push_attributes(&mut out, reference, at, lod.normals[vertex]);
        }
    }
    out
}

/// Corner `k` on the query grid, moved towards the centroid.
fn pulled(corners: &[[i32; 3]; 3], k: usize) -> [i32; 3] {
    std::array::from_fn(|axis| {
        let at = |v: usize| i64::from(corners[v][axis]) << QUERY_SHIFT;
        let sum = at(0) + at(1) + at(2);
        (at(k) + (sum - 3 * at(k)) / (3 * PULL)) as i32
    })
}

fn centroid(corners: &[[i32; 3]; 3]) -> [i32; 3] {
    std::array::from_fn(|axis| {
        let at = |v: usize| i64::from(corners[v][axis]) << QUERY_SHIFT;
        ((at(0) + at(1) + at(2)) / 3) as i32
    })
}

fn push_attributes(
    out: &mut Mesh,
    reference: &Mesh,
    at: Option<([u32; 3], [f32; 3])>,
    normal: [f32; 3],
) {
    out.normals
        .push(at.map_or(normal, |at| weighted(&reference.normals, at)));
    if !reference.tangents.is_empty() {
        let side = at.map_or(1.0, |(v, _)| reference.tangents[v[0] as usize][3]);
        let [x, y, z, _] = at.map_or([0.0; 4], |at| weighted(&reference.tangents, at));
        out.tangents.push([x, y, z, side]);
    }
    if !reference.colors.is_empty() {
        out.colors
            .push(at.map_or([1.0; 4], |at| weighted(&reference.colors, at)));
    }
    for (set, values) in out.uv_sets.iter_mut().zip(&reference.uv_sets) {
        set.push(at.map_or([0.0; 2], |at| weighted(values, at)));
    }
}

fn weighted<const N: usize>(values: &[[f32; N]], (vertex, b): ([u32; 3], [f32; 3])) -> [f32; N] {
    std::array::from_fn(|i| (0..3).map(|k| b[k] * values[vertex[k] as usize][i]).sum())
}
