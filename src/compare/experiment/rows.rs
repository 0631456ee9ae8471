//! One row of a comparison: one strategy on one grid of a case.

use super::file::ComparisonFile;
use super::reference::ReferenceTrial;
use crate::compare::error::CompareError;
use crate::compare::row::{Discrete, Row, Varied};
use crate::input::case::Case;
use crate::run::crew::processor_seconds;
use crate::run::memory;
use crate::solve::accuracy::{AccuracyError, Task, error_estimate, largest_difference};
use crate::solve::{Coverages, Goal, Solution, SolveError, Solver, Watch};
use crate::wave::{FarField, Mean, Physical, Resolution, Scheme, System, TotalErrors};

/// A case with all that its rows share.
pub(super) struct Bench<'a> {
    pub file: &'a ComparisonFile,
    pub varied: Option<Varied>,
    pub case: &'a Case,
    pub coverages: &'a Coverages<'a>,
    pub truth: FarField,
}

impl Bench<'_> {
    /// One line: a result, or the reason why there is none. Errors: the user stopped it.
    pub fn row(
        &self,
        (name, solver): (&str, &dyn Solver),
        mean: Mean,
        trial: &ReferenceTrial,
        watch: &mut dyn Watch,
    ) -> Result<Row, CompareError> {
        let resolution = match &trial.grid {
            Ok(resolution) => *resolution,
            Err(reason) => {
                return Ok(Row { result: Err(reason.clone()), ..Row::new(self.varied, name, None) });
            }
        };
        let discrete = Discrete { resolution, absorbing_mean: mean.absorbing };
        let mut row = Row::new(self.varied, name, Some(discrete));
        let task = self.task(solver, mean, resolution.scheme);
        match self.measure(&task, (resolution, trial.parts), &mut row, watch) {
            Err(stopped) if stopped.is_stop() => Err(stopped.into()),
            Err(error) => {
                if let AccuracyError::Solve(error) = &error {
                    row.account = row.account.or(error.account().cloned());
                }
                Ok(Row { result: Err(error.to_string()), ..row })
            }
            Ok(error) => Ok(Row { result: Ok(error), ..row }),
        }
    }

    fn task<'a>(&'a self, solver: &'a dyn Solver, mean: Mean, scheme: Scheme) -> Task<'a> {
        Task {
            coverages: self.coverages,
            media: &self.case.media,
            incidence: &self.case.incidence,
            mean,
            scheme,
            solver,
            goal: self.file.goal(),
            memory: memory::usable(),
        }
    }

    /// Solves as often as was asked, and judges the first result: its largest amplitude error.
    fn measure(
        &self,
        task: &Task,
        (resolution, parts): (Resolution, Option<[f64; 2]>),
        row: &mut Row,
        watch: &mut dyn Watch,
    ) -> Result<f64, AccuracyError> {
        let admitted = task.admitted(resolution)?;
        let system = task.systems(resolution)?.remove(0);
        (row.unknowns, row.bytes) = (Some(system.unknowns()), system.bytes());
        let (solver, goal) = (admitted.solver(), task.goal);
        let (Solution { field, account }, processor_seconds) = timed(solver, &*system, goal, watch)?;
        let mut seconds = vec![account.seconds];
        let mut processor_seconds: Vec<f64> = processor_seconds.into_iter().collect();
        let residual = account.residual;
        row.bytes += account.bytes;
        row.account = Some(account);
        let far = system.far_field(&field);
        let error = largest_difference(&self.truth, &far);
        row.error_estimate = parts.map(|parts| error_estimate(parts, residual));
        let errors = TotalErrors::of_amplitudes(row.error_estimate.unwrap_or(error), residual);
        Physical::judge(far, errors)?;
        for _ in 1..self.file.repeats.unwrap_or(3) {
            let (solution, processors) = timed(solver, &*system, goal, watch)?;
            seconds.push(solution.account.seconds);
            processor_seconds.extend(processors);
        }
        (row.seconds, row.processor_seconds) = (median(seconds), median(processor_seconds));
        Ok(error)
    }
}

/// A solution and the processor time that it took, s.
fn timed(
    solver: &dyn Solver,
    system: &dyn System,
    goal: Goal,
    watch: &mut dyn Watch,
) -> Result<(Solution, Option<f64>), SolveError> {
    let before = processor_seconds();
    let solution = solver.solve(system, goal, watch)?;
    Ok((solution, processor_seconds().zip(before).map(|(after, before)| after - before)))
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
