//! Invertex: inverse geometric textures.

pub mod asset;
pub mod attribute;
pub mod error;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod igt;
pub mod lod;
pub mod measure;
pub mod mesh;
pub mod output;
pub mod param;
pub mod render;
pub mod scene;

pub use error::{Error, Result};
