//! What a device must have, as data. In: what a device (or an embedder's declaration) offers. Out: the names of what is
//! missing. The same list is checked for our own devices and for foreign ones, and it says what to enable.

use ash::vk;

/// Everything this crate asks of a device.
#[derive(Debug)]
pub struct Requirements {
    /// Instance and device version, as `vk::make_api_version` packs it.
    pub api_version: u32,
    /// What the one queue must be able to do.
    pub queue: vk::QueueFlags,
    /// Features that must be supported and enabled.
    pub features: &'static [RequiredFeature],
    /// Limits that must be reached.
    pub limits: &'static [RequiredLimit],
    /// Device extensions that must be enabled: none so far.
    pub extensions: &'static [&'static str],
}

/// A feature by its Vulkan name.
#[derive(Debug)]
pub struct RequiredFeature {
    /// The member of the `VkPhysicalDevice..Features` struct.
    pub name: &'static str,
    get: fn(&Features) -> vk::Bool32,
    set: fn(&mut Features),
}

/// A limit by its Vulkan name.
#[derive(Debug)]
pub struct RequiredLimit {
    /// The member of `VkPhysicalDeviceLimits`.
    pub name: &'static str,
    /// The least value that will do.
    pub at_least: u64,
    get: fn(&vk::PhysicalDeviceLimits) -> u64,
}

/// The features of a device, supported or enabled. The `p_next` pointers are ignored.
#[derive(Clone, Copy, Debug, Default)]
pub struct Features {
    /// Vulkan 1.0.
    pub core: vk::PhysicalDeviceFeatures,
    /// Vulkan 1.2.
    pub vulkan12: vk::PhysicalDeviceVulkan12Features<'static>,
    /// Vulkan 1.3.
    pub vulkan13: vk::PhysicalDeviceVulkan13Features<'static>,
}

/// What a device offers, to be held against [`Requirements`].
pub(super) struct Offer<'a> {
    pub(super) api_version: u32,
    pub(super) queue: vk::QueueFlags,
    pub(super) features: &'a Features,
    pub(super) limits: &'a vk::PhysicalDeviceLimits,
    pub(super) extensions: &'a [String],
}

macro_rules! feature {
    ($name:literal, $($path:ident).+) => {
        RequiredFeature {
            name: $name,
            get: |features| features.$($path).+,
            set: |features| features.$($path).+ = vk::TRUE,
        }
    };
}

macro_rules! limit {
    ($name:literal, $at_least:expr, $limits:ident => $value:expr) => {
        RequiredLimit {
            name: $name,
            at_least: $at_least,
            get: |$limits| u64::from($value),
        }
    };
}

const REQUIREMENTS: Requirements = Requirements {
    api_version: vk::API_VERSION_1_3,
    queue: vk::QueueFlags::from_raw(
        vk::QueueFlags::GRAPHICS.as_raw() | vk::QueueFlags::COMPUTE.as_raw(),
    ),
    features: &[
        // A wrong index must read zero, not the neighbour's memory (and on some drivers end the process).
        feature!("robustBufferAccess", core.robust_buffer_access),
        feature!("dynamicRendering", vulkan13.dynamic_rendering),
        feature!("synchronization2", vulkan13.synchronization2),
        // Tells the largest buffer, so that a request beyond it is an error and not undefined.
        feature!("maintenance4", vulkan13.maintenance4),
    ],
    limits: &[
        limit!("maxStorageBufferRange", 1 << 27, limits => limits.max_storage_buffer_range),
        limit!("maxPushConstantsSize", 128, limits => limits.max_push_constants_size),
        limit!("maxBoundDescriptorSets", 4, limits => limits.max_bound_descriptor_sets),
        limit!("maxPerStageDescriptorStorageBuffers", super::shaders::MOST_STORAGE_BUFFERS, limits => limits.max_per_stage_descriptor_storage_buffers),
        limit!("maxComputeWorkGroupInvocations", 256, limits => limits.max_compute_work_group_invocations),
        limit!("maxComputeWorkGroupCount[0]", 65535, limits => limits.max_compute_work_group_count[0]),
        limit!("maxComputeSharedMemorySize", 16384, limits => limits.max_compute_shared_memory_size),
        limit!("maxImageDimension2D", 4096, limits => limits.max_image_dimension2_d),
    ],
    extensions: &[],
};

/// What a device must offer to run this crate; an embedder enables these on its own device.
pub fn requirements() -> &'static Requirements {
    &REQUIREMENTS
}

impl Requirements {
    /// The required features, switched on: for `VkDeviceCreateInfo`.
    pub fn features(&self) -> Features {
        let mut features = Features::default();
        for feature in self.features {
            (feature.set)(&mut features);
        }
        features
    }

    /// Names what `offer` lacks; empty when it will do.
    pub(super) fn missing(&self, offer: &Offer<'_>) -> Vec<String> {
        let mut missing = Vec::new();
        if offer.api_version < self.api_version {
            missing.push(format!(
                "Vulkan {} (it has {})",
                version(self.api_version),
                version(offer.api_version)
            ));
        }
        if !offer.queue.contains(self.queue) {
            missing.push(format!("a queue family with {:?}", self.queue));
        }
        for feature in self
            .features
            .iter()
            .filter(|feature| (feature.get)(offer.features) == vk::FALSE)
        {
            missing.push(format!("feature {}", feature.name));
        }
        for limit in self.limits {
            let value = (limit.get)(offer.limits);
            if value < limit.at_least {
                missing.push(format!(
                    "{} >= {} (it has {value})",
                    limit.name, limit.at_least
                ));
            }
        }
        for name in self
            .extensions
            .iter()
            .filter(|name| !offer.extensions.iter().any(|offered| offered == *name))
        {
            missing.push(format!("extension {name}"));
        }
        missing
    }
}

/// `1.3.230` of a packed version.
pub(super) fn version(packed: u32) -> String {
    format!(
        "{}.{}.{}",
        vk::api_version_major(packed),
        vk::api_version_minor(packed),
        vk::api_version_patch(packed)
    )
}
