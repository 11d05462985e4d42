//! Descriptor sets. In: a pipeline and its `Bindings`. Out: [`Bound`], which keeps the resources alive and gives its set
//! back when dropped. Pools are added on demand, each twice the size of the last.

use super::buffer::Buffer;
use super::context::Context;
use super::failure;
use super::image::{Image, Sampler};
use super::interface::{Resource, ShaderInterface, Slot, SlotKind};
use super::pipeline::{Pipeline, RawPipeline};
use crate::{Error, Result};
use ash::vk;
use std::marker::PhantomData;
use std::sync::{Arc, Mutex, PoisonError};

/// A pipeline with its resources bound, ready to be dispatched or drawn any number of times.
pub struct Bound<S>(pub(super) Arc<BoundSet>, PhantomData<fn() -> S>);

/// A descriptor set with all that it refers to.
pub(super) struct BoundSet {
    pub(super) pipeline: Arc<RawPipeline>,
    pub(super) set: vk::DescriptorSet,
    pool: vk::DescriptorPool,
    context: Context,
    _resources: Vec<Held>,
}

/// A resource kept alive.
#[derive(Clone)]
#[allow(dead_code, reason = "held for its Drop, never read")]
pub(super) enum Held {
    Buffer(Buffer),
    Image(Image),
    Sampler(Sampler),
    Set(Arc<BoundSet>),
}

impl<S> Clone for Bound<S> {
    fn clone(&self) -> Self {
        Bound(self.0.clone(), PhantomData)
    }
}

impl<S: ShaderInterface> Pipeline<S> {
    /// Binds resources by their GLSL names.
    ///
    /// [`Error::Capacity`] when a buffer is larger than a shader may see on this device. Panics when a resource belongs
    /// to another context.
    pub fn bind(&self, bindings: &S::Bindings<'_>) -> Result<Bound<S>> {
        let resources = S::resources(bindings);
        let limits = &self.context.info().limits;
        for (slot, resource) in S::SLOTS.iter().zip(&resources) {
            assert!(
                owner(resource).same(&self.context),
                "{}: {} belongs to another context",
                S::NAME,
                slot.name
            );
            if let Resource::Buffer(buffer) = resource {
                let uniform = slot.kind == SlotKind::UniformBuffer;
                let have = if uniform {
                    limits.uniform_buffer_bytes
                } else {
                    limits.storage_buffer_bytes
                };
                if buffer.bytes() > have {
                    let what = format!("bytes of buffer \"{}\" in {}", buffer.name(), S::NAME);
                    return Err(Error::Capacity {
                        what,
                        need: buffer.bytes(),
                        have,
                    });
                }
            }
        }
        let (pool, set) = self
            .context
            .0
            .sets
            .allocate(&self.context.0.device, self.raw.set_layout)?;
        let bound = BoundSet {
            pipeline: self.raw.clone(),
            set,
            pool,
            context: self.context.clone(),
            _resources: resources.iter().flat_map(held).collect(),
        };
        write(&self.context.0.device, set, S::SLOTS, &resources);
        Ok(Bound(Arc::new(bound), PhantomData))
    }
}

impl BoundSet {
    pub(super) fn context(&self) -> &Context {
        &self.context
    }
}

impl Drop for BoundSet {
    fn drop(&mut self) {
        self.context
            .0
            .sets
            .free(&self.context.0.device, self.pool, self.set);
    }
}

fn owner<'a>(resource: &Resource<'a>) -> &'a Context {
    match resource {
        Resource::Buffer(buffer) => buffer.context(),
        Resource::Image(image) | Resource::Sampled(image, _) => image.context(),
        Resource::Sampler(sampler) => sampler.context(),
    }
}

fn held(resource: &Resource<'_>) -> Vec<Held> {
    match *resource {
        Resource::Buffer(buffer) => vec![Held::Buffer(buffer.clone())],
        Resource::Image(image) => vec![Held::Image(image.clone())],
        Resource::Sampler(sampler) => vec![Held::Sampler(sampler.clone())],
        Resource::Sampled(image, sampler) => {
            vec![Held::Image(image.clone()), Held::Sampler(sampler.clone())]
        }
    }
}

/// What goes into one descriptor.
enum Descriptor {
    Buffer([vk::DescriptorBufferInfo; 1]),
    Image([vk::DescriptorImageInfo; 1]),
}

fn descriptor(resource: &Resource<'_>) -> Descriptor {
    let (view, sampler) = match *resource {
        Resource::Buffer(buffer) => {
            let range = buffer.bound_bytes();
            return Descriptor::Buffer([vk::DescriptorBufferInfo {
                buffer: buffer.handle(),
                offset: 0,
                range,
            }]);
        }
        Resource::Image(image) => (image.view(), vk::Sampler::null()),
        Resource::Sampler(sampler) => (vk::ImageView::null(), sampler.handle()),
        Resource::Sampled(image, sampler) => (image.view(), sampler.handle()),
    };
    Descriptor::Image([vk::DescriptorImageInfo {
        sampler,
        image_view: view,
        image_layout: vk::ImageLayout::GENERAL,
    }])
}

fn write(device: &ash::Device, set: vk::DescriptorSet, slots: &[Slot], resources: &[Resource<'_>]) {
    let descriptors: Vec<Descriptor> = resources.iter().map(descriptor).collect();
    let writes: Vec<vk::WriteDescriptorSet<'_>> = slots
        .iter()
        .zip(&descriptors)
        .map(|(slot, descriptor)| {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(slot.binding)
                .descriptor_type(slot.kind.descriptor_type());
            match descriptor {
                Descriptor::Buffer(info) => write.buffer_info(info),
                Descriptor::Image(info) => write.image_info(info),
            }
        })
        .collect();
    // SAFETY: the set was just allocated from this layout, and the resources are alive and of the slots' kinds.
    unsafe { device.update_descriptor_sets(&writes, &[]) };
}

/// The descriptor pools of a context.
#[derive(Default)]
pub(super) struct SetPools(Mutex<Vec<vk::DescriptorPool>>);

impl SetPools {
    /// A set from the newest pool that has room, or from a new one.
    fn allocate(
        &self,
        device: &ash::Device,
        layout: vk::DescriptorSetLayout,
    ) -> Result<(vk::DescriptorPool, vk::DescriptorSet)> {
        let mut pools = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let layouts = [layout];
        let take = |pool| {
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(pool)
                .set_layouts(&layouts);
            // SAFETY: pool and layout are alive, and the lock keeps other threads from the pool.
            unsafe { device.allocate_descriptor_sets(&info) }.map(|sets| (pool, sets[0]))
        };
        for pool in pools.iter().rev() {
            match take(*pool) {
                Err(vk::Result::ERROR_OUT_OF_POOL_MEMORY | vk::Result::ERROR_FRAGMENTED_POOL) => {}
                other => return other.map_err(failure::of("vkAllocateDescriptorSets")),
            }
        }
        let pool = create_pool(device, pools.len() as u32)?;
        pools.push(pool);
        take(pool).map_err(failure::of("vkAllocateDescriptorSets"))
    }

    fn free(&self, device: &ash::Device, pool: vk::DescriptorPool, set: vk::DescriptorSet) {
        let _pools = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the set came from this pool, the device no longer uses it, and the lock keeps others from the pool.
        // The call cannot fail.
        let _ = unsafe { device.free_descriptor_sets(pool, &[set]) };
    }

    /// # Safety
    /// The device no longer uses any set, and nobody will.
    pub(super) unsafe fn destroy(&self, device: &ash::Device) {
        for pool in self
            .0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .drain(..)
        {
            // SAFETY: the caller's promise.
            unsafe { device.destroy_descriptor_pool(pool, None) };
        }
    }
}

/// The `nth` pool of a context: 32 sets of up to 16 storage buffers and 8 of each other kind, doubled each time.
fn create_pool(device: &ash::Device, nth: u32) -> Result<vk::DescriptorPool> {
    let sets = 32 << nth.min(8);
    let sizes = SlotKind::ALL.map(|kind| vk::DescriptorPoolSize {
        ty: kind.descriptor_type(),
        descriptor_count: sets
            * if kind == SlotKind::StorageBuffer {
                16
            } else {
                8
            },
    });
    let info = vk::DescriptorPoolCreateInfo::default()
        .flags(vk::DescriptorPoolCreateFlags::FREE_DESCRIPTOR_SET)
        .max_sets(sets)
        .pool_sizes(&sizes);
    // SAFETY: nothing but sizes.
    unsafe { device.create_descriptor_pool(&info, None) }
        .map_err(failure::of("vkCreateDescriptorPool"))
}
