//! Maps to texture space that are computed, where position alone will not do.
//!
//! In: a mesh and which [`Map`]. Out: [`Computed`]: the paper's C, from the surface to T3, as places of vertices
//! ([`Embedding`]), apart from the projection P, which is that of any other primary ([`Map::line`]): charts are
//! projected like a uv set.
//! Source: Inverse Geometric Textures, section 2 and figure 3 (M_T = M o P o C).

use super::charts::{self, Stretch};
use super::cylindrical;
use super::grid::Frame;
use super::projection::Line;
use super::spherical;
use super::{Primary, PrimaryKind};
use crate::error::Result;
use crate::mesh::{Embedding, Mesh};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A map that is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Map {
    /// Charts by least squares conformal maps.
    Lscm,
    /// Charts by angle based flattening.
    Abf,
    /// Few charts by spectral analysis of geodesic distances.
    Isochart,
    /// Each part opened to a disk and laid on a square.
    GeometryImage,
    /// Surfaces without handles on a sphere, without a seam.
    Sphere,
    /// Tubes on a cylinder, without a seam.
    Cylinder,
}

impl Map {
    /// All of them.
    pub const ALL: [Map; 6] = [
        Map::Lscm,
        Map::Abf,
        Map::Isochart,
        Map::GeometryImage,
        Map::Sphere,
        Map::Cylinder,
    ];

    /// The projection lines of T3 (P of the paper).
    pub fn line(self) -> Line {
        match self {
            Map::Lscm | Map::Abf | Map::Isochart | Map::GeometryImage => Line::Parallel,
            Map::Sphere => Line::Sphere,
            Map::Cylinder => Line::Cylinder,
        }
    }

    /// The place in T3 that a point near the map's image stands for: a LoD's vertices are moved in T3, and may leave the
    /// sphere on which projection lines meet everything at a right angle. About an axis a place keeps its distance, which no
    /// projection line depends on: the poles of a closed surface lie on the axis itself.
    pub fn onto(self, t3: [f64; 3]) -> [f64; 3] {
        match self {
            Map::Lscm | Map::Abf | Map::Isochart | Map::GeometryImage | Map::Cylinder => t3,
            Map::Sphere => spherical::onto(t3),
        }
    }

    /// Whether the surface is cut into charts.
    pub fn has_charts(self) -> bool {
        self.line() == Line::Parallel
    }

    /// The map of this name.
    pub fn named(name: &str) -> Option<Map> {
        Map::ALL.into_iter().find(|map| map.name() == name)
    }

    /// The name, as `--primary` spells it.
    pub fn name(self) -> &'static str {
        match self {
            Map::Lscm => "lscm",
            Map::Abf => "abf",
            Map::Isochart => "isochart",
            Map::GeometryImage => "geometry-image",
            Map::Sphere => "sphere:map",
            Map::Cylinder => "cylinder:map",
        }
    }

    /// Whether a bound of the stretch decides how many charts there are.
    pub fn takes_stretch(self) -> bool {
        matches!(self, Map::Lscm | Map::Abf | Map::Isochart)
    }

    /// Computes the map of `mesh`.
    ///
    /// # Errors
    /// [`Error::Parameterization`](crate::Error::Parameterization) where the mesh cannot have it, and why.
    pub fn compute(self, mesh: &Mesh) -> Result<Computed> {
        self.compute_within(mesh, None)
    }

    /// The same, with charts merged only while their stretch (L2) is no more than `stretch`, where it is given and the map
    /// takes it.
    ///
    /// # Errors
    /// As [`Map::compute`].
    pub fn compute_within(self, mesh: &Mesh, stretch: Option<f64>) -> Result<Computed> {
        match self {
            Map::Lscm | Map::Abf | Map::Isochart | Map::GeometryImage => {
                charts::unwrap(mesh, self, stretch)
            }
            Map::Sphere => spherical::sphere(mesh),
            Map::Cylinder => cylindrical::cylinder(mesh),
        }
    }
}

impl fmt::Display for Map {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A computed map of one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Computed {
    /// Which.
    pub map: Map,
    /// Where vertices lie, and where the mesh is cut open.
    pub embedding: Embedding,
    /// The grid for it.
    pub frame: Frame,
    /// How good it is.
    pub quality: Quality,
}

impl Computed {
    /// The primary parameterization that reads it.
    pub fn primary(&self) -> Primary {
        Primary {
            kind: PrimaryKind::Computed(self.map),
            frame: self.frame,
        }
    }
}

/// How good a computed map is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Charts.
    pub charts: usize,
    /// Over all of them.
    pub stretch: Stretch,
    /// Length of all cuts, over the square root of the surface's area.
    pub seam_length: f64,
    /// Share of the square that charts fill.
    pub filled_fraction: f64,
    /// Triangles that are turned over on the grid, or lie in a chart that overlaps itself: none, but where nothing helped.
    pub turned_triangles: Vec<u32>,
}
