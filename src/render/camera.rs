//! Cameras: where a picture is taken from.
//!
//! In: an azimuth and elevation and the sphere to frame, or two matrices. Out: [`Camera`], and from it the one matrix
//! from world space to homogeneous *pixels* that the project pass uses. Matrices are computed in `f64` on the host and
//! rounded once. Camera space is right-handed, looks down -Z with +Y up; clip space is Vulkan's (z in 0..1, y down);
//! pixel (0, 0) is the top left one and its centre is (0.5, 0.5).

use crate::{Error, Result};
use glam::{DMat4, DVec3, DVec4};

/// The widest and highest image that can be drawn, in pixels.
pub const MAX_SIDE: u32 = 8192;

/// A view of the world: `clip = projection * view * p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World to camera space.
    pub view: DMat4,
    /// Camera to clip space (Vulkan's).
    pub projection: DMat4,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

/// How [`Camera::framed`] projects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// 40 degrees of view across the shorter side.
    #[default]
    Perspective,
    /// Parallel; the sphere fills the shorter side.
    Orthographic,
}

/// How much room is left round a framed sphere (1 is none).
const MARGIN: f64 = 1.02;
/// Half the vertical angle of view of a framed perspective camera, as a tangent: 20 degrees.
const TAN_HALF: f64 = 0.363_970_234_266_202_36;

impl Camera {
    /// A camera from its two matrices; refuses sizes out of range and matrices that are not finite or not invertible.
    pub fn new(view: DMat4, projection: DMat4, width: u32, height: u32) -> Result<Self> {
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(Error::Option {
                option: "--size",
                reason: format!("{width}x{height} is outside 1x1 to {MAX_SIDE}x{MAX_SIDE}"),
            });
        }
        for (name, matrix) in [("view", &view), ("projection", &projection)] {
            let determinant = matrix.determinant();
            if !matrix.is_finite() || !determinant.is_finite() || determinant == 0.0 {
                return Err(Error::Option {
                    option: "--camera",
                    reason: format!("the {name} matrix is not finite and invertible"),
                });
            }
        }
        Ok(Camera {
            view,
            projection,
            width,
            height,
        })
    }

    /// A camera that frames the sphere (`centre`, `radius`, world units), seen from `azimuth` (degrees about +Y, 0 on
    /// the +Z side, 90 on the +X side) and `elevation` (degrees above the horizon, clamped to +-90).
    pub fn framed(
        centre: [f64; 3],
        radius: f64,
        azimuth: f64,
        elevation: f64,
        projection: Projection,
        width: u32,
        height: u32,
    ) -> Result<Self> {
        let angles = [azimuth, elevation];
        Self::framed_from(1.0, centre, radius, angles, projection, [width, height])
    }

    /// [`framed`](Self::framed) from `distance` times as far away; parallel rays see as many times as much.
    ///
    /// # Errors
    /// [`Error::Option`] where an angle or the distance is not a finite number, or the distance not above 0.
    pub fn framed_from(
        distance: f64,
        centre: [f64; 3],
        radius: f64,
        [azimuth, elevation]: [f64; 2],
        projection: Projection,
        [width, height]: [u32; 2],
    ) -> Result<Self> {
        if !(distance.is_finite() && distance > 0.0) {
            return Err(Error::Option {
                option: "--distance",
                reason: format!("{distance} is not a finite number above 0"),
            });
        }
        if !(azimuth.is_finite() && elevation.is_finite()) {
            return Err(Error::Option {
                option: "--view",
                reason: "angles must be finite numbers".into(),
            });
        }
        let radius = if radius.is_finite() && radius > 0.0 {
            radius
        } else {
            1.0
        };
        let centre = DVec3::from_array(centre);
        let (sin_a, cos_a) = azimuth.to_radians().sin_cos();
        let (sin_e, cos_e) = elevation.clamp(-90.0, 90.0).to_radians().sin_cos();
        // The frame is made from the angles, not from a cross product with +Y, so that it exists at the poles.
        let toward = DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e);
        let right = DVec3::new(cos_a, 0.0, -sin_a);
        let up = toward.cross(right);
        let (distance, projection) = match projection {
            Projection::Perspective => perspective(radius, distance, width, height),
            Projection::Orthographic => orthographic(radius, distance, width, height),
        };
        let eye = centre + toward * distance;
        let rotation = DMat4::from_cols(
            DVec4::new(right.x, up.x, toward.x, 0.0),
            DVec4::new(right.y, up.y, toward.y, 0.0),
            DVec4::new(right.z, up.z, toward.z, 0.0),
            DVec4::W,
        );
        Camera::new(
            rotation * DMat4::from_translation(-eye),
            projection,
            width,
            height,
        )
    }

    /// The same view at `factor` times the resolution.
    pub fn scaled(&self, factor: u32) -> Result<Self> {
        Camera::new(
            self.view,
            self.projection,
            self.width.saturating_mul(factor),
            self.height.saturating_mul(factor),
        )
    }

    /// World space to (x, y, depth, 1) * w with x and y in pixels; rows, rounded to `f32`.
    pub(crate) fn pixel_rows(&self) -> [[f32; 4]; 4] {
        self.pixel_rows_from(0)
    }

    /// Likewise, y counted from row `top` on.
    pub(crate) fn pixel_rows_from(&self, top: u32) -> [[f32; 4]; 4] {
        let (w, h) = (f64::from(self.width) / 2.0, f64::from(self.height) / 2.0);
        let viewport = DMat4::from_cols(
            DVec4::new(w, 0.0, 0.0, 0.0),
            DVec4::new(0.0, h, 0.0, 0.0),
            DVec4::Z,
            DVec4::new(w, h - f64::from(top), 0.0, 1.0),
        );
        let m = viewport * self.projection * self.view;
        [0, 1, 2, 3].map(|row| m.row(row).as_vec4().to_array())
    }

    /// Where the eye is, (x, y, z, 1); or for a parallel camera the unit direction towards it, (x, y, z, 0).
    pub(crate) fn eye(&self) -> [f32; 4] {
        let inverse = self.view.inverse();
        let last = self.projection.row(3);
        if last.x == 0.0 && last.y == 0.0 && last.z == 0.0 {
            inverse
                .transform_vector3(DVec3::Z)
                .normalize_or(DVec3::Z)
                .extend(0.0)
                .as_vec4()
                .to_array()
        } else {
            inverse
                .transform_point3(DVec3::ZERO)
                .extend(1.0)
                .as_vec4()
                .to_array()
        }
    }

    /// The unit world direction of a direction given in camera space.
    pub(crate) fn world_direction(&self, camera: [f64; 3]) -> [f32; 3] {
        let world = self
            .view
            .inverse()
            .transform_vector3(DVec3::from_array(camera));
        world.normalize_or(DVec3::Y).as_vec3().to_array()
    }
}

/// Distance of the eye and projection for a sphere seen whole in both directions, from `times` as far away.
fn perspective(radius: f64, times: f64, width: u32, height: u32) -> (f64, DMat4) {
    let (tan_x, tan_y) = half_extents(TAN_HALF, width, height);
    let sine = TAN_HALF / (1.0 + TAN_HALF * TAN_HALF).sqrt();
    let distance = radius * MARGIN / sine * times;
    let (near, far) = (
        (distance - radius * 1.5).max(radius * 0.05 * times.min(1.0)),
        distance + radius * 1.5,
    );
    let projection = DMat4::from_cols(
        DVec4::new(1.0 / tan_x, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -1.0 / tan_y, 0.0, 0.0),
        DVec4::new(0.0, 0.0, -far / (far - near), -1.0),
        DVec4::new(0.0, 0.0, -far * near / (far - near), 0.0),
    );
    (distance, projection)
}

/// Distance of the eye and projection for a sphere seen whole by parallel rays, `times` as small.
fn orthographic(radius: f64, times: f64, width: u32, height: u32) -> (f64, DMat4) {
    let (half_x, half_y) = half_extents(radius * MARGIN * times, width, height);
    let (near, far) = (0.5 * radius, 3.5 * radius);
    let projection = DMat4::from_cols(
        DVec4::new(1.0 / half_x, 0.0, 0.0, 0.0),
        DVec4::new(0.0, -1.0 / half_y, 0.0, 0.0),
        DVec4::new(0.0, 0.0, -1.0 / (far - near), 0.0),
        DVec4::new(0.0, 0.0, -near / (far - near), 1.0),
    );
    (2.0 * radius, projection)
}

/// `half` along the shorter side, in proportion along the longer.
fn half_extents(half: f64, width: u32, height: u32) -> (f64, f64) {
    let (w, h) = (f64::from(width.max(1)), f64::from(height.max(1)));
    let shorter = w.min(h);
    (half * w / shorter, half * h / shorter)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixel(camera: &Camera, p: [f64; 3]) -> [f64; 3] {
        let rows = camera.pixel_rows();
        let h = rows.map(|r| {
            f64::from(r[0]) * p[0]
                + f64::from(r[1]) * p[1]
                + f64::from(r[2]) * p[2]
                + f64::from(r[3])
        });
        [h[0] / h[3], h[1] / h[3], h[2] / h[3]]
    }

    #[test]
    fn a_framed_sphere_lies_inside_the_image_and_in_front() {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            for (azimuth, elevation, w, h) in [
                (0.0, 0.0, 64, 64),
                (123.0, 90.0, 301, 64),
                (-45.0, -90.0, 33, 200),
            ] {
                let c = [3.0, -2.0, 0.5];
                let camera = Camera::framed(c, 2.0, azimuth, elevation, projection, w, h).unwrap();
                let middle = pixel(&camera, c);
                assert!(
                    (middle[0] - f64::from(w) / 2.0).abs() < 1e-3
                        && (middle[1] - f64::from(h) / 2.0).abs() < 1e-3
                );
                for axis in 0..3 {
                    for sign in [-2.0, 2.0] {
                        let mut p = c;
                        p[axis] += sign;
                        let q = pixel(&camera, p);
                        assert!(q[0] >= 0.0 && q[0] <= f64::from(w), "{q:?}");
                        assert!(q[1] >= 0.0 && q[1] <= f64::from(h), "{q:?}");
                        assert!(q[2] >= 0.0 && q[2] <= 1.0, "{q:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn up_is_up_and_azimuth_ninety_looks_from_plus_x() {
        let camera =
            Camera::framed([0.0; 3], 1.0, 90.0, 0.0, Projection::Orthographic, 100, 100).unwrap();
        assert!(pixel(&camera, [0.0, 0.5, 0.0])[1] < 50.0);
        // Seen from +X with +Y up, -Z is to the right.
        assert!(pixel(&camera, [0.0, 0.0, -0.5])[0] > 50.0);
        assert!(pixel(&camera, [0.5, 0.0, 0.0])[2] < pixel(&camera, [-0.5, 0.0, 0.0])[2]);
        assert_eq!(camera.eye()[3], 0.0);
        assert!((camera.eye()[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn sizes_and_matrices_out_of_range_are_refused() {
        assert!(Camera::new(DMat4::IDENTITY, DMat4::IDENTITY, 0, 4).is_err());
        assert!(Camera::new(DMat4::IDENTITY, DMat4::IDENTITY, 4, MAX_SIDE + 1).is_err());
        assert!(Camera::new(DMat4::ZERO, DMat4::IDENTITY, 4, 4).is_err());
        assert!(
            Camera::new(
                DMat4::IDENTITY,
                DMat4::from_cols_array(&[f64::NAN; 16]),
                4,
                4
            )
            .is_err()
        );
        assert!(
            Camera::framed([0.0; 3], 1.0, f64::NAN, 0.0, Projection::Perspective, 4, 4).is_err()
        );
    }
}
