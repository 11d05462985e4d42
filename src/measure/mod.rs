//! Numbers about results: how two pictures differ, how long something took.
//!
//! In: finished pictures, samples of time, or (the profile) a built model. Out: plain serialisable figures.

mod compare;
mod cuts;
mod displaced;
mod equal;
mod fetches;
mod flip;
mod folder;
mod lookups;
mod memory;
mod moving_light;
mod picture;
mod plan;
mod profile;
mod recovered;
mod run;
mod table_figures;
mod timing;
mod trace;

pub use compare::{Comparison, Region, compare, difference_image};
pub use cuts::{CutRanges, CutRun};
pub use displaced::{Displacements, displaced};
pub use equal::{EqualFlip, WithColour, at_equal_flip};
pub use fetches::{FetchCounts, fetches_of_uv};
pub use folder::{FolderComparison, PairComparison, compare_folders};
pub use memory::{MemoryRow, memory};
pub use moving_light::{Lit, MovingLight, OFF_EYE, in_grey};
pub use picture::Picture;
pub use plan::{Drawing, Ranges, Sweep, Variant, plan};
pub use profile::{Bench, ProfileSettings, Sitter, WHOLE};
pub use recovered::{AssessSettings, Assessment, Heat, Rating, assess, assess_in_cage};
pub use run::Run;
pub use timing::{PassStatistics, TimeStatistics, pass_statistics};
pub use trace::chrome_trace;
