//! The context: one device, one queue, and what lives as long as they do. In: a [`DeviceChoice`] or a
//! [`Foreign`] device. Out: [`Context`], which every other file of this room takes. Cheap to clone; the last clone, and
//! whatever was made from it, destroys everything in order: pipelines and sets, the allocator, the device, the messenger,
//! the instance.

use super::bind::SetPools;
use super::debug::Labels;
use super::device::{Candidate, DeviceChoice, DeviceInfo, choose};
use super::failure;
use super::foreign::Foreign;
use super::host::Host;
use super::memory::{Allocated, Memory};
use super::pipeline::PipelineStore;
use super::requirements::requirements;
use crate::{Error, Result};
use ash::vk;
use std::mem::ManuallyDrop;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// How to make a [`Context`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ContextOptions {
    /// Which device.
    pub device: DeviceChoice,
    /// Whether to load the validation layer with synchronization validation; [`Error::Requirement`] when it is not
    /// installed.
    pub validation: bool,
}

/// A Vulkan device ready for work. Clones share it; it may be used from many threads.
#[derive(Clone)]
pub struct Context(pub(super) Arc<Inner>);

/// What a context owns; reached through [`Context`] only.
pub(super) struct Inner {
    pub(super) device: ash::Device,
    pub(super) queue_family: u32,
    pub(super) info: DeviceInfo,
    pub(super) memory: ManuallyDrop<Memory>,
    pub(super) pipelines: PipelineStore,
    pub(super) sets: SetPools,
    pub(super) labels: Labels,
    queue: Mutex<vk::Queue>,
    physical_device: vk::PhysicalDevice,
    instance: ash::Instance,
    owned: Option<Host>,
}

impl Context {
    /// A context on a device of this machine. [`Error::NoDevice`] when there is none that `options` means,
    /// [`Error::Requirement`] when that one lacks something.
    pub fn new(options: &ContextOptions) -> Result<Self> {
        let host = Host::new(options.validation)?;
        let chosen = choose(host.candidates()?, &options.device)?;
        let device = create_device(&host.instance, &chosen)?;
        let queue_family = chosen.queue_family.unwrap_or(0);
        // SAFETY: the device was made with one queue of this family.
        let queue = unsafe { device.get_device_queue(queue_family, 0) };
        let foreign = Foreign {
            instance: host.instance.clone(),
            physical_device: chosen.raw,
            device,
            queue,
            queue_family,
            api_version: requirements().api_version,
            features: requirements().features(),
            extensions: Vec::new(),
            debug_utils: host.debug_utils,
            allocator: None,
        };
        Context::assemble(foreign, chosen.info, Some(host))
    }

    /// A context on a device that the caller owns and keeps.
    ///
    /// The declaration is checked against [`requirements`](super::requirements()); [`Error::Requirement`] names all that
    /// is missing.
    ///
    /// # Safety
    /// * The handles of `foreign` belong together, and its features and extensions were enabled on its device.
    /// * Instance and device (and a shared allocator's device) outlive this context and all that is made from it.
    /// * While [`Context::run`] or a call that uploads, downloads or creates an image is under way, nobody else uses the
    ///   queue.
    pub unsafe fn from_foreign(foreign: Foreign) -> Result<Self> {
        // SAFETY: the caller's promise.
        let info = unsafe { foreign.check() }?;
        Context::assemble(foreign, info, None)
    }

    fn assemble(foreign: Foreign, info: DeviceInfo, owned: Option<Host>) -> Result<Self> {
        let Foreign {
            instance,
            physical_device,
            device,
            queue,
            queue_family,
            debug_utils,
            allocator,
            ..
        } = foreign;
        let labels = Labels::new(&instance, &device, debug_utils);
        let parts = Memory::new(&instance, physical_device, &device, allocator)
            .and_then(|memory| Ok((memory, PipelineStore::new(&device)?)));
        let (memory, pipelines) = match parts {
            Ok(parts) => parts,
            Err(error) => {
                destroy_owned(&device, owned);
                return Err(error);
            }
        };
        Ok(Context(Arc::new(Inner {
            sets: SetPools::default(),
            memory: ManuallyDrop::new(memory),
            queue: Mutex::new(queue),
            pipelines,
            labels,
            info,
            device,
            queue_family,
            physical_device,
            instance,
            owned,
        })))
    }

    /// The device in use.
    pub fn info(&self) -> &DeviceInfo {
        &self.0.info
    }

    /// What the validation layer has said so far; empty for a foreign device, whose owner has its own messenger.
    pub fn validation_messages(&self) -> Vec<String> {
        self.0
            .owned
            .as_ref()
            .map(Host::messages)
            .unwrap_or_default()
    }

    /// Device memory in use now, by name. A shared allocator reports its other users too.
    pub fn allocations(&self) -> Vec<Allocated> {
        self.0.memory.report()
    }

    /// The device's functions, for callers who record their own commands.
    pub fn device(&self) -> &ash::Device {
        &self.0.device
    }

    /// The family of the one queue, for callers who make their own command pools.
    pub fn queue_family(&self) -> u32 {
        self.0.queue_family
    }

    /// The physical device.
    pub fn physical_device(&self) -> vk::PhysicalDevice {
        self.0.physical_device
    }

    /// The instance's functions.
    pub fn instance(&self) -> &ash::Instance {
        &self.0.instance
    }

    pub(super) fn same(&self, other: &Context) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    pub(super) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.0.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl std::fmt::Debug for Context {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Context")
            .field("device", &self.0.info.name)
            .finish_non_exhaustive()
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: this is the last use of everything below. The device is idle: `run` waits for what it submits, and a
        // foreign owner promised to keep this alive while its own submissions use it. The allocator goes before the
        // device, and `memory` is not touched again.
        unsafe {
            self.sets.destroy(&self.device);
            self.pipelines.destroy(&self.device);
            if self.owned.is_some() {
                for leak in self.memory.report() {
                    tracing::warn!("device memory leaked: {} ({} bytes)", leak.name, leak.bytes);
                }
            }
            ManuallyDrop::drop(&mut self.memory);
        }
        destroy_owned(&self.device, self.owned.take());
    }
}

/// Destroys the device, then messenger and instance, if they are our own.
fn destroy_owned(device: &ash::Device, owned: Option<Host>) {
    if owned.is_some() {
        // SAFETY: everything made from the device is gone.
        unsafe { device.destroy_device(None) };
    }
}

fn create_device(instance: &ash::Instance, chosen: &Candidate) -> Result<ash::Device> {
    let Some(queue_family) = chosen.queue_family else {
        return Err(Error::Requirement {
            device: chosen.info.name.clone(),
            missing: "a queue".to_owned(),
        });
    };
    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(queue_family)
        .queue_priorities(&priorities)];
    let mut features = requirements().features();
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features.core)
        .push_next(&mut features.vulkan12)
        .push_next(&mut features.vulkan13);
    // SAFETY: the candidate meets the requirements, so the features are supported; pointers outlive the call.
    unsafe { instance.create_device(chosen.raw, &info, None) }
        .map_err(failure::of("vkCreateDevice"))
}
