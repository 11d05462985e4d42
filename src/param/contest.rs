//! Which of several parameterizations serves levels of detail best: what `auto` weighs.
//!
//! In: what was measured of each ([`Quality`], and the share of the surface that is not one-to-one). Out: [`Weighed`], with
//! a cost.
//!
//! ```text
//! cost = L2 (1 + seams) / (1 - wrong)
//! seams = max(1.32 length / sqrt N, 2 charts / N)
//! ```
//!
//! N is the number of triangles of the coarsest LoD of the default chain. Its triangles have sides of 1.52 sqrt(area / N), so
//! a seam of that length (in roots of the area) has `seams` of them at its two sides, and no chart has fewer than two. A
//! simplifier keeps those for the seam: only the others are free to follow the shape, and the error of a LoD goes as one over
//! their number. The larger the stretch (Sander et al., from T3 to the surface, L2), the farther is the answer on the surface
//! from where it should be, for the same distance in T3, and the more triangles crowd in some texels. A share `wrong` of the
//! surface shows another part's colours.
//!
//! A map that is computed is out where its largest stretch (Linf) leaves the grid too few places: see [`COARSEST`]. In a uv set
//! that is a sliver or two, which somebody has looked at.

use super::computed::Quality;
use serde::{Deserialize, Serialize};

/// The coarsest level of the default chain, as a share of the triangles.
const LOD: f64 = 0.05;
/// Triangles at the two sides of a seam, for a side of an equilateral triangle: 2 / sqrt(4 / sqrt 3).
const AT_SEAM: f64 = 1.316;
/// Beyond this stretch the 2^24 places along the grid are fewer than ten thousand along the surface: steps of vertices would
/// be seen in a picture of it.
const COARSEST: f64 = 1600.0;
/// What has to be computed, and stored, has to be so much better than what is there.
const GAIN: f64 = 0.95;

/// A primary that was thought of, and how it was weighed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Weighed {
    /// Its kind, as `--primary` spells it.
    pub kind: String,
    /// What was measured; null where it cannot be had or was not tried.
    pub quality: Option<Quality>,
    /// Share of the surface that is not one-to-one.
    pub wrong_fraction: f64,
    /// Triangles at seams, as a share of those of a LoD at 5 %: may be more than one.
    pub seam_share: Option<f64>,
    /// The cost: 1 is perfect. Null where it was not weighed.
    pub cost: Option<f64>,
    /// Why it was not weighed.
    pub why_not: Option<String>,
}

impl Weighed {
    /// Weighs a map that was computed for a mesh of `triangles`.
    pub(super) fn computed(kind: String, quality: Quality, triangles: usize) -> Self {
        match quality.stretch.linf > COARSEST {
            true => {
                let why_not = format!("stretched up to {:.0}-fold", quality.stretch.linf);
                Weighed {
                    quality: Some(quality),
                    ..Weighed::none(kind, why_not)
                }
            }
            false => Weighed::new(kind, quality, 0.0, triangles),
        }
    }

    /// Weighs a primary of which a share is `wrong` over a mesh of `triangles`.
    pub(super) fn new(kind: String, quality: Quality, wrong: f64, triangles: usize) -> Self {
        let seam_share = seam_share(&quality, triangles);
        if !(quality.stretch.l2.is_finite() && quality.stretch.linf.is_finite()) {
            return Weighed::none(kind, "stretched past the numbers' range".into());
        }
        let cost = quality.stretch.l2 * (1.0 + seam_share) / (1.0 - wrong).max(0.01);
        Weighed {
            kind,
            wrong_fraction: wrong,
            seam_share: Some(seam_share),
            cost: Some(cost),
            why_not: None,
            quality: Some(quality),
        }
    }

    /// One that cannot be had, or was not tried, and why.
    pub(super) fn none(kind: String, why_not: String) -> Self {
        Weighed {
            kind,
            quality: None,
            wrong_fraction: 0.0,
            seam_share: None,
            cost: None,
            why_not: Some(why_not),
        }
    }

    /// Whether a computed one of this cost is worth more than `there`, which need not be computed.
    pub(super) fn beats(&self, there: &Weighed) -> bool {
        match (self.cost, there.cost) {
            (Some(own), Some(other)) => own < GAIN * other,
            (own, _) => own.is_some(),
        }
    }

    /// Whether any map that is computed could be better than this.
    pub(super) fn may_be_beaten(&self) -> bool {
        self.cost.is_none_or(|cost| 1.0 < GAIN * cost)
    }

    /// The cost and what it is made of, in a clause.
    pub(super) fn clause(&self) -> String {
        let (Some(cost), Some(share), Some(quality)) = (self.cost, self.seam_share, &self.quality)
        else {
            let reason = self.why_not.as_deref().unwrap_or("not weighed");
            return match reason.starts_with(&self.kind) {
                true => reason.into(),
                false => format!("{}: {reason}", self.kind),
            };
        };
        let mut made = vec![format!("stretch {:.3}", quality.stretch.l2)];
        made.push(match quality.seam_length {
            0.0 => "no seams".into(),
            length => format!(
                "seams of {length:.1} times the root of the area, {:.0} % of a 5 % LoD's triangles",
                100.0 * share
            ),
        });
        if self.wrong_fraction > 0.0 {
            made.push(format!(
                "{:.3} % not one-to-one",
                100.0 * self.wrong_fraction
            ));
        }
        format!("{} costs {cost:.2} ({})", self.kind, made.join(", "))
    }
}

/// See the head of the file.
fn seam_share(quality: &Quality, triangles: usize) -> f64 {
    let of_lod = (LOD * triangles as f64).max(1.0);
    let at_seams = AT_SEAM * quality.seam_length / of_lod.sqrt();
    let of_charts = match quality.seam_length {
        0.0 => 0.0,
        _ => 2.0 * quality.charts as f64 / of_lod,
    };
    at_seams.max(of_charts)
}
