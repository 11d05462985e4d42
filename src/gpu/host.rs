//! The Vulkan loader and an instance. In: whether to validate. Out: a [`Host`], which lists the physical devices; or
//! [`Error::NoDevice`] with how to get a driver.

use super::debug::Messenger;
use super::device::{Candidate, DeviceInfo, candidate};
use super::requirements::requirements;
use crate::{Error, Result};
use ash::vk;
use std::ffi::CStr;

pub(super) const GET_A_DRIVER: &str = "install a Vulkan driver (Debian and Ubuntu: `apt install libvulkan1 mesa-vulkan-drivers`, \
                            which also brings the software device llvmpipe), or use `--device cpu`";
const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// The loader with an instance of our own; whatever was made from the instance goes before it.
pub(super) struct Host {
    pub(super) entry: ash::Entry,
    pub(super) instance: ash::Instance,
    pub(super) debug_utils: bool,
    messenger: Option<Messenger>,
}

/// Every Vulkan device of this machine. [`Error::NoDevice`] when there is no loader or no driver.
pub fn devices() -> Result<Vec<DeviceInfo>> {
    let host = Host::new(false)?;
    Ok(host
        .candidates()?
        .into_iter()
        .map(|candidate| candidate.info)
        .collect())
}

impl Host {
    pub(super) fn new(validation: bool) -> Result<Self> {
        // SAFETY: loading the system's Vulkan loader runs its initialisers, which is what asking for Vulkan means.
        let entry = unsafe { ash::Entry::load() }.map_err(|error| {
            no_device(format!(
                "the Vulkan loader cannot be loaded ({error}); {GET_A_DRIVER}"
            ))
        })?;
        // SAFETY: plain queries.
        let (extensions, layers) = unsafe {
            (
                entry
                    .enumerate_instance_extension_properties(None)
                    .map_err(no_instance)?,
                entry
                    .enumerate_instance_layer_properties()
                    .map_err(no_instance)?,
            )
        };
        if validation
            && !layers
                .iter()
                .any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER))
        {
            let missing = "VK_LAYER_KHRONOS_validation (Debian and Ubuntu: `apt install vulkan-validationlayers`)";
            return Err(Error::Requirement {
                device: "the Vulkan loader".to_owned(),
                missing: missing.to_owned(),
            });
        }
        let debug_name = ash::ext::debug_utils::NAME;
        let has_debug = extensions
            .iter()
            .any(|one| one.extension_name_as_c_str() == Ok(debug_name));
        // With validation on, the layer provides the extension.
        let debug_utils = has_debug || validation;
        let instance = create_instance(&entry, debug_utils, validation)?;
        // From here on the instance destroys itself when something fails.
        let mut host = Host {
            entry,
            instance,
            debug_utils,
            messenger: None,
        };
        if validation {
            host.messenger = Some(Messenger::new(&host.entry, &host.instance)?);
        }
        Ok(host)
    }

    /// What the validation layer has said so far.
    pub(super) fn messages(&self) -> Vec<String> {
        self.messenger
            .as_ref()
            .map(Messenger::messages)
            .unwrap_or_default()
    }

    pub(super) fn candidates(&self) -> Result<Vec<Candidate>> {
        // SAFETY: the instance is alive.
        let physical =
            unsafe { self.instance.enumerate_physical_devices() }.map_err(no_instance)?;
        physical
            .into_iter()
            .enumerate()
            .map(|(index, raw)| candidate(&self.instance, index, raw))
            .collect()
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        self.messenger = None;
        // SAFETY: nothing made from the instance is left.
        unsafe { self.instance.destroy_instance(None) };
    }
}

fn create_instance(
    entry: &ash::Entry,
    debug_utils: bool,
    validation: bool,
) -> Result<ash::Instance> {
    let application = vk::ApplicationInfo::default()
        .application_name(c"invertex")
        .engine_name(c"invertex")
        .api_version(requirements().api_version);
    let mut extensions = Vec::new();
    let mut layers = Vec::new();
    if debug_utils {
        extensions.push(ash::ext::debug_utils::NAME.as_ptr());
    }
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut synchronization =
        vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut info = vk::InstanceCreateInfo::default().application_info(&application);
    if validation {
        layers.push(VALIDATION_LAYER.as_ptr());
        extensions.push(ash::ext::validation_features::NAME.as_ptr());
        info = info.push_next(&mut synchronization);
    }
    let info = info
        .enabled_extension_names(&extensions)
        .enabled_layer_names(&layers);
    // SAFETY: the names are static and everything `info` points to outlives the call.
    unsafe { entry.create_instance(&info, None) }.map_err(no_instance)
}

pub(super) fn no_device(reason: String) -> Error {
    Error::NoDevice { reason }
}

fn no_instance(code: vk::Result) -> Error {
    no_device(format!(
        "the Vulkan loader has no driver that works ({code:?}); {GET_A_DRIVER}"
    ))
}
