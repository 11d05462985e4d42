//! What cannot be had is a typed error that names it: devices, requirements, memory, sizes.
#![cfg(feature = "gpu")]
#![allow(unsafe_code, reason = "the tests hand over a device that they made")]

mod devices;
mod plain;

use devices::on_every_device;
use invertex::Error;
use invertex::gpu::shaders::test_add::{Bindings, Push, Shader};
use invertex::gpu::{
    BufferKind, Context, ContextOptions, DeviceChoice, Features, ImageOptions, requirements, vk,
};

#[test]
fn a_device_that_is_not_there_is_named() {
    for choice in ["no such card", "4711"] {
        let options = ContextOptions {
            device: choice.parse().unwrap(),
            validation: false,
        };
        let error = Context::new(&options).expect_err("no such device");
        assert!(matches!(error, Error::NoDevice { .. }), "{error}");
        assert!(
            error.to_string().contains(choice) && error.exit_code() == 4,
            "{error}"
        );
    }
}

#[test]
fn choices_are_read_and_found() {
    assert_eq!("AUTO".parse(), Ok(DeviceChoice::Auto));
    assert_eq!("1".parse(), Ok(DeviceChoice::Index(1)));
    assert_eq!(
        "SwiftShader".parse(),
        Ok(DeviceChoice::Name("SwiftShader".to_owned()))
    );
    for device in devices::usable() {
        let part: String = device
            .name
            .chars()
            .take(6)
            .collect::<String>()
            .to_uppercase();
        let found = Context::new(&ContextOptions {
            device: DeviceChoice::Name(part),
            validation: false,
        })
        .unwrap();
        assert_eq!(found.info().name[..6], device.name[..6]);
        assert!(
            device.missing.is_empty() && !device.driver.is_empty() && device.api.starts_with("1."),
            "{device:?}"
        );
    }
    let auto = Context::new(&ContextOptions::default()).unwrap();
    let best = devices::usable()
        .into_iter()
        .map(|device| device.kind)
        .min();
    assert_eq!(
        Some(auto.info().kind),
        best,
        "automatic choice takes the best kind"
    );
}

#[test]
fn a_foreign_device_is_held_to_the_requirements() {
    for index in 0..devices::usable().len() {
        let plain = plain::Plain::new(index);
        let mut foreign = plain.foreign();
        foreign.features = Features::default();
        foreign.features.core.robust_buffer_access = vk::TRUE;
        foreign.api_version = vk::API_VERSION_1_2;
        // SAFETY: the handles belong together and outlive the call.
        let error = unsafe { Context::from_foreign(foreign) }.expect_err("features are missing");
        let Error::Requirement { missing, .. } = &error else {
            panic!("{error}")
        };
        for name in [
            "dynamicRendering",
            "synchronization2",
            "maintenance4",
            "Vulkan 1.3",
        ] {
            assert!(missing.contains(name), "{name} in {missing}");
        }
        assert!(!missing.contains("robustBufferAccess"), "{missing}");
        // The same device, declared as it is, will do.
        // SAFETY: as above; the context goes before the device.
        let context = unsafe { Context::from_foreign(plain.foreign()) }.unwrap();
        assert!(context.info().usable);
    }
}

#[test]
fn requirements_are_data() {
    let names: Vec<&str> = requirements()
        .features
        .iter()
        .map(|feature| feature.name)
        .collect();
    assert!(names.contains(&"synchronization2"));
    assert_eq!(
        requirements().features().vulkan13.synchronization2,
        vk::TRUE
    );
    assert_eq!(requirements().api_version, vk::API_VERSION_1_3);
    assert!(requirements().limits.iter().all(|limit| limit.at_least > 0));
}

#[test]
fn absurd_sizes_are_typed_errors() {
    on_every_device(|ctx| {
        let limit = ctx.info().limits.storage_buffer_bytes;
        let error = ctx.storage("list", limit + 1).expect_err("over the range");
        assert!(
            matches!(error, Error::Capacity { need, have, .. } if need == limit + 1 && have == limit),
            "{error}"
        );
        assert!(error.to_string().contains("list"), "{error}");
        for bytes in [1 << 46, u64::MAX - 7, u64::MAX] {
            let error = ctx
                .buffer("everything", bytes, BufferKind::Readback)
                .expect_err("no such memory");
            assert!(
                matches!(error, Error::OutOfMemory { bytes: asked, .. } if asked >= bytes),
                "{error}"
            );
            assert!(error.to_string().contains("everything"), "{error}");
        }
        let usage = vk::ImageUsageFlags::STORAGE;
        let error = ctx
            .target("wall", 1 << 20, 1, vk::Format::R32_UINT, usage)
            .expect_err("too wide");
        assert!(
            matches!(
                error,
                Error::Capacity {
                    need: 1_048_576,
                    ..
                }
            ),
            "{error}"
        );
        let error = ctx
            .target("nothing", 0, 1, vk::Format::R32_UINT, usage)
            .expect_err("empty");
        assert!(matches!(error, Error::Capacity { need: 0, .. }), "{error}");
        let error = ctx
            .target("odd", 4, 4, vk::Format::D32_SFLOAT, usage)
            .expect_err("no depth storage");
        assert!(matches!(error, Error::Requirement { .. }), "{error}");
        let options = ImageOptions {
            size: [2, 2],
            layers: None,
            levels: 1,
            format: vk::Format::R8G8B8A8_UNORM,
            usage: vk::ImageUsageFlags::SAMPLED,
        };
        let error = ctx
            .texture("short", &options, &[&[0; 15]])
            .expect_err("a byte is missing");
        assert!(error.to_string().contains("16"), "{error}");
    });
}

#[test]
fn recording_errors_come_out_of_run() {
    on_every_device(|ctx| {
        let buffer = ctx.upload("words", &[1_u32; 4]).unwrap();
        let bound = ctx
            .compute::<Shader>()
            .unwrap()
            .bind(&Bindings {
                a: &buffer,
                b: &buffer,
                sum: &buffer,
            })
            .unwrap();
        let push = Push {
            count: 0,
            offset: 0,
        };
        let most = ctx.info().limits.workgroups[0];
        let mut recorder = ctx.recorder("too many groups").unwrap();
        if let Some(groups) = most.checked_add(1) {
            recorder.dispatch(&bound, &push, [groups, 1, 1]);
            assert!(matches!(ctx.run(recorder), Err(Error::Capacity { .. })));
        }
        let mut recorder = ctx.recorder("counts beyond the end").unwrap();
        recorder.dispatch_indirect(&bound, &push, &buffer, 8);
        assert!(matches!(
            ctx.run(recorder),
            Err(Error::Capacity {
                need: 20,
                have: 16,
                ..
            })
        ));
        let mut recorder = ctx.recorder("copy beyond the end").unwrap();
        recorder.copy_range(&buffer, 12, &buffer, 0, 8);
        assert!(matches!(
            ctx.run(recorder),
            Err(Error::Capacity {
                need: 20,
                have: 16,
                ..
            })
        ));
    });
}
