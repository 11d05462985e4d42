//! Progress on stderr, only on a terminal: one bar for the stage at work, with the time left.

use std::io::{self, IsTerminal};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::Common;
use invertex::asset::Progress;

/// A bar that draws only where someone can see it.
pub(super) struct Bar(ProgressBar);

impl Bar {
    /// A bar of `steps` steps (0: unknown, a spinner).
    pub(super) fn new(common: &Common, steps: u64) -> Self {
        let visible = !common.quiet && io::stderr().is_terminal();
        let target = if visible {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target((steps > 0).then_some(steps), target);
        // An unknown template key is our own slip: the plain style then serves.
        let template = "{spinner} {msg:30} {wide_bar:.cyan/dim} {pos}/{len}  {elapsed} ETA {eta}";
        bar.set_style(
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        if visible {
            bar.enable_steady_tick(Duration::from_millis(120));
        }
        Self(bar)
    }

    /// What is being worked on, and how far the whole is.
    pub(super) fn at(&self, what: &str, done: u64, of: u64) {
        self.0.set_length(of);
        self.0.set_position(done);
        self.0.set_message(what.to_owned());
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A bar hears how the library's work goes.
impl Progress for Bar {
    fn at(&self, stage: &'static str, subject: &str, done: usize, of: usize) {
        tracing::debug!("{stage} {subject}");
        Bar::at(self, &format!("{stage} {subject}"), done as u64, of as u64);
    }
}
