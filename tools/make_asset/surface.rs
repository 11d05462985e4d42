//! The vase as a surface: (arc length along the silhouette, turn) to position and normal.
//!
//! `turn` is 1 once round and may leave [0, 1]: everything is periodic. Seen from outside, growing turn goes right.

use crate::profile::Profile;
use crate::relief;
use glam::DVec3;

pub(crate) struct Surface<'a> {
    pub(crate) profile: &'a Profile,
}

/// Radians of one turn.
pub(crate) const TURN: f64 = std::f64::consts::TAU;

/// Step of the central differences, object units.
const STEP: f64 = 6e-4;

impl Surface<'_> {
    pub(crate) fn position(&self, s: f64, turn: f64) -> DVec3 {
        // Wrapped first: both ends of the seam must give the same bits.
        let turn = turn - turn.floor();
        let base = self.profile.at(s);
        let radius = (base.radius
            + relief::outward(base.height, turn) * (base.radius / 0.03).min(1.0))
        .max(0.0);
        DVec3::new(
            radius * libm::cos(turn * TURN),
            base.height,
            -radius * libm::sin(turn * TURN),
        )
    }

    /// Derivatives along s and along the turn.
    pub(crate) fn derivatives(&self, s: f64, turn: f64) -> (DVec3, DVec3) {
        let radius = self.profile.at(s).radius.max(0.02);
        let (low, high) = ((s - STEP).max(0.0), (s + STEP).min(self.profile.total()));
        let turns = STEP / (radius * TURN);
        (
            (self.position(high, turn) - self.position(low, turn)) / (high - low),
            (self.position(s, turn + turns) - self.position(s, turn - turns)) / (2.0 * turns),
        )
    }

    /// Outward unit normal. On the axis it is the axis.
    pub(crate) fn normal(&self, s: f64, turn: f64) -> DVec3 {
        if s <= 0.0 {
            return DVec3::NEG_Y;
        }
        if s >= self.profile.total() {
            return DVec3::Y;
        }
        let (along, round) = self.derivatives(s, turn);
        round.cross(along).normalize_or(DVec3::Y)
    }
}
