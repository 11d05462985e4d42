//! Pass *raster*: which triangle each pixel shows. Twin of `glsl/render/raster.vert` and `raster.frag`.
//!
//! In: projected vertices and the draws. Out: for each pixel the number of the nearest triangle in the picture, the
//! last of equals (as the depth test LESS_OR_EQUAL has it); backs stand behind ([`DrawRecord::step_back`]). The CPU walks bands of rows on all cores, each band all
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
                let step = |sense: i32| {
                    let by = draws[seen.draw].step_back(sense);
                    view.away.map(|a| by * a)
                };
                for y in seen.area[2].max(first)..=seen.area[3].min(last) {
                    for x in seen.area[0]..=seen.area[1] {
                        let at = (y - first) as usize * width + x as usize;
                        if let Some(depth) = depth_at(&corner, x, y, step)
                            && depth <= nearest[at]
                        {
                            (nearest[at], ids[at]) = (depth, seen.id);
                        }
                    }
                }
            }
        });
    ids
}

/// Depth of a triangle where it covers a pixel, after the step that `step` gives for the sense in which it is seen.
fn depth_at(
    corner: &[Projected; 3],
    x: i32,
    y: i32,
    step: impl Fn(i32) -> [f32; 2],
) -> Option<f32> {
    let edges = edges(corner, x, y);
    let sense = edges.covers();
    if sense == 0 {
        return None;
    }
    depth(corner, edges.barycentric(sense)?, step(sense))
}

/// A triangle that may be seen.
struct Seen {
    id: u32,
    draw: usize,
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
    for (number, draw) in draws.iter().enumerate() {
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
                        draw: number,
                        id: draw.first_triangle + local as u32,
                        vertex,
                        area,
                    })
                }),
        );
    }
    out
}
