//! Detail recovery: attributes of a reference resampled into textures of a simplified surface, offline.
//!
//! In: a built model, what is wanted of it and over which surface ([`Baker`]); or two models that share nothing but space
//! ([`Pair`]). Out: [`Baked`]: a texture for each attribute, and how much of it could be filled. Which point of the reference
//! a texel stands for is a [`Mapping`].
//!
//! ```text
//! built   LoD -> atlas -> texel.rs -> lookup ---------------------\
//!         primary -> address.rs: T3 point -> lookup ----------------> resample.rs: attribute/ -> mean -> fill.rs: gutter
//! pair    low -> laid.rs: uv, world -> texel.rs -> find.rs: point --/     around.rs: sky, thickness, light -^
//!          udim.rs: tiles, cage.rs -^        ^- probe.rs -> visible.rs: directions
//! ```
//!
//! The mappings of a pair are those of Tarini, Cignoni and Scopigno, *Visibility Based Methods and Assessment for
//! Detail-Recovery* (IEEE Visualization 2003); `find.rs` has the rays, `visible.rs` the directions, `continuity.rs` the
//! neighbours of texels across seams that the paper leaves open, `beyond.rs` those across the borders of tiles.

mod address;
mod around;
mod atlas;
mod bake;
mod beyond;
mod cage;
mod choose;
mod coding;
mod continuity;
mod conventional;
mod fill;
mod find;
mod high;
mod laid;
mod low;
mod many;
mod mapping;
mod over_low;
mod pair;
mod partner;
mod prefilter;
mod prefilter_apart;
mod prefilter_scope;
mod probe;
mod resample;
mod source;
mod standing;
mod surface;
mod texel;
mod udim;
mod visible;
mod wanted;

pub(crate) use continuity::{Links, centres};
pub(crate) use find::{Finder, Search};
pub(crate) use high::High;
pub(crate) use laid::Laid;
pub(crate) use pair::{cage_is_asked_for, lay, meet, reach};
pub(crate) use probe::spread;
pub(crate) use texel::place;
pub(crate) use visible::{Field, Fields};

pub use around::AroundOptions;
pub use bake::{BakeSettings, Baked, BakedTexture, Baker, Over};
pub use conventional::stage_baked;
pub use laid::UvLayout;
pub use many::{Answer, Ask, Question, Triangles};
pub use mapping::{Mapping, Misses, Probes, Recovery};
pub use pair::{Pair, PairSettings};
pub use partner::{Role, role};
pub use prefilter::prefilter;
pub use probe::Draw;
pub use wanted::BakeAttribute;
