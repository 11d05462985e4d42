//! What can be fetched at a point of the reference: colour, normal, artist textures, material; or, in place of its base
//! colour, any [`Attribute`] by name.
//!
//! In: reference meshes, materials, decoded images. Out: an [`AttributeSet`], plain words that the CPU
//! ([`surface`](self)) and the shaders (`glsl/common/surface.glsl`) read alike, and evaluate to the same bits.

pub(crate) mod arithmetic;
mod columns;
mod from_scene;
pub(crate) mod hemisphere;
mod material;
mod mips;
mod named;
mod occlusion;
pub(crate) mod prefiltered;
mod procedural;
pub(crate) mod sample;
mod show;
mod shown;
mod solid;
pub(crate) mod surface;
pub(crate) mod texture;
mod uv_record;
mod volume;

pub use from_scene::{attributes_of, attributes_showing};
pub use material::{Alpha, Material, Slot, SlotBinding};
pub(crate) use mips::append_chain;
pub use named::{Attribute, Factor, MOST_FACTORS, VertexAttribute};
pub use occlusion::OcclusionOptions;
pub use prefiltered::{Prefiltered, Scope};
pub use procedural::Procedural;
pub use shown::{Shown, ShownOptions};
pub use solid::Solid;
pub use surface::AttributeSet;
pub use texture::{Pixels, Sampler, TextureSet, Wrap};
pub use volume::Volume;
