//! Search for the grid that reaches a requested accuracy.

use super::error::AccuracyError;
use super::resolution::{raised, refine, smooth_size};
use super::task::{Estimated, Task};
use crate::solve::account::{GridTrial, Watch};
use crate::solve::demand::TooLarge;
use crate::wave::grid::MOST_POINTS;
use crate::wave::{Resolution, Scheme, Unphysical};

/// Error assigned to a result that violates a physical law when the grid is refined.
const UNPHYSICAL: f64 = 1.0;
/// Points per wavelength in the densest medium, and planes per wavelength, at which the search
/// starts for an accuracy of 1e-2: for the scalar wave and for Maxwell's equations.
const START: [[f64; 2]; 2] = [[3.0, 5.4], [3.2, 7.0]];
/// Resolutions tried before giving up.
const LEVELS: usize = 24;

impl Task<'_> {
    /// Refines plane and z separately until the estimate meets `accuracy`.
    ///
    /// # Errors
    /// An accuracy out of range, insufficient memory for the next grid, or an error that does not
    /// decrease.
    pub fn solve_to_accuracy(
        &self,
        accuracy: f64,
        watch: &mut dyn Watch,
    ) -> Result<Estimated, AccuracyError> {
        if !(1e-9..=0.5).contains(&accuracy) {
            return Err(AccuracyError::Accuracy(accuracy));
        }
        let mut task = *self;
        task.goal.tolerance = task.goal.tolerance.min(accuracy / 50.0);
        let resolution = task.start(accuracy)?;
        let mut search = Search { task, accuracy, resolution, last: None, refused: None, tried: Vec::new() };
        for _ in 0..LEVELS {
            if let Some(found) = search.try_grid(watch)? {
                return Ok(found);
            }
        }
        Err(search.given_up())
    }

    /// First resolution of the search.
    ///
    /// # Errors
    /// The layer is more wavelengths thick or wide than any grid can resolve.
    fn start(&self, accuracy: f64) -> Result<Resolution, AccuracyError> {
        let finer = (1e-2 / accuracy).max(1.0);
        let (scene, waves) = (self.coverages.scene, self.waves_per_um());
        let [per_wave, planes_per_wave] = START[usize::from(self.coverages.wave.is_vector())];
        let points = |axis: usize| {
            possible(accuracy, per_wave * finer.powf(0.25) * waves * scene.period_um[axis]).map(smooth_size)
        };
        let nx = if scene.uniform_in_plane() { 1 } else { points(0)? };
        let ny = if scene.uniform_in_y() { 1 } else { points(1)? };
        let planes = planes_per_wave * finer.powf(0.2) * waves * scene.thickness_um();
        let cells = possible(accuracy, planes / self.scheme.degree() as f64)?;
        let cells = cells.max(scene.strata.len()).max(2);
        Ok(Resolution { nx, ny, cells, scheme: self.scheme })
    }
}

/// State of a search.
struct Search<'a> {
    task: Task<'a>,
    accuracy: f64,
    /// The next grid.
    resolution: Resolution,
    /// The finest result obtained.
    last: Option<Estimated>,
    /// Why a grid gave no result.
    refused: Option<AccuracyError>,
    tried: Vec<GridTrial>,
}

impl Search<'_> {
    /// The result on the next grid if it is accurate enough; otherwise chooses a finer grid.
    fn try_grid(&mut self, watch: &mut dyn Watch) -> Result<Option<Estimated>, AccuracyError> {
        let (resolution, accuracy) = (self.resolution, self.accuracy);
        self.task.admitted(resolution).map_err(|refusal| self.beyond_memory(refusal))?;
        let clock = std::time::Instant::now();
        watch.grid(&GridTrial { resolution, accuracy, estimate: None, seconds: 0.0 });
        let guess = self.last.as_ref().map(|coarser| &*coarser.solved);
        let estimated = match self.task.estimated_from(guess, resolution, watch) {
            Ok(estimated) => estimated,
            Err(refusal) => return self.raise(refusal).map(|()| None),
        };
        let (estimate, seconds) = (Some(estimated.error_estimate), clock.elapsed().as_secs_f64());
        let trial = GridTrial { resolution, accuracy, estimate, seconds };
        watch.grid(&trial);
        self.tried.push(trial);
        if estimated.error_estimate <= accuracy {
            return Ok(Some(estimated));
        }
        self.resolution = refine(resolution, estimated.parts, accuracy);
        self.last = Some(estimated);
        Ok(None)
    }

    /// Chooses a finer grid if that can resolve the rejection.
    fn raise(&mut self, refusal: AccuracyError) -> Result<(), AccuracyError> {
        let finer = match &refusal {
            AccuracyError::Wave(too_coarse) => raised(self.resolution, too_coarse),
            // A grid too coarse for its contrast rings; refinement reduces the ringing.
            AccuracyError::Unphysical(Unphysical::OutOfRange { .. }) => {
                Some(refine(self.resolution, [UNPHYSICAL; 2], self.accuracy))
            }
            _ => None,
        };
        let Some(finer) = finer else { return Err(refusal) };
        (self.resolution, self.refused) = (finer, Some(refusal));
        Ok(())
    }

    fn beyond_memory(&self, next: TooLarge) -> AccuracyError {
        let asked = self.accuracy;
        let Some(last) = &self.last else { return AccuracyError::TooLarge { asked, first: next } };
        let tried = self.tried.iter().map(GridTrial::to_string).collect::<Vec<_>>().join("; ");
        let (reached, last) = (last.error_estimate, last.system().grid().resolution);
        AccuracyError::NotReached { asked, reached, last, next, tried }
    }

    fn given_up(self) -> AccuracyError {
        let asked = self.accuracy;
        match self.last {
            Some(last) => AccuracyError::GivenUp { levels: LEVELS, asked, reached: last.error_estimate },
            None => self.refused.unwrap_or(AccuracyError::Accuracy(asked)),
        }
    }
}

/// A number of points or cells along one axis, if a grid may have that many.
fn possible(asked: f64, need: f64) -> Result<usize, AccuracyError> {
    if need <= MOST_POINTS as f64 {
        Ok(need.ceil() as usize)
    } else {
        Err(AccuracyError::TooManyWaves { asked, need })
    }
}

/// The scheme that reaches an accuracy with the fewest planes: higher-order cells pay off once
/// their planes are needed anyway.
pub fn suited_scheme(accuracy: f64) -> Scheme {
    if accuracy < 3e-3 { Scheme::Quartic } else { Scheme::Cubic }
}
