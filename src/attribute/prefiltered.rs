//! Appearance filtered beforehand over a primary parameterization: what the shader LoD shows in place of a lookup.
//!
//! In: four images of all levels over the unit square of addresses. Out: [`Prefiltered`], and its textures in a
//! [`TextureSet`].
//!
//! Level l has (size >> l)² texels, down to one. A texel is the mean of what the full lookup answers in a window
//! two texels wide. The fourth channel of two of the images says how far the two are apart there, in eighths of a step of 8 bits: a shader that has the texel knows whether it will do.
//! Source: Inverse Geometric Textures, section 2.5 (mipmapping); the design's *shader LoD*.

use super::texture::{Pixels, Sampler, TextureSet, Wrap};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// What the images hold, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub(crate) enum Role {
    /// Base colour, sRGB; in the fourth channel the distance of base colours.
    Base = 0,
    /// Two-level normal, object space, from -1..1; in the fourth channel the largest distance of all there is.
    Normal = 1,
    /// Occlusion, roughness, metalness.
    Matter = 2,
    /// Emission, sRGB.
    Emissive = 3,
}

impl Role {
    pub(crate) const ALL: [Role; 4] = [Role::Base, Role::Normal, Role::Matter, Role::Emissive];

    /// Whether its first three channels are sRGB.
    pub(crate) fn is_srgb(self) -> bool {
        matches!(self, Role::Base | Role::Emissive)
    }
}

/// Codes of the fourth channel that make one step of 8 bits.
pub(crate) const CODES_A_STEP: f32 = 8.0;

/// What the images hold for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scope {
    /// Whether light does not change the base colour.
    pub unlit: bool,
    /// The layer of parts that is seen; other layers are looked up.
    pub layer: u8,
    /// The side of the surface that projection lines meet it from, 1 or -1; 0: either, there being one only.
    pub side: i8,
}

/// Appearance over a primary parameterization, all levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Prefiltered {
    size: u32,
    scope: Scope,
    images: [Vec<u8>; 4],
}

impl Prefiltered {
    /// The smallest and the largest first level's side.
    pub const SIZES: std::ops::RangeInclusive<u32> = 32..=4096;

    /// From RGBA images of 8 bits, each all levels after each other.
    ///
    /// # Errors
    /// [`Error::Input`] where the size is not a power of two in [`Prefiltered::SIZES`] or an image has another length.
    pub fn new(size: u32, scope: Scope, images: [Vec<u8>; 4]) -> Result<Self> {
        let fault = |reason: String| Err(Error::input("prefiltered appearance", "images", reason));
        if let Err(reason) = Self::check(size, scope) {
            return fault(reason);
        }
        let bytes = 4 * texels(size);
        match images.iter().find(|image| image.len() != bytes) {
            Some(image) => fault(format!("{} bytes, not {bytes}", image.len())),
            None => Ok(Prefiltered {
                size,
                scope,
                images,
            }),
        }
    }

    /// The reason why nothing can be of this size and scope.
    pub(crate) fn check(size: u32, scope: Scope) -> std::result::Result<(), String> {
        if !size.is_power_of_two() || !Self::SIZES.contains(&size) {
            return Err(format!("size {size} is not a power of two from 32 to 4096"));
        }
        match (-1..=1).contains(&scope.side) {
            true => Ok(()),
            false => Err(format!("side {} is not -1, 0 or 1", scope.side)),
        }
    }

    /// Texels along each side of the first level.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// What it holds for.
    pub fn scope(&self) -> Scope {
        self.scope
    }

    /// Base colour and distance, normal and distance, occlusion with roughness and metalness, emission; all levels.
    pub fn images(&self) -> &[Vec<u8>; 4] {
        &self.images
    }
}

/// Texels of all levels.
pub(crate) fn texels(size: u32) -> usize {
    levels(size).map(|(_, side)| side * side).sum()
}

/// Where each level begins, in texels, and its side.
pub(crate) fn levels(size: u32) -> impl Iterator<Item = (usize, usize)> {
    let mut at = 0;
    (0..=size.ilog2()).map(move |level| {
        let side = (size >> level) as usize;
        let begin = at;
        at += side * side;
        (begin, side)
    })
}

impl TextureSet {
    /// The ids of the four textures of `prefiltered` are this one and the next three. `key` tells it from other images of
    /// the set; the first axis of a primary that goes round repeats.
    pub(crate) fn add_prefiltered(
        &mut self,
        key: usize,
        prefiltered: &Prefiltered,
        goes_round: bool,
    ) -> Result<u32> {
        let sampler = Sampler {
            wrap_u: if goes_round {
                Wrap::Repeat
            } else {
                Wrap::Clamp
            },
            wrap_v: Wrap::Clamp,
            ..Sampler::default()
        };
        let mut first = None;
        for (role, rgba) in Role::ALL.into_iter().zip(prefiltered.images()) {
            let pixels = || {
                Ok(Pixels {
                    width: prefiltered.size,
                    height: prefiltered.size,
                    rgba,
                })
            };
            let id = self.add_levels(key + role as usize, role.is_srgb(), sampler, pixels)?;
            first.get_or_insert(id);
        }
        Ok(first.unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blank(size: u32) -> [Vec<u8>; 4] {
        std::array::from_fn(|_| vec![0; 4 * texels(size)])
    }

    #[test]
    fn levels_lie_after_each_other() {
        let all: Vec<_> = levels(32).collect();
        assert_eq!(all[..3], [(0, 32), (1024, 16), (1280, 8)]);
        assert_eq!(all.last(), Some(&(texels(32) - 1, 1)));
    }

    #[test]
    fn other_sizes_are_errors() {
        assert!(Prefiltered::new(32, Scope::default(), blank(32)).is_ok());
        for size in [0, 16, 33, 8192] {
            assert!(
                Prefiltered::new(size, Scope::default(), blank(32)).is_err(),
                "{size}"
            );
        }
        assert!(Prefiltered::new(64, Scope::default(), blank(32)).is_err());
    }
}
