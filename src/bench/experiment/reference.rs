//! The grids of a case with their error estimates, and the reference amplitudes of its rows.

use super::cases::Subject;
use super::file::{ComparisonFile, Points};
use crate::error::CompareResult;
use crate::input::case::Case;
use crate::input::wave_kind::WaveKind;
use crate::run::memory;
use crate::solve::accuracy::{AccuracyError, Estimated, Task};
use crate::solve::{Coverages, Gmres, Goal, Solver, Watch};
use crate::wave::{FarField, Mean, Order, Precision, Resolution, Scene, Scheme, TotalErrors};
use num_complex::Complex64;
use serde_json::Value;

/// A grid to compare on, and its part of the error.
pub(super) struct ReferenceTrial {
    /// None where the search for it failed, for this reason.
    pub grid: Result<Resolution, String>,
    /// Parts of the estimated error from the plane and from z; none where no coarser grid could be
    /// solved.
    pub parts: Option<[f64; 2]>,
}

impl ComparisonFile {
    /// All grids of a case, scheme by scheme: those of the list, or those that the search finds.
    pub(super) fn trials(
        &self,
        subject: &Subject,
        case: &Case,
        coverages: &Coverages,
        watch: &mut dyn Watch,
    ) -> CompareResult<Vec<ReferenceTrial>> {
        let solver = Gmres::default();
        let mut trials = Vec::new();
        for scheme in self.schemes(subject.wave) {
            let task = Task { scheme, ..task(case, coverages, &solver, self.goal().tolerance) };
            if let Some(accuracy) = self.searched() {
                trials.push(trial(task.solve_to_accuracy(accuracy, watch), None)?);
            }
            for points in self.listed().into_iter().flatten() {
                let grid = sized(&case.scene, points, scheme);
                trials.push(trial(task.solve_with_estimate(grid, watch), Some(grid))?);
            }
        }
        Ok(trials)
    }

    /// Checks everything that [`ComparisonFile::truth`] needs before it solves.
    ///
    /// # Errors
    /// No memory for the grid; a geometry or a direction that makes no problem on it.
    pub(super) fn check_reference(&self, wave: WaveKind, case: &Case, grids: &[Resolution]) -> CompareResult {
        let resolution = finer(wave, grids);
        let coverages = coverages(wave, case);
        let solver = Gmres::default();
        let task = task(case, &coverages, &solver, self.goal().tolerance);
        task.admitted(resolution).map_err(AccuracyError::Memory)?;
        task.systems(resolution)?;
        Ok(())
    }

    /// Reference amplitudes: those of the case file, or of a solve with 1.5 times as many points
    /// and cells.
    pub(super) fn truth(
        &self,
        subject: &Subject,
        case: &Case,
        trials: &[ReferenceTrial],
        watch: &mut dyn Watch,
    ) -> CompareResult<Vec<FarField>> {
        let grids: Vec<Resolution> = trials.iter().filter_map(|trial| trial.grid.clone().ok()).collect();
        let coverages = coverages(subject.wave, case);
        let solver = Gmres::default();
        let task = task(case, &coverages, &solver, 1e-3 * self.goal().tolerance);
        let (solved, _) = task.solve(finer(subject.wave, &grids), watch)?;
        let mut truth = Vec::new();
        for polarised in solved {
            let errors = TotalErrors::of_totals([1.0; 2], polarised.solution.account.residual);
            truth.push(polarised.far_field().judged(errors).map_err(AccuracyError::Unphysical)?);
        }
        let waves = if subject.wave == WaveKind::Vector { &PAIRS[..] } else { &[NO_PAIRS] };
        if let Some(known) = subject.known() {
            for (far, keys) in truth.iter_mut().zip(waves) {
                far.orders.retain_mut(|order| replace(order, known, keys));
            }
        }
        Ok(truth)
    }
}

/// Exact coverages for a wave.
pub(super) fn coverages(wave: WaveKind, case: &Case) -> Coverages<'_> {
    Coverages::new(wave.wave(), &case.scene, Precision::EXACT)
}

/// A listed grid, or the one that a search found, with its error as estimated from coarser ones.
///
/// # Errors
/// The user stopped it.
fn trial(
    solved: Result<Estimated, AccuracyError>,
    listed: Option<Resolution>,
) -> CompareResult<ReferenceTrial> {
    let estimated = match solved {
        Err(stopped) if stopped.is_stop() => return Err(stopped.into()),
        solved => solved.map_err(|error| error.to_string()),
    };
    let parts = estimated.as_ref().ok().map(|estimated| estimated.parts);
    let grid = match listed {
        Some(grid) => Ok(grid),
        None => estimated.map(|estimated| estimated.system().grid().resolution),
    };
    Ok(ReferenceTrial { grid, parts })
}

/// A solve without its grid, as the reference is solved.
pub(super) fn task<'a>(
    case: &'a Case,
    coverages: &'a Coverages<'a>,
    solver: &'a dyn Solver,
    tolerance: f64,
) -> Task<'a> {
    let Case { media, incidence, .. } = case;
    let mean = Mean::default();
    let goal = Goal { tolerance, ..Goal::default() };
    let memory = memory::usable();
    Task { coverages, media, incidence, mean, scheme: Scheme::Cubic, solver, goal, memory }
}

/// The grid of the reference.
fn finer(wave: WaveKind, grids: &[Resolution]) -> Resolution {
    let half_as_many_again = |of_grid: fn(&Resolution) -> usize| {
        let count = grids.iter().map(of_grid).max().unwrap_or(1);
        3 * count / 2
    };
    Resolution {
        nx: half_as_many_again(|grid| grid.nx),
        ny: half_as_many_again(|grid| grid.ny),
        cells: half_as_many_again(|grid| grid.cells),
        scheme: wave.wave().scheme(Scheme::Cubic),
    }
}

/// A grid of the list; one point is enough along an axis that nothing depends on.
pub(super) fn sized(scene: &Scene, points: Points, scheme: Scheme) -> Resolution {
    let nx = if scene.uniform_in_plane() { 1 } else { points.points };
    let ny = if scene.uniform_in_y() { 1 } else { points.points };
    Resolution { nx, ny, cells: points.cells, scheme }
}

/// Places of an order's amplitude in `R` and `T`: of its own polarisation, and of the crossed one.
type Keys = [&'static str; 2];
const NO_PAIRS: Keys = ["", ""];
const PAIRS: [Keys; 2] = [["/s/s", "/s/p"], ["/p/p", "/p/s"]];

/// Puts a reference order's amplitudes in place; false where the reference does not list it.
fn replace(order: &mut Order, known: &[Value], [own, crossed]: &Keys) -> bool {
    let same = |k: &&Value| k["m"] == order.m && (k["n"] == order.n || (k["n"].is_null() && order.n == 0));
    let Some(listed) = known.iter().find(same) else { return false };
    let amplitude = |side: &str, keys: &str| {
        let pair = listed[side].pointer(keys)?;
        Some(Complex64::new(pair[0].as_f64()?, pair[1].as_f64()?))
    };
    order.reflected = amplitude("R", own).unwrap_or(order.reflected);
    order.transmitted = amplitude("T", own).unwrap_or(order.transmitted);
    if !crossed.is_empty() {
        let [reflected, transmitted] = order.further[0];
        let sides = [("R", reflected), ("T", transmitted)];
        order.further[0] = sides.map(|(side, own)| amplitude(side, crossed).unwrap_or(own));
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_is_finer_along_every_axis() {
        let grid = |nx, ny, cells| Resolution { nx, ny, cells, scheme: Scheme::Cubic };
        let found = finer(WaveKind::Scalar, &[grid(8, 10, 10), grid(6, 12, 4)]);
        assert_eq!([found.nx, found.ny, found.cells], [12, 18, 15]);
    }
}
