//! A function of the user's own, in GLSL: `vec3 igt_procedural(vec3 position, vec3 normal, float time)`.
//!
//! In: a text. Out: [`Procedural`], which a device compiles when a picture is made ready for it (`src/render/function.rs`).

use crate::scene::read_file;
use crate::{Error, Result};
use std::path::Path;

/// Longest text, bytes.
const MOST: usize = 1 << 20;

/// A text that defines `igt_procedural`, and what errors call it.
///
/// `position` is a point of the reference at rest, in the file's unit; `normal` the reference's unit normal there; `time`
/// seconds. The result is a linear colour. What is in `glsl/common/solid.glsl` may be called: `igt_noise`, `igt_wood` ...
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Procedural {
    /// Name of the file.
    pub name: String,
    /// GLSL.
    pub text: String,
}

impl Procedural {
    /// Reads a file. It is compiled when a renderer is made.
    ///
    /// # Errors
    /// [`Error::Io`] where it cannot be read; [`Error::Input`] where it is no text, or longer than 1 MiB.
    pub fn load(path: &Path) -> Result<Procedural> {
        let name = path.display().to_string();
        let bytes = read_file(path)?;
        let fault = |reason: &str| Error::input(&name, "GLSL", reason);
        if bytes.len() > MOST {
            return Err(fault("is longer than 1 MiB"));
        }
        let text = String::from_utf8(bytes).map_err(|_| fault("is not UTF-8"))?;
        if text.contains('\0') {
            return Err(fault("holds a zero byte"));
        }
        Ok(Procedural { name, text })
    }
}
