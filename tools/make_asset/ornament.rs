//! Ornament that repeats: meander, rays, tongues, palmettes, scrolls, rosettes. Distances in the motif's own unit.

use crate::sdf;
use glam::{Vec2, vec2};

/// Greek key with strokes one unit wide: period 6, height 7 (0.5 of stroke below zero and above 6). `x` in a period.
pub(crate) fn meander(p: Vec2) -> f32 {
    let q = vec2(p.x.rem_euclid(6.0), p.y);
    let key = |q: Vec2| {
        let hook = [
            vec2(0.0, 0.0),
            vec2(0.0, 6.0),
            vec2(4.0, 6.0),
            vec2(4.0, 2.0),
            vec2(2.0, 2.0),
            vec2(2.0, 4.0),
        ];
        hook.windows(2)
            .map(|w| bar(q, w[0], w[1]))
            .fold(f32::MAX, f32::min)
    };
    let base = (q.y.abs() - 0.5).max(-0.5);
    base.min(key(q)).min(key(q - vec2(6.0, 0.0)))
}

/// An axis-parallel stroke one unit wide with square ends.
fn bar(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    sdf::rectangle(p, (a + b) * 0.5, (b - a).abs() * 0.5 + 0.5)
}

/// A pointed ray standing on z = 0: `half` wide at its foot.
pub(crate) fn ray(p: Vec2, half: f32, height: f32) -> f32 {
    sdf::polygon(p, &[vec2(-half, 0.0), vec2(half, 0.0), vec2(0.0, height)])
}

/// A scroll standing on the line z = 0, unit height, period `width`: a spiral of two turns on a running stroke.
pub(crate) fn scroll(p: Vec2, width: f32) -> f32 {
    const PITCH: f32 = 0.22;
    const STROKE: f32 = 0.068;
    let spiral = |p: Vec2| {
        let q = p - vec2(0.0, 0.54);
        let r = q.length();
        let turn = libm::atan2f(q.x, -q.y) / std::f32::consts::TAU + 0.5;
        // Arms lie at r = PITCH (turn + k); k = 0 and 1 are drawn.
        let k = (r / PITCH - turn).round().clamp(0.0, 1.0);
        (r - PITCH * (turn + k)).abs() - STROKE
    };
    let foot = |p: Vec2| {
        sdf::curve(
            p,
            [
                vec2(-width * 0.5, 0.06),
                vec2(-0.42, 0.02),
                vec2(-0.42, 0.5),
            ],
            0.06,
            STROKE,
        )
    };
    let along = p.y.abs() - 0.10;
    spiral(p)
        .min(along)
        .min(foot(p))
        .min(foot(p - vec2(width, 0.0)))
}

/// Seven leaves over two volutes, unit height.
pub(crate) fn palmette(p: Vec2) -> f32 {
    let q = vec2(p.x.abs(), p.y);
    let base = vec2(0.0, 0.30);
    let mut d = sdf::ellipse(q, base, vec2(0.085, 0.075));
    for (i, length) in [0.66, 0.58, 0.45, 0.33].into_iter().enumerate() {
        let angle = 0.44 * i as f32;
        let along = vec2(libm::sinf(angle), libm::cosf(angle));
        d = d.min(sdf::petal(
            q,
            base + along * 0.11,
            along,
            length - 0.09,
            0.062,
        ));
    }
    let volute = sdf::circle(q, vec2(0.20, 0.13), 0.088).abs() - 0.022;
    d.min(volute).min(sdf::circle(q, vec2(0.20, 0.13), 0.030))
}

/// The tendril that ties a palmette to the next, `width` away.
pub(crate) fn tendril(p: Vec2, width: f32) -> f32 {
    let q = vec2(p.x.abs(), p.y);
    let low = sdf::curve(
        q,
        [
            vec2(0.24, 0.05),
            vec2(width * 0.38, 0.0),
            vec2(width * 0.5, 0.16),
        ],
        0.022,
        0.022,
    );
    let over = sdf::curve(
        q,
        [
            vec2(0.0, 1.04),
            vec2(width * 0.40, 1.02),
            vec2(width * 0.5, 0.16),
        ],
        0.018,
        0.022,
    );
    low.min(over)
}

/// A dot with six dots around it, radius 1.
pub(crate) fn rosette(p: Vec2) -> f32 {
    let mut d = sdf::circle(p, Vec2::ZERO, 0.30);
    for i in 0..6 {
        let angle = std::f32::consts::TAU * i as f32 / 6.0;
        d = d.min(sdf::circle(
            p,
            vec2(libm::cosf(angle), libm::sinf(angle)) * 0.70,
            0.25,
        ));
    }
    d
}

/// Two braided strands, period 2, height 2 (z from -1 to 1); the eyes between them stay open.
pub(crate) fn guilloche(p: Vec2) -> f32 {
    let strand = |x: f32| {
        let wave = 0.62 * libm::sinf(std::f32::consts::PI * x);
        let slope = 0.62 * std::f32::consts::PI * libm::cosf(std::f32::consts::PI * x);
        ((p.y - wave).abs() / libm::sqrtf(1.0 + slope * slope)) - 0.17
    };
    let eye = vec2((p.x + 0.5).rem_euclid(1.0) - 0.5, p.y);
    let eye = vec2(eye.x.abs() - 0.5, eye.y);
    strand(p.x)
        .min(strand(p.x + 1.0))
        .min(sdf::circle(eye, Vec2::ZERO, 0.14))
}
