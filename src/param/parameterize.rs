//! A primary parameterization for a mesh, computed where it has to be.
//!
//! In: a mesh and a [`PrimaryRequest`]. Out: [`Chosen`]: the [`Primary`], why it was taken, and, where it is a computed map, the
//! mesh's places in T3. The mesh has to be cut open for those ([`Embedding::cut_open`](crate::mesh::Embedding::cut_open))
//! before anything else is done with it.

use super::computed::{Computed, Map};
use super::fit_choose::{choose, sound};
use super::{Primary, PrimaryRequest};
use crate::error::Result;
use crate::mesh::Mesh;

/// A primary parameterization and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// The primary.
    pub primary: Primary,
    /// Why this one, with the numbers that decided.
    pub why: String,
    /// The map, where it was computed.
    pub computed: Option<Computed>,
}

/// The primary for `request`, and why.
///
/// # Errors
/// [`Error::Parameterization`](crate::Error::Parameterization) where the request cannot be had, or nothing can, saying what to do.
pub fn parameterize(mesh: &Mesh, request: &PrimaryRequest) -> Result<Chosen> {
    match *request {
        PrimaryRequest::Computed(map, stretch) => computed(mesh, map, stretch),
        PrimaryRequest::Auto if !mesh.triangles.is_empty() => automatic(mesh),
        _ => {
            let (primary, why) = choose(mesh, request)?;
            Ok(Chosen {
                primary,
                why,
                computed: None,
            })
        }
    }
}

/// A sphere is taken up to this stretch: what it shrinks more has too few texels of the hash.
const STRETCH: f64 = 2.0;

/// What the file and positions give, if that is any good; else a sphere, else charts; else what there was.
fn automatic(mesh: &Mesh) -> Result<Chosen> {
    let instead = match sound(mesh) {
        Ok(Ok((primary, why))) => {
            return Ok(Chosen {
                primary,
                why,
                computed: None,
            });
        }
        Ok(Err(best)) => format!("the best of the others is {best}"),
        Err(_) => "nothing else can be had".into(),
    };
    let whole = |computed: &Computed| computed.quality.turned_triangles.is_empty();
    let sphere = Map::Sphere.compute(mesh);
    let round = |computed: &Computed| whole(computed) && computed.quality.stretch.l2 <= STRETCH;
    let (computed, how) = match sphere {
        Ok(sphere) if round(&sphere) => (sphere, "seamless, computed"),
        _ => match Map::Lscm.compute(mesh) {
            Ok(charts) if whole(&charts) => (charts, "charts, computed"),
            _ => {
                let (primary, why) = choose(mesh, &PrimaryRequest::Auto)?;
                return Ok(Chosen {
                    primary,
                    why,
                    computed: None,
                });
            }
        },
    };
    let why = format!("{}, {how}: {}; {instead}", computed.map, verdict(&computed));
    Ok(Chosen {
        primary: computed.primary(),
        why,
        computed: Some(computed),
    })
}

fn computed(mesh: &Mesh, map: Map, stretch: Option<f64>) -> Result<Chosen> {
    let computed = map.compute_within(mesh, stretch)?;
    let why = format!("{map}, as asked: {}", verdict(&computed));
    Ok(Chosen {
        primary: computed.primary(),
        why,
        computed: Some(computed),
    })
}

/// What the numbers say, in a clause.
fn verdict(computed: &Computed) -> String {
    let quality = &computed.quality;
    let pieces = if computed.map.has_charts() {
        "chart"
    } else {
        "part"
    };
    let charts = match quality.charts {
        1 => format!("1 {pieces}"),
        n => format!("{n} {pieces}s"),
    };
    let whole = match quality.turned_triangles.len() {
        0 => "one-to-one on the grid".to_owned(),
        n => format!("{n} triangles turned over"),
    };
    format!(
        "{charts}, {whole}, stretch {:.3} (at most {:.2}), angles {:.4}, seams {:.1} times the root of the area, {:.0} % of the square filled",
        quality.stretch.l2,
        quality.stretch.linf,
        quality.stretch.angle,
        quality.seam_length,
        100.0 * quality.filled_fraction
    )
}
