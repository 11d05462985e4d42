//! What can be fetched at a point of the reference: colour, normal, artist textures, material.
//!
//! In: reference meshes, materials, decoded images. Out: an [`AttributeSet`], plain words that the CPU
//! ([`surface`](self)) and the shaders (`glsl/common/surface.glsl`) read alike, and evaluate to the same bits.

pub(crate) mod arithmetic;
mod from_scene;
mod material;
mod mips;
pub(crate) mod sample;
pub(crate) mod surface;
pub(crate) mod texture;
mod uv_record;

pub use from_scene::attributes_of;
pub use material::{Alpha, Material, Slot, SlotBinding};
pub use surface::AttributeSet;
pub use texture::{Pixels, Sampler, TextureSet, Wrap};
