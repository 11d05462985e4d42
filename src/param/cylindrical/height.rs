//! How long a ring is, and how its length is spread.
//!
//! In: the flat ring, conformal (a narrow piece of the tube is as short as it is narrow), and a power p. Out: places on a
//! cylinder of radius 1. Where the tube has the width w the cylinder gets w^p of height for its length: all of a conformal
//! map at p = -1, its true length at p = 0, its true area at p = 1. Of the squared stretch of a tube of revolution,
//! (w^2 + w^-2p) times its area, over an area of w^p, p = 1/3 makes the least. How wide it is at a height is told by the area
//! there: the area of a conformal ring grows with height as w^2.

use super::annulus::Annulus;
use super::harmonic::Flat;
use super::{BEYOND, HALF_HEIGHT};
use glam::DVec3;

/// Pieces of height that area is gathered in.
const PIECES: usize = 512;
/// A piece counts for this share of the mean at least: heights stay apart.
const LEAST: f64 = 1e-4;

/// Places of all vertices about the axis, poles on it; none where nothing has area.
pub(super) fn spread(ring: &Annulus, flat: &Flat, power: f64) -> Option<Vec<DVec3>> {
    let share = shares(ring, flat, power)?;
    let height: Vec<f64> = flat.height.iter().map(|&h| at(&share, h)).collect();
    let whole = whole_height(ring, flat, &height)?;
    let half = (0.5 * whole).clamp(HALF_HEIGHT[0], HALF_HEIGHT[1]);
    let mut places: Vec<DVec3> = flat
        .angle
        .iter()
        .zip(&height)
        .map(|(angle, h)| DVec3::new(angle.cos(), angle.sin(), half * (2.0 * h - 1.0)))
        .collect();
    let beyond = half * (1.0 + 2.0 * BEYOND);
    for (&pole, side) in ring.poles.iter().zip([-1.0, 1.0]) {
        places[pole as usize] = DVec3::new(0.0, 0.0, side * beyond);
    }
    places.iter().all(|p| p.is_finite()).then_some(places)
}

/// Height reached at the end of each piece, from 0 to 1.
fn shares(ring: &Annulus, flat: &Flat, power: f64) -> Option<Vec<f64>> {
    let mut area = vec![0.0; PIECES];
    for &t in &ring.sides {
        let corners = ring.closed.triangles[t as usize];
        let [a, b, c] = corners.map(|v| ring.closed.places[v as usize]);
        let own = 0.5 * (b - a).cross(c - a).length();
        let heights = corners.map(|v| flat.height[v as usize]);
        let low = heights.iter().copied().fold(1.0, f64::min);
        let high = heights.iter().copied().fold(0.0, f64::max);
        let piece = |h: f64| ((h * PIECES as f64) as usize).min(PIECES - 1);
        let (first, last) = (piece(low), piece(high));
        for sum in &mut area[first..=last] {
            *sum += own / (last - first + 1) as f64;
        }
    }
    let mean = area.iter().sum::<f64>() / PIECES as f64;
    if !(mean > 0.0 && mean.is_finite()) {
        return None;
    }
    let grown = area.iter().scan(0.0, |sum, a| {
        *sum += (a / mean).max(LEAST).powf(0.5 * (1.0 + power));
        Some(*sum)
    });
    let mut share: Vec<f64> = std::iter::once(0.0).chain(grown).collect();
    let all = share[PIECES];
    share.iter_mut().for_each(|s| *s /= all);
    Some(share)
}

/// The share of height at the conformal height `h`.
fn at(share: &[f64], h: f64) -> f64 {
    let along = h.clamp(0.0, 1.0) * PIECES as f64;
    let piece = (along as usize).min(PIECES - 1);
    share[piece] + (along - piece as f64) * (share[piece + 1] - share[piece])
}

/// The height, over a radius of 1, that stretches least: that for which lengths along and around are stretched alike, as the
/// squared stretch is (around + along / height^2) height.
fn whole_height(ring: &Annulus, flat: &Flat, height: &[f64]) -> Option<f64> {
    let (mut around, mut along) = (0.0, 0.0);
    for (i, &t) in ring.sides.iter().enumerate() {
        if t as usize >= ring.closed.own {
            continue;
        }
        let corners = ring.closed.triangles[t as usize];
        let [a, b, c] = corners.map(|v| ring.closed.places[v as usize]);
        let angle = flat.angles(ring, i);
        let h = corners.map(|v| height[v as usize]);
        let (x, y) = (
            [angle[1] - angle[0], angle[2] - angle[0]],
            [h[1] - h[0], h[2] - h[0]],
        );
        let determinant = x[0] * y[1] - x[1] * y[0];
        let area = 0.5 * (b - a).cross(c - a).length();
        if determinant <= 0.0 {
            continue;
        }
        let by_angle = ((b - a) * y[1] - (c - a) * y[0]) / determinant;
        let by_height = ((c - a) * x[0] - (b - a) * x[1]) / determinant;
        around += area * by_angle.length_squared();
        along += area * by_height.length_squared();
    }
    let whole = (along / around).sqrt();
    (whole.is_finite() && whole > 0.0).then_some(whole)
}
