//! A plan answers soon: trials end at a time.

use crate::run::watch::{Event, RunWatch};
use std::time::{Duration, Instant};

/// Passes on what a trial tells, and stops it in time.
pub(super) struct Deadline<'a> {
    watch: &'a dyn RunWatch,
    end: Instant,
}

impl<'a> Deadline<'a> {
    /// So long from now.
    pub fn after(watch: &'a dyn RunWatch, limit: Duration) -> Self {
        Self { watch, end: Instant::now() + limit }
    }

    /// An equal part of the time left, for the next of several trials.
    pub fn part(&self, trials: usize) -> Self {
        let left = self.end.saturating_duration_since(Instant::now());
        Self::after(self.watch, left / trials.max(1) as u32)
    }

    /// True when somebody asked to stop, and not the time.
    pub fn is_called_off(&self) -> bool {
        self.watch.stop()
    }
}

impl RunWatch for Deadline<'_> {
    fn stop(&self) -> bool {
        Instant::now() >= self.end || self.watch.stop()
    }

    fn hear(&self, event: Event) {
        self.watch.hear(event);
    }
}
