//! One row of a comparison: one strategy on one grid of a case, and the mean media ⟨k²⟩ that it is
//! compared with.

use super::NamedStrategy;
use super::file::ComparisonFile;
use super::reference::{ReferenceTrial, task};
use crate::error::CompareResult;
use crate::input::case::Case;
use crate::row::{Discrete, Row, Varied};
use crate::run::crew::processor_seconds;
use crate::solve::accuracy::{AccuracyError, Task, error_estimate, largest_of_all};
use crate::solve::{Account, Coverages, Goal, Solution, SolveError, Solver, Watch};
use crate::wave::{FarField, Mean, Media, Resolution, System, TotalErrors};

/// A case with all that its rows share.
pub(super) struct Bench<'a> {
    pub file: &'a ComparisonFile,
    pub varied: Option<Varied>,
    pub case: &'a Case,
    pub coverages: &'a Coverages<'a>,
    pub truth: Vec<FarField>,
}

impl Bench<'_> {
    /// Computes one row: a result, or the reason why there is none. Errors: the user stopped it.
    pub fn row(
        &self,
        strategy: &NamedStrategy,
        mean: Mean,
        trial: &ReferenceTrial,
        watch: &mut dyn Watch,
    ) -> CompareResult<Row> {
        let resolution = match &trial.grid {
            Ok(resolution) => *resolution,
            Err(reason) => {
                return Ok(Row {
                    result: Err(reason.clone()),
                    ..Row::new(self.varied, &strategy.name, None)
                });
            }
        };
        let discrete = Discrete { resolution, absorbing_mean: mean.absorbing };
        let mut row = Row::new(self.varied, &strategy.name, Some(discrete));
        let goal = self.file.goal();
        let task = task(self.case, self.coverages, &*strategy.solver, goal.tolerance);
        let task = Task { mean, goal, scheme: resolution.scheme, ..task };
        match self.measure(&task, resolution, trial.parts, &mut row, watch) {
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

    /// Solves as often as requested; the result is the largest amplitude error of the first solve.
    fn measure(
        &self,
        task: &Task,
        resolution: Resolution,
        parts: Option<[f64; 2]>,
        row: &mut Row,
        watch: &mut dyn Watch,
    ) -> Result<f64, AccuracyError> {
        let admitted = task.admitted(resolution)?;
        let systems = task.systems(resolution)?;
        // Systems of s and p light share their memory.
        let unknowns = systems.iter().map(|system| system.unknowns()).sum();
        row.unknowns = Some(unknowns);
        row.bytes = systems[0].bytes();
        let solver = admitted.solver();
        let (solutions, processor_seconds) = timed(solver, &systems, task.goal, watch)?;
        let account = joined(&solutions);
        let mut seconds = vec![account.seconds];
        let mut processor_seconds: Vec<f64> = processor_seconds.into_iter().collect();
        let residual = account.residual;
        row.bytes += account.bytes;
        row.account = Some(account);
        let far_fields = systems.iter().zip(&solutions).map(|(system, s)| system.far_field(&s.field));
        let far_fields: Vec<FarField> = far_fields.collect();
        let error = largest_of_all(&self.truth, &far_fields);
        row.error_estimate = parts.map(|parts| error_estimate(parts, residual));
        let errors = TotalErrors::of_amplitudes(row.error_estimate.unwrap_or(error), residual);
        for far in far_fields {
            far.judged(errors)?;
        }
        for _ in 1..self.file.repeats.unwrap_or(3) {
            let (solutions, processors) = timed(solver, &systems, task.goal, watch)?;
            seconds.push(joined(&solutions).seconds);
            processor_seconds.extend(processors);
        }
        row.seconds = median(seconds);
        row.processor_seconds = median(processor_seconds);
        Ok(error)
    }
}

/// Solutions of all polarisations, and the processor time that they took, s.
fn timed(
    solver: &dyn Solver,
    systems: &[Box<dyn System>],
    goal: Goal,
    watch: &mut dyn Watch,
) -> Result<(Vec<Solution>, Option<f64>), SolveError> {
    let before = processor_seconds();
    let solutions: Result<_, _> = systems.iter().map(|system| solver.solve(&**system, goal, watch)).collect();
    Ok((solutions?, processor_seconds().zip(before).map(|(after, before)| after - before)))
}

/// One account of all polarisations.
fn joined(solutions: &[Solution]) -> Account {
    let mut joint = solutions[0].account.clone();
    solutions[1..].iter().for_each(|solution| joint.join(&solution.account));
    joint
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

impl ComparisonFile {
    /// The means that a strategy is compared with: the one requested, or else the one that suits it
    /// best and, where absorption makes a difference, the real one too.
    pub(super) fn means(&self, solver: &dyn Solver, absorbs: bool) -> Vec<Mean> {
        let depends_on_z = self.mean_depends_on_z.unwrap_or(true);
        let mean = |absorbing| Mean { depends_on_z, absorbing: absorbing && absorbs };
        match self.absorbing_mean {
            Some(requested) => vec![mean(requested)],
            None if absorbs && solver.suited_mean().absorbing => vec![mean(true), mean(false)],
            None => vec![mean(false)],
        }
    }
}

/// Whether any medium of the layer absorbs: otherwise both means are equal.
pub(super) fn absorbs(media: &Media) -> bool {
    media.backgrounds.iter().chain(&media.inclusions).any(|eta| (eta * eta).im != 0.0)
}
