//! Numbers about results: how two pictures differ, how long something took.
//!
//! In: finished pictures or samples of time. Out: plain serialisable figures. Nothing here draws or builds.

mod compare;
mod flip;
mod folder;
mod picture;
mod timing;

pub use compare::{Comparison, Region, compare, difference_image};
pub use folder::{FolderComparison, PairComparison, compare_folders};
pub use picture::Picture;
pub use timing::TimeStatistics;
