//! Quadric error metric: how far a point lies from the planes of the triangles that met at a vertex.
//!
//! In: triangles and border edges. Out: [`Quadric`], whose error is a mean squared distance. Each plane weighs as its area
//! does. Source: Garland and Heckbert 1997, Surface Simplification Using Quadric Error Metrics.

use glam::DVec3;
use std::ops::AddAssign;

/// What an edge without a neighbour weighs beside the triangles: it moves only along itself.
const BORDER_WEIGHT: f64 = 10.0;

/// The symmetric form x^T A x + 2 b^T x + c, and the weight of all planes in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Quadric {
    /// xx, yy, zz, xy, yz, zx.
    a: [f64; 6],
    b: DVec3,
    c: f64,
    weight: f64,
}

impl Quadric {
    /// Of a triangle's plane; nothing for one without area.
    pub(super) fn of_triangle([a, b, c]: [DVec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        let twice_area = normal.length();
        Self::of_plane(normal / twice_area, a, twice_area * 0.5)
    }

    /// Of the plane through an edge that stands upright on the triangle beside it, whose third corner is `beside`.
    pub(super) fn of_edge([a, b]: [DVec3; 2], beside: DVec3) -> Self {
        let along = b - a;
        let up = (beside - a).cross(along);
        let across = along.cross(up);
        let weight = along.length_squared() * BORDER_WEIGHT;
        Self::of_plane(across / across.length(), a, weight)
    }

    fn of_plane(n: DVec3, through: DVec3, weight: f64) -> Self {
        if !n.is_finite() || !weight.is_finite() {
            return Self::default();
        }
        let d = -n.dot(through);
        Quadric {
            a: [
                n.x * n.x,
                n.y * n.y,
                n.z * n.z,
                n.x * n.y,
                n.y * n.z,
                n.z * n.x,
            ]
            .map(|x| x * weight),
            b: n * (d * weight),
            c: d * d * weight,
            weight,
        }
    }

    /// The mean squared distance of `p` from the planes, weighed; never negative.
    pub(super) fn error(&self, p: DVec3) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.a;
        let square = xx * p.x * p.x + yy * p.y * p.y + zz * p.z * p.z;
        let mixed = xy * p.x * p.y + yz * p.y * p.z + zx * p.z * p.x;
        let sum = square + 2.0 * (mixed + self.b.dot(p)) + self.c;
        if self.weight > 0.0 {
            (sum / self.weight).max(0.0)
        } else {
            0.0
        }
    }
}

impl AddAssign<&Quadric> for Quadric {
    fn add_assign(&mut self, other: &Quadric) {
        self.a.iter_mut().zip(other.a).for_each(|(x, y)| *x += y);
        self.b += other.b;
        self.c += other.c;
        self.weight += other.weight;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn errors_are_squared_distances_from_planes() {
        let mut q = Quadric::of_triangle(CORNERS);
        assert_eq!(q.error(DVec3::new(7.0, -3.0, 0.0)), 0.0);
        assert!((q.error(DVec3::new(7.0, -3.0, 0.5)) - 0.25).abs() < 1e-12);
        // Two planes of equal weight: the mean.
        q += &Quadric::of_triangle([DVec3::ZERO, DVec3::Y, DVec3::Z]);
        assert!((q.error(DVec3::new(1.0, 0.0, 0.0)) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_border_resists_across_and_not_along() {
        let q = Quadric::of_edge([DVec3::ZERO, DVec3::X], DVec3::Y);
        assert!(q.error(DVec3::new(5.0, 0.0, 2.0)) < 1e-24);
        assert!((q.error(DVec3::new(0.5, 0.3, 0.0)) - 0.09).abs() < 1e-12);
    }

    #[test]
    fn what_has_no_area_says_nothing() {
        let q = Quadric::of_triangle([DVec3::ZERO, DVec3::X, DVec3::X]);
        assert_eq!(q, Quadric::default());
        assert_eq!(q.error(DVec3::ONE), 0.0);
    }
}
