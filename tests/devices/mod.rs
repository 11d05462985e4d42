//! The devices that the tests of `gpu/` run on. In: a test. Out: the test run on every usable device of this machine,
//! with validation and synchronization validation on, and no message from them at the end.
#![allow(dead_code, reason = "each test file uses a part")]

use invertex::gpu::{Context, ContextOptions, DeviceChoice, DeviceInfo, devices};

/// The usable devices; a machine without any fails the test.
pub(crate) fn usable() -> Vec<DeviceInfo> {
    let found = devices().expect("a Vulkan driver: see tools/setup");
    let usable: Vec<DeviceInfo> = found.into_iter().filter(|device| device.usable).collect();
    assert!(
        !usable.is_empty(),
        "no usable Vulkan device: see tools/setup"
    );
    usable
}

/// A validating context on a device.
pub(crate) fn context(device: &DeviceInfo) -> Context {
    let options = ContextOptions {
        device: DeviceChoice::Index(device.index),
        validation: true,
    };
    Context::new(&options).expect("a context with validation")
}

/// Runs `test` on every usable device; fails on any validation message and on any leaked allocation.
pub(crate) fn on_every_device(test: impl Fn(&Context)) {
    for device in usable() {
        let context = context(&device);
        test(&context);
        assert_eq!(
            context.validation_messages(),
            Vec::<String>::new(),
            "validation on {}",
            device.name
        );
        assert_eq!(context.allocations(), [], "leaked on {}", device.name);
    }
}
