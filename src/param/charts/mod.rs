//! Charts: a surface cut into disks that are laid flat and packed in a square.
//!
//! In: a mesh of any kind. Out: a [`Computed`] map, one-to-one on the grid that the tables are built on.
//!
//! ```text
//! mesh -> surface (welded, oriented) -> segment (nearly flat pieces) -> merge (while the union can be laid flat)
//!      -> map of each chart by the method -> pack -> grid: every triangle upright, no rim meets itself, or divide again
//! ```
//!
//! Components, holes, non-manifold edges: whatever is no oriented disk is a border or is cut. Triangles without area have no
//! chart: their corners lie in one point. Every step is the same on every run: sums are taken in the order of triangles, and
//! charts are solved side by side but never together.

mod abf;
mod chart;
mod cut;
mod geometry_image;
mod given;
mod injective;
mod isochart;
mod lscm;
mod merge;
mod pack;
mod segment;
mod settle;
mod stretch;
mod surface;
pub(super) mod ways;

use crate::error::{Error, Result};
use crate::mesh::{Embedding, Mesh, NONE};
pub(crate) use given::given;
use merge::{Bound, Flat, Flatten, charts};
use rayon::prelude::*;
use settle::{Settled, settle};
use std::collections::BTreeMap;
pub use stretch::Stretch;
pub(crate) use stretch::Sums;
use surface::Surface;

use super::computed::{Computed, Map, Quality};
use super::grid::Frame;

/// L2 stretch that a chart may have where nobody says otherwise.
const STRETCH: f64 = 1.1;

/// What merged charts may cost, by the L2 stretch: the largest stretch anywhere follows.
fn bound(l2: f64) -> Bound {
    Bound {
        l2,
        linf: 1.5 + 15.0 * (l2 - 1.0),
    }
}

/// How far a piece may be from flat before anything is measured (see [`segment`]): well within what the stretch allows.
fn bend(bound: Bound) -> f64 {
    (0.6 * (bound.l2 - 1.0)).clamp(0.004, 0.06)
}

const OFF_THE_SQUARE: &str = "geometry-image cannot be had: a part of it is stretched past the numbers' range on a \
    square; charts can be had, such as --primary lscm";

/// Steps of the vertex grid per unit of uv: the packed charts reach from 1/64 to 63/64 and fill 31/32 of the grid.
const GRID_STEPS: f64 = (1u32 << 24) as f64;

/// The charts of `mesh` by `map`, which is a method of charts, with an L2 stretch up to `stretch`.
///
/// # Errors
/// [`Error::Parameterization`] where no triangle has area.
pub(crate) fn unwrap(mesh: &Mesh, map: Map, stretch: Option<f64>) -> Result<Computed> {
    let surface = Surface::new(mesh);
    if (0..mesh.triangles.len()).all(|t| !surface.usable(t)) {
        return Err(Error::Parameterization {
            mesh: mesh.name.clone(),
            reason: format!("{map} cannot be had: none of its triangles has area"),
        });
    }
    let flatten = flatten(map);
    let flats = match map {
        Map::GeometryImage => squares(mesh, &surface)?,
        _ => several(&surface, map, bound(stretch.unwrap_or(STRETCH))),
    };
    let settled = settle(&surface, flats, flatten);
    let quality = quality(&surface, &settled);
    Ok(Computed {
        map,
        embedding: embedding(mesh, &settled),
        frame: Frame {
            origin: [0.5, 0.5, 0.0],
            scale: GRID_STEPS,
        },
        quality,
    })
}

/// Pieces, merged, laid flat by the method.
fn several(surface: &Surface, map: Map, bound: Bound) -> Vec<Flat> {
    let (piece, count) = match map {
        Map::Isochart => spectral(surface, bound),
        _ => segment::pieces(surface, bend(bound)),
    };
    // The conformal map says fast how large a chart may be; the method lays flat what came of it.
    let merged = charts(surface, &piece, count, lscm::lscm, bound);
    match map {
        Map::Abf => merge::again(surface, merged, abf::abf),
        _ => merged,
    }
}

/// Triangles that can be laid flat, by connected part.
fn parts(surface: &Surface) -> Vec<Vec<u32>> {
    let usable = (0..surface.triangles.len() as u32).filter(|&t| surface.usable(t as usize));
    isochart::connected(surface, usable.collect())
}

/// Each part on a square of its own.
fn squares(mesh: &Mesh, surface: &Surface) -> Result<Vec<Flat>> {
    let laid: Vec<Option<Flat>> = parts(surface)
        .par_iter()
        .map(|part| geometry_image::square(surface, part))
        .collect();
    let refused = || Error::Parameterization {
        mesh: mesh.name.clone(),
        reason: OFF_THE_SQUARE.into(),
    };
    laid.into_iter()
        .map(|flat| flat.ok_or_else(refused))
        .collect()
}

/// Pieces of each part of the surface that can be laid flat within the bound, by spectral analysis.
fn spectral(surface: &Surface, bound: Bound) -> (Vec<u32>, usize) {
    let good = |triangles: &[u32]| merge::within(surface, triangles, lscm::lscm, bound);
    let pieces: Vec<Vec<Vec<u32>>> = parts(surface)
        .into_par_iter()
        .map(|part| isochart::pieces(surface, part, &good))
        .collect();
    let mut piece = vec![NONE; surface.triangles.len()];
    let mut count = 0;
    for triangles in pieces.into_iter().flatten() {
        triangles
            .iter()
            .for_each(|&t| piece[t as usize] = count as u32);
        count += 1;
    }
    (piece, count)
}

fn flatten(map: Map) -> Flatten {
    match map {
        Map::Abf => abf::abf,
        _ => lscm::lscm,
    }
}

fn quality(surface: &Surface, settled: &Settled) -> Quality {
    let mut sums = stretch::Sums::default();
    let mut chart_of = vec![u32::MAX; surface.triangles.len()];
    for (c, flat) in settled.charts.iter().enumerate() {
        sums.join(&stretch::sums(&flat.chart, &flat.places));
        flat.chart
            .triangles
            .iter()
            .for_each(|&t| chart_of[t as usize] = c as u32);
    }
    let cut_inside: f64 = settled.charts.iter().map(|flat| slits(surface, flat)).sum();
    let between = (0..surface.across.len()).filter_map(|h| {
        let other = surface.neighbour(h)?;
        (chart_of[h / 3] < chart_of[other]).then(|| surface.length(h))
    });
    let area: f64 = surface.areas.iter().sum();
    Quality {
        charts: settled.charts.len(),
        stretch: sums.stretch(),
        seam_length: (between.sum::<f64>() + cut_inside) / area.sqrt(),
        filled_fraction: sums.flat_share(settled.side),
        turned_triangles: settled.turned.clone(),
    }
}

/// Length of the cuts inside of a chart: sides of its rim that have the same chart across.
fn slits(surface: &Surface, flat: &Flat) -> f64 {
    if flat.chart.cuts == 0 {
        return 0.0;
    }
    let own = |t: usize| flat.chart.triangles.binary_search(&(t as u32)).ok();
    let mut length = 0.0;
    for (i, &t) in flat.chart.triangles.iter().enumerate() {
        for k in 0..3usize {
            let h = 3 * t as usize + k;
            let Some(j) = surface.neighbour(h).and_then(own) else {
                continue;
            };
            let other = surface.across[h] as usize % 3;
            let joined = flat.chart.corners[i][k] == flat.chart.corners[j][(other + 1) % 3]
                && flat.chart.corners[i][(k + 1) % 3] == flat.chart.corners[j][other];
            if !joined {
                length += 0.5 * surface.length(h);
            }
        }
    }
    length
}

/// Places of the mesh's vertices, with copies where charts meet.
fn embedding(mesh: &Mesh, settled: &Settled) -> Embedding {
    const NOWHERE: u32 = u32::MAX;
    let mut places = vec![];
    let mut class = vec![[NOWHERE; 3]; mesh.triangles.len()];
    for flat in &settled.charts {
        let first = places.len() as u32;
        places.extend(&flat.places);
        for (&t, corners) in flat.chart.triangles.iter().zip(&flat.chart.corners) {
            class[t as usize] = corners.map(|v| v + first);
        }
    }
    let mut own = vec![NOWHERE; mesh.positions.len()];
    for (triangle, class) in mesh.triangles.iter().zip(&class) {
        for (&v, &c) in triangle.iter().zip(class) {
            if own[v as usize] == NOWHERE {
                own[v as usize] = c;
            }
        }
    }
    // Triangles without area: one point, that of the first corner that has one.
    for (triangle, class) in mesh.triangles.iter().zip(&mut class) {
        if class[0] == NOWHERE {
            let known = triangle
                .iter()
                .map(|&v| own[v as usize])
                .find(|&c| c != NOWHERE);
            *class = [known.unwrap_or(NOWHERE); 3];
        }
    }
    let mut copies = vec![];
    let mut copied: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut moved = vec![];
    let mut of_copies = vec![];
    for (t, (triangle, class)) in mesh.triangles.iter().zip(&class).enumerate() {
        for k in 0..3 {
            let (v, c) = (triangle[k], class[k]);
            if own[v as usize] == NOWHERE {
                own[v as usize] = c;
            }
            if own[v as usize] != c {
                let vertex = *copied.entry((v, c)).or_insert_with(|| {
                    copies.push(v);
                    of_copies.push(c);
                    (mesh.positions.len() + copies.len() - 1) as u32
                });
                moved.push([(3 * t + k) as u32, vertex]);
            }
        }
    }
    let place = |c: &u32| match places.get(*c as usize) {
        Some(p) => settle::to_uv(*p, settled.side),
        None => [0.5, 0.5, 0.0],
    };
    Embedding {
        t3: own.iter().chain(&of_copies).map(place).collect(),
        copies,
        moved,
    }
}
