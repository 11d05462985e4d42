//! How well each primary parameterization fits a mesh: where it is one-to-one, and where not.
//!
//! In: a mesh. Out: a [`Fit`] per primary that can be had, all numbers measured: shares of surface area that are turned,
//! shares of the hash domain that are covered more than once (by any triangles, or within one connected part, where
//! even the part does not decide), and the worst triangles by id.
//! Source: Inverse Geometric Textures, section 5 (non-bijective objects); design, section 3.

use super::fit_centre::search;
use super::fit_domain::Domain;
use super::fit_overlap::{LAYOUT_TEXELS, Overlap, SHEET_TEXELS, measure};
use super::fit_surface::{Surface, parts_of};
use super::projection::Line;
use super::{Axis, Primary, PrimaryKind};
use crate::error::Result;
use crate::mesh::{Components, Mesh};
use rayon::prelude::*;
use serde::Serialize;

/// Up to this share of texels is rounding: one texel in a large layout.
const ROUNDING: f64 = 2e-6;
/// Triangles named per fit.
const NAMED: usize = 16;

/// How one primary parameterization fits one mesh. Fractions are 0..1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// The primary.
    pub kind: PrimaryKind,
    /// Origin in T3 coordinates (axis third): the sphere's centre, a point of the cylinder's axis; otherwise the middle
    /// of the box.
    pub centre: [f64; 3],
    /// One-to-one: nothing turned, nothing covered twice, nothing without an image.
    pub bijective: bool,
    /// Share of the surface area whose projection lines meet the back: for a cylinder of the area that does not face
    /// its ends; for a uv set what is turned against the rest of its own chart.
    pub turned_fraction: f64,
    /// Share of the covered hash domain that is covered more than once.
    pub overlap_fraction: f64,
    /// The same within one connected part, where no layer can tell the answers apart.
    pub overlap_within_parts: f64,
    /// Share of the surface area whose image has no area, or that faces an end of the cylinder.
    pub degenerate_fraction: f64,
    /// Triangles (of non-zero area) without an image.
    pub degenerate_triangles: usize,
    /// Mean cosine between surface and projection line over the area, turned parts as 0: 1 where every line meets the
    /// surface at a right angle. 0 for uv sets.
    pub facing: f64,
    /// Charts of a uv set; connected parts otherwise.
    pub charts: usize,
    /// Share of the uv area with the minority orientation; 0 for others.
    pub mirrored_fraction: f64,
    /// All uv within [0, 1]; true for others.
    pub inside_unit_square: bool,
    /// Up to 16 triangles, worst first, that are turned or share their image.
    pub worst_triangles: Vec<u32>,
}

/// Every primary that can be had from the mesh: uv sets, planes, cylinders, the sphere, in this order. One that maps
/// more than half of the surface to nothing (a uv set in one point, a sphere about a flat thing) cannot be had.
pub fn fits(mesh: &Mesh) -> Vec<Fit> {
    let mut kinds: Vec<PrimaryKind> = (0..=u8::MAX)
        .map(PrimaryKind::UvSet)
        .filter(|&kind| exists(mesh, kind))
        .collect();
    kinds.extend(Axis::ALL.map(PrimaryKind::Plane));
    kinds.extend(Axis::ALL.map(PrimaryKind::Cylinder));
    kinds.push(PrimaryKind::Sphere);
    // All primaries from position have the same parts.
    let pieces = parts_of(mesh, PrimaryKind::Sphere);
    let fit_of = |kind| {
        let parts = if seamless(kind) {
            pieces.clone()
        } else {
            parts_of(mesh, kind)
        };
        fit_with(mesh, kind, None, parts)
    };
    kinds.into_par_iter().filter_map(fit_of).collect()
}

/// How `kind` fits, with its origin at `centre` (T3) or at the best point found. `None` where it cannot be had.
pub fn fit(mesh: &Mesh, kind: PrimaryKind, centre: Option<[f64; 3]>) -> Option<Fit> {
    exists(mesh, kind)
        .then(|| parts_of(mesh, kind))
        .and_then(|parts| fit_with(mesh, kind, centre, parts))
}

/// Whether the mesh has what the primary is made from.
fn exists(mesh: &Mesh, kind: PrimaryKind) -> bool {
    let vertices = mesh.positions.len();
    match kind {
        PrimaryKind::UvSet(set) => {
            let uv = mesh.uv_sets.get(set as usize);
            uv.is_some_and(|uv| uv.len() == vertices)
        }
        PrimaryKind::Computed(_) => mesh.embedding.t3.len() == vertices,
        _ => true,
    }
}

/// [`fit`] with the parts known; the uv set exists.
fn fit_with(
    mesh: &Mesh,
    kind: PrimaryKind,
    centre: Option<[f64; 3]>,
    parts: Components,
) -> Option<Fit> {
    let mut surface = Surface::new(mesh, kind, parts);
    if surface.area <= 0.0 || !surface.area.is_finite() {
        return None;
    }
    let centre = centre.unwrap_or_else(|| origin(mesh, &mut surface));
    if kind.line() != Line::Parallel {
        surface.set_origin(mesh, centre);
    }
    let without_image = |t: usize| if surface.facing[t] == 0.0 { 1.0 } else { 0.0 };
    if surface.sum(without_image) > 0.5 * surface.area {
        return None;
    }
    Some(measured(mesh, &surface, centre))
}

impl Fit {
    /// The primary itself, ready for building.
    pub fn primary(&self, mesh: &Mesh) -> Result<Primary> {
        match self.kind {
            PrimaryKind::UvSet(_) | PrimaryKind::Plane(_) => Primary::centred(self.kind, mesh),
            PrimaryKind::Cylinder(_) | PrimaryKind::Sphere | PrimaryKind::Computed(_) => {
                Primary::new(self.kind, mesh, self.centre)
            }
        }
    }

    /// Whether T3 comes from position.
    pub fn is_seamless(&self) -> bool {
        seamless(self.kind)
    }

    /// How far from one-to-one where layers cannot help: 0 is best.
    pub(crate) fn fault(&self) -> f64 {
        self.turned_fraction + self.overlap_within_parts + self.degenerate_fraction
    }
}

fn seamless(kind: PrimaryKind) -> bool {
    !kind.has_charts()
}

/// The origin to use: the point that turns least for spheres and cylinders, the middle of the box for the others.
/// Leaves `surface` measured from somewhere inside the mesh.
fn origin(mesh: &Mesh, surface: &mut Surface) -> [f64; 3] {
    let (low, high) = bounds(&surface.points);
    let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    if surface.kind.line() == Line::Parallel {
        return middle;
    }
    let centroid = surface.centroid(mesh);
    surface.set_origin(mesh, centroid);
    let spaces = surface.half_spaces(mesh);
    let extent = [0, 1, 2].map(|k| high[k] - low[k]);
    let radius = 0.5 * extent.iter().map(|x| x * x).sum::<f64>().sqrt();
    let starts = [[0.0; 3], [0, 1, 2].map(|k| middle[k] - centroid[k])];
    let found = search(&spaces, &starts, radius);
    let mut origin = [0, 1, 2].map(|k| (centroid[k] + found[k]).clamp(low[k], high[k]));
    if let PrimaryKind::Cylinder(_) = surface.kind {
        origin[2] = middle[2];
    }
    origin
}

fn measured(mesh: &Mesh, surface: &Surface, centre: [f64; 3]) -> Fit {
    let share = |value: &dyn Fn(usize) -> f64| surface.sum(value) / surface.area;
    let turned = |t: usize| surface.facing[t] < 0.0;
    let flag = |x: bool| if x { 1.0 } else { 0.0 };
    let counted = share(&|t| flag(surface.counted[t]));
    let turned_counted = share(&|t| flag(surface.counted[t] && turned(t)));
    let overlap = overlap(mesh, surface);
    let degenerate = |t: usize| surface.facing[t] == 0.0 || !surface.counted[t];
    let nowhere_turned = (0..surface.areas.len())
        .all(|t| !turned(t) && (surface.areas[t] == 0.0 || surface.facing[t] > 0.0));
    Fit {
        kind: surface.kind,
        centre,
        // In a layout a turned sliver that covers nothing twice is rounding.
        bijective: (nowhere_turned || !seamless(surface.kind)) && overlap.fraction() <= ROUNDING,
        turned_fraction: if counted > 0.0 {
            turned_counted / counted
        } else {
            0.0
        },
        overlap_fraction: overlap.fraction(),
        overlap_within_parts: overlap.fraction_within(),
        degenerate_fraction: share(&|t| flag(degenerate(t))),
        degenerate_triangles: (0..surface.areas.len())
            .filter(|&t| surface.areas[t] > 0.0 && surface.facing[t] == 0.0)
            .count(),
        facing: if surface.kind.has_charts() {
            0.0
        } else {
            share(&|t| surface.facing[t].max(0.0))
        },
        charts: surface.parts,
        mirrored_fraction: mirrored(mesh, surface),
        inside_unit_square: inside_unit_square(mesh, surface.kind),
        worst_triangles: worst(surface, &overlap),
    }
}

/// Overlap over the hash domain; a uv set that fits one tile is measured on that tile.
fn overlap(mesh: &Mesh, surface: &Surface) -> Overlap {
    let whole = Domain::new(surface.kind, &surface.points, 0.0);
    let (domain, side) = match surface.kind.has_charts() {
        true => {
            let (low, high) = bounds(&surface.points);
            let tile = [low[0].floor(), low[1].floor()];
            let one_tile = (0..2).all(|k| high[k] - tile[k] <= 1.0);
            (
                if one_tile { Domain::tile(tile) } else { whole },
                LAYOUT_TEXELS,
            )
        }
        false => (whole, SHEET_TEXELS),
    };
    measure(&domain, side, &surface.part, |t| surface.corners(mesh, t))
}

/// Share of the uv area with the minority orientation.
fn mirrored(mesh: &Mesh, surface: &Surface) -> f64 {
    if !surface.kind.has_charts() {
        return 0.0;
    }
    let (mut front, mut back) = (0.0, 0.0);
    for t in 0..surface.areas.len() {
        let area = surface.uv_area(mesh, t);
        if area > 0.0 {
            front += area
        } else {
            back -= area
        }
    }
    front.min(back) / (front + back).max(f64::MIN_POSITIVE)
}

fn inside_unit_square(mesh: &Mesh, kind: PrimaryKind) -> bool {
    let PrimaryKind::UvSet(set) = kind else {
        return true;
    };
    mesh.uv_sets[set as usize]
        .iter()
        .flatten()
        .all(|x| (0.0..=1.0).contains(x))
}

/// The triangles with the largest turned area or the most shared texels.
fn worst(surface: &Surface, overlap: &Overlap) -> Vec<u32> {
    let badness = |t: usize| {
        let turned = if surface.facing[t] < 0.0 {
            surface.areas[t] / surface.area
        } else {
            0.0
        };
        let shared = overlap.shared_by.get(t).copied().unwrap_or(0);
        turned.max(f64::from(shared) / overlap.covered.max(1) as f64)
    };
    let mut bad: Vec<(f64, u32)> = (0..surface.areas.len())
        .map(|t| (badness(t), t as u32))
        .filter(|&(b, _)| b > 0.0)
        .collect();
    bad.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    bad.truncate(NAMED);
    bad.into_iter().map(|(_, t)| t).collect()
}

fn bounds(points: &[[f64; 3]]) -> ([f64; 3], [f64; 3]) {
    points.iter().fold(
        ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]),
        |(low, high), p| {
            (
                [0, 1, 2].map(|k| low[k].min(p[k])),
                [0, 1, 2].map(|k| high[k].max(p[k])),
            )
        },
    )
}
