//! Observes a running study and can stop it.

use crate::input::study::{Point, Study};
use crate::store::queue::QueueStanding;

/// An event of a run.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A stage other than the solves begins, such as "packing realisation 2".
    Stage(&'a str),
    /// Progress of all workers of a folder.
    Standing(&'a QueueStanding),
    /// A solve begins.
    Solving(&'a Study, &'a Point),
    /// Number of solves that are already stored.
    Kept(usize),
    /// Number of solves that cannot be computed for lack of a packing or a grid.
    Dropped(usize),
    /// A solve has ended, successfully or not.
    Ended,
    /// A solve is stored, or has failed for the given reason.
    Solved(&'a Point, Option<&'a str>),
}

/// Receives the events of a run, from several threads.
pub trait RunWatch: Sync {
    /// True if the run should stop; checked at every step of solvers and packings.
    fn stop(&self) -> bool {
        false
    }

    /// Receives an event.
    fn hear(&self, _event: Event) {}

    /// Announces a stage.
    fn stage(&self, what: &str) {
        self.hear(Event::Stage(what));
    }
}

/// Ignores all events and never stops.
impl RunWatch for () {}
