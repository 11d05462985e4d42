//! How far the details of a reference stand from their places in a picture of a LoD.
//!
//! In: a scene at rest, a camera, a picture that was drawn through inverse textures. Out: for each pixel the distance on the screen
//! between its middle and where the point of the reference that it shows belongs. A bound on the displacement of every point
//! is a bound on these, but for half a sixteenth of a pixel each way: corners are drawn on that grid.

use crate::render::{Camera, Rendered};
use crate::scene::Scene;
use glam::{DVec3, DVec4};
use rayon::prelude::*;
use serde::Serialize;

/// For each pixel its displacement in pixels; none where nothing is, or where the point of the reference turns its back to the
/// eye: it should not be seen at all.
pub fn displaced(scene: &Scene, camera: &Camera, image: &Rendered) -> Vec<Option<f32>> {
    let instances = scene.instances();
    let to_clip = camera.projection * camera.view;
    let undo = camera.view.inverse();
    let perspective = camera.projection.z_axis.w != 0.0;
    let eye = undo.transform_point3(DVec3::ZERO);
    let back = undo.transform_vector3(DVec3::Z);
    let width = image.width as usize;
    let half = [image.width, image.height].map(|n| f64::from(n) * 0.5);
    let at = |k: usize| {
        let instance = instances.get(image.draw[k] as usize)?;
        let mesh = &scene.meshes[instance.mesh];
        let triangle = image.triangle[k] as usize;
        if triangle >= mesh.triangles.len() {
            return None;
        }
        let world = |p: [f32; 3]| {
            instance
                .world
                .transform_point3(DVec3::from(p.map(f64::from)))
        };
        let [p, q, r] = mesh.corners(triangle).map(world);
        let [b1, b2] = image.barycentric[k].map(f64::from);
        let point = p + (q - p) * b1 + (r - p) * b2;
        let to_eye = if perspective { eye - point } else { back };
        let outward = (q - p).cross(r - p) * instance.world.determinant().signum();
        if outward.dot(to_eye) <= 0.0 {
            return None;
        }
        let clip: DVec4 = to_clip * point.extend(1.0);
        let x = (clip.x / clip.w + 1.0) * half[0] - (k % width) as f64 - 0.5;
        let y = (clip.y / clip.w + 1.0) * half[1] - (k / width) as f64 - 0.5;
        Some(x.hypot(y) as f32)
    };
    (0..image.draw.len()).into_par_iter().map(at).collect()
}

/// What [`displaced`] found in a picture, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Displacements {
    /// Pixels that have a displacement.
    pub pixels: usize,
    /// The mean.
    pub mean: f64,
    /// 99 % of them are at most this.
    pub p99: f32,
    /// The largest.
    pub max: f32,
}

impl Displacements {
    /// Of the pixels of a picture; all zero where none has one.
    pub fn of(off: &[Option<f32>]) -> Self {
        let mut known: Vec<f32> = off.iter().flatten().copied().collect();
        known.sort_unstable_by(f32::total_cmp);
        let Some(&max) = known.last() else {
            return Displacements::default();
        };
        let sum: f64 = known.iter().map(|&d| f64::from(d)).sum();
        Displacements {
            pixels: known.len(),
            mean: sum / known.len() as f64,
            p99: known[known.len() * 99 / 100],
            max,
        }
    }
}
