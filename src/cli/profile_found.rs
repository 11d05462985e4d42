//! What `profile` may go through, and everything that it found.

use invertex::measure::{CutRun, EqualFlip, MemoryRow, Run, Sweep};
use invertex::render::Clock;
use serde::Serialize;

use super::{Common, note};

/// A [`Sweep`], as a flag's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum SweepChoice {
    Hash,
    Layout,
    Lod,
    Distance,
    Filter,
    Cuts,
}

impl SweepChoice {
    /// None for cuts, which are no drawings of levels.
    pub(super) fn sweep(self) -> Option<Sweep> {
        match self {
            SweepChoice::Hash => Some(Sweep::Hash),
            SweepChoice::Layout => Some(Sweep::Layout),
            SweepChoice::Lod => Some(Sweep::Lod),
            SweepChoice::Distance => Some(Sweep::Distance),
            SweepChoice::Filter => Some(Sweep::Filter),
            SweepChoice::Cuts => None,
        }
    }
}

/// Everything a profile found.
#[derive(Serialize)]
pub(super) struct Report {
    pub(super) device: String,
    pub(super) clock: Option<Clock>,
    pub(super) path: &'static str,
    pub(super) shading: &'static str,
    pub(super) size: [u32; 2],
    pub(super) frames: u32,
    pub(super) warm_up: u32,
    pub(super) runs: Vec<Run>,
    pub(super) memory: Vec<MemoryRow>,
    pub(super) cuts: Vec<CutRun>,
    pub(super) equal_flip: Vec<EqualFlip>,
    pub(super) outputs: Vec<String>,
    pub(super) warnings: Vec<String>,
}

impl Report {
    /// What a reader of the numbers should know.
    pub(super) fn remark(&self, common: &Common) {
        for warning in &self.warnings {
            note(common, warning);
        }
        if self.clock == Some(Clock::Wall) {
            let text = "times are the host's wall clock, not a device's time stamps";
            note(common, text);
        }
        let fewest = self.runs.iter().map(|run| run.frames).min().unwrap_or(0);
        if fewest < self.frames as usize {
            let text = format!(
                "{fewest} frames of some rows instead of {}: they would have taken more than a second; --frames N \
                 draws N whatever they take",
                self.frames
            );
            note(common, &text);
        }
    }
}
