//! How steep colours are: for each triangle of the reference and each level the largest change of colour an object unit.
//!
//! In one patch the change along any direction is a convex function of the place: it is largest at corners of what the triangle
//! and the patch share.

use super::ground::Ground;
use super::palette::{Look, Palette, Side, change, stretch};
use super::polygon::Polygon;
use glam::{DMat2, DVec2, Vec4};
use rayon::prelude::*;

/// A bound may exceed what is reached by this factor.
const SLACK: f64 = 1.02;
/// What rounding may take away, as a factor.
const ROUNDING: f64 = 1.0 + 1e-5;
/// Rectangles that a triangle may ask for.
const PATIENCE: usize = 1 << 20;

/// For each triangle and level; no level less than a coarser one.
pub(super) fn steepness(ground: &Ground<'_>, palette: &Palette) -> Vec<f32> {
    let of = |t: usize| {
        let mut levels = vec![0f32; palette.levels];
        let corners = ground.positions(t as u32);
        let Some(change) = change(palette.coordinates(t as u32), corners) else {
            return levels;
        };
        let mut coarser = 0f32;
        for k in (0..palette.levels).rev() {
            if !palette.is_as_next(t as u32, t as u32, k) {
                coarser = coarser.max(of_level(palette, t as u32, k, change));
            }
            levels[k] = coarser;
        }
        levels
    };
    (0..ground.triangles.len())
        .into_par_iter()
        .with_min_len(16)
        .flat_map_iter(of)
        .collect()
}

fn of_level(palette: &Palette, t: u32, level: usize, change: DMat2) -> f32 {
    match &palette.looks[t as usize] {
        Look::Corners(patch) => (slope(patch.x, patch.y, change) * ROUNDING) as f32,
        Look::Picture { uv, .. } => {
            let side = palette.side(t, t, level);
            let (size, shift) = side.scale();
            let size = DVec2::from(size);
            let change = DMat2::from_cols(change.x_axis * size, change.y_axis * size);
            let corners = uv.map(|c| (c * size - shift).to_array());
            (steepest(side, Polygon::new(corners), change) * ROUNDING) as f32
        }
    }
}

/// The largest change of colour along a direction, from those along two.
fn slope(x: Vec4, y: Vec4, change: DMat2) -> f64 {
    let along = |c: DVec2| x.as_dvec4() * c.x + y.as_dvec4() * c.y;
    let (u, v) = (along(change.x_axis), along(change.y_axis));
    let (a, b, c) = (u.length_squared(), u.dot(v), v.length_squared());
    (0.5 * (a + c + ((a - c) * (a - c) + 4.0 * b * b).sqrt())).sqrt()
}

fn steepest(side: Side<'_>, polygon: Polygon<2>, change: DMat2) -> f64 {
    let mut waiting = vec![polygon];
    let (mut lower, mut upper, mut looked) = (0f64, 0f64, 0);
    while let Some(polygon) = waiting.pop() {
        if polygon.is_empty() {
            continue;
        }
        looked += 1;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for c in polygon.corners() {
            for k in 0..2 {
                (low[k], high[k]) = (low[k].min(c[k]), high[k].max(c[k]));
            }
        }
        let patches = side.patches(low, high);
        let count = patches.map(|[first, last]| last - first);
        if count == [0, 0] {
            let found = in_patch(side, &polygon, patches.map(|run| run[0]), change);
            (lower, upper) = (lower.max(found), upper.max(found));
            continue;
        }
        let [x, y] = side.summary(patches, low, high).slope.map(f64::from);
        // Each of two functions is no steeper than its own slope: together no more than both.
        let rows = [change.row(0), change.row(1)];
        let bound = (rows[0].length() * x + rows[1].length() * y).min(x.hypot(y) * stretch(change));
        if bound <= lower * SLACK || looked >= PATIENCE {
            upper = upper.max(bound);
            continue;
        }
        let k = usize::from(count[1] > count[0]);
        let at = (patches[k][0] + (count[k] + 1) / 2) as f64;
        waiting.extend(polygon.halves(|c| c[k] - at));
    }
    upper.max(lower)
}

fn in_patch(side: Side<'_>, polygon: &Polygon<2>, [x, y]: [i64; 2], change: DMat2) -> f64 {
    let patch = match side {
        // What changes at once is as steep as between two texels.
        Side::Texels(field) => field.smooth_patch(x, y),
        Side::Corners(patch) => *patch,
    };
    let at = |c: &[f64; 2]| {
        let (u, v) = ((c[0] - x as f64) as f32, (c[1] - y as f64) as f32);
        slope(patch.x + patch.xy * v, patch.y + patch.xy * u, change)
    };
    polygon.corners().iter().map(at).fold(0.0, f64::max)
}
