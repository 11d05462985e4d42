//! An embedder: an instance and a device made with plain ash, as an engine would have them. In: a position in the
//! loader's list of devices. Out: the handles, destroyed in order when dropped.
#![allow(dead_code, reason = "each test file uses a part")]

use invertex::gpu::{Features, Foreign, ash, requirements, vk};

/// Someone else's Vulkan.
pub(crate) struct Plain {
    pub(crate) entry: ash::Entry,
    pub(crate) instance: ash::Instance,
    pub(crate) physical_device: vk::PhysicalDevice,
    pub(crate) device: ash::Device,
    pub(crate) queue_family: u32,
    pub(crate) queue: vk::Queue,
}

impl Plain {
    /// The `index`th physical device that has Vulkan 1.3, with the features that the crate requires and one more.
    pub(crate) fn new(index: usize) -> Self {
        // SAFETY: all structs outlive the calls that they are given to, and every handle is alive when used.
        unsafe {
            let entry = ash::Entry::load().unwrap();
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&info, None).unwrap();
            let mut found = instance.enumerate_physical_devices().unwrap();
            found.retain(|one| {
                instance.get_physical_device_properties(*one).api_version >= vk::API_VERSION_1_3
            });
            let physical_device = found[index];
            let families = instance.get_physical_device_queue_family_properties(physical_device);
            let wanted = requirements().queue;
            let queue_family = families
                .iter()
                .position(|family| family.queue_flags.contains(wanted))
                .unwrap() as u32;
            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(queue_family)
                .queue_priorities(&[1.0])];
            let mut features = Plain::features();
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_features(&features.core)
                .push_next(&mut features.vulkan12)
                .push_next(&mut features.vulkan13);
            let device = instance
                .create_device(physical_device, &info, None)
                .unwrap();
            let queue = device.get_device_queue(queue_family, 0);
            Plain {
                entry,
                instance,
                physical_device,
                device,
                queue_family,
                queue,
            }
        }
    }

    /// What the embedder enables: what is required, and what it needs for itself.
    pub(crate) fn features() -> Features {
        let mut features = requirements().features();
        features.vulkan12.timeline_semaphore = vk::TRUE;
        features
    }

    /// The handles to hand over, with a true declaration.
    pub(crate) fn foreign(&self) -> Foreign {
        Foreign {
            instance: self.instance.clone(),
            physical_device: self.physical_device,
            device: self.device.clone(),
            queue: self.queue,
            queue_family: self.queue_family,
            api_version: vk::API_VERSION_1_3,
            features: Plain::features(),
            extensions: Vec::new(),
            debug_utils: false,
            allocator: None,
        }
    }
}

impl Drop for Plain {
    fn drop(&mut self) {
        // SAFETY: everything made from the device is gone.
        unsafe {
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}

impl Plain {
    /// Records into a command buffer of the engine's, submits it and waits.
    pub(crate) fn submit(&self, record: impl FnOnce(vk::CommandBuffer)) {
        let device = &self.device;
        // SAFETY: every handle is made here, used by this thread alone, and destroyed after the wait.
        unsafe {
            let info = vk::CommandPoolCreateInfo::default().queue_family_index(self.queue_family);
            let pool = device.create_command_pool(&info, None).unwrap();
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(pool)
                .command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info).unwrap()[0];
            device
                .begin_command_buffer(commands, &vk::CommandBufferBeginInfo::default())
                .unwrap();
            record(commands);
            device.end_command_buffer(commands).unwrap();
            let buffers = [commands];
            let submit = [vk::SubmitInfo::default().command_buffers(&buffers)];
            device
                .queue_submit(self.queue, &submit, vk::Fence::null())
                .unwrap();
            device.queue_wait_idle(self.queue).unwrap();
            device.destroy_command_pool(pool, None);
        }
    }
}

/// A compute pass that the engine makes from a SPIR-V module and storage buffers, all by itself.
pub(crate) struct EnginePass<'a> {
    device: &'a ash::Device,
    module: vk::ShaderModule,
    set_layout: vk::DescriptorSetLayout,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
}

impl<'a> EnginePass<'a> {
    /// `buffers`: the bindings of set 0, all of them storage buffers.
    pub(crate) fn new(engine: &'a Plain, spirv: &[u8], buffers: &[u32], push_bytes: u32) -> Self {
        let device = &engine.device;
        let words: Vec<u32> = spirv
            .chunks(4)
            .map(|word| u32::from_le_bytes(word.try_into().unwrap()))
            .collect();
        let bindings: Vec<_> = buffers
            .iter()
            .map(|binding| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(*binding)
                    .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let push = [vk::PushConstantRange {
            stage_flags: vk::ShaderStageFlags::COMPUTE,
            offset: 0,
            size: push_bytes,
        }];
        // SAFETY: all structs outlive the calls that they are given to, and every handle is alive when used.
        unsafe {
            let module = device
                .create_shader_module(&vk::ShaderModuleCreateInfo::default().code(&words), None)
                .unwrap();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            let set_layout = device.create_descriptor_set_layout(&info, None).unwrap();
            let set_layouts = [set_layout];
            let info = vk::PipelineLayoutCreateInfo::default()
                .set_layouts(&set_layouts)
                .push_constant_ranges(&push);
            let layout = device.create_pipeline_layout(&info, None).unwrap();
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main");
            let info = [vk::ComputePipelineCreateInfo::default()
                .stage(stage)
                .layout(layout)];
            let pipeline = device
                .create_compute_pipelines(vk::PipelineCache::null(), &info, None)
                .unwrap()[0];
            let sizes = [vk::DescriptorPoolSize {
                ty: vk::DescriptorType::STORAGE_BUFFER,
                descriptor_count: buffers.len() as u32,
            }];
            let info = vk::DescriptorPoolCreateInfo::default()
                .max_sets(1)
                .pool_sizes(&sizes);
            let pool = device.create_descriptor_pool(&info, None).unwrap();
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(pool)
                .set_layouts(&set_layouts);
            let set = device.allocate_descriptor_sets(&info).unwrap()[0];
            EnginePass {
                device,
                module,
                set_layout,
                layout,
                pipeline,
                pool,
                set,
            }
        }
    }

    /// Puts buffers into the set: (binding, buffer).
    pub(crate) fn bind(&self, buffers: &[(u32, vk::Buffer)]) {
        for (binding, buffer) in buffers {
            let info = [vk::DescriptorBufferInfo {
                buffer: *buffer,
                offset: 0,
                range: vk::WHOLE_SIZE,
            }];
            let write = vk::WriteDescriptorSet::default()
                .dst_set(self.set)
                .dst_binding(*binding)
                .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                .buffer_info(&info);
            // SAFETY: the engine has waited for earlier uses of the set.
            unsafe { self.device.update_descriptor_sets(&[write], &[]) };
        }
    }

    /// Records the pass, with a barrier before the host's or another pass's use of what it writes.
    pub(crate) fn record(&self, commands: vk::CommandBuffer, push: &[u8], groups: u32) {
        let barrier = [vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::SHADER_WRITE)
            .dst_access_mask(vk::AccessFlags::MEMORY_READ)];
        // SAFETY: the command buffer is being recorded, and the handles are alive.
        unsafe {
            self.device
                .cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, self.pipeline);
            let sets = [self.set];
            self.device.cmd_bind_descriptor_sets(
                commands,
                vk::PipelineBindPoint::COMPUTE,
                self.layout,
                0,
                &sets,
                &[],
            );
            self.device.cmd_push_constants(
                commands,
                self.layout,
                vk::ShaderStageFlags::COMPUTE,
                0,
                push,
            );
            self.device.cmd_dispatch(commands, groups, 1, 1);
            self.device.cmd_pipeline_barrier(
                commands,
                vk::PipelineStageFlags::COMPUTE_SHADER,
                vk::PipelineStageFlags::ALL_COMMANDS,
                vk::DependencyFlags::empty(),
                &barrier,
                &[],
                &[],
            );
        }
    }
}

impl Drop for EnginePass<'_> {
    fn drop(&mut self) {
        // SAFETY: the engine has waited for what used these.
        unsafe {
            self.device.destroy_descriptor_pool(self.pool, None);
            self.device.destroy_pipeline(self.pipeline, None);
            self.device.destroy_pipeline_layout(self.layout, None);
            self.device
                .destroy_descriptor_set_layout(self.set_layout, None);
            self.device.destroy_shader_module(self.module, None);
        }
    }
}
