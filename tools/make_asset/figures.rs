//! The figures of the belly: ships under sail, dolphins and the sea, painted into an `Ink`.
//!
//! Coordinates are the figure's own, z up, the frieze one unit high; `scale` is the frieze's height in object units,
//! so that edges are as soft as a texel is wide. Everything looks to the right, as on most of the old vases.

use crate::bands::{Ink, Paint};
use crate::ornament;
use crate::sdf;
use glam::{Vec2, vec2};

/// Brush for one sample: distances of the figure's unit become coverage.
pub(crate) struct Brush<'a> {
    pub(crate) ink: &'a mut Ink,
    /// Texel width in the figure's unit.
    pub(crate) texel: f32,
}

impl Brush<'_> {
    pub(crate) fn with(&mut self, paint: Paint, distance: f32) {
        self.ink
            .paint(paint, (0.5 - distance / self.texel).clamp(0.0, 1.0));
    }
    pub(crate) fn cut(&mut self, distance: f32) {
        self.ink.cut((0.5 - distance / self.texel).clamp(0.0, 1.0));
    }
}

fn hull(p: Vec2) -> f32 {
    let t = p.x / 0.70;
    let lower = 0.125 + 0.085 * t * t * t * t;
    let upper = 0.270 + 0.045 * t * t;
    let body = ((lower - p.y).max(p.y - upper) * 0.95).max(p.x.abs() - 0.70);
    let ram = sdf::polygon(
        p,
        &[
            vec2(0.56, 0.150),
            vec2(0.88, 0.150),
            vec2(0.93, 0.172),
            vec2(0.88, 0.188),
            vec2(0.80, 0.215),
            vec2(0.66, 0.310),
        ],
    );
    let bow = sdf::curve(
        p,
        [vec2(0.66, 0.27), vec2(0.80, 0.33), vec2(0.71, 0.47)],
        0.034,
        0.010,
    );
    let stern = sdf::curve(
        p,
        [vec2(-0.60, 0.21), vec2(-0.98, 0.27), vec2(-0.83, 0.62)],
        0.052,
        0.014,
    );
    let curl = sdf::curve(
        p,
        [vec2(-0.83, 0.62), vec2(-0.78, 0.74), vec2(-0.67, 0.66)],
        0.014,
        0.010,
    );
    let feather = sdf::curve(
        p,
        [vec2(-0.86, 0.50), vec2(-0.82, 0.62), vec2(-0.70, 0.56)],
        0.012,
        0.008,
    );
    body.min(ram).min(bow).min(stern).min(curl).min(feather)
}

fn crew(p: Vec2) -> f32 {
    let mut d = (p.y - 0.335).abs().max(p.x.abs() - 0.57) - 0.006;
    // Nine rowers, nine oars; folding x would mirror them, so the nearest three are tried.
    let nearest = (p.x / 0.125).round();
    for i in -1..=1 {
        let k = (nearest + i as f32).clamp(-4.0, 4.0);
        let x = k * 0.125;
        d = d.min(sdf::circle(p, vec2(x + 0.012, 0.392), 0.026));
        d = d.min(sdf::taper(
            p,
            vec2(x, 0.29),
            vec2(x + 0.008, 0.352),
            0.040,
            0.020,
        ));
        d = d.min(sdf::taper(
            p,
            vec2(x + 0.02, 0.22),
            vec2(x - 0.085, 0.035),
            0.0055,
            0.014,
        ));
    }
    let rudder = sdf::taper(p, vec2(-0.66, 0.29), vec2(-0.80, 0.02), 0.010, 0.026);
    let helmsman = sdf::taper(p, vec2(-0.665, 0.30), vec2(-0.650, 0.42), 0.050, 0.024);
    d.min(rudder)
        .min(helmsman)
        .min(sdf::circle(p, vec2(-0.640, 0.474), 0.032))
}

fn sail(p: Vec2) -> f32 {
    let x = p.x - 0.03;
    let top = 0.895 - 0.16 * x * x;
    let bottom = 0.520 + 0.20 * x * x - 0.03;
    let half = 0.43 + 0.075 * libm::sinf((p.y - 0.5) * 7.0);
    (p.y - top).max(bottom - p.y).max(x.abs() - half) * 0.92
}

fn rigging(p: Vec2) -> f32 {
    let mast = sdf::taper(p, vec2(0.02, 0.27), vec2(0.02, 0.955), 0.013, 0.009);
    let yard = sdf::curve(
        p,
        [vec2(-0.50, 0.845), vec2(0.03, 0.955), vec2(0.56, 0.845)],
        0.012,
        0.012,
    );
    let mut ropes = f32::MAX;
    for foot in [
        vec2(-0.79, 0.52),
        vec2(0.72, 0.45),
        vec2(-0.56, 0.34),
        vec2(0.56, 0.34),
    ] {
        ropes = ropes.min(sdf::segment(p, vec2(0.02, 0.945), foot) - 0.0045);
    }
    mast.min(yard).min(ropes)
}

/// A ship under sail, bow to the right; x from -0.95 to 0.95.
pub(crate) fn ship(p: Vec2, mut brush: Brush) {
    brush.with(Paint::Slip, rigging(p));
    let cloth = sail(p);
    brush.with(Paint::Slip, cloth - 0.011);
    brush.with(Paint::White, cloth + 0.002);
    let stripe = ((p.x - 0.03) / 0.172).fract().abs();
    let stripe = (stripe - 0.5).abs() * 0.172 - 0.020;
    brush.with(Paint::Red, stripe.max(cloth + 0.014));
    let device = sdf::circle(p, vec2(0.03, 0.70), 0.105);
    brush.with(Paint::White, (device - 0.016).max(cloth + 0.01));
    brush.with(Paint::Slip, device);
    brush.with(
        Paint::White,
        ornament::rosette((p - vec2(0.03, 0.70)) / 0.085) * 0.085,
    );
    brush.with(Paint::Slip, crew(p));
    let body = hull(p);
    brush.with(Paint::Slip, body);
    // Strakes cut through the slip, shields along the rail, the eye that lets the ship see.
    for z in [0.185, 0.208] {
        brush.cut(((p.y - z - 0.05 * p.x * p.x).abs() - 0.0035).max(body + 0.012));
    }
    let shield = vec2(
        (p.x / 0.104).fract().abs() * 0.104 - 0.052,
        p.y - 0.245 - 0.035 * p.x * p.x,
    );
    let row = p.x.abs() - 0.52;
    brush.with(
        Paint::White,
        sdf::circle(shield, Vec2::ZERO, 0.020).max(row),
    );
    brush.with(Paint::Red, sdf::circle(shield, Vec2::ZERO, 0.012).max(row));
    let eye = vec2(0.665, 0.245);
    brush.with(Paint::White, sdf::ellipse(p, eye, vec2(0.040, 0.026)));
    brush.with(Paint::Red, sdf::circle(p, eye, 0.019));
    brush.with(Paint::Slip, sdf::circle(p, eye, 0.010));
}

/// A leaping dolphin, about 0.5 long, centred.
pub(crate) fn dolphin(p: Vec2, mut brush: Brush) {
    let body = sdf::curved_leaf(p, 0.200, 0.056, 0.062);
    let beak = sdf::taper(p, vec2(0.160, 0.010), vec2(0.242, -0.026), 0.022, 0.008);
    let fin = sdf::curve(
        p,
        [vec2(0.02, 0.10), vec2(-0.01, 0.155), vec2(-0.055, 0.158)],
        0.024,
        0.004,
    );
    let flipper = sdf::curve(
        p,
        [vec2(0.085, 0.01), vec2(0.06, -0.035), vec2(0.02, -0.052)],
        0.018,
        0.004,
    );
    let tail = sdf::taper(p, vec2(-0.150, 0.026), vec2(-0.215, -0.012), 0.024, 0.012);
    let up = sdf::curve(
        p,
        [
            vec2(-0.205, -0.005),
            vec2(-0.262, 0.004),
            vec2(-0.288, 0.052),
        ],
        0.015,
        0.004,
    );
    let down = sdf::curve(
        p,
        [
            vec2(-0.205, -0.010),
            vec2(-0.232, -0.050),
            vec2(-0.222, -0.094),
        ],
        0.015,
        0.004,
    );
    let all = body
        .min(beak)
        .min(fin)
        .min(flipper)
        .min(tail)
        .min(up)
        .min(down);
    brush.with(Paint::Slip, all);
    let t = p.x / 0.2;
    let belly = (p.y - 0.062 * (1.0 - t * t) + 0.018).abs() - 0.0032;
    brush.cut(belly.max(body + 0.010));
    brush.with(Paint::White, sdf::circle(p, vec2(0.142, 0.034), 0.0105));
    brush.with(Paint::Slip, sdf::circle(p, vec2(0.143, 0.034), 0.0050));
}

/// Little crests along the foot of the frieze; `x` runs on round the vase.
pub(crate) fn sea(p: Vec2, mut brush: Brush) {
    for (row, z) in [(0.0f32, 0.052), (0.5, 0.020)] {
        let x = ((p.x / 0.108 + row).rem_euclid(1.0) - 0.5) * 0.108;
        let crest = sdf::curve(
            vec2(x, p.y - z),
            [vec2(-0.054, 0.012), vec2(0.006, -0.020), vec2(0.054, 0.030)],
            0.004,
            0.008,
        );
        brush.with(Paint::Slip, crest);
    }
}
