//! Time limits of trials, so that a plan is quick.

use crate::run::watch::{Event, RunWatch};
use std::time::{Duration, Instant};

/// Forwards the events of a trial and stops it in time.
pub(super) struct Deadline<'a> {
    /// Stops on the user's request alone.
    pub watch: &'a dyn RunWatch,
    end: Instant,
}

impl<'a> Deadline<'a> {
    /// A deadline after `limit`.
    pub fn after(watch: &'a dyn RunWatch, limit: Duration) -> Self {
        Self { watch, end: Instant::now() + limit }
    }

    /// A deadline after an equal share of the time left, for the next of several trials.
    pub fn part(&self, trials: usize) -> Self {
        let left = self.end.saturating_duration_since(Instant::now());
        Self::after(self.watch, left / trials.max(1) as u32)
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
