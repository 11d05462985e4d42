//! A primary parameterization for a mesh, computed where it has to be.
//!
//! In: a mesh and a [`PrimaryRequest`]. Out: [`Chosen`]: the [`Primary`], why it was taken, and, where it is a computed map, the
//! mesh's places in T3. The mesh has to be cut open for those ([`Embedding::cut_open`](crate::mesh::Embedding::cut_open))
//! before anything else is done with it.

use super::computed::{Computed, Map};
use super::fit_choose::choose;
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
        PrimaryRequest::Computed(map) => computed(mesh, map),
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

fn computed(mesh: &Mesh, map: Map) -> Result<Chosen> {
    let computed = map.compute(mesh)?;
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
    let charts = match quality.charts {
        1 => "1 chart".to_owned(),
        n => format!("{n} charts"),
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
