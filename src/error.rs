//! The one error type. A variant per stage of the pipeline, each carrying the offender; the command line maps
//! variants to exit codes (see [`Error::exit_code`]). Our own bugs panic; a caller's input never does.

use std::path::PathBuf;

/// What every fallible function of the crate returns.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong because of input, environment or device.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        #[source]
        source: std::io::Error,
    },
    /// A file holds something that cannot be used: names the file, the element in it and the reason.
    #[error("{file}: {element}: {reason}")]
    Input {
        /// The file (or a name for bytes that came from memory).
        file: String,
        /// The element, as a JSON-pointer-like path (`accessors[3]`, `meshes[0].primitives[1]`).
        element: String,
        /// Why it cannot be used, and what to do.
        reason: String,
    },
    /// A primary parameterization cannot be had from this mesh.
    #[error("mesh \"{mesh}\": {reason}")]
    Parameterization {
        /// Name of the mesh.
        mesh: String,
        /// Why, and what to do.
        reason: String,
    },
    /// A parameter given by the caller is out of its range.
    #[error("{option}: {reason}")]
    Option {
        /// The parameter, as the command line spells it (`--hash`).
        option: &'static str,
        /// What is wrong with it and what is allowed.
        reason: String,
    },
    /// No Vulkan device that can be used.
    #[error("no usable Vulkan device: {reason}")]
    NoDevice {
        /// What was looked for and what was found; how to get one.
        reason: String,
    },
    /// A device lacks something that [`requirements`](crate) names.
    #[error("device \"{device}\" lacks {missing}")]
    Requirement {
        /// Name of the device.
        device: String,
        /// The features, extensions or limits, by their Vulkan names.
        missing: String,
    },
    /// The device was lost in the middle of work.
    #[error("the Vulkan device was lost during {during}")]
    DeviceLost {
        /// The pass or call.
        during: String,
    },
    /// Memory of the device or the host ran out.
    #[error("out of {kind} memory for {what} ({bytes} bytes)")]
    OutOfMemory {
        /// `device` or `host`.
        kind: &'static str,
        /// What the memory was for.
        what: String,
        /// How much was asked for.
        bytes: u64,
    },
    /// Something is larger than a table, a buffer or a format can hold.
    #[error("{what}: {need} needed, {have} available")]
    Capacity {
        /// What is too large.
        what: String,
        /// What is needed, in the unit named by `what`.
        need: u64,
        /// What there is.
        have: u64,
    },
    /// Another Vulkan call failed.
    #[error("{call} failed: {code}")]
    Vulkan {
        /// The call.
        call: &'static str,
        /// The Vulkan result code, by name.
        code: String,
    },
    /// A comparison or a threshold failed: not an error of input, exit code 5.
    #[error("{0}")]
    Threshold(String),
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
}

impl Error {
    /// The exit code the command line gives: 2 usage, 3 bad input, 4 no usable device, 5 threshold.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Option { .. } => 2,
            Error::Io { .. }
            | Error::Input { .. }
            | Error::Parameterization { .. }
            | Error::Capacity { .. } => 3,
            Error::NoDevice { .. }
            | Error::Requirement { .. }
            | Error::DeviceLost { .. }
            | Error::OutOfMemory { .. }
            | Error::Vulkan { .. } => 4,
            Error::Threshold(_) => 5,
            Error::Cancelled => 130,
        }
    }

    /// An [`Error::Input`] from its three parts.
    pub fn input(
        file: impl Into<String>,
        element: impl Into<String>,
        reason: impl Into<String>,
    ) -> Self {
        Error::Input {
            file: file.into(),
            element: element.into(),
            reason: reason.into(),
        }
    }

    /// An [`Error::Io`] about `path`.
    pub fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Error::Io {
            path: path.into(),
            source,
        }
    }
}
