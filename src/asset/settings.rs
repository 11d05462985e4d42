//! What a build is told: settings, where it runs, who listens.
//!
//! In: what a caller wants. Out: [`BuildSettings`], checked against a scene before any work.

use crate::igt::{BuildOptions, Layout};
use crate::lod::Simplifier;
use crate::lod::progressive::colour::Distance;
use crate::param::PrimaryRequest;
use crate::scene::Scene;
use crate::{Error, Result};

/// What a build needs to know besides the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildSettings {
    /// The primary parameterization of meshes that `primary_of` does not name.
    pub primary: PrimaryRequest,
    /// Primary parameterizations by the name of the mesh.
    pub primary_of: Vec<(String, PrimaryRequest)>,
    /// Texels along each side of the hash texture, a power of two; `None`: by the mesh's triangles, see [`hash_for`].
    pub hash: Option<u32>,
    /// The layout of the tables.
    pub layout: Layout,
    /// Fractions of the whole model's triangles, one for each LoD.
    pub lods: Vec<f32>,
    /// What makes them.
    pub simplifier: Simplifier,
    /// What meshes that nothing deforms get besides, so that any view takes a cut of them.
    pub multiresolution: Multiresolution,
}

/// Whether a mesh gets a multiresolution model, and what it knows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Multiresolution {
    /// It gets none.
    #[default]
    None,
    /// It knows how far details are displaced.
    Geometry,
    /// It knows that, and what colours are off by.
    Colours(Distance),
}

impl Default for BuildSettings {
    fn default() -> Self {
        BuildSettings {
            primary: PrimaryRequest::Auto,
            primary_of: Vec::new(),
            hash: None,
            layout: Layout::Packed,
            lods: vec![0.5, 0.2, 0.1, 0.05],
            simplifier: Simplifier::default(),
            multiresolution: Multiresolution::None,
        }
    }
}

/// Where tables are built. The bytes are the same.
#[derive(Clone, Copy, Default)]
pub enum Processor<'a> {
    /// On all cores.
    #[default]
    Cpu,
    /// On a Vulkan device.
    #[cfg(feature = "gpu")]
    Device(&'a crate::gpu::Context),
    /// On a Vulkan device; meshes that it has no room for on all cores.
    #[cfg(feature = "gpu")]
    Preferably(&'a crate::gpu::Context),
    /// Never made; keeps the lifetime where there are no devices.
    #[cfg(not(feature = "gpu"))]
    #[doc(hidden)]
    Absent(&'a std::convert::Infallible),
}

/// Hears how a build goes. `()` hears nothing.
pub trait Progress {
    /// `stage` is at work on `subject` (a mesh, or nothing in particular); `done` of `of` steps of the build are over.
    fn at(&self, stage: &'static str, subject: &str, done: usize, of: usize) {
        let _ = (stage, subject, done, of);
    }

    /// Asked between steps: whether to stop, which ends the build with [`Error::Cancelled`].
    fn cancelled(&self) -> bool {
        false
    }
}

impl Progress for () {}

/// The hash resolution for a mesh of `triangles` triangles: about half a triangle a texel, where lists hold some three.
pub fn hash_for(triangles: usize) -> u32 {
    let side = (triangles as f64 * 2.0).sqrt() as u32;
    // The nearest power of two in ratio: past sqrt(2) of one, the next is nearer.
    let below = 1u32 << side.max(1).ilog2();
    let nearest = if f64::from(side) > f64::from(below) * std::f64::consts::SQRT_2 {
        below * 2
    } else {
        below
    };
    nearest.clamp(32, 4096)
}

/// Refuses what cannot be built, before any work.
pub(super) fn check(scene: &Scene, settings: &BuildSettings) -> Result<()> {
    if scene.meshes.iter().all(|mesh| mesh.triangles.is_empty()) {
        return Err(Error::input(
            &scene.name,
            "meshes",
            "have no triangles: there is nothing to build",
        ));
    }
    if let Some(hash) = settings.hash {
        BuildOptions {
            hash,
            layout: settings.layout,
        }
        .bits()?;
    }
    if settings.lods.is_empty() || settings.lods.len() > 32 {
        let reason = format!("{} levels; 1 to 32 are possible", settings.lods.len());
        return Err(Error::Option {
            option: "--lods",
            reason,
        });
    }
    for (name, _) in &settings.primary_of {
        if !scene.meshes.iter().any(|mesh| mesh.name == *name) {
            let names: Vec<&str> = scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
            let reason = format!(
                "there is no mesh \"{name}\"; there are: {}",
                names.join(", ")
            );
            return Err(Error::Option {
                option: "--primary",
                reason,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_has_about_two_texels_a_triangle() {
        assert_eq!(hash_for(8192), 128);
        assert_eq!(hash_for(1), 32);
        assert_eq!(hash_for(1 << 19), 1024);
        assert_eq!(hash_for(100_000_000), 4096);
        for triangles in [3000, 7000, 94_722, 327_680] {
            let ratio = f64::from(hash_for(triangles)).powi(2) / triangles as f64;
            assert!((1.0..=4.1).contains(&ratio), "{triangles}: {ratio}");
        }
    }
}
