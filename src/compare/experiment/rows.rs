//! One row of a comparison: one strategy on one grid.

use super::file::ComparisonFile;
use crate::compare::error::CompareError;
use crate::compare::pages::Row;
use crate::input::case::Case;
use crate::run::memory;
use crate::solve::accuracy::{AccuracyError, Solved, Task, error_estimate, largest_difference};
use crate::solve::{Coverages, SolveError, Solver, Watch};
use crate::wave::{FarField, Mean, Physical, Resolution, TotalErrors};

impl ComparisonFile {
    /// One line: a result, or the reason why there is none. Errors: the user stopped it.
    pub(super) fn row(
        &self,
        (name, solver): (&str, &dyn Solver),
        resolution: Resolution,
        case: &Case,
        coverages: &Coverages,
        truth: &FarField,
        watch: &mut dyn Watch,
    ) -> Result<Row, CompareError> {
        let task = Task {
            coverages,
            media: &case.media,
            incidence: &case.incidence,
            mean: Mean { depends_on_z: self.mean_depends_on_z, absorbing: self.absorbing_mean },
            scheme: resolution.scheme,
            solver,
            goal: self.goal,
            memory: memory::usable(),
        };
        let mut row = Row::new(name, resolution);
        match self.measure(&task, resolution, truth, &mut row, watch) {
            Err(AccuracyError::Solve(cancelled @ SolveError::Cancelled { .. })) => Err(cancelled.into()),
            Err(error) => {
                let account = match &error {
                    AccuracyError::Solve(error) => error.account().cloned(),
                    _ => None,
                };
                account.iter().for_each(|account| row.take(account));
                row.outcome = error.to_string();
                Ok(row)
            }
            Ok(()) => Ok(row),
        }
    }

    /// Solves as often as was asked, and judges the first result.
    fn measure(
        &self,
        task: &Task,
        resolution: Resolution,
        truth: &FarField,
        row: &mut Row,
        watch: &mut dyn Watch,
    ) -> Result<(), AccuracyError> {
        let solver = task.admitted(resolution)?;
        let system = task.systems(resolution)?.remove(0);
        (row.unknowns, row.bytes) = (system.unknowns(), system.bytes());
        let solution = solver.solver().solve(&*system, task.goal, watch)?;
        row.take(&solution.account);
        let (residual, mut seconds) = (solution.account.residual, vec![solution.account.seconds]);
        let solved = [Solved { system, solution }];
        let far = solved[0].far_field();
        let error = largest_difference(truth, &far);
        row.error_estimate = match task.estimate_parts(&solved, std::slice::from_ref(&far), watch) {
            Err(stopped @ AccuracyError::Solve(SolveError::Cancelled { .. })) => return Err(stopped),
            parts => parts.ok().map(|parts| error_estimate(parts, residual)),
        };
        let errors = TotalErrors::of_amplitudes(row.error_estimate.unwrap_or(error), residual);
        Physical::judge(far, errors)?;
        for _ in 1..self.repeats {
            seconds.push(solver.solver().solve(&*solved[0].system, task.goal, watch)?.account.seconds);
        }
        seconds.sort_by(f64::total_cmp);
        row.seconds = seconds[seconds.len() / 2];
        row.error = Some(error);
        row.outcome = "converged".into();
        Ok(())
    }
}
