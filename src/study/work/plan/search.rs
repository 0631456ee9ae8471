//! What a search of a grid that was cut short says about the grid that it would have found.

use super::deadline::Deadline;
use crate::input::study::Study;
use crate::run::crew::processor_seconds;
use crate::run::watch::{Event, RunWatch};
use crate::solve::GridTrial;
use crate::solve::accuracy::grid_error::scaled;
use crate::wave::Resolution;
use std::sync::Mutex;

/// Work on a test solve with the companions of its error estimate, in solves: they have four fifths
/// of the points, or of the cells.
pub(super) const WITH_ESTIMATE: f64 = 2.4;

/// A search of a grid that its deadline may end: what its last grid tells of the next.
pub(super) struct SearchWatch<'a> {
    watch: Deadline<'a>,
    /// Processor seconds when the present grid began.
    begun: Mutex<Option<f64>>,
    /// The last grid with an error, and its processor seconds.
    last: Mutex<Option<(GridTrial, f64)>>,
}

/// Least order at which the error of an amplitude among grains falls with the mesh width.
const ORDER: f64 = 3.0;

/// Larger errors than an amplitude may have say no more than that a grid is too coarse.
const MOST_ERROR: f64 = 1.0;

impl<'a> SearchWatch<'a> {
    pub fn new(watch: Deadline<'a>) -> Self {
        Self { watch, begun: Mutex::default(), last: Mutex::default() }
    }

    /// The grid at which the error of the last one would have fallen to the accuracy, and the core
    /// seconds of a solve on it.
    pub fn suggestion(&self, study: &Study) -> Option<(Resolution, f64)> {
        let (trial, seconds) = (*self.last.lock().ok()?)?;
        let finer = (trial.estimate?.min(MOST_ERROR) / trial.accuracy).max(1.0).powf(1.0 / ORDER);
        let grid = scaled(trial.resolution, finer);
        let unknowns = |r: Resolution| (r.nx * r.ny * r.planes()) as f64;
        let more = unknowns(grid) / unknowns(trial.resolution);
        let polarisations = if study.wave.is_vector() { 2.0 } else { 1.0 };
        Some((grid, seconds * more / (WITH_ESTIMATE * polarisations)))
    }
}

impl RunWatch for SearchWatch<'_> {
    fn stop(&self) -> bool {
        self.watch.stop()
    }

    fn hear(&self, event: Event) {
        if let (Event::Grid(trial), Some(now)) = (event, processor_seconds()) {
            let begun = self.begun.lock().ok().and_then(|mut begun| begun.replace(now));
            if let (Some(_), Some(begun), Ok(mut last)) = (trial.estimate, begun, self.last.lock()) {
                *last = Some((*trial, now - begun));
            }
        }
        self.watch.hear(event);
    }
}

#[cfg(test)]
mod tests {
    use super::super::deadline::PlanClock;
    use super::*;
    use crate::input::check::check;
    use crate::wave::Scheme;
    use std::path::Path;

    /// At third order, eight times the error asked for takes half the mesh width: eight times the
    /// unknowns. *Planted*: an order of 6, as fine grids of smooth media have.
    #[test]
    fn an_unfinished_search_tells_the_next_grid() {
        let deadline = Deadline { watch: &(), jobs: 1, clock: PlanClock::start(), end: 1.0 };
        let search = SearchWatch::new(deadline);
        let file = toml::from_str("title = 't'\n[layer]\nthickness_um = 1.0\nbinder.index = 1.5\n");
        let study = check(&file.expect("a study file"), Path::new("."), "test").expect("a sound study");
        assert_eq!(search.suggestion(&study), None);
        let resolution = Resolution { nx: 20, ny: 30, cells: 40, scheme: Scheme::Cubic };
        let trial = GridTrial { resolution, accuracy: 1e-2, estimate: None, seconds: 0.0 };
        search.hear(Event::Grid(&trial));
        assert_eq!(search.suggestion(&study), None, "its error is not known yet");
        search.hear(Event::Grid(&GridTrial { estimate: Some(8e-2), ..trial }));
        let (_, spent) = search.last.lock().expect("no panic").expect("a grid");
        let (grid, seconds) = search.suggestion(&study).expect("a grid");
        assert_eq!(grid, Resolution { nx: 40, ny: 60, cells: 80, ..resolution });
        search.hear(Event::Grid(&GridTrial { estimate: Some(30.0), ..trial }));
        let coarse = search.suggestion(&study).expect("a grid").0;
        assert_eq!(coarse, Resolution { nx: 96, ny: 144, cells: 186, ..resolution }, "as for an error of 1");
        let unknowns = |r: Resolution| (r.nx * r.ny * r.planes()) as f64;
        let expected = spent * unknowns(grid) / unknowns(resolution) / WITH_ESTIMATE;
        assert!((seconds / expected - 1.0).abs() < 1e-12 || seconds == expected, "{seconds} for {expected}");
    }
}
