//! The only Vulkan: contexts, memory, pipelines, recording, readback, timings.
//!
//! In: GLSL that `build.rs` turned into [`shaders`]. Out: buffers, images and timings. Knows no mesh. One file per
//! Vulkan concern; a pass is one call of the [`Recorder`], a binding is a struct whose fields are named as in GLSL.

#![allow(
    unsafe_code,
    reason = "the one room that talks to a C interface; every block has its SAFETY line"
)]

mod bind;
mod buffer;
mod context;
mod debug;
mod device;
mod draw;
mod failure;
mod foreign;
mod graphics_state;
mod host;
mod image;
mod interface;
mod memory;
mod pipeline;
mod readback;
mod recorder;
mod requirements;
mod submit;
mod timing;

/// The shaders of `glsl/`, one module per pass, generated from reflection.
#[allow(clippy::all, missing_debug_implementations, reason = "generated")]
pub mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}

pub use ash::{self, vk};
pub use bind::Bound;
pub use buffer::{Buffer, BufferKind};
pub use context::{Context, ContextOptions};
pub use device::{DeviceChoice, DeviceInfo, DeviceKind, Limits};
pub use draw::{Clear, GraphicsPass};
pub use foreign::Foreign;
pub use gpu_allocator;
pub use host::devices;
pub use image::{Image, ImageOptions, Sampler, SamplerOptions};
pub use interface::{
    ComputeShader, GraphicsShader, Resource, ShaderInterface, Slot, SlotKind, Stage,
};
pub use memory::Allocated;
pub use pipeline::{GraphicsOptions, Pipeline};
pub use recorder::{InUse, Recorder};
pub use requirements::{Features, RequiredFeature, RequiredLimit, Requirements, requirements};
pub use timing::{PassTime, Timings};
