//! Charts packed and brought to the grid, where every triangle must still stand upright.
//!
//! In: charts with their maps. Out: [`Settled`]: the same in a square, in steps of the grid that tables keep of charts (21
//! bits a side). Rounding may turn thin triangles over: a vertex of theirs moves by a step or two, or else the chart is
//! divided and all is packed again. What is turned after that is listed.

use super::injective::meets_itself;
use super::merge::{Flat, Flatten, divided};
use super::pack::pack;
use super::surface::Surface;
use glam::DVec2;

/// Steps of uv that tables keep.
const STEPS: f64 = (1u32 << 21) as f64;
/// The square's border, as a share of the unit square: a LoD may reach over a chart.
const MARGIN: f64 = 1.0 / 64.0;
/// Times that charts are divided and packed again.
const TRIES: usize = 6;
/// How far a vertex may move to set a triangle upright, in steps.
const REACH: i32 = 3;

/// Packed charts on the grid.
pub(crate) struct Settled {
    /// Places are whole numbers of steps.
    pub(crate) charts: Vec<Flat>,
    /// Side of the square in the same.
    pub(crate) side: f64,
    /// Triangles that are turned over or lie in a chart whose rim meets itself.
    pub(crate) turned: Vec<u32>,
}

/// A place in steps as uv.
pub(crate) fn to_uv(place: DVec2, side: f64) -> [f32; 3] {
    let uv = (place + DVec2::splat((STEPS - side) * 0.5)) / STEPS;
    [uv.x as f32, uv.y as f32, 0.0]
}

/// Packs charts and brings them to the grid; divides those that do not survive it.
pub(crate) fn settle(surface: &Surface, flats: Vec<Flat>, flatten: Flatten) -> Settled {
    let mut maps = flats;
    let mut tried = 0;
    loop {
        tried += 1;
        let mut charts = maps.clone();
        let side = pack(&mut charts);
        let whole = (STEPS * (1.0 - 2.0 * MARGIN)).floor();
        let scale = whole / side;
        let mut broken = vec![];
        for (c, flat) in charts.iter_mut().enumerate() {
            flat.places
                .iter_mut()
                .for_each(|p| *p = (*p * scale).round());
            let turned = set_upright(flat);
            let rim: Vec<DVec2> = flat
                .chart
                .rim
                .iter()
                .map(|&v| flat.places[v as usize])
                .collect();
            if !turned.is_empty() {
                broken.push((c, turned));
            } else if flat.chart.triangles.len() > 1 && meets_itself(&rim) {
                broken.push((c, flat.chart.triangles.clone()));
            }
        }
        let divisible = broken
            .iter()
            .any(|(c, _)| maps[*c].chart.triangles.len() > 1);
        if tried == TRIES || !divisible {
            let mut turned: Vec<u32> = broken.into_iter().flat_map(|(_, turned)| turned).collect();
            turned.sort_unstable();
            return Settled {
                charts,
                side: whole,
                turned,
            };
        }
        let broken: Vec<usize> = broken.into_iter().map(|(c, _)| c).collect();
        maps = again(surface, maps, &broken, flatten);
    }
}

/// The maps, those of `broken` (growing) divided in two.
fn again(surface: &Surface, maps: Vec<Flat>, broken: &[usize], flatten: Flatten) -> Vec<Flat> {
    let mut out = Vec::with_capacity(maps.len() + broken.len());
    for (c, flat) in maps.into_iter().enumerate() {
        if broken.binary_search(&c).is_err() || flat.chart.triangles.len() < 2 {
            out.push(flat);
            continue;
        }
        let (a, b) = super::merge::halves(surface, &flat.chart.triangles);
        out.extend(
            [a, b]
                .into_iter()
                .flat_map(|half| divided(surface, half, flatten)),
        );
    }
    out
}

/// Moves vertices of triangles that are not upright; returns the triangles that stay so.
fn set_upright(flat: &mut Flat) -> Vec<u32> {
    let down = |flat: &Flat| -> Vec<usize> {
        (0..flat.chart.corners.len())
            .filter(|&i| double_area(flat, i) <= 0.0)
            .collect()
    };
    let mut left = down(flat);
    for _ in 0..2 {
        if left.is_empty() {
            break;
        }
        let mut around: Vec<(u32, usize)> = vec![];
        let wanted: Vec<u32> = left.iter().flat_map(|&i| flat.chart.corners[i]).collect();
        for (i, corners) in flat.chart.corners.iter().enumerate() {
            around.extend(
                corners
                    .iter()
                    .filter(|v| wanted.contains(v))
                    .map(|&v| (v, i)),
            );
        }
        around.sort_unstable();
        for group in around.chunk_by(|a, b| a.0 == b.0) {
            let triangles: Vec<usize> = group.iter().map(|g| g.1).collect();
            nudge(flat, group[0].0 as usize, &triangles);
        }
        left = down(flat);
    }
    left.into_iter().map(|i| flat.chart.triangles[i]).collect()
}

/// Moves a vertex to the nearest step where all its `triangles` are upright, if there is one.
fn nudge(flat: &mut Flat, v: usize, triangles: &[usize]) {
    let upright = |flat: &Flat| triangles.iter().all(|&i| double_area(flat, i) > 0.0);
    if upright(flat) {
        return;
    }
    let stood = flat.places[v];
    let mut steps: Vec<(i32, i32, i32)> = (-REACH..=REACH)
        .flat_map(|x| (-REACH..=REACH).map(move |y| (x * x + y * y, x, y)))
        .collect();
    steps.sort_unstable();
    for (_, x, y) in steps {
        flat.places[v] = stood + DVec2::new(x.into(), y.into());
        if upright(flat) {
            return;
        }
    }
    flat.places[v] = stood;
}

/// Exact: steps are whole numbers of 21 bits.
fn double_area(flat: &Flat, i: usize) -> f64 {
    let [a, b, c] = flat.chart.corners[i].map(|v| flat.places[v as usize]);
    (b - a).perp_dot(c - a)
}
