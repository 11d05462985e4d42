//! Relief that is real geometry: lobes, tongues, beads. These are what a coarse mesh loses and an inverse
//! geometric texture brings back through the reference's normals.
//!
//! In: height of the silhouette and turn (1 = once round). Out: how far the surface stands out along the radius.
//! Displacing along the radius keeps one radius for each height and angle.

use crate::sdf;
use glam::vec2;

/// Lobes round the foot of the body.
pub(crate) const LOBES: u32 = 30;
/// Tongues round the shoulder.
pub(crate) const TONGUES: u32 = 40;
/// Beads of the ring where the neck begins.
pub(crate) const BEADS: u32 = 40;
/// Lobes of the lid.
pub(crate) const LID_LOBES: u32 = 20;
/// Petals of the knob.
pub(crate) const BUD_PETALS: u32 = 10;

fn smooth(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Rises after `a`, falls before `b`, `ease` long each.
fn between(a: f64, b: f64, ease: f64, x: f64) -> f64 {
    smooth(a, a + ease, x) * (1.0 - smooth(b - ease, b, x))
}

/// Offset from the middle of the nearest of `n` repeats round the vase, -1 to 1.
pub(crate) fn across(turn: f64, n: u32) -> f64 {
    let t = turn * f64::from(n);
    2.0 * (t - t.floor()) - 1.0
}

/// A round lobe: 1 in the middle, 0 in the groove between two.
pub(crate) fn lobe(turn: f64, n: u32) -> f64 {
    let x = across(turn, n);
    (1.0 - x * x).max(0.0).sqrt()
}

/// Outward displacement in object units.
pub(crate) fn outward(height: f64, turn: f64) -> f64 {
    let mut d = 0.0;
    if height < 0.62 {
        let rise = between(0.296, 0.585, 0.07, height);
        // Scaled by the width of a lobe, which grows with the body.
        d += rise * (lobe(turn, LOBES) - 0.72) * (0.016 + 0.055 * (height - 0.29).max(0.0));
    } else if (1.30..1.48).contains(&height) {
        // Tongues end in an arch at their lower side: the groove is the distance to a hanging shape.
        let x = across(turn, TONGUES) as f32;
        let arch = sdf::taper(
            vec2(x, height as f32 * 24.0),
            vec2(0.0, 33.1),
            vec2(0.0, 36.0),
            0.86,
            0.80,
        );
        d += 0.0085 * smooth(0.05, -0.55, f64::from(arch)) * between(1.30, 1.478, 0.012, height);
    } else if (1.482..1.522).contains(&height) {
        let x = across(turn, BEADS);
        let z = (height - 1.5) / 0.0165;
        d += 0.013 * (1.0 - x * x * 0.9 - z * z).max(0.0).sqrt();
    } else if (1.905..2.075).contains(&height) {
        d += 0.010 * (lobe(turn, LID_LOBES) - 0.6) * between(1.912, 2.066, 0.03, height);
    } else if height > 2.13 {
        let twisted = turn + 0.6 * (height - 2.13);
        d += 0.0075 * (lobe(twisted, BUD_PETALS) - 0.6) * between(2.132, 2.285, 0.03, height);
    }
    // Two grooves cut into the neck, and one in the foot.
    for (at, depth) in [(1.556, 0.0035), (1.772, 0.0035), (0.082, 0.003)] {
        let z = (height - at) / 0.0075;
        d -= depth * (1.0 - z * z).max(0.0);
    }
    d
}
