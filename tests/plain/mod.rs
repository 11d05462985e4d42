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
