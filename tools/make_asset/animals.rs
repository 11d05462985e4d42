//! The animals of the shoulder: wild goats and swans. Coordinates as in `figures`: the frieze is one unit high.

use crate::bands::Paint;
use crate::figures::Brush;
use crate::sdf;
use glam::{Vec2, vec2};

fn goat_legs(p: Vec2) -> f32 {
    let legs = [
        [vec2(0.33, 0.46), vec2(0.43, 0.27), vec2(0.36, 0.05)],
        [vec2(0.22, 0.44), vec2(0.20, 0.25), vec2(0.17, 0.05)],
        [vec2(-0.40, 0.47), vec2(-0.31, 0.27), vec2(-0.44, 0.05)],
        [vec2(-0.34, 0.44), vec2(-0.19, 0.27), vec2(-0.29, 0.05)],
    ];
    let mut d = f32::MAX;
    for [hip, knee, hoof] in legs {
        d = d
            .min(sdf::taper(p, hip, knee, 0.085, 0.030))
            .min(sdf::taper(p, knee, hoof, 0.030, 0.019));
        d = d.min(sdf::taper(
            p,
            hoof,
            hoof + vec2(0.045, -0.018),
            0.022,
            0.018,
        ));
    }
    d
}

/// A wild goat at a walk; x from -0.65 to 0.7.
pub(crate) fn goat(p: Vec2, mut brush: Brush) {
    let trunk = sdf::curve(
        p,
        [vec2(-0.40, 0.55), vec2(-0.05, 0.43), vec2(0.28, 0.56)],
        0.125,
        0.145,
    );
    let neck = sdf::curve(
        p,
        [vec2(0.32, 0.58), vec2(0.47, 0.66), vec2(0.49, 0.81)],
        0.115,
        0.058,
    );
    let head = sdf::taper(p, vec2(0.50, 0.815), vec2(0.665, 0.735), 0.062, 0.032);
    let horn = sdf::curve(
        p,
        [vec2(0.50, 0.86), vec2(0.34, 1.13), vec2(0.02, 0.78)],
        0.027,
        0.007,
    );
    let horn2 = sdf::curve(
        p,
        [vec2(0.53, 0.87), vec2(0.30, 1.03), vec2(0.12, 0.75)],
        0.020,
        0.006,
    );
    let ear = sdf::taper(p, vec2(0.46, 0.84), vec2(0.375, 0.80), 0.020, 0.010);
    let beard = sdf::taper(p, vec2(0.610, 0.715), vec2(0.570, 0.600), 0.020, 0.004);
    let tail = sdf::curve(
        p,
        [vec2(-0.50, 0.60), vec2(-0.60, 0.66), vec2(-0.58, 0.76)],
        0.030,
        0.010,
    );
    let body = trunk.min(goat_legs(p));
    let all = body
        .min(neck)
        .min(head)
        .min(horn)
        .min(horn2)
        .min(ear)
        .min(beard)
        .min(tail);
    brush.with(Paint::Slip, all);
    brush.with(
        Paint::Red,
        sdf::ellipse(p, vec2(0.385, 0.665), vec2(0.060, 0.095)),
    );
    brush.with(
        Paint::Red,
        sdf::ellipse(p, vec2(-0.36, 0.54), vec2(0.085, 0.072)),
    );
    let dot = vec2(
        (p.x / 0.075).fract().abs() * 0.075 - 0.0375,
        p.y - 0.405 - 0.10 * p.x * p.x,
    );
    brush.with(
        Paint::White,
        sdf::circle(dot, Vec2::ZERO, 0.015).max((p.x + 0.05).abs() - 0.225),
    );
    brush.cut(
        (sdf::ellipse(p, vec2(0.245, 0.52), vec2(0.120, 0.165)).abs() - 0.006).max(0.20 - p.x),
    );
    brush.cut(
        (sdf::ellipse(p, vec2(-0.37, 0.52), vec2(0.150, 0.155)).abs() - 0.006)
            .max(p.x + 0.28)
            .max(trunk),
    );
    for x in [-0.10, -0.03, 0.04] {
        brush.cut(sdf::curve(
            p,
            [vec2(x, 0.57), vec2(x + 0.035, 0.52), vec2(x + 0.01, 0.46)],
            0.006,
            0.004,
        ));
    }
    brush.with(Paint::White, sdf::circle(p, vec2(0.535, 0.822), 0.018));
    brush.with(Paint::Slip, sdf::circle(p, vec2(0.538, 0.822), 0.009));
}

/// A swan; x from -0.6 to 0.65.
pub(crate) fn swan(p: Vec2, mut brush: Brush) {
    let trunk = sdf::ellipse(p, vec2(0.02, 0.385), vec2(0.33, 0.165));
    let tail = sdf::curve(
        p,
        [vec2(-0.18, 0.40), vec2(-0.38, 0.42), vec2(-0.56, 0.53)],
        0.100,
        0.022,
    );
    let neck = sdf::curve(
        p,
        [vec2(0.24, 0.42), vec2(0.53, 0.55), vec2(0.36, 0.74)],
        0.105,
        0.052,
    );
    let nape = sdf::curve(
        p,
        [vec2(0.36, 0.74), vec2(0.27, 0.92), vec2(0.43, 0.925)],
        0.052,
        0.046,
    );
    let head = sdf::ellipse(p, vec2(0.440, 0.905), vec2(0.080, 0.056));
    let beak = sdf::taper(p, vec2(0.48, 0.895), vec2(0.625, 0.845), 0.034, 0.012);
    let mut legs = f32::MAX;
    for x in [-0.05, 0.13] {
        legs = legs.min(sdf::taper(
            p,
            vec2(x, 0.26),
            vec2(x + 0.02, 0.055),
            0.026,
            0.016,
        ));
        legs = legs.min(sdf::taper(
            p,
            vec2(x - 0.03, 0.040),
            vec2(x + 0.10, 0.030),
            0.018,
            0.012,
        ));
    }
    brush.with(
        Paint::Slip,
        trunk
            .min(tail)
            .min(neck)
            .min(nape)
            .min(head)
            .min(beak)
            .min(legs),
    );
    let wing = sdf::curve(
        p,
        [vec2(0.14, 0.42), vec2(-0.12, 0.50), vec2(-0.42, 0.50)],
        0.100,
        0.014,
    );
    brush.with(Paint::Red, wing.max(-p.x - 0.02) + 0.014);
    brush.cut(wing.abs() - 0.006);
    for i in 0..4 {
        let z = 0.375 + 0.040 * i as f32;
        brush.cut(
            sdf::curve(
                p,
                [
                    vec2(-0.02, z),
                    vec2(-0.18, z + 0.035),
                    vec2(-0.40, 0.475 + 0.012 * i as f32),
                ],
                0.005,
                0.004,
            )
            .max(wing),
        );
    }
    let bar = (p.x - 0.005).abs() - 0.012;
    brush.with(Paint::White, bar.max(wing + 0.012));
    brush.with(Paint::White, sdf::circle(p, vec2(0.452, 0.915), 0.018));
    brush.with(Paint::Slip, sdf::circle(p, vec2(0.455, 0.915), 0.009));
}
