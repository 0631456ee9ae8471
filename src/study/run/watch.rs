//! Who looks on while a study runs, and may stop it.

use crate::input::study::{Point, Study};
use crate::store::queue::QueueStanding;

/// Hears what a run does; called from several threads.
pub trait RunWatch: Sync {
    /// True when the run shall end; asked at every step of every solver and packing.
    fn stop(&self) -> bool {
        false
    }

    /// The run begins: `kept` of the study's solves are already in the store.
    fn begins(&self, _study: &Study, _kept: usize) {}

    /// A stage other than the solves begins, such as "packing realisation 2".
    fn stage(&self, _what: &str) {}

    /// How far all workers of a folder are.
    fn standing(&self, _standing: &QueueStanding) {}

    /// A solve begins.
    fn solving(&self, _study: &Study, _point: &Point) {}

    /// Solves of a realisation need no work: they are in the store already.
    fn kept(&self, _study: &Study, _solves: usize) {}

    /// A solve has ended, in whichever way.
    fn ended(&self) {}

    /// A solve has ended and its record is safe, or it has failed.
    fn solved(&self, _study: &Study, _point: &Point, _failure: Option<&str>) {}
}

/// Watches nothing and never stops.
impl RunWatch for () {}
