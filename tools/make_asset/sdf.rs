//! Signed distances in the plane (object units, negative inside), the brush of every motif.
//!
//! Most are exact; those that are not (`curved_leaf`) are close to it near their outline, where the paint's
//! edge is.

use glam::{Vec2, vec2};

pub(crate) fn circle(p: Vec2, centre: Vec2, radius: f32) -> f32 {
    p.distance(centre) - radius
}

pub(crate) fn ellipse(p: Vec2, centre: Vec2, radii: Vec2) -> f32 {
    // First-order distance: value over gradient length.
    let q = p - centre;
    let k0 = (q / radii).length();
    let k1 = (q / (radii * radii)).length().max(1e-6);
    k0 * (k0 - 1.0) / k1
}

pub(crate) fn segment(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let (pa, ba) = (p - a, b - a);
    let t = (pa.dot(ba) / ba.dot(ba)).clamp(0.0, 1.0);
    (pa - ba * t).length()
}

/// A stroke whose half width goes from `ra` at `a` to `rb` at `b`.
pub(crate) fn taper(p: Vec2, a: Vec2, b: Vec2, ra: f32, rb: f32) -> f32 {
    let (pa, ba) = (p - a, b - a);
    let t = (pa.dot(ba) / ba.dot(ba)).clamp(0.0, 1.0);
    (pa - ba * t).length() - (ra + (rb - ra) * t)
}

/// A tapered stroke along the quadratic curve a, b (control), c: twelve straight pieces.
pub(crate) fn curve(p: Vec2, [a, b, c]: [Vec2; 3], ra: f32, rb: f32) -> f32 {
    const PIECES: usize = 12;
    let at = |t: f32| a * ((1.0 - t) * (1.0 - t)) + b * (2.0 * t * (1.0 - t)) + c * (t * t);
    let mut best = f32::MAX;
    for i in 0..PIECES {
        let (t0, t1) = (i as f32 / PIECES as f32, (i + 1) as f32 / PIECES as f32);
        best = best.min(taper(
            p,
            at(t0),
            at(t1),
            ra + (rb - ra) * t0,
            ra + (rb - ra) * t1,
        ));
    }
    best
}

/// A polygon, any winding (Quilez's exact form).
pub(crate) fn polygon(p: Vec2, corners: &[Vec2]) -> f32 {
    let mut distance = (p - corners[0]).length_squared();
    let mut sign = 1.0;
    for i in 0..corners.len() {
        let (a, b) = (corners[i], corners[(i + corners.len() - 1) % corners.len()]);
        let (e, w) = (b - a, p - a);
        let t = (w.dot(e) / e.dot(e)).clamp(0.0, 1.0);
        distance = distance.min((w - e * t).length_squared());
        let inside = [p.y >= a.y, p.y < b.y, e.x * w.y > e.y * w.x];
        if inside.iter().all(|&c| c) || inside.iter().all(|&c| !c) {
            sign = -sign;
        }
    }
    sign * distance.sqrt()
}

pub(crate) fn rectangle(p: Vec2, centre: Vec2, half: Vec2) -> f32 {
    let q = (p - centre).abs() - half;
    q.max(Vec2::ZERO).length() + q.x.max(q.y).min(0.0)
}

/// A petal from `base` along the unit direction `along`: round tip of `radius`, pointed foot.
pub(crate) fn petal(p: Vec2, base: Vec2, along: Vec2, length: f32, radius: f32) -> f32 {
    taper(
        p,
        base,
        base + along * (length - radius),
        radius * 0.18,
        radius,
    )
}

/// A lens-shaped body of half length `half` lying along x, bent upwards by `bend`, `thick` at its thickest.
pub(crate) fn curved_leaf(p: Vec2, half: f32, thick: f32, bend: f32) -> f32 {
    let t = p.x / half;
    let profile = thick * (1.0 - t * t).max(0.0);
    let off = (p.y - bend * (1.0 - t * t)).abs() - profile;
    off.max(p.x.abs() - half) * 0.85
}

/// Rotates by the angle whose cosine and sine are given.
pub(crate) fn turn(p: Vec2, cos: f32, sin: f32) -> Vec2 {
    vec2(p.x * cos + p.y * sin, p.y * cos - p.x * sin)
}
