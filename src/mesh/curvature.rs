//! How much a surface bends. In: positions and triangles. Out: the mean curvature at each vertex.
//!
//! Mean curvature is half the divergence of the normal over the surface. On a triangle the normal is taken as the linear
//! function between unit normals at its corners, whose divergence is a sum of three products; a vertex has the mean of the
//! triangles round it, by area. The normals are those of Max, *Weights for Computing Vertex Normals from Facet Normals*
//! (Journal of Graphics Tools 4(2), 1999): where corners lie on a sphere they are its normals, and the answer is 1 / r.

use super::Weld;
use glam::DVec3;

/// The mean curvature at each vertex, in 1 / unit of length: positive where the surface bulges outwards, negative in hollows,
/// 0 where it is flat or has no area. Vertices at the same position share it, so that seams do not show.
///
/// Triangles must only name existing positions.
pub fn mean_curvature(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<f32> {
    let weld = Weld::by_position(positions);
    let corners = |t: &[u32; 3]| t.map(|v| DVec3::from_array(positions[v as usize].map(f64::from)));
    let place = |v: u32| weld.of[v as usize] as usize;
    let mut normals = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let p = corners(triangle);
        for k in 0..3 {
            let (e, f) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            let weight = e.length_squared() * f.length_squared();
            if weight > 0.0 {
                normals[place(triangle[k])] += e.cross(f) / weight;
            }
        }
    }
    let normals: Vec<DVec3> = normals.iter().map(|n| n.normalize_or_zero()).collect();
    let (mut sums, mut areas) = (vec![0.0; positions.len()], vec![0.0; positions.len()]);
    for triangle in triangles {
        let p = corners(triangle);
        let twice = (p[1] - p[0]).cross(p[2] - p[0]);
        let area = twice.length();
        if area <= 0.0 || !area.is_finite() {
            continue;
        }
        let upright = twice / area;
        // The gradient of a corner's weight, times twice the area, is the edge opposite, turned by a quarter inwards.
        let along = |k: usize| upright.cross(p[(k + 2) % 3] - p[(k + 1) % 3]);
        let divergence: f64 = (0..3)
            .map(|k| normals[place(triangle[k])].dot(along(k)))
            .sum();
        for v in triangle {
            sums[place(*v)] += 0.5 * divergence;
            areas[place(*v)] += area;
        }
    }
    let mean = |&v: &u32| {
        let (sum, area) = (sums[v as usize], areas[v as usize]);
        if area > 0.0 { (sum / area) as f32 } else { 0.0 }
    };
    weld.of.iter().map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, shapes};

    fn of(mesh: &Mesh) -> Vec<f32> {
        mean_curvature(&mesh.positions, &mesh.triangles)
    }

    #[test]
    fn a_ball_has_one_over_its_radius_and_a_hollow_one_minus_that() {
        for radius in [0.01f32, 1.0, 250.0] {
            let mut ball = shapes::icosphere(2);
            let grow = |c: &mut f32| *c *= radius;
            ball.positions.iter_mut().flatten().for_each(grow);
            let near = |c: &f32, want: f32| (c * radius - want).abs() < 1e-4;
            assert!(of(&ball).iter().all(|c| near(c, 1.0)));
            ball.triangles.iter_mut().for_each(|t| t.swap(0, 1));
            assert!(of(&ball).iter().all(|c| near(c, -1.0)));
        }
    }

    #[test]
    fn a_plane_has_none_and_a_tube_half_of_a_ball() {
        assert!(of(&shapes::grid(9)).iter().all(|c| c.abs() < 1e-6));
        // Away from its rims, where a normal knows one side only.
        let tube = shapes::tube(96, 24);
        let inside = |p: &[f32; 3]| {
            let (low, high) = tube.bounds().unwrap_or_default();
            let share = (p[2] - low[2]) / (high[2] - low[2]);
            (0.2..0.8).contains(&share)
        };
        let all = of(&tube);
        let middle = tube.positions.iter().zip(&all).filter(|(p, _)| inside(p));
        let radius = (tube.positions[0][0].powi(2) + tube.positions[0][1].powi(2)).sqrt();
        let mut count = 0;
        for (_, c) in middle {
            assert!((c * radius - 0.5).abs() < 5e-3, "{c}");
            count += 1;
        }
        assert!(count > 500);
    }

    #[test]
    fn a_saddle_bends_both_ways_at_once() {
        // z = a x^2 - a y^2: its mean curvature is 0 in the middle; with + it is -2 a, since the front looks up.
        for (sign, want) in [(-1.0f32, 0.0), (1.0, -0.6)] {
            let mut sheet = shapes::grid(40);
            for p in &mut sheet.positions {
                let (x, y) = (p[0] - 0.5, p[1] - 0.5);
                p[2] = 0.3 * (x * x + sign * y * y);
            }
            let middle = of(&sheet)[20 * 41 + 20];
            assert!((middle - want).abs() < 0.01, "{middle} {want}");
        }
    }

    #[test]
    fn what_has_no_area_has_none() {
        assert_eq!(mean_curvature(&[[1.0; 3]; 3], &[[0, 1, 2]]), [0.0; 3]);
        assert!(mean_curvature(&[], &[]).is_empty());
    }
}
