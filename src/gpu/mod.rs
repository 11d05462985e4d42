//! The only Vulkan: contexts, memory, pipelines, recording, readback, timings.
//!
//! In: GLSL that `build.rs` turned into [`shaders`]. Out: buffers, images and timings. Knows no mesh. One file per
//! Vulkan concern; a pass is one call of the [`Recorder`], a binding is a struct whose fields are named as in GLSL.
//!
//! ```no_run
//! use invertex::gpu::shaders::test_add::{Bindings, Push, Shader};
//! use invertex::gpu::{Context, ContextOptions};
//!
//! let ctx = Context::new(&ContextOptions::default())?;
//! let a = ctx.upload("a", &[1_u32, 2, 3])?;
//! let sum = ctx.storage("sum", a.bytes())?;
//! let bound = ctx.compute::<Shader>()?.bind(&Bindings { a: &a, b: &a, sum: &sum })?;
//! let mut recorder = ctx.recorder("add")?;
//! recorder.dispatch(&bound, &Push { count: 3, offset: 0 }, [1, 1, 1]);
//! let timings = ctx.run(recorder)?;
//! assert_eq!(ctx.download::<u32>(&sum)?, [2, 4, 6]);
//! println!("{} ns", timings.total);
//! # Ok::<(), invertex::Error>(())
//! ```
//!
//! # Embedding
//!
//! An engine hands over what it already has and keeps what is its own. [`requirements`] says, as data, what its device
//! must have enabled; [`Context::from_foreign`] checks the declaration and names what is missing. A context owns no
//! statics: any number of them live side by side, on one device or on several.
//!
//! * Preparing ([`Context::upload`], [`Pipeline::bind`], ...) allocates and may submit and wait.
//! * Recording ([`Recorder::foreign`]) only records into the engine's command buffer: a full barrier before each pass,
//!   and the pass. It never submits, waits or allocates on the device.
//! * Submitting is the engine's. What [`Recorder::finish`] returns keeps the resources alive until it is done.
//!
//! ```no_run
//! use invertex::gpu::shaders::test_add::{Bindings, Push, Shader};
//! use invertex::gpu::{self, Context, Foreign, Recorder, ash, vk};
//!
//! # struct Engine { instance: ash::Instance, physical_device: vk::PhysicalDevice, device: ash::Device,
//! #     queue: vk::Queue, queue_family: u32 }
//! # fn embed(engine: &Engine, commands: vk::CommandBuffer) -> invertex::Result<gpu::InUse> {
//! let foreign = Foreign {
//!     instance: engine.instance.clone(),
//!     physical_device: engine.physical_device,
//!     device: engine.device.clone(),
//!     queue: engine.queue,
//!     queue_family: engine.queue_family,
//!     api_version: vk::API_VERSION_1_3,
//!     // What the engine enabled when it made its device: at least these.
//!     features: gpu::requirements().features(),
//!     extensions: vec![],
//!     debug_utils: false,
//!     allocator: None,
//! };
//! // SAFETY: the handles belong together and outlive the context.
//! let ctx = unsafe { Context::from_foreign(foreign) }?;
//! let words = ctx.upload("words", &[1_u32, 2, 3])?;
//! let sum = ctx.storage("sum", words.bytes())?;
//! let bound = ctx.compute::<Shader>()?.bind(&Bindings { a: &words, b: &words, sum: &sum })?;
//!
//! // SAFETY: the engine is recording `commands`, outside a render pass.
//! let mut recorder = unsafe { Recorder::foreign(&ctx, commands) };
//! recorder.dispatch(&bound, &Push { count: 3, offset: 0 }, [1, 1, 1]);
//! recorder.finish()
//! # }
//! ```
//!
//! An engine with its own pipeline layouts includes `common/igt.glsl` in its own shaders instead, defines how the tables'
//! words are loaded, and takes from here only the buffers ([`Buffer::handle`]). `tests/embedding.rs` does both.

#![allow(
    unsafe_code,
    reason = "the one room that talks to a C interface; every block has its SAFETY line"
)]

mod bind;
mod buffer;
#[cfg(feature = "compile-shaders")]
mod compile;
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
#[cfg(feature = "compile-shaders")]
pub use compile::UserText;
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
pub use pipeline::{GraphicsOptions, Pipeline, Variant};
pub use recorder::{InUse, Recorder};
pub use requirements::{Features, RequiredFeature, RequiredLimit, Requirements, requirements};
pub use timing::{PassTime, Timings};
