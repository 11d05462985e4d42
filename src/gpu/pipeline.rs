//! Pipelines. In: a generated `Shader` type, specialization constants, graphics state. Out: [`Pipeline`], made once per
//! context and kept there. Layouts come from reflection; set 0 only.

use super::context::Context;
use super::failure;
use super::interface::{ComputeShader, GraphicsShader, ShaderInterface, Slot, Stage};
use crate::{Error, Result};
use ash::vk;
use std::collections::HashMap;
use std::marker::PhantomData;
use std::sync::{Arc, Mutex, PoisonError};

/// A compute or graphics pipeline of the shader `S`.
pub struct Pipeline<S> {
    pub(super) context: Context,
    pub(super) raw: Arc<RawPipeline>,
    shader: PhantomData<fn() -> S>,
}

/// The handles of a pipeline; destroyed with the context.
pub(super) struct RawPipeline {
    pub(super) pipeline: vk::Pipeline,
    pub(super) layout: vk::PipelineLayout,
    pub(super) set_layout: vk::DescriptorSetLayout,
    pub(super) push_stages: vk::ShaderStageFlags,
    pub(super) bind_point: vk::PipelineBindPoint,
}

/// State of a graphics pipeline. Vertices are pulled from storage buffers by `gl_VertexIndex`; there are no vertex
/// buffers and no blending.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GraphicsOptions<'a> {
    /// Formats of the colour images, in the order of the fragment shader's outputs.
    pub color_formats: &'a [vk::Format],
    /// Format of the depth image, if there is one.
    pub depth: Option<vk::Format>,
    /// What the vertices form.
    pub topology: vk::PrimitiveTopology,
    /// Which side is not drawn; counter-clockwise in framebuffer coordinates is the front.
    pub cull: vk::CullModeFlags,
    /// Whether fragments behind the depth image (`LESS_OR_EQUAL` passes) are dropped, and the others written to it.
    pub depth_test: bool,
}

/// What makes a pipeline another one.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    shader: &'static str,
    constants: Vec<(u32, u32)>,
    graphics: Option<(
        Vec<vk::Format>,
        Option<vk::Format>,
        vk::PrimitiveTopology,
        vk::CullModeFlags,
        bool,
    )>,
}

/// The pipelines of a context and the driver's cache behind them.
pub(super) struct PipelineStore {
    cache: vk::PipelineCache,
    made: Mutex<HashMap<Key, Arc<RawPipeline>>>,
}

impl Context {
    /// The compute pipeline of `S`.
    pub fn compute<S: ComputeShader>(&self) -> Result<Pipeline<S>> {
        self.compute_with(&[])
    }

    /// The compute pipeline of `S` with specialization constants `(id, value)`; the ids are constants of the generated
    /// module, the value's bits are those of the constant's type.
    pub fn compute_with<S: ComputeShader>(&self, constants: &[(u32, u32)]) -> Result<Pipeline<S>> {
        let invocations = S::WORKGROUP.iter().product::<u32>();
        let have = self.info().limits.workgroup_invocations;
        if invocations > have {
            let what = format!("invocations in a workgroup of {}", S::NAME);
            return Err(Error::Capacity {
                what,
                need: invocations.into(),
                have: have.into(),
            });
        }
        let key = Key {
            shader: S::NAME,
            constants: constants.to_vec(),
            graphics: None,
        };
        self.pipeline::<S>(key, |cache, layout, stages| {
            let info = vk::ComputePipelineCreateInfo::default()
                .stage(stages[0])
                .layout(layout);
            // SAFETY: stage and layout are alive and were made for each other by reflection.
            unsafe { self.0.device.create_compute_pipelines(cache, &[info], None) }
                .map_err(|(_, code)| code)
        })
    }

    /// The graphics pipeline of `S` for these attachments and this state. Viewport and scissor are the whole target.
    pub fn graphics<S: GraphicsShader>(
        &self,
        options: &GraphicsOptions<'_>,
    ) -> Result<Pipeline<S>> {
        let o = options;
        let state = (
            o.color_formats.to_vec(),
            o.depth,
            o.topology,
            o.cull,
            o.depth_test,
        );
        let key = Key {
            shader: S::NAME,
            constants: Vec::new(),
            graphics: Some(state),
        };
        self.pipeline::<S>(key, |cache, layout, stages| {
            self.0.create_graphics(cache, layout, stages, options)
        })
    }

    fn pipeline<S: ShaderInterface>(
        &self,
        key: Key,
        create: impl FnOnce(
            vk::PipelineCache,
            vk::PipelineLayout,
            &[vk::PipelineShaderStageCreateInfo<'_>],
        ) -> Result<Vec<vk::Pipeline>, vk::Result>,
    ) -> Result<Pipeline<S>> {
        let store = &self.0.pipelines;
        let mut made = store.made.lock().unwrap_or_else(PoisonError::into_inner);
        let raw = match made.get(&key) {
            Some(raw) => raw.clone(),
            None => {
                let raw = Arc::new(build::<S>(self, &key.constants, |layout, stages| {
                    create(store.cache, layout, stages)
                })?);
                self.0.labels.name(raw.pipeline, S::NAME);
                made.insert(key, raw.clone());
                raw
            }
        };
        Ok(Pipeline {
            context: self.clone(),
            raw,
            shader: PhantomData,
        })
    }
}

/// Makes layouts, modules and the pipeline; gives back what was made when a step fails.
fn build<S: ShaderInterface>(
    context: &Context,
    constants: &[(u32, u32)],
    create: impl FnOnce(
        vk::PipelineLayout,
        &[vk::PipelineShaderStageCreateInfo<'_>],
    ) -> Result<Vec<vk::Pipeline>, vk::Result>,
) -> Result<RawPipeline> {
    let device = &context.0.device;
    let mut raw = RawPipeline {
        pipeline: vk::Pipeline::null(),
        layout: vk::PipelineLayout::null(),
        set_layout: vk::DescriptorSetLayout::null(),
        push_stages: S::PUSH_STAGES,
        bind_point: match S::STAGES {
            [
                Stage {
                    flags: vk::ShaderStageFlags::COMPUTE,
                    ..
                },
            ] => vk::PipelineBindPoint::COMPUTE,
            _ => vk::PipelineBindPoint::GRAPHICS,
        },
    };
    let mut modules = Vec::new();
    let result = fill::<S>(device, constants, create, &mut raw, &mut modules);
    // SAFETY: modules are not needed once the pipeline is made; on failure nothing refers to the layouts either.
    unsafe {
        for module in modules {
            device.destroy_shader_module(module, None);
        }
        if result.is_err() {
            raw.destroy(device);
        }
    }
    result.map(|()| raw)
}

fn fill<S: ShaderInterface>(
    device: &ash::Device,
    constants: &[(u32, u32)],
    create: impl FnOnce(
        vk::PipelineLayout,
        &[vk::PipelineShaderStageCreateInfo<'_>],
    ) -> Result<Vec<vk::Pipeline>, vk::Result>,
    raw: &mut RawPipeline,
    modules: &mut Vec<vk::ShaderModule>,
) -> Result<()> {
    raw.set_layout = set_layout(device, S::SLOTS)?;
    raw.layout = pipeline_layout(
        device,
        raw.set_layout,
        S::PUSH_STAGES,
        size_of::<S::Push>() as u32,
    )?;
    for stage in S::STAGES {
        modules.push(shader_module(device, stage)?);
    }
    let values: Vec<u8> = constants
        .iter()
        .flat_map(|(_, value)| value.to_ne_bytes())
        .collect();
    let entries: Vec<vk::SpecializationMapEntry> = constants
        .iter()
        .enumerate()
        .map(|(at, (id, _))| vk::SpecializationMapEntry {
            constant_id: *id,
            offset: 4 * at as u32,
            size: 4,
        })
        .collect();
    let specialization = vk::SpecializationInfo::default()
        .map_entries(&entries)
        .data(&values);
    let stages: Vec<vk::PipelineShaderStageCreateInfo<'_>> = S::STAGES
        .iter()
        .zip(modules.iter())
        .map(|(stage, module)| {
            vk::PipelineShaderStageCreateInfo::default()
                .stage(stage.flags)
                .module(*module)
                .name(c"main")
                .specialization_info(&specialization)
        })
        .collect();
    let pipelines = create(raw.layout, &stages).map_err(failure::of("vkCreatePipelines"))?;
    raw.pipeline = pipelines[0];
    Ok(())
}

/// The layout of set 0.
fn set_layout(device: &ash::Device, slots: &[Slot]) -> Result<vk::DescriptorSetLayout> {
    let bindings: Vec<vk::DescriptorSetLayoutBinding<'_>> = slots
        .iter()
        .map(|slot| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(slot.binding)
                .descriptor_type(slot.kind.descriptor_type())
                .descriptor_count(1)
                .stage_flags(slot.stages)
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: the bindings are distinct (build.rs checks) and outlive the call.
    unsafe { device.create_descriptor_set_layout(&info, None) }
        .map_err(failure::of("vkCreateDescriptorSetLayout"))
}

fn pipeline_layout(
    device: &ash::Device,
    set_layout: vk::DescriptorSetLayout,
    push_stages: vk::ShaderStageFlags,
    push_bytes: u32,
) -> Result<vk::PipelineLayout> {
    let sets = [set_layout];
    let ranges = [vk::PushConstantRange {
        stage_flags: push_stages,
        offset: 0,
        size: push_bytes,
    }];
    let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
    if !push_stages.is_empty() {
        info = info.push_constant_ranges(&ranges);
    }
    // SAFETY: the set layout is alive; the block is within 128 bytes (build.rs checks).
    unsafe { device.create_pipeline_layout(&info, None) }
        .map_err(failure::of("vkCreatePipelineLayout"))
}

/// The words of a stage as a module.
fn shader_module(device: &ash::Device, stage: &Stage) -> Result<vk::ShaderModule> {
    let words: Vec<u32> = stage
        .spirv
        .chunks_exact(4)
        .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
        .collect();
    let info = vk::ShaderModuleCreateInfo::default().code(&words);
    // SAFETY: the SPIR-V came from shaderc and was checked against its hash at build time.
    unsafe { device.create_shader_module(&info, None) }.map_err(failure::of("vkCreateShaderModule"))
}

impl RawPipeline {
    /// # Safety
    /// The device no longer uses the pipeline, and nobody will.
    unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: the caller's promise; null handles are ignored.
        unsafe {
            device.destroy_pipeline(self.pipeline, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

impl PipelineStore {
    pub(super) fn new(device: &ash::Device) -> Result<Self> {
        // SAFETY: an empty cache.
        let cache =
            unsafe { device.create_pipeline_cache(&vk::PipelineCacheCreateInfo::default(), None) }
                .map_err(failure::of("vkCreatePipelineCache"))?;
        Ok(PipelineStore {
            cache,
            made: Mutex::default(),
        })
    }

    /// # Safety
    /// The device no longer uses any of the pipelines, and nobody will.
    pub(super) unsafe fn destroy(&self, device: &ash::Device) {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        for (_, raw) in made.drain() {
            // SAFETY: the caller's promise.
            unsafe { raw.destroy(device) };
        }
        // SAFETY: as above.
        unsafe { device.destroy_pipeline_cache(self.cache, None) };
    }
}
