//! Tables on a device: built there by compute passes, and asked there.
//!
//! In: what the CPU build takes, and a [`crate::gpu::Context`]. Out: the same [`Tables`](super::Tables), byte for byte.

mod build;
mod cover;
mod gutter;
mod query;

mod scan;

pub use build::{Timed, build};
pub use query::{query, repeat};

/// Workgroups for `threads` threads of `size` each, spread over two dimensions (the first is limited to 65535).
pub(super) fn groups(threads: u64, size: u64) -> [u32; 3] {
    let groups = threads.div_ceil(size).max(1);
    let x = groups.min(32_768);
    [x as u32, groups.div_ceil(x) as u32, 1]
}
