//! A cylinder for tubes that no axis sees whole: places on it are computed, projection away from the axis does the rest.
//!
//! In: a mesh whose parts have no handles. Out: a [`Computed`] map without seams: every triangle is seen the right way round
//! from the axis, on the integer grid too.
//!
//! ```text
//! mesh -> closed (holes get a lid) -> annulus (two poles taken out) -> harmonic (angle and height) -> height (how long)
//!      -> grid; the poles go onto the axis, beyond the ends
//! ```
//!
//! The poles are the middles of the two longest holes; where there are fewer, vertices far away. Each part covers the whole
//! cylinder; layers tell parts apart.
//! Source: Tutte, How to draw a graph (1963), for a ring by Gortler, Gotsman, Thurston, Discrete one-forms on meshes and
//! applications to 3D mesh parameterization (2006): with positive weights, heights fixed at both ends and angles free, no
//! triangle of the flat ring is turned over.

mod annulus;
mod harmonic;
mod height;

use super::charts::{Stretch, Sums};
use super::computed::{Computed, Map, Quality};
use super::grid::Frame;
use super::spherical::closed::{self, Closed};
use super::spherical::grid::{STEPS, settle};
use crate::error::{Error, Result};
use crate::mesh::{Embedding, Mesh};
use annulus::Annulus;
use glam::DVec3;
use rayon::prelude::*;

/// How far places reach on the grid: 31/32 of it.
const REACH: f64 = 31.0 / 32.0;
/// Half the height over the radius, at least and at most: angles and heights keep 18 bits.
const HALF_HEIGHT: [f64; 2] = [0.25, 32.0];
/// How far beyond its end a pole lies, as a share of the height.
const BEYOND: f64 = 0.02;
/// Powers of a tube's width by which its length is spread, best first (see [`height`]).
const POWERS: [f64; 3] = [1.0 / 3.0, -0.5, -1.0];

/// The cylindrical map of `mesh`.
///
/// # Errors
/// [`Error::Parameterization`] where a part is no tube: handles, edges of three triangles, too few triangles, or too many in too
/// little room.
pub(crate) fn cylinder(mesh: &Mesh) -> Result<Computed> {
    let refuse = |reason: &str| Error::Parameterization {
        mesh: mesh.name.clone(),
        reason: format!("cylinder:map cannot be had: {reason}; charts can, such as --primary lscm"),
    };
    let (parts, weld) = closed::parts(mesh, Map::Cylinder)?;
    let rings: Vec<Annulus> = parts
        .par_iter()
        .map(Annulus::new)
        .collect::<Result<_, String>>()
        .map_err(|reason| refuse(&reason))?;
    let laid: Vec<Option<(Vec<[i32; 3]>, f64)>> = rings.par_iter().map(on_grid).collect();
    let none = [(REACH * STEPS) as i32, 0, 0];
    let mut t3 = vec![none; mesh.positions.len()];
    let mut filled = 0.0f64;
    for (ring, laid) in rings.iter().zip(laid) {
        let (places, height) = laid.ok_or_else(|| {
            refuse("too many of its triangles meet in too little room, or are too large for their tube")
        })?;
        filled = filled.max(height);
        for (vertex, place) in ring.closed.vertex.iter().zip(places) {
            if let Some(v) = vertex {
                t3[*v as usize] = place;
            }
        }
    }
    let places: Vec<[i32; 3]> = weld.iter().map(|&first| t3[first as usize]).collect();
    let unit = |c: i32| (f64::from(c) / STEPS) as f32;
    Ok(Computed {
        map: Map::Cylinder,
        embedding: Embedding {
            t3: places.iter().map(|p| p.map(unit)).collect(),
            ..Embedding::default()
        },
        frame: Frame {
            origin: [0.0; 3],
            scale: STEPS,
        },
        quality: quality(mesh, &places, parts.len(), filled),
    })
}

/// Places of a part's vertices on the grid, with the share of the grid's height that they take: by the way of spreading
/// heights that stretches least, of those that turn no triangle over.
fn on_grid(ring: &Annulus) -> Option<(Vec<[i32; 3]>, f64)> {
    let flat = harmonic::solve(ring)?;
    let tried = POWERS.iter().filter_map(|&power| {
        let places = height::spread(ring, &flat, power)?;
        let (radius, half) = extent(&places);
        let round = |p: &DVec3| (*p * (REACH * STEPS / radius.max(half))).round().as_ivec3();
        let on_grid: Vec<[i32; 3]> = places.iter().map(|p| round(p).to_array()).collect();
        let triangles = &ring.closed.triangles;
        let settled = settle(on_grid, triangles, |t| !seen_upright(&t));
        let whole = triangles
            .iter()
            .all(|t| seen_upright(&t.map(|v| settled[v as usize])));
        let stretch = stretch(ring, &settled).l2;
        let filled = REACH * (half / radius).min(1.0);
        whole.then_some((stretch, settled, filled))
    });
    tried
        .reduce(|best, other| if other.0 < best.0 { other } else { best })
        .map(|(_, places, filled)| (places, filled))
}

/// The radius, and the largest distance from the middle height.
fn extent(places: &[DVec3]) -> (f64, f64) {
    places.iter().fold((0.0, 0.0), |(radius, half), p| {
        (p.truncate().length().max(radius), p.z.abs().max(half))
    })
}

/// Whether half-lines from the axis meet a triangle everywhere from inside: its normal has to point away from the axis at
/// each corner that does not lie on it, and so does in between. Exact.
fn seen_upright(corners: &[[i32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p.map(i128::from));
    let across = |i: usize, j: usize| (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
    let normal = [across(1, 2), across(2, 0)];
    let mut away = 0;
    for p in [a, b, c].iter().filter(|p| p[0] != 0 || p[1] != 0) {
        let sense = normal[0] * p[0] + normal[1] * p[1];
        if sense <= 0 {
            return false;
        }
        away += 1;
    }
    away >= 2
}

/// What the map does to a part's own triangles.
fn stretch(ring: &Annulus, places: &[[i32; 3]]) -> Stretch {
    let closed: &Closed = &ring.closed;
    let mut sums = Sums::default();
    for t in &closed.triangles[..closed.own] {
        let shape = t.map(|v| closed.places[v as usize]);
        let image = t.map(|v| in_units(places[v as usize]));
        add(&mut sums, shape, image);
    }
    sums.stretch()
}

fn in_units(place: [i32; 3]) -> DVec3 {
    DVec3::from(place.map(f64::from)) / STEPS
}

fn add(sums: &mut Sums, shape: [DVec3; 3], image: [DVec3; 3]) {
    let [a, b, c] = shape;
    if (b - a).cross(c - a).length() > 0.0 {
        sums.add_in_space(shape, image);
    }
}

/// Stretch over all parts together, and what is turned over on the grid.
fn quality(mesh: &Mesh, places: &[[i32; 3]], parts: usize, filled: f64) -> Quality {
    let mut sums = Sums::default();
    let mut turned = vec![];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corners = triangle.map(|v| places[v as usize]);
        let [p, q, r] = corners;
        let line = p == q || q == r || r == p;
        if !line && !seen_upright(&corners) {
            turned.push(t as u32);
        }
        let shape = mesh.corners(t).map(|p| DVec3::from(p.map(f64::from)));
        add(&mut sums, shape, corners.map(in_units));
    }
    Quality {
        charts: parts,
        stretch: sums.stretch(),
        seam_length: 0.0,
        filled_fraction: filled,
        turned_triangles: turned,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_is_seen_upright_from_inside_only() {
        let (a, b, c) = ([1000, 0, 0], [0, 1000, 0], [700, 700, 500]);
        assert!(seen_upright(&[a, b, c]));
        assert!(!seen_upright(&[a, c, b]), "wound the other way");
        // A cone about the axis: its tip may lie on it, a whole edge may not.
        assert!(seen_upright(&[b, a, [0, 0, -50]]));
        assert!(!seen_upright(&[b, [0, 0, 900], [0, 0, -50]]));
        // Flat across the axis: met by no half-line.
        assert!(!seen_upright(&[
            [1000, 0, 0],
            [-500, 800, 0],
            [-500, -800, 0]
        ]));
    }
}
