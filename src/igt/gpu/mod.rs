//! Tables on a device: built there by compute passes, and asked there.
//!
//! Builds and lookups that have no room in a device's storage buffers go in portions and pages.
//!
//! In: what the CPU build takes, and a [`crate::gpu::Context`]. Out: the same [`Tables`](super::Tables), byte for byte.

mod build;
mod cover;
mod gutter;
mod pages;
mod portions;
mod query;
mod query_paged;
mod scan;

pub use build::{Timed, build, build_in_portions};
pub use query::{query, repeat};
pub use query_paged::query_in_pages;

/// Workgroups for `threads` threads of `size` each, spread over two dimensions (the first is limited to 65535).
pub(super) fn groups(threads: u64, size: u64) -> [u32; 3] {
    let groups = threads.div_ceil(size).max(1);
    let x = groups.min(32_768);
    [x as u32, groups.div_ceil(x) as u32, 1]
}
