//! Device memory, all of it through gpu-allocator. In: the memory requirements of a buffer or an image and its name.
//! Out: an allocation, or a typed error that says for what and how much. The allocator goes before the device.

use super::failure;
use crate::{Error, Result};
use ash::vk;
use gpu_allocator::vulkan::{
    Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc,
};
use gpu_allocator::{AllocationError, AllocationSizes, MemoryLocation};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

const MIB: u64 = 1 << 20;

/// The allocator of a context: its own, or one that an embedder shares.
pub(super) struct Memory {
    allocator: Arc<Mutex<Allocator>>,
    properties: vk::PhysicalDeviceMemoryProperties,
}

/// A live allocation, for reports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Allocated {
    /// What it was made for.
    pub name: String,
    /// Its size.
    pub bytes: u64,
}

impl Memory {
    pub(super) fn new(
        instance: &ash::Instance,
        physical_device: vk::PhysicalDevice,
        device: &ash::Device,
        shared: Option<Arc<Mutex<Allocator>>>,
    ) -> Result<Self> {
        // SAFETY: the handles belong together and are alive.
        let properties = unsafe { instance.get_physical_device_memory_properties(physical_device) };
        let allocator = match shared {
            Some(allocator) => allocator,
            None => {
                let created = Allocator::new(&AllocatorCreateDesc {
                    instance: instance.clone(),
                    device: device.clone(),
                    physical_device,
                    debug_settings: Default::default(),
                    buffer_device_address: false,
                    // Small blocks: several contexts may share a process, and software devices use host memory.
                    allocation_sizes: AllocationSizes::new(32 * MIB, 16 * MIB),
                });
                Arc::new(Mutex::new(
                    created.map_err(|error| typed(&error, "the allocator", 0))?,
                ))
            }
        };
        Ok(Memory {
            allocator,
            properties,
        })
    }

    pub(super) fn allocate(
        &self,
        name: &str,
        requirements: vk::MemoryRequirements,
        location: MemoryLocation,
        linear: bool,
    ) -> Result<Allocation> {
        if requirements.size > self.largest_heap(requirements.memory_type_bits) {
            return Err(failure::out_of_memory("device", name, requirements.size));
        }
        let scheme = AllocationScheme::GpuAllocatorManaged;
        let description = AllocationCreateDesc {
            name,
            requirements,
            location,
            linear,
            allocation_scheme: scheme,
        };
        self.lock()
            .allocate(&description)
            .map_err(|error| typed(&error, name, requirements.size))
    }

    pub(super) fn free(&self, allocation: Allocation) {
        if let Err(error) = self.lock().free(allocation) {
            tracing::error!("device memory could not be freed: {error}");
        }
    }

    /// What is allocated now.
    pub(super) fn report(&self) -> Vec<Allocated> {
        let report = self.lock().generate_report();
        report
            .allocations
            .into_iter()
            .map(|one| Allocated {
                name: one.name,
                bytes: one.size,
            })
            .collect()
    }

    /// Vulkan forbids asking for more than a heap holds, so a driver need not answer such a request with an error.
    fn largest_heap(&self, memory_type_bits: u32) -> u64 {
        let types = self.properties.memory_types_as_slice().iter().enumerate();
        let allowed = types.filter(|(index, _)| memory_type_bits >> index & 1 == 1);
        let heaps = allowed
            .map(|(_, memory)| self.properties.memory_heaps[memory.heap_index as usize].size);
        heaps.max().unwrap_or(0)
    }

    fn lock(&self) -> MutexGuard<'_, Allocator> {
        self.allocator
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

fn typed(error: &AllocationError, what: &str, bytes: u64) -> Error {
    match error {
        AllocationError::OutOfMemory => failure::out_of_memory("device", what, bytes),
        other => Error::Vulkan {
            call: "vkAllocateMemory",
            code: format!("{other} (for {what})"),
        },
    }
}
