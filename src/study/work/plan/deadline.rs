//! The time that the trials of a plan may take.

use crate::run::crew::processor_seconds;
use crate::run::watch::{Event, RunWatch};
use std::time::Instant;

/// Time since a plan began: that of the clock on the wall, or where other programs take the
/// processor's, that of the processor, but at least a third of the wall's.
#[derive(Clone, Copy)]
pub(super) struct PlanClock {
    began: Instant,
    /// Processor seconds at the beginning.
    used: Option<f64>,
}

/// Seconds on the wall in which a plan uses at least one second of its time.
const SLOWEST: f64 = 3.0;

impl PlanClock {
    /// Starts now.
    pub fn start() -> Self {
        Self { began: Instant::now(), used: processor_seconds() }
    }

    /// Seconds since the start.
    fn seconds(self) -> f64 {
        let wall = self.began.elapsed().as_secs_f64();
        let used = processor_seconds().zip(self.used).map_or(wall, |(now, before)| now - before);
        used.clamp(wall / SLOWEST, wall)
    }

    /// Whether this time has passed.
    fn has_passed(self, seconds: f64) -> bool {
        self.began.elapsed().as_secs_f64() >= seconds && self.seconds() >= seconds
    }
}

/// Forwards the events of a trial and stops it in time.
pub(super) struct Deadline<'a> {
    /// Stops on the user's request alone.
    pub watch: &'a dyn RunWatch,
    /// Solves at a time.
    pub jobs: usize,
    /// The time since the plan began.
    pub clock: PlanClock,
    /// When to stop, s of that time.
    pub end: f64,
}

impl Deadline<'_> {
    /// A deadline after an equal share of the time left, for the next of several trials.
    pub fn part(&self, trials: usize) -> Self {
        let now = self.clock.seconds();
        Self { end: now + (self.end - now).max(0.0) / trials.max(1) as f64, ..*self }
    }
}

impl RunWatch for Deadline<'_> {
    fn stop(&self) -> bool {
        self.clock.has_passed(self.end) || self.watch.stop()
    }

    fn hear(&self, event: Event) {
        self.watch.hear(event);
    }
}
