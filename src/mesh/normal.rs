//! Areas and normals. In: positions and triangles. Out: areas in square units, unit normals.

use super::Mesh;

/// Twice the area vector of a triangle: (b - a) x (c - a), in double precision.
pub(crate) fn double_area_vector(corners: [[f32; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = corners.map(|p| glam::DVec3::from_array(p.map(f64::from)));
    (b - a).cross(c - a).to_array()
}

impl Mesh {
    /// Area of triangle `t` in square object units.
    pub fn face_area(&self, t: usize) -> f64 {
        glam::DVec3::from_array(double_area_vector(self.corners(t))).length() * 0.5
    }

    /// Area of every triangle in square object units.
    pub fn face_areas(&self) -> Vec<f64> {
        (0..self.triangles.len())
            .map(|t| self.face_area(t))
            .collect()
    }

    /// Unit normal of triangle `t` by its winding (counter-clockwise is outside); zero for a degenerate triangle.
    pub fn face_normal(&self, t: usize) -> [f64; 3] {
        glam::DVec3::from_array(double_area_vector(self.corners(t)))
            .normalize_or_zero()
            .to_array()
    }
}

/// Unit vertex normals: the sum of the area vectors of the triangles round each vertex.
///
/// Vertices at the same position share their normal, so that a uv seam does not show as a crease. A vertex without
/// area round it gets +Z. Lengths: one normal per position.
///
/// Triangles must only name existing positions.
pub fn smooth_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let weld = super::Weld::by_position(positions);
    let mut sums = vec![glam::DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let area =
            glam::DVec3::from_array(double_area_vector(triangle.map(|v| positions[v as usize])));
        for v in triangle {
            sums[weld.of[*v as usize] as usize] += area;
        }
    }
    weld.of
        .iter()
        .map(|&v| {
            sums[v as usize]
                .normalize_or(glam::DVec3::Z)
                .as_vec3()
                .to_array()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::mesh::{shapes, smooth_normals};

    #[test]
    fn areas_of_known_shapes() {
        let total = |mesh: crate::mesh::Mesh| mesh.face_areas().iter().sum::<f64>();
        assert!((total(shapes::grid(7)) - 1.0).abs() < 1e-6);
        assert!((total(shapes::octahedron()) - 4.0 * 3f64.sqrt()).abs() < 1e-6);
        let sphere = total(shapes::icosphere(4));
        assert!(sphere < 4.0 * std::f64::consts::PI && sphere > 0.99 * 4.0 * std::f64::consts::PI);
    }

    #[test]
    fn smooth_normals_of_a_sphere_are_its_positions() {
        for mesh in [shapes::icosphere(3), shapes::uv_sphere(32, 16)] {
            for (normal, position) in smooth_normals(&mesh.positions, &mesh.triangles)
                .iter()
                .zip(&mesh.positions)
            {
                let dot: f32 = (0..3).map(|k| normal[k] * position[k]).sum();
                assert!(dot > 0.995, "{} {normal:?} {position:?}", mesh.name);
            }
        }
    }

    #[test]
    fn no_area_gives_a_unit_normal_all_the_same() {
        assert_eq!(
            smooth_normals(&[[1.0; 3]; 3], &[[0, 1, 2]]),
            vec![[0.0, 0.0, 1.0]; 3]
        );
    }

    /// Positions near the largest float: the sums are done in double precision and stay finite.
    #[test]
    fn huge_positions_do_not_overflow() {
        let far = f32::MAX / 4.0;
        let normals = smooth_normals(
            &[[-far, 0.0, 0.0], [far, 0.0, 0.0], [0.0, far, 0.0]],
            &[[0, 1, 2]],
        );
        assert!(normals.iter().flatten().all(|c| c.is_finite()));
    }
}
