//! Who looks on while a study runs, and may stop it.

use crate::input::study::{Point, Study};
use crate::store::queue::QueueStanding;

/// What happens in a run.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A stage other than the solves begins, such as "packing realisation 2".
    Stage(&'a str),
    /// How far all workers of a folder are.
    Standing(&'a QueueStanding),
    /// A solve of a study begins.
    Solving(&'a Study, &'a Point),
    /// Number of solves that are in the store already.
    Kept(usize),
    /// Number of solves that cannot be made, for want of a packing or a grid.
    Dropped(usize),
    /// A solve has ended, in whichever way.
    Ended,
    /// The record of a solve is safe, or it has failed for the reason given.
    Solved(&'a Point, Option<&'a str>),
}

/// Hears what a run does; called from several threads.
pub trait RunWatch: Sync {
    /// True when the run is to end; asked at every step of every solver and packing.
    fn stop(&self) -> bool {
        false
    }

    /// Something happens.
    fn hear(&self, _event: Event) {}

    /// A stage begins.
    fn stage(&self, what: &str) {
        self.hear(Event::Stage(what));
    }
}

/// Watches nothing and never stops.
impl RunWatch for () {}
