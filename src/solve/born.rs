//! The Born series about the mean medium: u ← u₀ − A⁻¹V u (P2 (2.5)–(2.7)).

use super::solver::{Account, Goal, Solution, SolveError, Solver, Step, Watch};
use super::vectors::norm;
use crate::wave::{Field, Problem};
use serde::{Deserialize, Serialize};

/// Terms are added until they are small; stops early when they grow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Born {
    /// Steps over which the ratio of successive terms is averaged (geometric mean).
    pub window: usize,
}

impl Default for Born {
    fn default() -> Born {
        Born { window: 6 }
    }
}

/// Terms this much larger than the incident wave have nothing left to add to.
const HOPELESS: f64 = 1e3;

impl Solver for Born {
    fn name(&self) -> &'static str {
        "born"
    }

    fn solve_from(
        &self,
        problem: &Problem,
        start: Option<&Field>,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<Solution, SolveError> {
        let clock = std::time::Instant::now();
        let background = problem.background_wave();
        let scale = norm(flat(&background));
        let mut field = start.cloned().unwrap_or_else(|| background.clone());
        let mut term = Field::zeros(problem.shape());
        let bytes = 3 * field.len() * size_of::<num_complex::Complex64>();
        let mut account = Account { solver: self.name().into(), bytes, ..Account::default() };
        loop {
            // The residual is the next term of the series, so one application serves both.
            problem.residual(&background, &field, &mut term);
            account.operator_applications += 1;
            account.residual = norm(flat(&term)) / scale;
            account.history.push(account.residual);
            account.seconds = clock.elapsed().as_secs_f64();
            if account.residual <= goal.tolerance {
                return Ok(Solution { field, account });
            }
            self.judge(&account, goal)?;
            field += &term;
            account.steps += 1;
            let step = Step {
                step: account.steps,
                applications: account.operator_applications,
                residual: account.residual,
            };
            if watch.step(&step).is_break() {
                return Err(SolveError::Cancelled { account: Box::new(account) });
            }
        }
    }
}

impl Born {
    /// Gives up on growth over the window, on a hopeless size, and on too many applications.
    fn judge(&self, account: &Account, goal: Goal) -> Result<(), SolveError> {
        let ratio = ratio_of_terms(&account.history, self.window);
        let hopeless = !account.residual.is_finite() || account.residual > HOPELESS;
        if hopeless || ratio.is_some_and(|r| r >= 1.0) {
            let ratio = ratio.unwrap_or(f64::INFINITY);
            return Err(SolveError::Diverged { account: Box::new(account.clone()), ratio });
        }
        if account.operator_applications >= goal.max_applications {
            let advice =
                format!("terms shrink by {:.4} a step; use krylov or allow more", ratio.unwrap_or(1.0));
            return Err(SolveError::NotConverged {
                account: Box::new(account.clone()),
                tolerance: goal.tolerance,
                advice,
            });
        }
        Ok(())
    }
}

/// Geometric mean of the ratio of successive terms over the last `window` steps, once there are that many.
pub fn ratio_of_terms(history: &[f64], window: usize) -> Option<f64> {
    let last = history.len().checked_sub(1)?;
    let first = last.checked_sub(window.max(1))?;
    Some((history[last] / history[first]).powf(1.0 / window.max(1) as f64))
}

fn flat(field: &Field) -> &[num_complex::Complex64] {
    field.as_slice().expect("fields are contiguous")
}
