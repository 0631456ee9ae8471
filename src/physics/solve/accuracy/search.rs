//! Search for the grid that reaches a requested accuracy, and resolutions related to a given one:
//! companions for error estimates, and refinements.

use super::error::{AccuracyError, Result};
use super::task::{Estimated, Task};
use crate::solve::account::{GridTrial, Watch};
use crate::solve::demand::TooLarge;
use crate::wave::MOST_POINTS;
use crate::wave::contrast::nufft::is_smooth;
use crate::wave::{Resolution, Scheme, Unphysical, WaveError};

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
    pub fn solve_to_accuracy(&self, accuracy: f64, watch: &mut dyn Watch) -> Result<Estimated> {
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
        let reached = search.last.map(|last| last.error_estimate);
        let given_up =
            reached.map(|reached| AccuracyError::GivenUp { levels: LEVELS, asked: accuracy, reached });
        Err(given_up.or(search.refused).unwrap_or(AccuracyError::Accuracy(accuracy)))
    }

    /// [`Self::solve_to_accuracy`] that tries the grid of another direction first, and refines it
    /// for this one where its estimate asks for it; the result's grid is nowhere coarser.
    ///
    /// # Errors
    /// As [`Self::solve_to_accuracy`].
    pub fn solve_to_accuracy_from(
        &self,
        before: Option<Resolution>,
        accuracy: f64,
        watch: &mut dyn Watch,
    ) -> Result<Estimated> {
        if let Some(resolution) = before {
            match self.solve_with_estimate(resolution, watch) {
                Ok(tried) if tried.error_estimate <= accuracy => return Ok(tried),
                Err(AccuracyError::Wave(refusal)) if raised(resolution, &refusal).is_some() => {}
                tried => drop(tried?),
            }
        }
        let refined = self.solve_to_accuracy(accuracy, watch)?;
        let (fine, Some(coarse)) = (refined.system().grid().resolution, before) else { return Ok(refined) };
        let both = Resolution {
            nx: fine.nx.max(coarse.nx),
            ny: fine.ny.max(coarse.ny),
            cells: fine.cells.max(coarse.cells),
            scheme: fine.scheme,
        };
        if both == fine { Ok(refined) } else { self.solve_with_estimate(both, watch) }
    }

    /// First resolution of the search.
    ///
    /// # Errors
    /// The layer is more wavelengths thick or wide than any grid can resolve.
    fn start(&self, accuracy: f64) -> Result<Resolution> {
        let finer = (1e-2 / accuracy).max(1.0);
        let scene = self.coverages.scene;
        let waves = self.waves_per_um();
        let [per_wave, planes_per_wave] = START[usize::from(self.coverages.wave.is_vector())];
        let points = |axis: usize| {
            possible(accuracy, per_wave * finer.powf(0.25) * waves * scene.period_um[axis]).map(smooth_size)
        };
        let nx = if scene.uniform_in_plane() { 1 } else { points(0)? };
        let ny = if scene.uniform_in_y() { 1 } else { points(1)? };
        let planes = planes_per_wave * finer.powf(0.2) * waves * scene.thickness_um();
        let cells = possible(accuracy, planes / self.scheme.degree() as f64)?;
        Ok(Resolution { nx, ny, cells: cells.max(scene.strata.len()).max(2), scheme: self.scheme })
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
    fn try_grid(&mut self, watch: &mut dyn Watch) -> Result<Option<Estimated>> {
        let resolution = self.resolution;
        let accuracy = self.accuracy;
        self.task.admitted(resolution).map_err(|refusal| self.beyond_memory(refusal))?;
        let clock = std::time::Instant::now();
        watch.grid(&GridTrial { resolution, accuracy, estimate: None, seconds: 0.0 });
        let guess = self.last.as_ref().map(|coarser| &*coarser.solved);
        let estimated = match self.task.estimated_from(guess, resolution, watch) {
            Ok(estimated) => estimated,
            Err(refusal) => return self.raise(refusal).map(|()| None),
        };
        let estimate = Some(estimated.error_estimate);
        let seconds = clock.elapsed().as_secs_f64();
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
    fn raise(&mut self, refusal: AccuracyError) -> Result<()> {
        let finer = match &refusal {
            AccuracyError::Wave(too_coarse) => raised(self.resolution, too_coarse),
            // A grid too coarse for its contrast rings; refinement reduces the ringing.
            AccuracyError::Unphysical(Unphysical::OutOfRange { .. }) => {
                Some(refine(self.resolution, [UNPHYSICAL; 2], self.accuracy))
            }
            _ => None,
        };
        let Some(finer) = finer else { return Err(refusal) };
        self.resolution = finer;
        self.refused = Some(refusal);
        Ok(())
    }

    fn beyond_memory(&self, next: TooLarge) -> AccuracyError {
        let Some(last) = &self.last else {
            return AccuracyError::TooLarge { asked: self.accuracy, first: next };
        };
        let tried = self.tried.iter().map(GridTrial::to_string).collect::<Vec<_>>().join("; ");
        let reached = last.error_estimate;
        let last = last.system().grid().resolution;
        AccuracyError::NotReached { asked: self.accuracy, reached, last, next, tried }
    }
}

/// A number of points or cells along one axis, if a grid may have that many.
fn possible(accuracy: f64, need: f64) -> Result<usize> {
    let count = (need <= MOST_POINTS as f64).then(|| need.ceil() as usize);
    count.ok_or(AccuracyError::TooManyWaves { asked: accuracy, need })
}

/// The scheme that reaches an accuracy with the fewest planes: higher-order cells pay off once
/// their planes are needed anyway.
pub fn suited_scheme(accuracy: f64) -> Scheme {
    if accuracy < 3e-3 { Scheme::Quartic } else { Scheme::Cubic }
}

/// Lower limit on the own error as a fraction of the difference, however coarse the companion.
const LEAST_SHARE: f64 = 0.3;

/// Own error as a fraction of the difference to a companion, from the ratios of refinement in the
/// plane and across z; 1.5 for a finer companion.
pub(crate) fn error_share([plane, across]: [f64; 2], [in_plane, in_z]: [i32; 2]) -> f64 {
    if plane < 1.0 || across < 1.0 {
        return 1.5;
    }
    (1.0 / (plane.powi(in_plane) * across.powi(in_z) - 1.0)).max(LEAST_SHARE)
}

/// The coarsest sufficient resolution if a grid was rejected as too coarse.
pub fn raised(r: Resolution, refusal: &WaveError) -> Option<Resolution> {
    match *refusal {
        WaveError::CellTooHigh { needed, .. } => Some(Resolution { cells: needed.max(r.cells + 1), ..r }),
        WaveError::GridTooCoarse { need, .. } => {
            let raise = |n: usize| if n == 1 { 1 } else { n.max(smooth_size(need)) };
            Some(Resolution { nx: raise(r.nx), ny: raise(r.ny), ..r })
        }
        _ => None,
    }
}

/// Smallest product of 2, 3 and 5 that is at least `n`.
pub fn smooth_size(n: usize) -> usize {
    (n.max(2)..).find(|&n| is_smooth(n)).expect("smooth numbers are unbounded")
}

/// Points scaled by `factor`, rounded away from the present number to sizes with a fast transform.
pub(crate) fn scaled_plane(r: Resolution, factor: f64, uniform: [bool; 2]) -> Resolution {
    let scale = |n: usize, uniform: bool| if uniform { n } else { scaled_points(n, factor) };
    Resolution { nx: scale(r.nx, uniform[0]), ny: scale(r.ny, uniform[1]), ..r }
}

/// Points along one axis scaled by `factor`; see [`scaled_plane`].
pub(crate) fn scaled_points(n: usize, factor: f64) -> usize {
    match n {
        1 if factor > 1.0 => 3,
        n if factor > 1.0 => smooth_size((n as f64 * factor).ceil() as usize),
        n => (2..n).rev().find(|&k| (k as f64) <= n as f64 * factor && is_smooth(k)).unwrap_or(n),
    }
}

/// Cells scaled by `factor`, rounded away from the present number.
pub(crate) fn scaled_cells(r: Resolution, factor: f64) -> Resolution {
    let cells = r.cells as f64 * factor;
    let cells = if factor > 1.0 { cells.ceil() } else { cells.floor() };
    Resolution { cells: (cells as usize).max(1), ..r }
}

/// Refines each direction whose error exceeds half of the accuracy, as far as the fast convergence
/// of coarse grids suggests.
pub(crate) fn refine(r: Resolution, parts: [f64; 2], accuracy: f64) -> Resolution {
    let factor = |part: f64| (part / (0.4 * accuracy)).powf(1.0 / 6.0).clamp(1.1, 1.7);
    let mut next = r;
    if parts[0] > 0.45 * accuracy {
        let grow = |n: usize| if n == 1 { 1 } else { scaled_points(n, factor(parts[0])) };
        next.nx = grow(r.nx);
        next.ny = grow(r.ny);
    }
    if parts[1] > 0.45 * accuracy {
        next.cells = ((r.cells as f64 * factor(parts[1])).round() as usize).max(r.cells + 1);
    }
    if next != r {
        return next;
    }
    // Neither exceeds its half, but their sum with the safety factor does: the direction with the
    // larger error is refined.
    let larger = if parts[0] > parts[1] { [accuracy, 0.0] } else { [0.0, accuracy] };
    refine(r, larger, accuracy)
}
