//! Which primary parameterization to use, and why.
//!
//! In: a mesh and a [`PrimaryRequest`]. Out: the [`Primary`] and a sentence with the numbers that decided. What was asked
//! for by name is given whenever it can be had at all, with a warning where it is not one-to-one.
//!
//! Order of preference, from the measurements on the shared models: a seamless primary that is one-to-one; a seamless one
//! that is nearly so (the LoD simplifies without seams, which is worth more than a few turned triangles); a uv set (layers
//! tell its overlapping charts apart); whatever is least bad.

use super::fit::{Fit, fit, fits};
use super::{Axis, Primary, PrimaryKind, PrimaryRequest};
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// A seamless primary is "nearly one-to-one" up to this turned share of the surface.
const NEARLY: f64 = 0.04;
/// A cylinder's ends may be this much of the surface (they fall back on the nearest reference point).
const ENDS: f64 = 0.25;
/// Whatever is taken, up to this share of its domain may be covered twice within one chart or part.
const WITHIN: f64 = 0.10;

/// The primary for `request`, and why: one that the file or positions give. [`parameterize`](super::parameterize()) also
/// computes.
///
/// # Errors
/// [`Error::Parameterization`] where the request cannot be had, or nothing can, saying what to do.
pub fn choose(mesh: &Mesh, request: &PrimaryRequest) -> Result<(Primary, String)> {
    if mesh.triangles.is_empty() {
        return Err(refuse(
            mesh,
            "it has no triangles, so there is nothing to parameterize".into(),
        ));
    }
    let (fit, why) = match *request {
        PrimaryRequest::Auto => automatic(mesh).map(|(fit, why, _)| (fit, why))?,
        PrimaryRequest::UvSet(set) => asked(mesh, &[PrimaryKind::UvSet(set)], None)?,
        PrimaryRequest::Plane(axis) => asked(mesh, &axes(axis).map(PrimaryKind::Plane), None)?,
        PrimaryRequest::Cylinder(axis) => {
            asked(mesh, &axes(axis).map(PrimaryKind::Cylinder), None)?
        }
        PrimaryRequest::Sphere(centre) => asked(
            mesh,
            &[PrimaryKind::Sphere],
            centre.map(|c| c.map(f64::from)),
        )?,
        PrimaryRequest::Computed(map, _) => {
            return Err(refuse(mesh, format!("{map} has to be computed")));
        }
    };
    Ok((fit.primary(mesh)?, why))
}

fn axes(axis: Option<Axis>) -> [Axis; 3] {
    axis.map_or(Axis::ALL, |axis| [axis; 3])
}

/// The best of `kinds`, which the caller named.
fn asked(mesh: &Mesh, kinds: &[PrimaryKind], centre: Option<[f64; 3]>) -> Result<(Fit, String)> {
    let mut kinds = kinds.to_vec();
    kinds.dedup();
    let found: Vec<Fit> = kinds
        .iter()
        .filter_map(|&kind| fit(mesh, kind, centre))
        .collect();
    let best = least_fault(found.iter()).ok_or_else(|| refuse(mesh, cannot(mesh, kinds[0])))?;
    Ok((
        best.clone(),
        format!("{}, as asked: {}", best.kind, verdict(best)),
    ))
}

/// How good the best is that the file and positions give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// Without seams, and one-to-one or nearly so.
    Seamless,
    /// A uv set that is one-to-one but for what layers tell apart.
    Charts,
    /// Neither.
    Poor,
}

/// The best that the file and positions give, why, and how good it is.
fn automatic(mesh: &Mesh) -> Result<(Fit, String, Standing)> {
    let all = fits(mesh);
    let seamless = || all.iter().filter(|f| f.is_seamless());
    if let Some(best) = most_facing(seamless().filter(|f| f.bijective)) {
        return Ok((
            best.clone(),
            format!("{}, seamless and {}", best.kind, verdict(best)),
            Standing::Seamless,
        ));
    }
    let near = |f: &&Fit| {
        f.turned_fraction <= NEARLY
            && f.degenerate_fraction <= ENDS
            && f.overlap_within_parts <= WITHIN
    };
    if let Some(best) = most_facing(seamless().filter(near)) {
        let why = format!(
            "{}, seamless and nearly one-to-one: {}",
            best.kind,
            verdict(best)
        );
        return Ok((best.clone(), why, Standing::Seamless));
    }
    let charts = least_fault(all.iter().filter(|f| !f.is_seamless()));
    let rival = least_fault(seamless());
    let instead = rival.map_or(String::new(), |r| {
        format!(
            "; the best seamless one, {}, has {}",
            r.kind,
            percent(r.turned_fraction, "turned")
        )
    });
    if let Some(best) = charts.filter(|f| f.fault() <= WITHIN) {
        return Ok((
            best.clone(),
            format!("{}: {}{instead}", best.kind, verdict(best)),
            Standing::Charts,
        ));
    }
    let best =
        least_fault(all.iter()).ok_or_else(|| refuse(mesh, cannot(mesh, PrimaryKind::Sphere)))?;
    Ok((
        best.clone(),
        format!(
            "{}, the least bad: {}; expect wrong colours there, a uv unwrapping would help",
            best.kind,
            verdict(best)
        ),
        Standing::Poor,
    ))
}

/// What [`choose`] gives for [`PrimaryRequest::Auto`].
pub(super) struct Found {
    pub(super) primary: Primary,
    pub(super) why: String,
    pub(super) standing: Standing,
    /// Charts of a uv set; connected parts otherwise.
    pub(super) charts: usize,
    /// Share that is not one-to-one, where layers do not help.
    pub(super) fault: f64,
    /// The numbers, in a clause.
    pub(super) verdict: String,
}

/// The best that the file and positions give.
///
/// # Errors
/// As [`choose`], where nothing can be had.
pub(super) fn found(mesh: &Mesh) -> Result<Found> {
    let (fit, why, standing) = automatic(mesh)?;
    Ok(Found {
        primary: fit.primary(mesh)?,
        why,
        standing,
        charts: fit.charts,
        fault: fit.fault(),
        verdict: format!("{}: {}", fit.kind, verdict(&fit)),
    })
}

/// The fit whose projection lines meet the surface most squarely; the first of equals.
fn most_facing<'a>(fits: impl Iterator<Item = &'a Fit>) -> Option<&'a Fit> {
    fits.reduce(|best, f| if f.facing > best.facing { f } else { best })
}

/// The fit with the least fault; the first of equals.
fn least_fault<'a>(fits: impl Iterator<Item = &'a Fit>) -> Option<&'a Fit> {
    fits.min_by(|a, b| a.fault().total_cmp(&b.fault()))
}

/// What the numbers say, in a clause.
fn verdict(fit: &Fit) -> String {
    let mut clauses = vec![];
    if fit.kind.has_charts() {
        clauses.push(if fit.charts == 1 {
            "1 chart".to_string()
        } else {
            format!("{} charts", fit.charts)
        });
    }
    if fit.bijective {
        clauses.push("one-to-one over the mesh".into());
        return clauses.join(", ");
    }
    if fit.turned_fraction > 0.0 {
        clauses.push(percent(fit.turned_fraction, "of the surface is turned"));
    }
    if fit.degenerate_fraction > 0.0 {
        let what = if let PrimaryKind::Cylinder(_) = fit.kind {
            "faces an end"
        } else {
            "has no image"
        };
        clauses.push(percent(fit.degenerate_fraction, what));
    }
    if fit.overlap_fraction > 0.0 {
        let within = percent(fit.overlap_within_parts, "within one part, ambiguous");
        clauses.push(percent(
            fit.overlap_fraction,
            &format!("of the domain is covered more than once ({within})"),
        ));
    }
    clauses.join(", ")
}

fn percent(share: f64, what: &str) -> String {
    if share > 0.0 && share < 1e-5 {
        return format!("less than 0.001 % {what}");
    }
    let digits = if share >= 0.01 || share == 0.0 { 1 } else { 3 };
    format!("{:.digits$} % {what}", share * 100.0)
}

/// Why a kind cannot be had at all.
fn cannot(mesh: &Mesh, kind: PrimaryKind) -> String {
    let sets = mesh.uv_sets.len();
    match kind {
        PrimaryKind::UvSet(set) if set as usize >= sets => {
            format!(
                "it has no uv set {set} (it has {sets}); choose a primary from position, such as --primary sphere"
            )
        }
        PrimaryKind::UvSet(set) => format!(
            "most of the surface has no area in uv set {set}; unwrap it, or choose a primary from position, such as --primary sphere"
        ),
        _ => format!(
            "{kind} maps most of its surface to nothing; choose another with --primary, or give it a uv set"
        ),
    }
}

fn refuse(mesh: &Mesh, reason: String) -> Error {
    Error::Parameterization {
        mesh: mesh.name.clone(),
        reason,
    }
}
