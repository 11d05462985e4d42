//! Pipelines. In: a generated `Shader` type, specialization constants, graphics state. Out: [`Pipeline`], made once per
//! context and kept there. Layouts come from reflection; set 0 only.

use super::context::{Context, Inner};
use super::failure;
use super::interface::{ComputeShader, GraphicsShader, ShaderInterface, Slot};
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

/// What makes a pipeline of a shader another one than the shader says.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Variant {
    /// Specialization constants, id and value; the ids are constants of the generated module, the value's bits are those of
    /// the constant's type. A stage without a constant is not concerned.
    pub constants: Vec<(u32, u32)>,
    /// Other SPIR-V for one of the stages, with no binding that the shader does not have.
    pub code: Option<(vk::ShaderStageFlags, Vec<u8>)>,
}

/// What makes a pipeline another one.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    shader: &'static str,
    variant: Variant,
    /// The colour formats, and the rest of the state.
    graphics: Option<(Vec<vk::Format>, GraphicsOptions<'static>)>,
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
        self.compute_variant(&Variant {
            constants: constants.to_vec(),
            code: None,
        })
    }

    /// The compute pipeline of a variant of `S`.
    ///
    /// # Errors
    /// [`Error::Input`] for code with a binding that `S` does not have; those of the device.
    pub fn compute_variant<S: ComputeShader>(&self, variant: &Variant) -> Result<Pipeline<S>> {
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
            variant: variant.clone(),
            graphics: None,
        };
        self.pipeline::<S>(key, None)
    }

    /// The graphics pipeline of `S` for these attachments and this state. Viewport and scissor are the whole target.
    pub fn graphics<S: GraphicsShader>(
        &self,
        options: &GraphicsOptions<'_>,
    ) -> Result<Pipeline<S>> {
        self.graphics_variant(options, &Variant::default())
    }

    /// The graphics pipeline of a variant of `S`.
    ///
    /// # Errors
    /// As [`Context::compute_variant`].
    pub fn graphics_variant<S: GraphicsShader>(
        &self,
        options: &GraphicsOptions<'_>,
        variant: &Variant,
    ) -> Result<Pipeline<S>> {
        let state = GraphicsOptions {
            color_formats: &[],
            ..*options
        };
        let key = Key {
            shader: S::NAME,
            variant: variant.clone(),
            graphics: Some((options.color_formats.to_vec(), state)),
        };
        self.pipeline::<S>(key, Some(options))
    }

    fn pipeline<S: ShaderInterface>(
        &self,
        key: Key,
        graphics: Option<&GraphicsOptions<'_>>,
    ) -> Result<Pipeline<S>> {
        check_code::<S>(&key.variant)?;
        let store = &self.0.pipelines;
        let mut made = store.made.lock().unwrap_or_else(PoisonError::into_inner);
        let raw = match made.get(&key) {
            Some(raw) => raw.clone(),
            None => {
                let raw = Arc::new(self.0.create_pipeline::<S>(&key.variant, graphics)?);
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

impl Inner {
    /// Makes layouts, modules and the pipeline; gives back what was made when a step fails.
    fn create_pipeline<S: ShaderInterface>(
        &self,
        variant: &Variant,
        graphics: Option<&GraphicsOptions<'_>>,
    ) -> Result<RawPipeline> {
        let mut raw = RawPipeline {
            pipeline: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            push_stages: S::PUSH_STAGES,
            bind_point: match graphics {
                None => vk::PipelineBindPoint::COMPUTE,
                Some(_) => vk::PipelineBindPoint::GRAPHICS,
            },
        };
        let mut modules = Vec::new();
        let result = self.fill::<S>(variant, graphics, &mut raw, &mut modules);
        // SAFETY: modules are not needed once the pipeline is made; on failure nothing refers to the layouts either.
        unsafe {
            for module in modules {
                self.device.destroy_shader_module(module, None);
            }
            if result.is_err() {
                raw.destroy(&self.device);
            }
        }
        result.map(|()| raw)
    }

    fn fill<S: ShaderInterface>(
        &self,
        Variant { constants, code }: &Variant,
        graphics: Option<&GraphicsOptions<'_>>,
        raw: &mut RawPipeline,
        modules: &mut Vec<vk::ShaderModule>,
    ) -> Result<()> {
        raw.set_layout = set_layout(&self.device, S::SLOTS)?;
        let push_bytes = size_of::<S::Push>() as u32;
        raw.layout = pipeline_layout(&self.device, raw.set_layout, S::PUSH_STAGES, push_bytes)?;
        for stage in S::STAGES {
            let other = code.as_ref().filter(|(flags, _)| *flags == stage.flags);
            let spirv = other.map_or(stage.spirv, |(_, spirv)| spirv);
            modules.push(shader_module(&self.device, spirv)?);
        }
        let values: Vec<u8> = constants
            .iter()
            .flat_map(|(_, value)| value.to_ne_bytes())
            .collect();
        let entries: Vec<_> = constants.iter().enumerate().map(constant_entry).collect();
        let specialization = vk::SpecializationInfo::default()
            .map_entries(&entries)
            .data(&values);
        let stages: Vec<_> = S::STAGES
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
        let cache = self.pipelines.cache;
        raw.pipeline = match graphics {
            None => self.create_compute(cache, raw.layout, stages[0]),
            Some(options) => self.create_graphics(cache, raw.layout, &stages, options),
        }?;
        Ok(())
    }

    fn create_compute(
        &self,
        cache: vk::PipelineCache,
        layout: vk::PipelineLayout,
        stage: vk::PipelineShaderStageCreateInfo<'_>,
    ) -> Result<vk::Pipeline> {
        let info = [vk::ComputePipelineCreateInfo::default()
            .stage(stage)
            .layout(layout)];
        // SAFETY: stage and layout are alive and were made for each other by reflection.
        let made = unsafe { self.device.create_compute_pipelines(cache, &info, None) };
        made.map(|pipelines| pipelines[0])
            .map_err(|(_, code)| failure::of("vkCreateComputePipelines")(code))
    }
}

/// Where the value of the `index`th constant stands.
fn constant_entry((index, (id, _)): (usize, &(u32, u32))) -> vk::SpecializationMapEntry {
    vk::SpecializationMapEntry {
        constant_id: *id,
        offset: 4 * index as u32,
        size: 4,
    }
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

fn words_of(spirv: &[u8]) -> Vec<u32> {
    let words = spirv.as_chunks::<4>().0.iter();
    words.map(|word| u32::from_le_bytes(*word)).collect()
}

/// Refuses other code whose bindings the pipeline's layout would not have.
fn check_code<S: ShaderInterface>(variant: &Variant) -> Result<()> {
    let Some((_, spirv)) = &variant.code else {
        return Ok(());
    };
    let has = |binding: &u32| S::SLOTS.iter().any(|slot| slot.binding == *binding);
    match bindings(&words_of(spirv)).into_iter().find(|b| !has(b)) {
        None => Ok(()),
        Some(binding) => Err(Error::input(
            S::NAME,
            "code",
            format!("binding {binding} is none of this shader's"),
        )),
    }
}

/// The bindings that a module decorates variables with.
fn bindings(words: &[u32]) -> Vec<u32> {
    const HEADER_WORDS: usize = 5;
    // OpDecorate target Binding literal.
    const DECORATE: u32 = 71;
    const BINDING: u32 = 33;
    let (mut found, mut at) = (Vec::new(), HEADER_WORDS);
    while let Some(&word) = words.get(at) {
        if word & 0xffff == DECORATE && words.get(at + 2) == Some(&BINDING) {
            found.extend(words.get(at + 3));
        }
        at += (word >> 16).max(1) as usize;
    }
    found
}

/// The bytes of a stage as a module.
fn shader_module(device: &ash::Device, spirv: &[u8]) -> Result<vk::ShaderModule> {
    let words = words_of(spirv);
    let info = vk::ShaderModuleCreateInfo::default().code(&words);
    // SAFETY: the SPIR-V came from shaderc; what is committed was checked against its hash at build time.
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
