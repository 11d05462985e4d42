//! `doctor`: which devices there are, what they lack, and how to get it.

use invertex::{Error, Result};
use serde::Serialize;

use super::Common;
use super::print::{self, Table};

/// Say which devices there are, what is missing, and how to get it.
///
/// Each usable device is opened once, so that "usable" means that it works. Exit code 4 when none does;
/// `--device cpu` needs none.
#[derive(clap::Args)]
#[command(after_help = "\
JSON: version, features{}, devices[]: index, name, driver, api, kind, usable, missing[], limits{}; advice[].

Examples:
  invertex doctor
  invertex doctor --json
  VK_DRIVER_FILES=/usr/share/vulkan/icd.d/lvp_icd.x86_64.json invertex doctor     only this driver")]
pub(super) struct Doctor {}

#[derive(Serialize)]
struct Report {
    version: &'static str,
    features: Features,
    devices: Vec<Found>,
    advice: Vec<String>,
}

#[derive(Serialize)]
struct Features {
    gpu: bool,
    compile_shaders: bool,
}

#[cfg(feature = "gpu")]
type Found = invertex::gpu::DeviceInfo;
#[cfg(not(feature = "gpu"))]
type Found = ();

impl Doctor {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        let (devices, advice) = examine();
        let usable = count_usable(&devices);
        let features = Features {
            gpu: cfg!(feature = "gpu"),
            compile_shaders: cfg!(feature = "compile-shaders"),
        };
        let report = Report {
            version: env!("CARGO_PKG_VERSION"),
            features,
            devices,
            advice,
        };
        if common.json {
            print::json(&report)?;
        } else {
            print::text(&readable(&report))?;
        }
        if usable > 0 {
            return Ok(());
        }
        let reason = report.advice.join("; ");
        Err(Error::NoDevice { reason })
    }
}

#[cfg(feature = "gpu")]
fn count_usable(devices: &[Found]) -> usize {
    devices.iter().filter(|device| device.usable).count()
}

#[cfg(not(feature = "gpu"))]
fn count_usable(devices: &[Found]) -> usize {
    devices.len()
}

#[cfg(feature = "gpu")]
fn examine() -> (Vec<Found>, Vec<String>) {
    use invertex::gpu::{Context, ContextOptions, DeviceChoice, devices};
    let mut advice = Vec::new();
    let mut found = match devices() {
        Ok(found) => found,
        Err(Error::NoDevice { reason }) => return (Vec::new(), vec![reason]),
        Err(error) => return (Vec::new(), vec![error.to_string()]),
    };
    for device in found.iter_mut().filter(|device| device.usable) {
        let options = ContextOptions {
            device: DeviceChoice::Index(device.index),
            validation: false,
        };
        if let Err(error) = Context::new(&options) {
            device.usable = false;
            device.missing.push(format!("it cannot be opened: {error}"));
        }
    }
    for device in found.iter().filter(|device| !device.usable) {
        advice.push(format!(
            "{} lacks {}: update its driver, or choose another with --device",
            device.name,
            device.missing.join(", ")
        ));
    }
    if count_usable(&found) == 0 {
        advice.push(
            "install a software device (Debian and Ubuntu: `apt install libvulkan1 mesa-vulkan-drivers`), or use \
             `--device cpu`"
                .to_owned(),
        );
    }
    (found, advice)
}

#[cfg(not(feature = "gpu"))]
fn examine() -> (Vec<Found>, Vec<String>) {
    (
        Vec::new(),
        vec![
            "this invertex was built without the feature \"gpu\"; `--device cpu` works".to_owned(),
        ],
    )
}

fn readable(report: &Report) -> String {
    let mut text = format!("invertex {}\n\n", report.version);
    text += &device_table(&report.devices);
    for advice in &report.advice {
        text += &format!("\n{advice}\n");
    }
    text
}

#[cfg(feature = "gpu")]
fn device_table(devices: &[Found]) -> String {
    if devices.is_empty() {
        return "No Vulkan device.\n".to_owned();
    }
    let mut table = Table::new(&["index", "device", "driver", "Vulkan", "usable"]);
    for device in devices {
        let usable = if device.usable {
            "yes".to_owned()
        } else {
            format!("no: {}", device.missing.join(", "))
        };
        table.row([
            device.index.to_string(),
            device.name.clone(),
            device.driver.clone(),
            device.api.clone(),
            usable,
        ]);
    }
    table.text()
}

#[cfg(not(feature = "gpu"))]
fn device_table(_devices: &[Found]) -> String {
    let mut table = Table::new(&["device"]);
    table.row(["cpu"]);
    table.text()
}
