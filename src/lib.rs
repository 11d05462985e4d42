//! Invertex: inverse geometric textures.

pub mod error;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod mesh;
pub mod scene;
pub mod param;
pub mod lod;
pub mod igt;
pub mod attribute;
pub mod asset;
pub mod render;
pub mod measure;
pub mod output;

pub use error::{Error, Result};
