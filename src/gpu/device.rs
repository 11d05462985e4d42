//! Which devices there are and which one to take. In: an instance. Out: a [`DeviceInfo`] for every physical device with
//! what it lacks, and the choice among them.

use super::failure;
use super::host::{GET_A_DRIVER, no_device};
use super::requirements::{Features, Offer, requirements, version};
use crate::{Error, Result};
use ash::vk;
use std::ffi::{CStr, CString};
use std::str::FromStr;

/// The device to use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The best usable one: discrete, then integrated, virtual, software.
    #[default]
    Auto,
    /// By [`DeviceInfo::index`].
    Index(usize),
    /// The first usable one whose name contains this, in any case.
    Name(String),
}

impl FromStr for DeviceChoice {
    type Err = std::convert::Infallible;

    /// `auto`, an index, or part of a name.
    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        Ok(match text.parse() {
            Ok(index) => DeviceChoice::Index(index),
            Err(_) if text.eq_ignore_ascii_case("auto") => DeviceChoice::Auto,
            Err(_) => DeviceChoice::Name(text.to_owned()),
        })
    }
}

/// The kind of a device, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceKind {
    /// A graphics card.
    Discrete,
    /// A GPU that shares memory with the processor.
    Integrated,
    /// A virtual machine's GPU.
    Virtual,
    /// A software implementation.
    Cpu,
    /// Something else.
    Other,
}

/// A physical device and whether it can be used.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DeviceInfo {
    /// Position in the loader's list.
    pub index: usize,
    /// Name of the device.
    pub name: String,
    /// Name and version of the driver.
    pub driver: String,
    /// Vulkan version, `1.3.230`.
    pub api: String,
    /// What kind of device it is.
    pub kind: DeviceKind,
    /// Whether it meets the [`requirements`].
    pub usable: bool,
    /// What it lacks, by Vulkan names; empty when usable.
    pub missing: Vec<String>,
    /// Limits that decide what fits.
    pub limits: Limits,
}

/// The limits that decide what fits on a device.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Limits {
    /// Largest storage buffer a shader can see, in bytes (`maxStorageBufferRange`).
    pub storage_buffer_bytes: u64,
    /// Largest uniform buffer a shader can see, in bytes (`maxUniformBufferRange`).
    pub uniform_buffer_bytes: u64,
    /// Largest buffer, in bytes (`maxBufferSize`).
    pub buffer_bytes: u64,
    /// Largest memory heap on the device, in bytes.
    pub device_memory_bytes: u64,
    /// Most invocations in a workgroup.
    pub workgroup_invocations: u32,
    /// Most workgroups in a dispatch, per axis.
    pub workgroups: [u32; 3],
    /// Memory that a workgroup shares, in bytes.
    pub shared_memory_bytes: u32,
    /// Longest side of a 2D image, in texels.
    pub image_texels: u32,
    /// Most layers of an image.
    pub image_layers: u32,
    /// Nanoseconds per timestamp tick; 0 when the queue has no timestamps.
    pub timestamp_nanoseconds: f32,
    /// Valid bits of a timestamp.
    pub timestamp_bits: u32,
}

/// A physical device with the queue family to use, if it has one.
pub(super) struct Candidate {
    pub(super) raw: vk::PhysicalDevice,
    pub(super) queue_family: Option<u32>,
    pub(super) info: DeviceInfo,
}

/// What is known of the `index`th physical device.
pub(super) fn candidate(
    instance: &ash::Instance,
    index: usize,
    raw: vk::PhysicalDevice,
) -> Result<Candidate> {
    // SAFETY: `raw` comes from `instance`.
    let core = unsafe { instance.get_physical_device_properties(raw) };
    let families = queue_families(instance, raw);
    let wanted = requirements().queue;
    let queue_family = families
        .iter()
        .position(|family| family.queue_flags.contains(wanted))
        .map(|at| at as u32);
    let family = queue_family
        .map(|at| families[at as usize])
        .unwrap_or_default();
    let extensions = extensions(instance, raw)?;
    let mut missing = requirements().missing(&Offer {
        api_version: core.api_version,
        queue: family.queue_flags,
        features: &supported_features(instance, raw, core.api_version),
        limits: &core.limits,
        extensions: &extensions,
    });
    missing.sort();
    Ok(Candidate {
        raw,
        queue_family,
        info: describe(instance, index, raw, &family, missing),
    })
}

/// The information about a device whose shortcomings are known.
pub(super) fn describe(
    instance: &ash::Instance,
    index: usize,
    raw: vk::PhysicalDevice,
    family: &vk::QueueFamilyProperties,
    missing: Vec<String>,
) -> DeviceInfo {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut maintenance = vk::PhysicalDeviceMaintenance4Properties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default()
        .push_next(&mut driver)
        .push_next(&mut maintenance);
    // SAFETY: `raw` comes from `instance`; structs that an older device does not know are left as they are.
    let memory = unsafe {
        instance.get_physical_device_properties2(raw, &mut properties);
        instance.get_physical_device_memory_properties(raw)
    };
    let core = properties.properties;
    let heaps = memory.memory_heaps_as_slice().iter();
    let on_device = heaps.filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL));
    let limits = Limits {
        storage_buffer_bytes: core.limits.max_storage_buffer_range.into(),
        uniform_buffer_bytes: core.limits.max_uniform_buffer_range.into(),
        buffer_bytes: maintenance.max_buffer_size,
        device_memory_bytes: on_device.map(|heap| heap.size).max().unwrap_or(0),
        workgroup_invocations: core.limits.max_compute_work_group_invocations,
        workgroups: core.limits.max_compute_work_group_count,
        shared_memory_bytes: core.limits.max_compute_shared_memory_size,
        image_texels: core.limits.max_image_dimension2_d,
        image_layers: core.limits.max_image_array_layers,
        timestamp_nanoseconds: if family.timestamp_valid_bits == 0 {
            0.0
        } else {
            core.limits.timestamp_period
        },
        timestamp_bits: family.timestamp_valid_bits,
    };
    DeviceInfo {
        index,
        name: text(core.device_name_as_c_str()),
        driver: driver_text(&driver, core.driver_version),
        api: version(core.api_version),
        kind: kind(core.device_type),
        usable: missing.is_empty(),
        missing,
        limits,
    }
}

/// What a device supports; versions it does not have stay all off.
fn supported_features(
    instance: &ash::Instance,
    raw: vk::PhysicalDevice,
    api_version: u32,
) -> Features {
    let mut vulkan12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut vulkan13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut query = vk::PhysicalDeviceFeatures2::default();
    if api_version >= vk::API_VERSION_1_2 {
        query = query.push_next(&mut vulkan12);
    }
    if api_version >= vk::API_VERSION_1_3 {
        query = query.push_next(&mut vulkan13);
    }
    // SAFETY: `raw` comes from `instance`, and only structs of the device's version are chained.
    unsafe { instance.get_physical_device_features2(raw, &mut query) };
    let core = query.features;
    Features {
        core,
        vulkan12,
        vulkan13,
    }
}

pub(super) fn queue_families(
    instance: &ash::Instance,
    raw: vk::PhysicalDevice,
) -> Vec<vk::QueueFamilyProperties> {
    // SAFETY: `raw` comes from `instance`.
    unsafe { instance.get_physical_device_queue_family_properties(raw) }
}

fn extensions(instance: &ash::Instance, raw: vk::PhysicalDevice) -> Result<Vec<String>> {
    // SAFETY: `raw` comes from `instance`.
    let found = unsafe { instance.enumerate_device_extension_properties(raw) }
        .map_err(failure::of("vkEnumerateDeviceExtensionProperties"))?;
    Ok(found
        .iter()
        .map(|one| text(one.extension_name_as_c_str()))
        .collect())
}

/// The one of `found` that `choice` means.
pub(super) fn choose(found: Vec<Candidate>, choice: &DeviceChoice) -> Result<Candidate> {
    if found.is_empty() {
        return Err(no_device(format!(
            "the Vulkan loader knows no device; {GET_A_DRIVER}"
        )));
    }
    let listed: Vec<String> = found
        .iter()
        .map(|one| format!("{} \"{}\"", one.info.index, one.info.name))
        .collect();
    let mut matching: Vec<Candidate> = found
        .into_iter()
        .filter(|one| matches(choice, &one.info))
        .collect();
    // Stable: among equals the loader's order decides. Only `Auto` prefers a kind, and the faster software.
    matching.sort_by_key(|one| {
        (
            !one.info.usable,
            (*choice == DeviceChoice::Auto).then_some((one.info.kind, is_slow(&one.info))),
        )
    });
    match matching.into_iter().next() {
        None => Err(no_device(format!(
            "{choice:?} matches none of {}",
            listed.join(", ")
        ))),
        Some(one) if one.info.usable => Ok(one),
        Some(one) => Err(Error::Requirement {
            device: one.info.name,
            missing: one.info.missing.join(", "),
        }),
    }
}

/// SwiftShader takes 2 to 4 times as long as llvmpipe for our passes, and the loader often lists it first.
fn is_slow(info: &DeviceInfo) -> bool {
    info.name.contains("SwiftShader")
}

fn matches(choice: &DeviceChoice, info: &DeviceInfo) -> bool {
    match choice {
        DeviceChoice::Auto => true,
        DeviceChoice::Index(index) => info.index == *index,
        DeviceChoice::Name(part) => info.name.to_lowercase().contains(&part.to_lowercase()),
    }
}

fn kind(raw: vk::PhysicalDeviceType) -> DeviceKind {
    match raw {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
        _ => DeviceKind::Other,
    }
}

fn driver_text(driver: &vk::PhysicalDeviceDriverProperties<'_>, packed: u32) -> String {
    let (name, details) = (
        text(driver.driver_name_as_c_str()),
        text(driver.driver_info_as_c_str()),
    );
    match (name.is_empty(), details.is_empty()) {
        (true, _) => version(packed),
        (false, true) => format!("{name} {}", version(packed)),
        (false, false) => format!("{name}, {details}"),
    }
}

fn text<E>(name: std::result::Result<&CStr, E>) -> String {
    name.map(|name| CString::from(name).to_string_lossy().into_owned())
        .unwrap_or_default()
}
