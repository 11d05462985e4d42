//! A sphere for surfaces that are not star-shaped: places on it are computed, projection from the centre does the rest.
//!
//! In: a mesh whose parts have no handles; holes are closed. Out: a [`Computed`] map without seams: every triangle is seen
//! the right way round from the centre, on the integer grid too.
//!
//! ```text
//! mesh -> closed (holes get a lid) -> coarsen (to a tetrahedron) -> build (vertex by vertex onto the sphere) -> grid
//! ```
//!
//! Each part covers the whole sphere; layers tell parts apart.
//! Source: Praun, Hoppe, Spherical Parametrization and Remeshing (2003).

mod build;
pub(super) mod closed;
mod coarsen;
pub(super) mod grid;
mod place;

use super::charts::Stretch;
use super::computed::{Computed, Map, Quality};
use super::grid::Frame;
use crate::error::{Error, Result};
use crate::mesh::{Embedding, Mesh};
use closed::Closed;
use glam::DVec3;
use rayon::prelude::*;

/// The spherical map of `mesh`.
///
/// # Errors
/// [`Error::Parameterization`] where a part is no sphere: handles, edges of three triangles, surfaces that touch in a point.
pub(crate) fn sphere(mesh: &Mesh) -> Result<Computed> {
    let (parts, weld) = closed::parts(mesh, Map::Sphere)?;
    let of_parts: Vec<Option<Vec<[i32; 3]>>> = parts.par_iter().map(on_grid).collect();
    let mut t3 = vec![[grid::RADIUS as i32, 0, 0]; mesh.positions.len()];
    for (part, places) in parts.iter().zip(of_parts) {
        let Some(places) = places else {
            return Err(Error::Parameterization {
                mesh: mesh.name.clone(),
                reason: "sphere:map cannot be had: too many triangles meet in too little room; try --primary lscm".into(),
            });
        };
        for (vertex, place) in part.vertex.iter().zip(places) {
            if let Some(v) = vertex {
                t3[*v as usize] = place;
            }
        }
    }
    let places: Vec<[i32; 3]> = weld.iter().map(|&first| t3[first as usize]).collect();
    let quality = quality(mesh, &places, parts.len());
    let unit = |c: i32| (f64::from(c) / grid::STEPS) as f32;
    Ok(Computed {
        map: Map::Sphere,
        embedding: Embedding {
            t3: places.iter().map(|p| p.map(unit)).collect(),
            ..Embedding::default()
        },
        frame: Frame {
            origin: [0.0; 3],
            scale: grid::STEPS,
        },
        quality,
    })
}

/// The point of the map's sphere in the direction of `t3`.
pub(crate) fn onto(t3: [f64; 3]) -> [f64; 3] {
    let radius = grid::RADIUS / grid::STEPS;
    (DVec3::from(t3).try_normalize().unwrap_or(DVec3::X) * radius).to_array()
}

/// Places of a part's vertices on the grid.
fn on_grid(part: &Closed) -> Option<Vec<[i32; 3]>> {
    let scaled = part.of_unit_area();
    let coarse = coarsen::coarsen(&scaled)?;
    let places = build::build(&scaled, &coarse)?;
    let all_numbers = places.iter().all(|p| p.is_finite());
    let round = |p: &DVec3| (*p * grid::RADIUS).round().as_ivec3().to_array();
    let on_grid = places.iter().map(round).collect();
    let turned = |t| grid::determinant(t) <= 0;
    all_numbers.then(|| grid::settle(on_grid, &scaled.triangles, turned))
}

impl Closed {
    /// The same as large as the unit sphere: what stretch is measured against.
    fn of_unit_area(&self) -> Closed {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.places[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        let all: f64 = self.triangles.iter().map(area).sum();
        let sphere = 4.0 * std::f64::consts::PI;
        let scale = if all > 0.0 {
            (sphere / all).sqrt()
        } else {
            1.0
        };
        let middle = self.places.iter().sum::<DVec3>() / self.places.len() as f64;
        Closed {
            vertex: self.vertex.clone(),
            places: self.places.iter().map(|p| (*p - middle) * scale).collect(),
            triangles: self.triangles.clone(),
            own: self.own,
        }
    }
}

/// Stretch from the sphere to the surface over all parts together, and what is turned over on the grid.
fn quality(mesh: &Mesh, places: &[[i32; 3]], parts: usize) -> Quality {
    let mut sums = super::charts::Sums::default();
    let mut turned = vec![];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corners = triangle.map(|v| places[v as usize]);
        let [a, b, c] = mesh.corners(t).map(|p| DVec3::from(p.map(f64::from)));
        // What names a place twice, at a pole for instance, is seen from nowhere.
        let [p, q, r] = corners;
        let line = p == q || q == r || r == p;
        if !line && grid::determinant(corners) <= 0 {
            turned.push(t as u32);
        }
        if (b - a).cross(c - a).length() > 0.0 {
            sums.add_in_space(
                [a, b, c],
                corners.map(|p| DVec3::from(p.map(f64::from)) / grid::STEPS),
            );
        }
    }
    let stretch: Stretch = sums.stretch();
    Quality {
        charts: parts,
        stretch,
        seam_length: 0.0,
        filled_fraction: 1.0,
        turned_triangles: turned,
    }
}
