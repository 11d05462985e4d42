//! Detail recovery: attributes of a reference resampled into textures of a simplified surface, offline.
//!
//! In: a built model, what is wanted of it and over which surface. Out: [`Baked`]: a texture for each attribute, and how
//! much of it could be filled. The correspondence so far is [`Mapping::UvMatch`], the inverse geometric texture itself.
//!
//! ```text
//! LoD -> atlas -> texel.rs: triangle and barycentrics of a sample -\
//! primary -> address.rs: T3 point of a sample -----------------------> lookup -> attribute/ -> mean -> fill.rs: gutter
//! ```

mod address;
mod atlas;
mod bake;
mod conventional;
mod fill;
mod low;
mod source;
mod surface;
mod texel;

pub use bake::{BakeSettings, Baked, BakedTexture, Baker, Mapping, Over};
pub use conventional::stage_baked;
pub use source::BakeAttribute;
