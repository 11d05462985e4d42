//! Where on the simple surface rays went wrong: the paper's figure 6.
//!
//! Distances are added up in integers, so that the sums do not depend on which core came first.

use crate::recover::place;
use std::sync::atomic::{AtomicU64, Ordering};

/// Steps of a diagonal that distances are counted in: fine enough for one ray, and 2^24 rays of a whole diagonal fit.
const STEPS: f64 = (1u64 << 40) as f64;

/// Mean distances of the rays that met each texel of a mesh's texture, row after row from v = 0, in percent of the reference's
/// diagonal; none where no ray did.
#[derive(Clone, Debug, PartialEq)]
pub struct Heat {
    /// Texels along each side.
    pub size: u32,
    /// In object space.
    pub object_space: Vec<Option<f32>>,
    /// In image space.
    pub image_space: Vec<Option<f32>>,
}

/// Sums on their way.
pub(super) struct Gathering {
    size: u32,
    diagonal: f64,
    /// Of each mesh and texel: sum and count in image space, sum and count in object space.
    meshes: Vec<Vec<[AtomicU64; 4]>>,
}

impl Gathering {
    pub(super) fn new(meshes: usize, size: u32, diagonal: f64) -> Gathering {
        let texels = size as usize * size as usize;
        let empty = || (0..texels).map(|_| Default::default()).collect();
        Gathering {
            size,
            diagonal,
            meshes: (0..meshes).map(|_| empty()).collect(),
        }
    }

    pub(super) fn add(&self, mesh: usize, uv: [f32; 2], image: f64, object: Option<f64>) {
        if self.size == 0 {
            return;
        }
        let texel = &self.meshes[mesh][place(self.size, uv)];
        let put = |slot: usize, distance: f64| {
            let steps = (distance / self.diagonal * STEPS).min(STEPS) as u64;
            texel[slot].fetch_add(steps, Ordering::Relaxed);
            texel[slot + 1].fetch_add(1, Ordering::Relaxed);
        };
        put(0, image);
        if let Some(object) = object {
            put(2, object);
        }
    }

    pub(super) fn finish(self) -> Vec<Heat> {
        let size = self.size;
        let mean = |texel: &[AtomicU64; 4], slot: usize| {
            let [sum, count] = [slot, slot + 1].map(|k| texel[k].load(Ordering::Relaxed));
            (count > 0).then(|| (sum as f64 / STEPS / count as f64 * 100.0) as f32)
        };
        let heat = |texels: Vec<[AtomicU64; 4]>| Heat {
            size,
            image_space: texels.iter().map(|t| mean(t, 0)).collect(),
            object_space: texels.iter().map(|t| mean(t, 2)).collect(),
        };
        let meshes = self.meshes.into_iter().filter(|_| size > 0);
        meshes.map(heat).collect()
    }
}
