//! Someone else's device. In: the handles an embedder already has and its declaration of what it enabled. Out: the same
//! declaration checked against [`requirements`](super::requirements()), naming what is missing.

use super::device::{DeviceInfo, describe, queue_families};
use super::requirements::{Features, Offer, requirements};
use crate::{Error, Result};
use ash::vk;
use gpu_allocator::vulkan::Allocator;
use std::sync::{Arc, Mutex};

/// An instance, device and queue that somebody else owns, for [`Context::from_foreign`](super::Context::from_foreign).
///
/// Vulkan cannot tell which features were enabled on a device, so the embedder declares them.
pub struct Foreign {
    /// The instance.
    pub instance: ash::Instance,
    /// The physical device of `device`.
    pub physical_device: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    /// A queue of `queue_family`.
    pub queue: vk::Queue,
    /// The family that `queue` was made from.
    pub queue_family: u32,
    /// The `apiVersion` that the instance was made for.
    pub api_version: u32,
    /// The features enabled on the device.
    pub features: Features,
    /// The device extensions enabled.
    pub extensions: Vec<String>,
    /// Whether the instance has `VK_EXT_debug_utils` enabled, so that passes can be labelled.
    pub debug_utils: bool,
    /// An allocator to share; `None` makes one for this context alone.
    pub allocator: Option<Arc<Mutex<Allocator>>>,
}

impl Foreign {
    /// The device's information, or [`Error::Requirement`] naming everything that was not declared or is not there.
    ///
    /// # Safety
    /// `physical_device` belongs to `instance`, and both are alive.
    pub(super) unsafe fn check(&self) -> Result<DeviceInfo> {
        // SAFETY: the caller's promise.
        let core = unsafe {
            self.instance
                .get_physical_device_properties(self.physical_device)
        };
        let families = queue_families(&self.instance, self.physical_device);
        let family = families
            .get(self.queue_family as usize)
            .copied()
            .unwrap_or_default();
        let missing = requirements().missing(&Offer {
            api_version: core.api_version.min(self.api_version),
            queue: family.queue_flags,
            features: &self.features,
            limits: &core.limits,
            extensions: &self.extensions,
        });
        let info = describe(&self.instance, 0, self.physical_device, &family, missing);
        match info.usable {
            true => Ok(info),
            false => Err(Error::Requirement {
                device: info.name,
                missing: info.missing.join(", "),
            }),
        }
    }
}
