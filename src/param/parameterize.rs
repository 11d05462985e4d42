//! A primary parameterization for a mesh, computed where it has to be.
//!
//! In: a mesh and a [`PrimaryRequest`]. Out: [`Chosen`]: the [`Primary`], why it was taken, and, where it is a computed map, the
//! mesh's places in T3. The mesh has to be cut open for those ([`Embedding::cut_open`](crate::mesh::Embedding::cut_open))
//! before anything else is done with it.

use super::charts;
use super::computed::{Computed, Map};
use super::contest::Weighed;
use super::fit_choose::{Found, Standing, choose, found};
use super::{Primary, PrimaryKind, PrimaryRequest};
use crate::error::{Error, Result};
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
    /// What `auto` weighed against each other; empty where nothing had to be.
    pub weighed: Vec<Weighed>,
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
                weighed: vec![],
            })
        }
    }
}

/// Beside a uv set that will do a sphere is tried up to so many triangles: it takes 30 to 90 microseconds a triangle, so
/// that auto spends three seconds on it at most. What is no sphere is refused within milliseconds.
const TRIED: usize = 100_000;
/// A sphere up to this cost is taken without a cylinder being computed beside it, and neither has charts beside it.
const GOOD: f64 = 2.0;

/// What is seamless and there already; else what costs least of the file's uv set and of what can be computed; else what
/// there was.
fn automatic(mesh: &Mesh) -> Result<Chosen> {
    match found(mesh) {
        Ok(found) if found.standing == Standing::Charts => beside_charts(mesh, found),
        Ok(found) if found.standing == Standing::Seamless => Ok(as_found(found, vec![])),
        Ok(found) => {
            let instead = format!("the best of the others is {}", found.verdict);
            let mut weighed = vec![];
            Ok(match from_nothing(mesh, &instead, &mut weighed) {
                Some(chosen) => chosen,
                None => as_found(found, weighed),
            })
        }
        Err(error) => from_nothing(mesh, "nothing else can be had", &mut vec![]).ok_or(error),
    }
}

fn as_found(found: Found, weighed: Vec<Weighed>) -> Chosen {
    Chosen {
        primary: found.primary,
        why: found.why,
        computed: None,
        weighed,
    }
}

/// The uv set that was found, or a sphere or cylinder that costs less. Charts are not computed beside charts: measured on the flight
/// helmet an artist's, which follow what the eye looks at, were better than these numbers say.
fn beside_charts(mesh: &Mesh, found: Found) -> Result<Chosen> {
    let PrimaryKind::UvSet(set) = found.primary.kind else {
        return Ok(as_found(found, vec![]));
    };
    let quality = charts::given(mesh, &mesh.uv_sets[set as usize], found.charts);
    let kind = found.primary.kind.to_string();
    let there = Weighed::new(kind, quality, found.fault, mesh.triangles.len());
    let why = format!("{}; {}", found.why, there.clause());
    if !there.may_be_beaten() {
        let why = format!("{why}: nothing computed would do better");
        return Ok(Chosen {
            why,
            ..as_found(found, vec![there])
        });
    }
    let (best, mut others) = seamless(mesh, TRIED, |w| w.beats(&there));
    let mut clauses = vec![there.clause()];
    clauses.extend(others.iter().map(Weighed::clause));
    others.insert(0, there);
    Ok(match best {
        Some(computed) => Chosen {
            primary: computed.primary(),
            why: format!(
                "{}, seamless, computed: {}; {}",
                computed.map,
                verdict(&computed),
                clauses.join("; ")
            ),
            computed: Some(computed),
            weighed: others,
        },
        None => Chosen {
            why: format!("{why}; {}", clauses[1..].join("; ")),
            ..as_found(found, others)
        },
    })
}

/// A sphere and, where that is none or costs much, a cylinder: the one that costs least of those that are `wanted`, and how
/// both were weighed. A mesh of more than `most` triangles is not tried.
fn seamless(
    mesh: &Mesh,
    most: usize,
    wanted: impl Fn(&Weighed) -> bool,
) -> (Option<Computed>, Vec<Weighed>) {
    let mut best: Option<(f64, Computed)> = None;
    let mut weighed = vec![];
    for map in [Map::Sphere, Map::Cylinder] {
        let (computed, of_map) = tried(mesh, map, most);
        if let (Some(computed), Some(cost)) = (computed, of_map.cost)
            && wanted(&of_map)
            && best.as_ref().is_none_or(|(least, _)| cost < *least)
        {
            best = Some((cost, computed));
        }
        weighed.push(of_map);
        if best.as_ref().is_some_and(|(cost, _)| *cost <= GOOD) {
            break;
        }
    }
    (best.map(|(_, computed)| computed), weighed)
}

/// A sphere, a cylinder, or charts, where the file and positions give nothing good; none where neither can be had whole.
fn from_nothing(mesh: &Mesh, instead: &str, weighed: &mut Vec<Weighed>) -> Option<Chosen> {
    let (mut best, of_both) = seamless(mesh, usize::MAX, |_| true);
    *weighed = of_both;
    let least = weighed.iter().filter_map(|w| w.cost).reduce(f64::min);
    if least.is_none_or(|cost| cost > GOOD) {
        let (charts, of_charts) = tried(mesh, Map::Lscm, usize::MAX);
        if let Some(cost) = of_charts.cost
            && least.is_none_or(|least| cost < least)
        {
            best = charts;
        }
        weighed.push(of_charts);
    }
    let computed = best?;
    let how = match computed.map.has_charts() {
        true => "charts, computed",
        false => "seamless, computed",
    };
    let costs: Vec<String> = weighed.iter().map(Weighed::clause).collect();
    Some(Chosen {
        primary: computed.primary(),
        why: format!(
            "{}, {how}: {}; {}; {instead}",
            computed.map,
            verdict(&computed),
            costs.join("; ")
        ),
        computed: Some(computed),
        weighed: std::mem::take(weighed),
    })
}

/// A map that is computed, if it is whole, and how it was weighed.
fn tried(mesh: &Mesh, map: Map, most: usize) -> (Option<Computed>, Weighed) {
    let triangles = mesh.triangles.len();
    let none = |why: String| (None, Weighed::none(map.to_string(), why));
    if triangles > most {
        return none(format!("not tried for more than {most} triangles"));
    }
    match map.compute(mesh) {
        Ok(computed) if computed.quality.turned_triangles.is_empty() => {
            let quality = computed.quality.clone();
            let weighed = Weighed::computed(map.to_string(), quality, triangles);
            (weighed.cost.is_some().then_some(computed), weighed)
        }
        Ok(computed) => {
            let turned = computed.quality.turned_triangles.len();
            none(format!("{turned} triangles turned over"))
        }
        Err(Error::Parameterization { reason, .. }) => none(reason),
        Err(other) => none(other.to_string()),
    }
}

fn computed(mesh: &Mesh, map: Map, stretch: Option<f64>) -> Result<Chosen> {
    let computed = map.compute_within(mesh, stretch)?;
    let why = format!("{map}, as asked: {}", verdict(&computed));
    Ok(Chosen {
        primary: computed.primary(),
        why,
        computed: Some(computed),
        weighed: vec![],
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
