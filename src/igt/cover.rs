//! Which hash texels a triangle touches: conservative, exact, in integers.
//!
//! In: a triangle on the vertex grid. Out: boxes of texels ([`boxes`]), cut into tiles of at most [`TILE`] texels, and of
//! each tile the texels in which the triangle may own a query point ([`Toucher::touched`]). A texel is missed only where a
//! plane separates the closed triangle from the closed texel, so every owner of every query point is in the list of that
//! point's texel. Twins: `glsl/common/igt_boxes.glsl`, `igt_touches.glsl`.
//!
//! Source: Inverse Geometric Textures, section 2.1 ("conservative, even if the triangle slightly touches the texel").

mod boxes;
mod touches;

pub use boxes::{MAX_BOXES, SEVERAL_OCTANTS, TILE, TexelBox, boxes};
pub use touches::Toucher;
