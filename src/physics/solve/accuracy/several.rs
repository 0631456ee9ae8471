//! Several directions of one geometry on one grid: those that need most of it choose it and judge
//! its error, as the test solves of a study do; the others are solved on it alone, without
//! companions.

use super::companions::{error_estimate, judged};
use super::error::{AccuracyError, Result};
use super::task::{Estimated, Solved, Task};
use crate::numerics::estimate::largest;
use crate::solve::account::{Goal, Watch};
use crate::wave::{FarField, Incidence, Resolution, Side};

/// A grid that several directions share, with the errors that it causes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedGrid {
    /// The grid.
    pub resolution: Resolution,
    /// Contributions of the grid to the largest estimate of the directions compared: plane, z.
    pub parts: [f64; 2],
    /// Amplitude error that the grid was searched for; `None` for a given grid.
    accuracy: Option<f64>,
}

impl SharedGrid {
    /// The grid on which all `tasks` reach `accuracy`.
    ///
    /// # Errors
    /// As [`Task::solve_to_accuracy`].
    pub fn found(tasks: &[Task], accuracy: f64, watch: &mut dyn Watch) -> Result<SharedGrid> {
        let mut shared: Option<SharedGrid> = None;
        for task in tasks {
            let before = shared.map(|grid| grid.resolution);
            let found = task.solve_to_accuracy_from(before, accuracy, watch)?;
            shared = Some(Self::joined(shared, &found, Some(accuracy)));
        }
        shared.ok_or(AccuracyError::Accuracy(accuracy))
    }

    /// A given grid, judged by `tasks`.
    ///
    /// # Errors
    /// As [`Task::solve_with_estimate`].
    pub fn given(tasks: &[Task], resolution: Resolution, watch: &mut dyn Watch) -> Result<SharedGrid> {
        let mut shared: Option<SharedGrid> = None;
        for task in tasks {
            let found = task.solve_with_estimate(resolution, watch)?;
            shared = Some(Self::joined(shared, &found, None));
        }
        Ok(shared.unwrap_or(SharedGrid { resolution, parts: [0.0; 2], accuracy: None }))
    }

    /// What the solves so far share with one more, which has the finest grid of them.
    fn joined(before: Option<SharedGrid>, found: &Estimated, accuracy: Option<f64>) -> SharedGrid {
        let known = before.map_or([0.0; 2], |grid| grid.parts);
        let is_larger = found.parts[0] + found.parts[1] > known[0] + known[1];
        let parts = if is_larger { found.parts } else { known };
        SharedGrid { resolution: found.system().grid().resolution, parts, accuracy }
    }

    /// Solves one direction on the grid; its error estimate is that of the directions compared,
    /// with its own residual. A direction whose orders or cells need a finer grid searches its own.
    ///
    /// # Errors
    /// As [`Task::solve`], and results that break a physical law.
    pub fn solve(&self, task: &Task, watch: &mut dyn Watch) -> Result<Estimated> {
        let tolerance = self.accuracy.map_or(task.goal.tolerance, |a| task.goal.tolerance.min(a / 50.0));
        let task = Task { goal: Goal { tolerance, ..task.goal }, ..*task };
        let solved = self.solve_here(&task, watch);
        match (solved, self.accuracy) {
            (Err(AccuracyError::Wave(_) | AccuracyError::Unphysical(_)), Some(accuracy)) => {
                task.solve_to_accuracy(accuracy, watch)
            }
            (solved, _) => solved,
        }
    }

    fn solve_here(&self, task: &Task, watch: &mut dyn Watch) -> Result<Estimated> {
        let (solved, seconds_setup) = task.solve(self.resolution, watch)?;
        let far_fields: Vec<FarField> = solved.iter().map(Solved::far_field).collect();
        let residual = largest(solved.iter().map(|s| s.solution.account.residual));
        Ok(Estimated {
            far_fields: judged(far_fields, self.parts, residual)?,
            solved,
            error_estimate: error_estimate(self.parts, residual),
            parts: self.parts,
            seconds_setup,
            seconds_estimate: 0.0,
        })
    }
}

/// The directions that choose a shared grid: on either side the steepest and the flattest, as of a
/// study's test solves; by number, ascending.
pub fn compared_directions(lights: &[Incidence]) -> Vec<usize> {
    let mut compared = Vec::new();
    for side in [Side::Incident, Side::Exit] {
        let polar = |&i: &usize| lights[i].polar_deg;
        let of_side = || (0..lights.len()).filter(|&i| lights[i].from == side);
        compared.extend(of_side().min_by(|a, b| polar(a).total_cmp(&polar(b))));
        // the first of equals
        compared.extend(of_side().rev().max_by(|a, b| polar(a).total_cmp(&polar(b))));
    }
    compared.sort_unstable();
    compared.dedup();
    compared
}

#[cfg(test)]
#[path = "several_tests.rs"]
mod tests;
