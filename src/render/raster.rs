//! Pass *raster*: which triangle each pixel shows. Twin of `glsl/render/raster.vert` and `raster.frag`.
//!
//! In: projected vertices and the draws. Out: for each pixel the number of the nearest triangle in the picture, the
//! last of equals (as the depth test LESS_OR_EQUAL has it). The CPU walks bands of rows on all cores, each band all
//! triangles in order.

use super::cover::{bounds, depth, edges};
use super::draw::{DrawRecord, Projected, ViewConstants};
use super::shade::NOTHING;
use rayon::prelude::*;

/// Rows of one band.
const BAND: usize = 16;

/// Triangle ids, row by row.
pub(crate) fn cpu(
    corners: &[[u32; 4]],
    draws: &[DrawRecord],
    view: &ViewConstants,
    projected: &[Projected],
) -> Vec<u32> {
    let (width, height) = (view.width as usize, view.height as usize);
    let boxes = boxes(corners, draws, view, projected);
    let mut ids = vec![NOTHING; width * height];
    ids.par_chunks_mut(width * BAND)
        .enumerate()
        .for_each(|(band, ids)| {
            let first = (band * BAND) as i32;
            let last = first + (ids.len() / width) as i32 - 1;
            let mut nearest = vec![1f32; ids.len()];
            for seen in boxes
                .iter()
                .filter(|b| b.area[2] <= last && b.area[3] >= first)
            {
                let corner = seen.vertex.map(|v| projected[v as usize]);
                for y in seen.area[2].max(first)..=seen.area[3].min(last) {
                    for x in seen.area[0]..=seen.area[1] {
                        let at = (y - first) as usize * width + x as usize;
                        test(&corner, x, y, seen.id, &mut nearest[at], &mut ids[at]);
                    }
                }
            }
        });
    ids
}

fn test(corner: &[Projected; 3], x: i32, y: i32, id: u32, nearest: &mut f32, owner: &mut u32) {
    let edges = edges(corner, x, y);
    let sense = edges.covers();
    if sense == 0 {
        return;
    }
    if let Some(depth) = edges.barycentric(sense).and_then(|b| depth(corner, b))
        && depth <= *nearest
    {
        (*nearest, *owner) = (depth, id);
    }
}

/// A triangle that may be seen.
struct Seen {
    id: u32,
    vertex: [u32; 3],
    area: [i32; 4],
}

fn boxes(
    corners: &[[u32; 4]],
    draws: &[DrawRecord],
    view: &ViewConstants,
    projected: &[Projected],
) -> Vec<Seen> {
    let mut out = Vec::new();
    for draw in draws {
        let first = draw.corner_base as usize;
        let triangles = &corners[first..first + draw.triangle_count as usize];
        out.par_extend(
            triangles
                .par_iter()
                .enumerate()
                .filter_map(|(local, corner)| {
                    let vertex = [corner[0], corner[1], corner[2]]
                        .map(|v| v - draw.vertex_base + draw.projected_base);
                    let area = bounds(
                        &vertex.map(|v| projected[v as usize]),
                        view.width,
                        view.height,
                    )?;
                    Some(Seen {
                        id: draw.first_triangle + local as u32,
                        vertex,
                        area,
                    })
                }),
        );
    }
    out
}
