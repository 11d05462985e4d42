//! Pictures of simple surfaces from directions all around: which triangle, and which point of it, each pixel shows.
//!
//! In: surfaces in the world, [`Probes`]. Out: for each direction what its picture shows. Pictures are drawn by the deferred
//! renderer, whose triangles and barycentrics are the same bits on the processor and on every device.

use super::laid::Laid;
use super::mapping::Probes;
use crate::Result;
use crate::attribute::arithmetic::{V3, dot3};
use crate::attribute::{AttributeSet, Material, TextureSet};
use crate::render::{Camera, Options, Output, Picture, Projection, Rendered, Renderer};
use glam::DMat4;

/// Turns between two directions: the golden angle, which leaves none near another.
const GOLDEN: f64 = 2.399_963_229_728_653;

/// `count` unit vectors spread evenly over the sphere, the spiral turned by `turn` radians.
pub(crate) fn spread(count: u32, turn: f64) -> Vec<[f64; 3]> {
    let direction = |k: u32| {
        let y = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count.max(1));
        let (sin, cos) = (f64::from(k) * GOLDEN + turn).sin_cos();
        let r = (1.0 - y * y).max(0.0).sqrt();
        [r * sin, y, r * cos]
    };
    (0..count).map(direction).collect()
}

/// A pixel of a probe's picture that shows the front of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) triangle: usize,
    pub(super) b: [f32; 3],
}

/// What makes a renderer of a picture: on the processor or on a device.
pub type Draw<'a> = &'a dyn Fn(Picture) -> Result<Renderer>;

/// Surfaces ready to be seen.
pub(super) struct Probing<'a> {
    renderer: Renderer,
    lows: &'a [&'a Laid],
    centre: [f64; 3],
    radius: f64,
    size: u32,
}

impl<'a> Probing<'a> {
    pub(super) fn new(lows: &'a [&'a Laid], probes: &Probes, draw: Draw) -> Result<Probing<'a>> {
        let set = AttributeSet::new(TextureSet::default(), &[Material::default()], 1);
        let mut picture = Picture::new(set);
        for low in lows {
            let mesh = &low.world;
            let base = picture.attributes.push_mesh(mesh)?;
            let geometry = picture.add_geometry(&mesh.positions, &mesh.triangles, &[], &[], 0.0)?;
            picture.draw(geometry, base, None, DMat4::IDENTITY)?;
        }
        let (centre, radius) = picture.bounding_sphere();
        Ok(Probing {
            renderer: draw(picture)?,
            lows,
            centre,
            radius,
            size: probes.size,
        })
    }

    /// Shows `take` every pixel whose front is seen from `direction`: the surface's number and the point.
    pub(super) fn see(&self, direction: [f64; 3], take: &mut dyn FnMut(usize, Seen)) -> Result<()> {
        let shown = self.renderer.draw(&self.camera(direction)?, &options())?;
        let towards = direction.map(|c| c as f32);
        let fronts: Vec<Vec<bool>> = self.lows.iter().map(|low| fronts(low, towards)).collect();
        for pixel in 0..shown.draw.len() {
            if let Some((low, seen)) = seen(&shown, pixel)
                && fronts[low][seen.triangle]
            {
                take(low, seen);
            }
        }
        Ok(())
    }

    fn camera(&self, [x, y, z]: [f64; 3]) -> Result<Camera> {
        let (azimuth, elevation) = (x.atan2(z), y.clamp(-1.0, 1.0).asin());
        Camera::framed(
            self.centre,
            self.radius,
            azimuth.to_degrees(),
            elevation.to_degrees(),
            Projection::Orthographic,
            self.size,
            self.size,
        )
    }
}

fn options() -> Options {
    Options {
        output: Output::Unlit,
        ..Options::default()
    }
}

/// The triangles whose front is seen from `towards`.
fn fronts(low: &Laid, towards: V3) -> Vec<bool> {
    let front = |t: usize| dot3(low.world.face_normal(t).map(|c| c as f32), towards) > 0.0;
    (0..low.world.triangles.len()).map(front).collect()
}

fn seen(shown: &Rendered, pixel: usize) -> Option<(usize, Seen)> {
    let draw = shown.draw[pixel];
    let [b1, b2] = shown.barycentric[pixel];
    (draw != u32::MAX).then(|| {
        let seen = Seen {
            triangle: shown.triangle[pixel] as usize,
            b: [1.0 - b1 - b2, b1, b2],
        };
        (draw as usize, seen)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_spread_and_those_of_two_turns_are_apart() {
        for count in [1, 29, 512] {
            let all = spread(count, 0.0);
            let sum = all
                .iter()
                .fold([0.0; 3], |s, d| [s[0] + d[0], s[1] + d[1], s[2] + d[2]]);
            let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt();
            assert!(count == 1 || length / f64::from(count) < 0.05, "{count}");
        }
        // The views that measure are none of the probes.
        let dot = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        let (probes, views) = (spread(29, 0.0), spread(512, 1.0));
        let nearest = probes
            .iter()
            .flat_map(|p| views.iter().map(move |v| dot(p, v)));
        let nearest = nearest.fold(-1.0, f64::max);
        assert!(nearest < 0.999_99, "{nearest}");
    }
}
