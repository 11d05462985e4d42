//! What the host knows of a shader. In: nothing at run time; build.rs writes implementations of [`ShaderInterface`] into
//! [`shaders`](super::shaders) from the reflection of `spirv/`. Out: the names, slots and layouts that pipelines and
//! descriptor sets are made from. A binding number stands in GLSL and nowhere else.

use super::{Buffer, Image, Sampler};
use ash::vk;

/// One stage of a pipeline.
#[derive(Clone, Copy, Debug)]
pub struct Stage {
    /// Which one.
    pub flags: vk::ShaderStageFlags,
    /// The module, little endian; its entry point is `main`.
    pub spirv: &'static [u8],
}

/// One descriptor of set 0.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// Instance name in GLSL.
    pub name: &'static str,
    /// Binding in GLSL.
    pub binding: u32,
    /// What goes there.
    pub kind: SlotKind,
    /// The stages that use it.
    pub stages: vk::ShaderStageFlags,
}

/// The kinds of descriptors this crate's shaders use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlotKind {
    /// `buffer Block { .. } name;`
    StorageBuffer,
    /// `uniform Block { .. } name;`
    UniformBuffer,
    /// `uniform image2D name;`
    StorageImage,
    /// `uniform texture2D name;`
    SampledImage,
    /// `uniform sampler name;`
    Sampler,
    /// `uniform sampler2D name;`
    CombinedImageSampler,
}

impl SlotKind {
    /// Every kind, for sizing descriptor pools.
    pub const ALL: [SlotKind; 6] = [
        SlotKind::StorageBuffer,
        SlotKind::UniformBuffer,
        SlotKind::StorageImage,
        SlotKind::SampledImage,
        SlotKind::Sampler,
        SlotKind::CombinedImageSampler,
    ];

    /// Vulkan's name for it.
    pub const fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            SlotKind::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
            SlotKind::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
            SlotKind::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
            SlotKind::SampledImage => vk::DescriptorType::SAMPLED_IMAGE,
            SlotKind::Sampler => vk::DescriptorType::SAMPLER,
            SlotKind::CombinedImageSampler => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
        }
    }
}

/// What is put into a slot.
#[derive(Clone, Copy)]
pub enum Resource<'a> {
    /// A storage or uniform buffer, whole.
    Buffer(&'a Buffer),
    /// A storage or sampled image.
    Image(&'a Image),
    /// A sampler alone.
    Sampler(&'a Sampler),
    /// An image with its sampler.
    Sampled(&'a Image, &'a Sampler),
}

/// A pipeline's shaders and what they read; implemented by the generated `Shader` types.
pub trait ShaderInterface: 'static {
    /// `<stage>_<pass>`, as the files are named.
    const NAME: &'static str;
    /// One compute stage, or a vertex and a fragment stage.
    const STAGES: &'static [Stage];
    /// The descriptors, sorted by binding.
    const SLOTS: &'static [Slot];
    /// The stages that see the push constants; empty when there are none.
    const PUSH_STAGES: vk::ShaderStageFlags;
    /// Invocations per workgroup.
    const WORKGROUP: [u32; 3];
    /// One field per slot, named as in GLSL.
    type Bindings<'a>: Copy;
    /// The push-constant block, or `()`.
    type Push: bytemuck::Pod;
    /// The bound resources in the order of [`SLOTS`](Self::SLOTS).
    fn resources<'a>(bindings: &Self::Bindings<'a>) -> Vec<Resource<'a>>;
}

/// A pipeline of one compute stage.
pub trait ComputeShader: ShaderInterface {}

/// A pipeline of a vertex and a fragment stage.
pub trait GraphicsShader: ShaderInterface {}
