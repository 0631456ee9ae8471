//! The door: what a strategy is asked for, what it reports, and how it fails.

use super::System;
use super::demand::Size;
use crate::wave::{Field, Problem, Resolution};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::ControlFlow;
use thiserror::Error;

/// What is asked of a solver.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Goal {
    /// Relative residual to reach.
    pub tolerance: f64,
    /// Most operator applications (each one inverse and one forward transform of every plane).
    pub max_applications: usize,
}

impl Default for Goal {
    fn default() -> Goal {
        Goal { tolerance: 1e-6, max_applications: 2000 }
    }
}

/// One step of a solver, as shown to its watcher.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub step: usize,
    pub applications: usize,
    pub residual: f64,
}

/// Someone who looks on: progress bars, histories, cancellation.
pub trait Watch {
    /// Called after every step; `Break` stops the solve with [`SolveError::Cancelled`].
    fn step(&mut self, step: &Step) -> ControlFlow<()>;

    /// Called when a search for a grid begins to try one, and again when its error is known.
    fn grid(&mut self, _: &GridTrial) {}
}

/// A grid that a search tries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridTrial {
    /// The grid.
    pub resolution: Resolution,
    /// Largest amplitude error that was asked for.
    pub accuracy: f64,
    /// Largest amplitude error estimated, once it is known.
    pub estimate: Option<f64>,
    /// Seconds spent on this grid and its companions.
    pub seconds: f64,
}

impl fmt::Display for GridTrial {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Resolution { nx, ny, cells, .. } = self.resolution;
        write!(f, "{nx} × {ny} points, {cells} cells")?;
        match self.estimate {
            Some(estimate) => write!(f, ": error {estimate:.1e} in {:.1} s", self.seconds),
            None => write!(f, " for an error of {:.1e}", self.accuracy),
        }
    }
}

/// Nobody looks on.
pub struct Silent;

impl Watch for Silent {
    fn step(&mut self, _: &Step) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// The account of a solve.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Account {
    pub solver: String,
    pub steps: usize,
    pub operator_applications: usize,
    /// Relative residual after each step, the start included.
    pub history: Vec<f64>,
    /// Relative residual of the delivered field.
    pub residual: f64,
    pub seconds: f64,
    /// Bytes of the solver's own vectors.
    pub bytes: usize,
}

/// A converged field; there is no other kind.
#[derive(Clone, Debug)]
pub struct Solution {
    pub field: Field,
    pub account: Account,
}

/// Why there is no solution.
#[derive(Debug, Error)]
pub enum SolveError {
    #[error(
        "{} stopped at residual {:.2e} after {} operator applications (asked: {tolerance:.1e}): {advice}",
        .account.solver, .account.residual, .account.operator_applications
    )]
    NotConverged { account: Box<Account>, tolerance: f64, advice: String },
    #[error(
        "{} diverges: successive terms grow by a factor {ratio:.3} a step (residual {:.2e} after {} steps); \
         use solver = \"krylov\", which converges on the same problem",
        .account.solver, .account.residual, .account.steps
    )]
    Diverged { account: Box<Account>, ratio: f64 },
    #[error("the solve was cancelled after {} steps at residual {:.2e}", .account.steps, .account.residual)]
    Cancelled { account: Box<Account> },
    #[error("{field} is {value}; allowed is {allowed}: {remedy}")]
    Setting { field: &'static str, value: String, allowed: String, remedy: String },
}

impl SolveError {
    /// The account of what was done before the failure, where there is one.
    pub fn account(&self) -> Option<&Account> {
        match self {
            Self::NotConverged { account, .. }
            | Self::Diverged { account, .. }
            | Self::Cancelled { account } => Some(account),
            Self::Setting { .. } => None,
        }
    }
}

/// A strategy. The solver owns its loop; the problem owns the yardstick.
pub trait Solver: Send + Sync {
    fn name(&self) -> &'static str;

    /// Solves to `goal.tolerance`, or says why not. `start` is a first guess of u, if there is one.
    fn solve_from(
        &self,
        problem: &dyn System,
        start: Option<&Field>,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<Solution, SolveError>;

    fn solve(&self, problem: &dyn System, goal: Goal, watch: &mut dyn Watch) -> Result<Solution, SolveError> {
        self.solve_from(problem, None, goal, watch)
    }

    /// Most bytes that the strategy takes besides the problem itself, for a problem of that size.
    fn most_bytes(&self, size: &Size) -> f64 {
        size.fields(50.0)
    }

    /// The same strategy in `bytes`, where it can do with less than [`Solver::most_bytes`].
    fn within(&self, _size: &Size, _bytes: f64) -> Option<Box<dyn Solver>> {
        None
    }
}

/// The scalar problem behind a system, for a strategy that splits its operator point by point.
pub(in crate::solve) fn scalar<'a>(system: &'a dyn System, name: &str) -> Result<&'a Problem, SolveError> {
    system.scalar().ok_or_else(|| SolveError::Setting {
        field: "solver",
        value: name.to_string(),
        allowed: "krylov, bicgstab, born or direct for Maxwell's equations".to_string(),
        remedy:
            "this strategy works on field values at points, and the unknowns here are moments: use krylov"
                .to_string(),
    })
}

/// The strategies by name, with their settings; chosen in this one `match`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SolverChoice {
    Krylov(super::Gmres),
    Bicgstab(super::Bicgstab),
    Born(super::Born),
    ConvergentBorn(super::ConvergentBorn),
    Relaxation(super::Relaxation),
    Direct(super::Direct),
}

impl Default for SolverChoice {
    fn default() -> SolverChoice {
        SolverChoice::Krylov(super::Gmres::default())
    }
}

impl SolverChoice {
    /// All names, the default first.
    pub const NAMES: [&'static str; 6] =
        ["krylov", "bicgstab", "born", "convergent_born", "relaxation", "direct"];

    /// The strategy of that name with its default settings.
    pub fn named(name: &str) -> Result<SolverChoice, SolveError> {
        match name {
            "krylov" => Ok(SolverChoice::Krylov(Default::default())),
            "bicgstab" => Ok(SolverChoice::Bicgstab(Default::default())),
            "born" => Ok(SolverChoice::Born(Default::default())),
            "convergent_born" => Ok(SolverChoice::ConvergentBorn(Default::default())),
            "relaxation" => Ok(SolverChoice::Relaxation(Default::default())),
            "direct" => Ok(SolverChoice::Direct(Default::default())),
            _ => Err(SolveError::Setting {
                field: "solver",
                value: name.to_string(),
                allowed: Self::NAMES.join(", "),
                remedy: "choose one of these".to_string(),
            }),
        }
    }

    /// The strategy itself.
    pub fn build(&self) -> Box<dyn Solver> {
        match *self {
            SolverChoice::Krylov(settings) => Box::new(settings),
            SolverChoice::Bicgstab(settings) => Box::new(settings),
            SolverChoice::Born(settings) => Box::new(settings),
            SolverChoice::ConvergentBorn(settings) => Box::new(settings),
            SolverChoice::Relaxation(settings) => Box::new(settings),
            SolverChoice::Direct(settings) => Box::new(settings),
        }
    }
}
