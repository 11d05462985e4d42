//! `--lod`: which level of detail.
//!
//! In: `N`, `triangles:N`, `pixels:X`, `pixels:X,colour:Y` or `surface:X`, a built model, a camera. Out: a level: 0 is the reference's own
//! geometry, 1, 2, .. the chain; or the limits of a cut.

use std::str::FromStr;

use invertex::Result;
use invertex::asset::Built;
use invertex::lod::multiresolution::{Criterion, Limits};
use invertex::render::{Camera, in_chain, levels, triangles};

use super::bad_option;

/// What `--lod` says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LodChoice {
    /// This level.
    Level(usize),
    /// The finest level with at most so many triangles, over the whole model; the coarsest where all have more.
    Triangles(usize),
    /// Of a multiresolution model the cut that keeps within so many pixels by a criterion; of others the coarsest level whose
    /// deviation stays under the pixels.
    Cut {
        /// Pixels on the screen.
        pixels: f64,
        /// What must keep within them.
        criterion: Criterion,
    },
}

impl FromStr for LodChoice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let wrong = || {
            format!(
                "\"{text}\" is not a level (0, 1, ..), triangles:N, pixels:X, pixels:X,colour:Y or surface:X"
            )
        };
        let limit = |text: &str| {
            let limit = text.parse::<f64>().ok();
            limit
                .filter(|x| x.is_finite() && *x >= 0.0)
                .ok_or_else(wrong)
        };
        match text.split_once(':') {
            None => text.parse().map(LodChoice::Level).map_err(|_| wrong()),
            Some(("triangles", n)) => n.parse().map(LodChoice::Triangles).map_err(|_| wrong()),
            Some(("surface", pixels)) => Ok(LodChoice::Cut {
                pixels: limit(pixels)?,
                criterion: Criterion::Surface,
            }),
            Some(("pixels", limits)) => {
                let (pixels, colour) = match limits.split_once(",colour:") {
                    Some((pixels, colour)) => (pixels, Some(limit(colour)?)),
                    None => (limits, None),
                };
                Ok(LodChoice::Cut {
                    pixels: limit(pixels)?,
                    criterion: colour.map_or(Criterion::Displacement, Criterion::Colour),
                })
            }
            Some(_) => Err(wrong()),
        }
    }
}

impl LodChoice {
    /// The level for `built` seen by `camera`; `sphere` is round everything that is drawn.
    ///
    /// # Errors
    /// [`invertex::Error::Option`] for a level that the model does not have.
    pub(super) fn level(
        &self,
        built: &Built,
        camera: &Camera,
        sphere: ([f64; 3], f64),
    ) -> Result<usize> {
        let levels = levels(built);
        match *self {
            LodChoice::Level(level) if level < levels => Ok(level),
            LodChoice::Level(level) => {
                let reason = format!(
                    "the model has levels 0 (the reference) to {}, not {level}",
                    levels - 1
                );
                Err(bad_option("--lod", reason))
            }
            LodChoice::Triangles(most) => {
                let fits = |&level: &usize| triangles(built, level) <= most;
                Ok((0..levels).find(fits).unwrap_or(levels - 1))
            }
            LodChoice::Cut { pixels: most, .. } => {
                let scale = pixels_per_unit(camera, sphere);
                let fits = |&level: &usize| deviation(built, level) * scale <= most;
                Ok((0..levels).rev().find(fits).unwrap_or(0))
            }
        }
    }
}

impl LodChoice {
    /// The limits of a cut; none where a level is meant. In a sequence what is finer stays so until it may be coarser with
    /// a tenth to spare: nothing flickers.
    pub(super) fn limits(&self, is_sequence: bool) -> Option<Limits> {
        let LodChoice::Cut { pixels, criterion } = *self else {
            return None;
        };
        Some(Limits {
            pixels,
            criterion,
            hysteresis: if is_sequence { 0.9 } else { 1.0 },
            outside: true,
        })
    }
}

/// Largest deviation of any instance at `level`, in world units.
fn deviation(built: &Built, level: usize) -> f64 {
    let of_instance = |instance: invertex::scene::Instance| {
        let mesh = built.of_mesh(instance.mesh)?;
        let k = in_chain(mesh.lods.len(), level)?;
        let world = glam::DMat3::from_mat4(instance.world);
        let stretch = [world.x_axis, world.y_axis, world.z_axis]
            .map(|c| c.length_squared())
            .iter()
            .sum::<f64>()
            .sqrt();
        // Frobenius' norm is never less than the largest stretch; a skinned mesh is taken as it is.
        let stretch = if instance.skin.is_some() {
            1.0
        } else {
            stretch
        };
        Some(f64::from(mesh.deviation_max(k)) * stretch)
    };
    built
        .scene
        .instances()
        .into_iter()
        .filter_map(of_instance)
        .fold(0.0, f64::max)
}

/// Pixels that a unit length across the view can span at the point of the sphere nearest to the eye.
fn pixels_per_unit(camera: &Camera, (centre, radius): ([f64; 3], f64)) -> f64 {
    let p = &camera.projection;
    let half = [
        f64::from(camera.width) / 2.0,
        f64::from(camera.height) / 2.0,
    ];
    let across = (p.x_axis.x * half[0])
        .abs()
        .max((p.y_axis.y * half[1]).abs());
    let depth = -camera
        .view
        .transform_point3(glam::DVec3::from_array(centre))
        .z
        - radius;
    // w of a point at this depth: the depth itself in perspective, a constant otherwise.
    let w = (p.z_axis.w * -depth + p.w_axis.w).abs();
    let perspective = p.z_axis.w != 0.0;
    if perspective && depth <= 0.0 {
        return f64::INFINITY; // the eye is inside the sphere: nothing but the reference is surely fine
    }
    across / w.max(1e-12)
}

#[cfg(test)]
mod tests {
    use super::*;
    use invertex::render::Projection;

    #[test]
    fn choices_are_read() {
        assert_eq!("3".parse(), Ok(LodChoice::Level(3)));
        assert_eq!("triangles:500".parse(), Ok(LodChoice::Triangles(500)));
        for (text, criterion) in [
            ("pixels:0.5", Criterion::Displacement),
            ("pixels:0.5,colour:2", Criterion::Colour(2.0)),
            ("surface:0.5", Criterion::Surface),
        ] {
            let pixels = 0.5;
            assert_eq!(text.parse(), Ok(LodChoice::Cut { pixels, criterion }));
        }
        for bad in [
            "",
            "-1",
            "x",
            "pixels:",
            "pixels:nan",
            "pixels:-1",
            "pixels:1,colour:",
            "pixels:1,colour:-2",
            "pixels:1,colour:nan",
            "pixels:,colour:2",
            "colour:2",
            "surface:",
            "surface:-1",
            "surface:1,colour:2",
            "triangles:1.5",
            "metres:1",
        ] {
            assert!(bad.parse::<LodChoice>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_unit_sphere_that_fills_the_frame_spans_it() {
        let camera = Camera::framed(
            [0.0; 3],
            1.0,
            10.0,
            20.0,
            Projection::Orthographic,
            200,
            200,
        )
        .unwrap();
        let scale = pixels_per_unit(&camera, ([0.0; 3], 1.0));
        assert!((scale - 100.0 / 1.02).abs() < 1e-6, "{scale}");
        // In perspective the nearest point of the sphere is larger than its middle.
        let camera =
            Camera::framed([0.0; 3], 1.0, 10.0, 20.0, Projection::Perspective, 200, 200).unwrap();
        let near = pixels_per_unit(&camera, ([0.0; 3], 1.0));
        let middle = pixels_per_unit(&camera, ([0.0; 3], 0.0));
        assert!(
            near > middle && middle > 90.0 && middle < 110.0,
            "{near} {middle}"
        );
        assert_eq!(pixels_per_unit(&camera, ([0.0; 3], 1e6)), f64::INFINITY);
    }
}
