//! `--device`: where to compute.
//!
//! In: `auto`, `cpu`, an index or part of a name. Out: [`Device`]. `auto` takes a device when there is one and says so
//! when there is none, or when it has no room for a mesh; a device that was named must be there and have room.

#[cfg(feature = "gpu")]
use invertex::Error;
use invertex::Result;
use invertex::asset::Processor;
#[cfg(feature = "gpu")]
use invertex::gpu::{Context, ContextOptions, DeviceChoice};

use super::Common;
#[cfg(feature = "gpu")]
use super::note;

/// Where to compute.
pub(super) enum Device {
    /// The reference implementation.
    Cpu,
    /// A Vulkan device that was asked for.
    #[cfg(feature = "gpu")]
    Gpu(Context),
    /// A Vulkan device that was found: what it has no room for goes to the processor.
    #[cfg(feature = "gpu")]
    Found(Context),
}

impl Device {
    /// The device that `common` means.
    ///
    /// # Errors
    /// Those of [`Context::new`] where a device was named that is absent or lacks something.
    #[cfg(feature = "gpu")]
    pub(super) fn open(common: &Common) -> Result<Self> {
        if common.device.eq_ignore_ascii_case("cpu") {
            return Ok(Device::Cpu);
        }
        let Ok(choice) = common.device.parse::<DeviceChoice>();
        let automatic = choice == DeviceChoice::Auto;
        match Context::new(&ContextOptions {
            device: choice,
            validation: validation(),
        }) {
            Ok(context) => {
                tracing::info!("device: {}", context.info().name);
                Ok(if automatic {
                    Device::Found(context)
                } else {
                    Device::Gpu(context)
                })
            }
            Err(error @ (Error::NoDevice { .. } | Error::Requirement { .. })) if automatic => {
                note(common, &format!("{error}; using the processor"));
                Ok(Device::Cpu)
            }
            Err(error) => Err(error),
        }
    }

    /// Without Vulkan compiled in there is only the processor.
    #[cfg(not(feature = "gpu"))]
    pub(super) fn open(common: &Common) -> Result<Self> {
        if ["cpu", "auto"].contains(&common.device.to_ascii_lowercase().as_str()) {
            return Ok(Device::Cpu);
        }
        let reason =
            "this invertex was built without the feature \"gpu\"; use `--device cpu`".to_owned();
        Err(invertex::Error::NoDevice { reason })
    }

    /// The context, where it is a Vulkan device.
    #[cfg(feature = "gpu")]
    pub(super) fn context(&self) -> Option<&Context> {
        match self {
            Device::Cpu => None,
            Device::Gpu(context) | Device::Found(context) => Some(context),
        }
    }

    /// Where a build makes its tables.
    pub(super) fn processor(&self) -> Processor<'_> {
        match self {
            Device::Cpu => Processor::Cpu,
            #[cfg(feature = "gpu")]
            Device::Gpu(context) => Processor::Device(context),
            #[cfg(feature = "gpu")]
            Device::Found(context) => Processor::Preferably(context),
        }
    }

    /// Name for results: `cpu`, or the device's.
    pub(super) fn name(&self) -> String {
        match self {
            Device::Cpu => "cpu".to_owned(),
            #[cfg(feature = "gpu")]
            Device::Gpu(context) | Device::Found(context) => context.info().name.clone(),
        }
    }

    /// Complaints of the validation layer, which are our own bugs.
    pub(super) fn check(&self) {
        #[cfg(feature = "gpu")]
        if let Some(context) = self.context() {
            for message in context.validation_messages() {
                tracing::error!("validation: {message}");
            }
        }
    }
}

/// `INVERTEX_VALIDATION=1` loads the validation layer, for reports of bugs.
#[cfg(feature = "gpu")]
fn validation() -> bool {
    std::env::var_os("INVERTEX_VALIDATION").is_some_and(|value| value == "1")
}
