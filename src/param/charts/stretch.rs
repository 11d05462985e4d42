//! What a map does to lengths and angles.
//!
//! In: a [`Chart`] and its map. Out: [`Stretch`]: for each triangle the map has singular values, sigma_1 >= sigma_2, of
//! lengths in the plane per length on the surface.
//! Source: Sander, Snyder, Gortler, Hoppe, Texture Mapping Progressive Meshes (2001), section 3: stretch is measured from
//! the plane to the surface, 1 / sigma, and is 1 where nothing is stretched.

use super::chart::Chart;
use super::lscm::laid_flat;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// The stretch of a map whose area is that of the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    /// Root mean square over the surface and over all directions: 1 is none.
    pub l2: f64,
    /// The largest anywhere, in any direction.
    pub linf: f64,
    /// Mean over the surface of (sigma_1 / sigma_2 + sigma_2 / sigma_1) / 2 - 1: 0 is conformal.
    pub angle: f64,
}

/// Sums of which [`Stretch`] is made.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    squares: f64,
    angles: f64,
    worst: f64,
    area: f64,
    flat_area: f64,
}

impl Sums {
    /// Adds a triangle of the surface, laid flat, and its image.
    pub(crate) fn add(&mut self, shape: [DVec2; 3], image: [DVec2; 3]) {
        let double = (shape[1] - shape[0]).perp_dot(shape[2] - shape[0]);
        let singular = singular_values(shape, image);
        self.area += 0.5 * double;
        self.flat_area += 0.5 * (image[1] - image[0]).perp_dot(image[2] - image[0]);
        let [large, small] = singular;
        let (gamma, little) = (1.0 / small, 1.0 / large);
        self.squares += 0.5 * double * 0.5 * (gamma * gamma + little * little);
        self.angles += 0.5 * double * (0.5 * (large / small + small / large) - 1.0);
        self.worst = self.worst.max(gamma);
    }

    /// Adds a triangle of the surface and its image, both in space, wound alike.
    pub(crate) fn add_in_space(&mut self, corners: [DVec3; 3], image: [DVec3; 3]) {
        self.add(laid_flat(corners), laid_flat(image));
    }

    /// Both together.
    pub(crate) fn join(&mut self, other: &Sums) {
        self.squares += other.squares;
        self.angles += other.angles;
        self.worst = self.worst.max(other.worst);
        self.area += other.area;
        self.flat_area += other.flat_area;
    }

    /// Share of a square that the images fill.
    pub(crate) fn flat_share(&self, side: f64) -> f64 {
        self.flat_area / (side * side)
    }

    /// The stretch, with the plane scaled to the surface's area; infinite where something has no image.
    pub(crate) fn stretch(&self) -> Stretch {
        if self.area <= 0.0 {
            return Stretch {
                l2: 1.0,
                linf: 1.0,
                angle: 0.0,
            };
        }
        let scale = (self.flat_area / self.area).max(0.0).sqrt();
        let or_infinite = |x: f64| if x.is_finite() { x } else { f64::INFINITY };
        Stretch {
            l2: or_infinite((self.squares / self.area).sqrt() * scale),
            linf: or_infinite(self.worst * scale),
            angle: or_infinite(self.angles / self.area),
        }
    }
}

/// Singular values of the affine map from one triangle to another, the larger first; the second is 0 or negative where
/// the image is degenerate or turned over.
pub(crate) fn singular_values(shape: [DVec2; 3], image: [DVec2; 3]) -> [f64; 2] {
    let (a, b) = (shape[1] - shape[0], shape[2] - shape[0]);
    let (p, q) = (image[1] - image[0], image[2] - image[0]);
    let determinant = a.perp_dot(b);
    // Columns of the Jacobian.
    let x = (p * b.y - q * a.y) / determinant;
    let y = (q * a.x - p * b.x) / determinant;
    let same = DVec2::new(x.x + y.y, x.y - y.x).length();
    let turned = DVec2::new(x.x - y.y, x.y + y.x).length();
    [0.5 * (same + turned), 0.5 * (same - turned)]
}

/// Sums over a chart.
pub(crate) fn sums(chart: &Chart, flat: &[DVec2]) -> Sums {
    let mut sums = Sums::default();
    for i in 0..chart.corners.len() {
        sums.add(
            laid_flat(chart.triangle(i)),
            chart.corners[i].map(|v| flat[v as usize]),
        );
    }
    sums
}

/// Scales a map to the area of its chart; false where it has none.
pub(crate) fn to_own_area(chart: &Chart, flat: &mut [DVec2]) -> bool {
    let mut area = 0.0;
    let mut flat_area = 0.0;
    for (i, corners) in chart.corners.iter().enumerate() {
        let [a, b, c] = chart.triangle(i);
        area += (b - a).cross(c - a).length();
        let [a, b, c] = corners.map(|v| flat[v as usize]);
        flat_area += (b - a).perp_dot(c - a);
    }
    let scale = (area / flat_area).sqrt();
    let usable = scale.is_finite() && scale > 0.0;
    if usable {
        flat.iter_mut().for_each(|p| *p *= scale);
    }
    usable
}
