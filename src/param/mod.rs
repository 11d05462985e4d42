//! Primary parameterizations M_T: which point of texture space T3, and which hash address, a surface point has.
//!
//! In: a [`Mesh`]. Out: a [`Primary`], which maps vertices to the integer grid of T3 ([`grid`]) and whose
//! projection lines ([`projection`]) decide which reference point a T3 point stands for.
//! Source: Inverse Geometric Textures, section 2 (M_T = M o P o C): [`Primary::t3_of`] is C, [`projection::Line`] is P and
//! [`projection::Line::texel`] is M.

mod charts;
mod computed;
mod contest;
mod cylindrical;
pub mod fit;
mod fit_centre;
mod fit_choose;
pub(crate) mod fit_domain;
mod fit_overlap;
pub(crate) mod fit_surface;
pub mod grid;
pub mod layer;
mod parameterize;
pub mod projection;
mod spherical;
pub(crate) mod weld;

use crate::error::{Error, Result};
use crate::mesh::Mesh;
pub use charts::Stretch;
pub use computed::{Computed, Map, Quality};
pub use contest::Weighed;
pub use fit::{Fit, fit, fits};
pub use fit_choose::choose;
use grid::Frame;
pub use layer::{Parts, parts};
pub use parameterize::{Chosen, parameterize};
use projection::Line;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// A coordinate axis of object space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

impl Axis {
    /// All three, in order.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// A cyclic permutation of `p` that brings this axis to the third place; it keeps handedness.
    pub fn to_third<T: Copy>(self, p: [T; 3]) -> [T; 3] {
        match self {
            Axis::X => [p[1], p[2], p[0]],
            Axis::Y => [p[2], p[0], p[1]],
            Axis::Z => p,
        }
    }

    /// The inverse of [`Axis::to_third`].
    pub fn from_third<T: Copy>(self, p: [T; 3]) -> [T; 3] {
        match self {
            Axis::X => [p[2], p[0], p[1]],
            Axis::Y => [p[1], p[2], p[0]],
            Axis::Z => p,
        }
    }
}

/// The kind of a primary parameterization.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PrimaryKind {
    /// An artist's uv set (TEXCOORD_n) as charts: T3 is (u, v, 0), lines run along the third coordinate.
    UvSet(u8),
    /// Orthogonal projection along an axis: T3 is the position, lines are parallel to the axis.
    Plane(Axis),
    /// Projection away from an axis: T3 is the position, lines are half-lines perpendicular to the axis.
    Cylinder(Axis),
    /// Central projection: T3 is the position, lines are half-lines from the centre.
    Sphere,
    /// A map that was computed: T3 is what the mesh's [`Embedding`](crate::mesh::Embedding) says.
    Computed(Map),
}

impl PrimaryKind {
    /// The family of projection lines: P of the paper, whatever C is.
    pub fn line(self) -> Line {
        match self {
            PrimaryKind::UvSet(_) | PrimaryKind::Plane(_) => Line::Parallel,
            PrimaryKind::Cylinder(_) => Line::Cylinder,
            PrimaryKind::Sphere => Line::Sphere,
            PrimaryKind::Computed(map) => map.line(),
        }
    }

    /// Whether T3 is a plane of charts, (u, v, 0): the surface has seams.
    pub fn has_charts(self) -> bool {
        match self {
            PrimaryKind::UvSet(_) => true,
            PrimaryKind::Computed(map) => map.has_charts(),
            _ => false,
        }
    }
}

/// A primary parameterization, ready to map points: its kind, and where its frame lies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Primary {
    /// What is projected and how.
    pub kind: PrimaryKind,
    /// Where T3's integer grid lies. Its origin is the sphere's centre, a point of the cylinder's axis, or the
    /// middle of the charts' box.
    pub frame: Frame,
}

impl Primary {
    /// The primary of `kind` over `mesh` with the given `origin` (in T3 coordinates, see [`Primary::t3_of`]); the
    /// scale is the one that fits the mesh.
    pub fn new(kind: PrimaryKind, mesh: &Mesh, origin: [f64; 3]) -> Result<Self> {
        if let PrimaryKind::UvSet(set) = kind
            && mesh
                .uv_sets
                .get(set as usize)
                .is_none_or(|uv| uv.len() != mesh.positions.len())
        {
            return Err(Error::Parameterization {
                mesh: mesh.name.clone(),
                reason: format!(
                    "it has no uv set {set} (it has {}); choose a primary from position, such as --primary sphere",
                    mesh.uv_sets.len()
                ),
            });
        }
        if let PrimaryKind::Computed(map) = kind
            && mesh.embedding.t3.len() != mesh.positions.len()
        {
            return Err(Error::Parameterization {
                mesh: mesh.name.clone(),
                reason: format!("{map} is not computed for it"),
            });
        }
        let unscaled = Primary {
            kind,
            frame: Frame { origin, scale: 1.0 },
        };
        let reach = (0..mesh.positions.len())
            .map(|v| unscaled.t3_of(mesh, v))
            .flat_map(|p| {
                [
                    (p[0] - origin[0]).abs(),
                    (p[1] - origin[1]).abs(),
                    (p[2] - origin[2]).abs(),
                ]
            })
            .fold(0.0, f64::max);
        let frame = Frame::fitting(origin, reach).ok_or_else(|| Error::Parameterization {
            mesh: mesh.name.clone(),
            reason: format!("{kind} has no extent over it: every vertex maps to one point"),
        })?;
        Ok(Primary { kind, frame })
    }

    /// The primary of `kind` with its origin in the middle of the mesh's T3 box.
    pub fn centred(kind: PrimaryKind, mesh: &Mesh) -> Result<Self> {
        let probe = Primary {
            kind,
            frame: Frame {
                origin: [0.0; 3],
                scale: 1.0,
            },
        };
        if let PrimaryKind::UvSet(_) | PrimaryKind::Computed(_) = kind {
            Primary::new(kind, mesh, [0.0; 3])?;
        }
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for v in 0..mesh.positions.len() {
            let p = probe.t3_of(mesh, v);
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        if mesh.positions.is_empty() {
            (low, high) = ([0.0; 3], [0.0; 3]);
        }
        Primary::new(kind, mesh, [0, 1, 2].map(|k| (low[k] + high[k]) * 0.5))
    }

    /// Whether T3 comes from position, so that the surface has no cuts (seams) in T3.
    pub fn is_seamless(&self) -> bool {
        !self.kind.has_charts()
    }

    /// The family of projection lines.
    pub fn line(&self) -> Line {
        self.kind.line()
    }

    /// The T3 coordinates of an object-space position, for primaries from position: the axis comes third. For the others a
    /// point of T3 is what it is.
    pub fn t3_of_position(&self, p: [f64; 3]) -> [f64; 3] {
        match self.kind {
            PrimaryKind::UvSet(_) | PrimaryKind::Sphere | PrimaryKind::Computed(_) => p,
            PrimaryKind::Plane(axis) | PrimaryKind::Cylinder(axis) => axis.to_third(p),
        }
    }

    /// The T3 coordinates (before the grid) of a vertex. Panics where the vertex or its uv set does not exist.
    pub fn t3_of(&self, mesh: &Mesh, vertex: usize) -> [f64; 3] {
        match self.kind {
            PrimaryKind::UvSet(set) => {
                let uv = mesh.uv_sets[set as usize][vertex];
                [uv[0] as f64, uv[1] as f64, 0.0]
            }
            PrimaryKind::Computed(_) => mesh.embedding.t3[vertex].map(f64::from),
            _ => self.t3_of_position(mesh.positions[vertex].map(f64::from)),
        }
    }

    /// A T3 point on the vertex grid (see [`grid`]); points outside the domain go to its border.
    pub fn to_grid(&self, t3: [f64; 3]) -> [i32; 3] {
        self.frame.to_vertex_grid(t3)
    }

    /// A T3 point on the query grid; points outside the domain go to its border.
    pub fn to_query(&self, t3: [f64; 3]) -> [i32; 3] {
        self.frame.to_query_grid(t3)
    }
}

impl fmt::Display for PrimaryKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letter = |axis: &Axis| ["x", "y", "z"][*axis as usize];
        match self {
            PrimaryKind::UvSet(set) => write!(f, "uv{set}"),
            PrimaryKind::Plane(axis) => write!(f, "plane:{}", letter(axis)),
            PrimaryKind::Cylinder(axis) => write!(f, "cylinder:{}", letter(axis)),
            PrimaryKind::Sphere => write!(f, "sphere"),
            PrimaryKind::Computed(map) => write!(f, "{map}"),
        }
    }
}

/// What a caller asks for with `--primary`; missing parameters are found by measuring.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PrimaryRequest {
    /// The best one, by measured bijectivity, stretch and seams.
    #[default]
    Auto,
    /// `uv0`, `uv1`, ...
    UvSet(u8),
    /// `plane` or `plane:z`.
    Plane(Option<Axis>),
    /// `cylinder` or `cylinder:y`.
    Cylinder(Option<Axis>),
    /// `sphere` or `sphere:x,y,z` (the centre).
    Sphere(Option<[f32; 3]>),
    /// A computed map, and for charts how much they may be stretched: `lscm`, `lscm:1.05`.
    Computed(Map, Option<f64>),
}

impl FromStr for PrimaryRequest {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let refuse = |reason: String| Error::Option {
            option: "--primary",
            reason,
        };
        if let Some(map) = Map::named(text) {
            return Ok(PrimaryRequest::Computed(map, None));
        }
        let (kind, parameter) = match text.split_once(':') {
            Some((kind, parameter)) => (kind, Some(parameter)),
            None => (text, None),
        };
        let axis = || match parameter {
            None => Ok(None),
            Some("x") => Ok(Some(Axis::X)),
            Some("y") => Ok(Some(Axis::Y)),
            Some("z") => Ok(Some(Axis::Z)),
            Some(other) => Err(refuse(format!("axis \"{other}\" is not x, y or z"))),
        };
        if let (Some(map), Some(bound)) = (Map::named(kind), parameter)
            && map.takes_stretch()
        {
            let stretch = bound.parse().ok().filter(|s| (1.0..=10.0).contains(s));
            let stretch = stretch.ok_or_else(|| {
                refuse(format!("stretch \"{bound}\" is not a number from 1 to 10"))
            })?;
            return Ok(PrimaryRequest::Computed(map, Some(stretch)));
        }
        match kind {
            "auto" if parameter.is_none() => Ok(PrimaryRequest::Auto),
            "plane" => Ok(PrimaryRequest::Plane(axis()?)),
            "cylinder" => Ok(PrimaryRequest::Cylinder(axis()?)),
            "sphere" => Ok(PrimaryRequest::Sphere(parameter.map(centre).transpose()?)),
            _ => match kind.strip_prefix("uv").map(u8::from_str) {
                Some(Ok(set)) if parameter.is_none() => Ok(PrimaryRequest::UvSet(set)),
                _ => Err(refuse(format!(
                    "\"{text}\" is none of auto, uv0, uv1, .., plane[:axis], cylinder[:axis], sphere[:x,y,z], {}",
                    Map::ALL.map(Map::name).join(", ")
                ))),
            },
        }
    }
}

fn centre(text: &str) -> Result<[f32; 3]> {
    let refuse = || Error::Option {
        option: "--primary",
        reason: format!("sphere centre \"{text}\" is not three finite numbers x,y,z"),
    };
    let numbers: Vec<f32> = text
        .split(',')
        .map(|n| n.trim().parse())
        .collect::<Result<_, _>>()
        .map_err(|_| refuse())?;
    let c: [f32; 3] = numbers.try_into().map_err(|_| refuse())?;
    if c.iter().all(|x| x.is_finite()) {
        Ok(c)
    } else {
        Err(refuse())
    }
}
