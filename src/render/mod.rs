//! Pictures of a mesh, by correspondence and attribute.
//!
//! In: a [`Picture`] (geometries, draws, attributes) and a [`Camera`]. Out: [`Rendered`]: colours and AOVs. The deferred
//! path has three passes, each a Rust file beside the shader of the same name, with the same bits on every processor:
//!
//! ```text
//! project  vertices -> snapped pixels          project.rs   glsl/render/project.comp
//! raster   triangles -> id of each pixel       raster.rs    glsl/render/raster.vert .frag    (coverage: cover.rs)
//! shade    id -> correspondence -> attributes -> colour     shade.rs  glsl/render/shade.comp
//! ```

pub(crate) mod beforehand;
mod camera;
mod camera_file;
mod constants;
mod correspond;
mod cover;
mod cut;
mod deform;
#[cfg(feature = "gpu")]
mod device;
mod draw;
mod filter;
#[cfg(feature = "gpu")]
mod forward;
mod frame;
mod function;
#[cfg(feature = "gpu")]
mod known;
mod levels;
mod light;
mod picture;
mod plain;
mod project;
mod raster;
mod renderer;
mod resolve;
mod shade;
mod stage;
mod switching;
mod timed;

pub use camera::{Camera, MAX_SIDE, Projection};
pub use camera_file::{View, parse_views};
pub use constants::legend;
pub(crate) use constants::{THRESHOLDS_AT, constants};
pub(crate) use correspond::inverse_at;
pub use cut::{Cuts, Cutter};
pub use draw::Light;
pub use filter::Filter;
pub use levels::{
    in_chain, keep_only, level_near, levels, reference_sphere, subjects, subjects_prefiltered,
    triangles,
};
pub use picture::{Geometry, Picture};
pub use renderer::{Options, Output, Rendered, Renderer};
pub(crate) use shade::Drawn;
pub(crate) use stage::level_zero;
pub use stage::{Correspond, Subject, stage, stage_posed, stage_with};
pub use switching::{Step, Switching, blended};
pub(crate) use timed::Taking;
pub use timed::{Clock, FrameBudget, FrameTime, TimedFrames};
