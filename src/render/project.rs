//! Pass *project*: vertices to pixels. Twin of `glsl/render/project.comp`.
//!
//! In: object-space positions, the draws, the view. Out: one [`Projected`] per vertex of each draw. A vertex before the
//! eye is snapped to a sixteenth of a pixel, so that coverage is decided by integers; one behind the eye, or absurdly
//! far to a side, keeps only its homogeneous position (see [`super::cover`]).

use super::draw::{DrawRecord, Projected, ViewConstants};
use rayon::prelude::*;

/// Snapped coordinates of ordinary vertices stay below this, in sixteenths of a pixel (131072 pixels).
const REACH: f32 = 2_097_152.0;

/// All vertices of all draws.
pub(crate) fn cpu(
    positions: &[[f32; 3]],
    draws: &[DrawRecord],
    view: &ViewConstants,
) -> Vec<Projected> {
    let mut out = Vec::new();
    for draw in draws {
        let first = draw.vertex_base as usize;
        let vertices = &positions[first..first + draw.vertex_count as usize];
        out.par_extend(vertices.par_iter().map(|&p| project(p, draw, view)));
    }
    out
}

fn project(p: [f32; 3], draw: &DrawRecord, view: &ViewConstants) -> Projected {
    let world = draw.world.map(|row| affine(row, p));
    let [hx, hy, z, w] = view.rows.map(|row| affine(row, world));
    let mut out = Projected {
        hx,
        hy,
        z,
        w,
        ..Projected::default()
    };
    if w > 1e-20 {
        let (x, y) = ((hx / w) * 16.0 + 0.5, (hy / w) * 16.0 + 0.5);
        if x > -REACH && x < REACH && y > -REACH && y < REACH {
            (out.x, out.y) = (x.floor() as i32, y.floor() as i32);
            out.inverse_w = 1.0 / w;
            out.ordinary = 1;
        }
    }
    out
}

/// `row . (p, 1)`, summed from x on.
pub(crate) fn affine(row: [f32; 4], p: [f32; 3]) -> f32 {
    row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]
}
