//! A user's function in the shaders that shade: [`Procedural`](crate::attribute::Procedural) on a device.
//!
//! In: the attributes of a picture. Out: a variant of a shading pipeline, with the function compiled into it where there is
//! one. The processor has no compiler for it and says so.

use crate::attribute::AttributeSet;
#[cfg(feature = "gpu")]
use crate::gpu::{Variant, vk};
use crate::{Error, Result};

/// The variant of the shading stage whose source is at `path` below `glsl/`; no constant is given a value.
///
/// # Errors
/// [`Error::Input`] where the user's function does not compile.
#[cfg(feature = "gpu")]
pub(super) fn variant(
    attributes: &AttributeSet,
    stage: vk::ShaderStageFlags,
    path: &str,
) -> Result<Variant> {
    let code = code(attributes, path)?;
    Ok(Variant {
        constants: Vec::new(),
        code: code.map(|code| (stage, code)),
    })
}

#[cfg(feature = "compile-shaders")]
fn code(attributes: &AttributeSet, path: &str) -> Result<Option<Vec<u8>>> {
    const BEFORE: &str = "#version 460\n#extension GL_GOOGLE_include_directive : require\n\
                          #include \"common/solid.glsl\"\n\
                          vec3 igt_procedural(vec3 position, vec3 normal, float time);";
    const BEHIND: &str = "void main() { vec3 color = igt_procedural(vec3(0.0), vec3(0.0), 0.0); }";
    let Some(function) = attributes.procedural() else {
        return Ok(None);
    };
    let user = crate::gpu::UserText {
        name: &function.name,
        text: &function.text,
        before: BEFORE,
        behind: BEHIND,
    };
    user.behind(path, "IGT_PROCEDURAL").map(Some)
}

#[cfg(all(feature = "gpu", not(feature = "compile-shaders")))]
fn code(attributes: &AttributeSet, _: &str) -> Result<Option<Vec<u8>>> {
    match attributes.procedural() {
        None => Ok(None),
        Some(_) => Err(refused(
            "this invertex cannot compile it: build it with the feature compile-shaders",
        )),
    }
}

/// Refuses to draw a user's function on the processor.
pub(super) fn not_here(attributes: &AttributeSet) -> Result<()> {
    match attributes.procedural() {
        None => Ok(()),
        Some(_) => Err(refused(
            "a function in GLSL runs on a Vulkan device only: name one with --device, see `invertex doctor`",
        )),
    }
}

fn refused(reason: &str) -> Error {
    Error::Option {
        option: "--procedural",
        reason: reason.into(),
    }
}
