//! From Vulkan result codes to the crate's errors. In: a `vk::Result` and the call it came from. Out: an [`Error`].

use crate::Error;
use ash::vk;

/// Turns the result code of `call` into an error, for `map_err`.
pub(super) fn of(call: &'static str) -> impl Fn(vk::Result) -> Error {
    move |code| match code {
        vk::Result::ERROR_DEVICE_LOST => Error::DeviceLost {
            during: call.to_owned(),
        },
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => out_of_memory("device", call, 0),
        vk::Result::ERROR_OUT_OF_HOST_MEMORY => out_of_memory("host", call, 0),
        _ => Error::Vulkan {
            call,
            code: format!("{code:?}"),
        },
    }
}

/// As [`of`], for a call that asked for `bytes` of memory for `what`.
pub(super) fn allocating(
    call: &'static str,
    what: &str,
    bytes: u64,
) -> impl Fn(vk::Result) -> Error {
    let what = what.to_owned();
    move |code| match code {
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => out_of_memory("device", &what, bytes),
        vk::Result::ERROR_OUT_OF_HOST_MEMORY => out_of_memory("host", &what, bytes),
        other => of(call)(other),
    }
}

pub(super) fn out_of_memory(kind: &'static str, what: &str, bytes: u64) -> Error {
    Error::OutOfMemory {
        kind,
        what: what.to_owned(),
        bytes,
    }
}
