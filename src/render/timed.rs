//! Frames drawn again and again for their times, none of which is brought back.
//!
//! In: a [`Renderer`], a camera, how many frames. Out: [`TimedFrames`]: the time of every frame and of each of its passes.
//! On a device these are its own time stamps, without submission and read-back; on the processor the wall clock.
//! Nothing is counted while time is taken: counters come from [`Renderer::draw`], of another run.

use super::camera::Camera;
use super::draw::ViewConstants;
#[cfg(feature = "gpu")]
use super::renderer::forward_can;
use super::renderer::{Options, Processor, Renderer, flags};
use crate::Result;
#[cfg(feature = "gpu")]
use crate::gpu::Timings;
use serde::Serialize;
use std::time::Instant;

/// What the times were taken with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Clock {
    /// Time stamps of the device, before the first pass to after the last.
    #[serde(rename = "device time stamps")]
    Device,
    /// The host's clock round the work.
    #[serde(rename = "wall clock")]
    Wall,
}

/// The time of one frame, nanoseconds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameTime {
    /// From the beginning of the first pass to the end of the last.
    pub total: u64,
    /// Each pass by name, in order.
    pub passes: Vec<(String, u64)>,
}

/// Times of many frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TimedFrames {
    /// What they were taken with.
    pub clock: Clock,
    /// In the order drawn, frames of the warm-up left out.
    pub frames: Vec<FrameTime>,
}

/// How many frames are drawn for their times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameBudget {
    /// Frames drawn first and not timed: drivers compile at the first one, caches fill, clocks rise.
    pub warm_up: u32,
    /// Frames timed.
    pub frames: u32,
    /// Fewer frames, but not fewer than [`FrameBudget::LEAST`], where they would take longer than so many seconds; and a
    /// quarter of it for the warm-up, of at least one frame.
    pub seconds: Option<f64>,
}

impl FrameBudget {
    /// Frames that are timed however long they take.
    pub const LEAST: u32 = 3;
}

impl Renderer {
    /// Draws frames for their times, as `budget` says; at least one.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    pub fn time(
        &self,
        camera: &Camera,
        options: &Options,
        budget: &FrameBudget,
    ) -> Result<TimedFrames> {
        let factor = super::resolve::factor(options.samples)?;
        let fine = camera.scaled(factor)?;
        let view = ViewConstants::new(&fine, &options.light, flags(options), options.time);
        let mut taking = Taking::new(budget);
        match &self.on {
            Processor::Cpu => loop {
                let (pixels, passes) = self.pixels(&view)?;
                std::hint::black_box(&pixels);
                if !taking.frame(0, passes) {
                    break;
                }
            },
            #[cfg(feature = "gpu")]
            Processor::Deferred(device) => device.repeat(&view, |t| taking.stamped(t))?,
            #[cfg(feature = "gpu")]
            Processor::Forward(forward) => {
                forward_can(&view)?;
                forward.repeat(&view, |t| taking.stamped(t))?;
            }
        }
        Ok(taking.done())
    }
}

/// Frames while they are taken: by a device's stamps, and by the host's clock where there are none.
pub(crate) struct Taking<'a> {
    budget: &'a FrameBudget,
    warm: u32,
    /// When the stage at hand (warm-up, timed frames) began, and when the last frame ended.
    began: Instant,
    last: Instant,
    frames: Vec<FrameTime>,
    wall: Vec<u64>,
}

impl<'a> Taking<'a> {
    pub(crate) fn new(budget: &'a FrameBudget) -> Self {
        let now = Instant::now();
        Taking {
            budget,
            warm: 0,
            began: now,
            last: now,
            frames: Vec::new(),
            wall: Vec::new(),
        }
    }

    #[cfg(feature = "gpu")]
    pub(crate) fn stamped(&mut self, timings: Timings) -> bool {
        let passes = timings.passes.into_iter();
        let passes = passes.map(|p| (p.name, p.nanoseconds)).collect();
        self.frame(timings.total, passes)
    }

    /// A frame is over. Whether another is wanted.
    pub(crate) fn frame(&mut self, total: u64, passes: Vec<(String, u64)>) -> bool {
        let now = Instant::now();
        let wall = now.duration_since(self.last).as_nanos() as u64;
        self.last = now;
        let spent = now.duration_since(self.began).as_secs_f64();
        let over = |share: f64| self.budget.seconds.is_some_and(|most| spent > most * share);
        if self.warm < self.budget.warm_up {
            self.warm += 1;
            if self.warm == self.budget.warm_up || over(0.25) {
                (self.warm, self.began) = (self.budget.warm_up, now);
            }
            return true;
        }
        self.frames.push(FrameTime { total, passes });
        self.wall.push(wall);
        let count = self.frames.len() as u32;
        count < self.budget.frames && (count < FrameBudget::LEAST || !over(1.0))
    }

    pub(crate) fn done(self) -> TimedFrames {
        if self.frames.iter().any(|frame| frame.total > 0) {
            return TimedFrames {
                clock: Clock::Device,
                frames: self.frames,
            };
        }
        let frames = self.frames.into_iter().zip(self.wall);
        let timed = |(frame, total): (FrameTime, u64)| FrameTime { total, ..frame };
        TimedFrames {
            clock: Clock::Wall,
            frames: frames.map(timed).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames taken under a budget whose frames take no time at all, or more than all of it.
    fn taken(seconds: Option<f64>, warm_up: u32, frames: u32) -> (u32, TimedFrames) {
        let budget = FrameBudget {
            warm_up,
            frames,
            seconds,
        };
        let (mut taking, mut drawn) = (Taking::new(&budget), 1);
        while taking.frame(7, Vec::new()) {
            drawn += 1;
        }
        (drawn, taking.done())
    }

    #[test]
    fn the_warm_up_is_left_out_and_a_budget_of_no_time_still_gives_the_least() {
        let (drawn, frames) = taken(None, 3, 40);
        assert_eq!((drawn, frames.frames.len()), (43, 40));
        assert_eq!((frames.clock, frames.frames[0].total), (Clock::Device, 7));
        let (drawn, frames) = taken(Some(0.0), 3, 40);
        assert_eq!(drawn, 1 + FrameBudget::LEAST);
        assert_eq!(frames.frames.len() as u32, FrameBudget::LEAST);
        let (drawn, frames) = taken(Some(0.0), 0, 2);
        assert_eq!((drawn, frames.frames.len()), (2, 2));
    }
}
