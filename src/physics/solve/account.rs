//! Goal, account and errors of a solve, and what watches it.

use crate::wave::{Field, Resolution};
use std::fmt;
use std::ops::{ControlFlow, RangeInclusive};
use thiserror::Error;

/// Factor on the tolerance of a residual that breaks the balance of energy, and the smallest one.
const SMALLER: f64 = 0.1;
const LEAST_TOLERANCE: f64 = 1e-9;

/// Goal of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Goal {
    /// Relative residual to reach.
    pub tolerance: f64,
    /// Limit on operator applications (each one inverse and one forward transform of every plane).
    pub max_applications: usize,
}

impl Default for Goal {
    fn default() -> Goal {
        Goal { tolerance: 1e-6, max_applications: 2000 }
    }
}

impl Goal {
    /// The next goal for a field whose residual breaks the balance of energy, as trapped waves
    /// amplify it; `None` near what rounding allows.
    pub fn smaller(self) -> Option<Goal> {
        let tolerance = SMALLER * self.tolerance;
        (tolerance >= LEAST_TOLERANCE).then_some(Goal { tolerance, ..self })
    }
}

/// One step of a solver, as reported to its watch.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Number of the step, from 0.
    pub step: usize,
    /// Operator applications so far.
    pub applications: usize,
    /// Relative residual.
    pub residual: f64,
}

/// Observer of a solve: progress bars, histories, cancellation.
pub trait Watch {
    /// Called after every step; `Break` stops the solve with [`SolveError::Cancelled`].
    fn step(&mut self, step: &Step) -> ControlFlow<()>;

    /// Called when a search starts on a grid, and again when its error is known.
    fn grid(&mut self, _: &GridTrial) {}
}

/// A grid tried by a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridTrial {
    /// The grid.
    pub resolution: Resolution,
    /// Largest amplitude error requested.
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

/// A watch that ignores everything.
pub struct Silent;

impl Watch for Silent {
    fn step(&mut self, _: &Step) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// The account of a solve.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Account {
    /// Name of the strategy.
    pub solver: String,
    /// Steps taken.
    pub steps: usize,
    /// Operator applications, each one inverse and one forward transform of every plane.
    pub operator_applications: usize,
    /// Relative residual after each step, including the start.
    pub history: Vec<f64>,
    /// Relative residual of the delivered field.
    pub residual: f64,
    /// Wall time of the solve, s.
    pub seconds: f64,
    /// Bytes of the solver's own vectors.
    pub bytes: usize,
}

impl Account {
    /// Adds the account of another polarisation: sums of steps, applications and seconds, the
    /// larger residual.
    pub fn join(&mut self, other: &Account) {
        self.steps += other.steps;
        self.operator_applications += other.operator_applications;
        self.seconds += other.seconds;
        self.residual = self.residual.max(other.residual);
        self.bytes = self.bytes.max(other.bytes);
    }

    /// Adds the steps, applications and seconds of the solve from whose field this one went on.
    pub fn follow(&mut self, before: &Account) {
        let residual = self.residual;
        self.join(before);
        self.residual = residual;
    }
}

/// A converged field; strategies return no others.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Nodes and bubbles of every harmonic: planes × harmonics.
    pub field: Field,
    /// Account of the solve.
    pub account: Account,
}

/// Why there is no solution.
#[derive(Debug, Error)]
pub enum SolveError {
    /// The goal was not met within its limits.
    #[error(
        "{} stopped at residual {:.2e} after {} operator applications (requested: {tolerance:.1e}): {advice}",
        .account.solver, .account.residual, .account.operator_applications
    )]
    NotConverged {
        /// Account up to the failure.
        account: Box<Account>,
        /// Requested relative residual.
        tolerance: f64,
        /// What to try.
        advice: String,
    },
    /// The iteration diverges.
    #[error(
        "{} diverges: successive terms grow by a factor {ratio:.3} per step (residual {:.2e} after {} steps); {}",
        .account.solver, .account.residual, .account.steps, instead_of(&account.solver)
    )]
    Diverged {
        /// Account up to the failure.
        account: Box<Account>,
        /// Growth factor of successive terms.
        ratio: f64,
    },
    /// The watch stopped the solve.
    #[error("the solve was cancelled after {} steps at residual {:.2e}", .account.steps, .account.residual)]
    Cancelled {
        /// Account up to the cancellation.
        account: Box<Account>,
    },
    /// A setting that is invalid or does not suit the problem.
    #[error("{field} is {value}; allowed is {allowed}: {remedy}")]
    Setting {
        /// Name of the setting.
        field: &'static str,
        /// Value found.
        value: String,
        /// What is allowed.
        allowed: String,
        /// What to try.
        remedy: String,
    },
}

impl SolveError {
    /// The error of a setting.
    pub(super) fn setting(field: &'static str, value: impl ToString, allowed: &str, remedy: &str) -> Self {
        let value = value.to_string();
        SolveError::Setting { field, value, allowed: allowed.into(), remedy: remedy.into() }
    }

    /// Refuses the setting of a whole number that is not in a range.
    pub(super) fn unless_within(
        field: &'static str,
        value: usize,
        range: RangeInclusive<usize>,
        remedy: &str,
    ) -> Result<(), Self> {
        let allowed = format!("a whole number from {} to {}", range.start(), range.end());
        if range.contains(&value) { Ok(()) } else { Err(Self::setting(field, value, &allowed, remedy)) }
    }

    /// Account up to the failure, if there is one.
    pub fn account(&self) -> Option<&Account> {
        match self {
            Self::NotConverged { account, .. }
            | Self::Diverged { account, .. }
            | Self::Cancelled { account } => Some(account),
            Self::Setting { .. } => None,
        }
    }
}

/// Remedy if a strategy diverges.
fn instead_of(solver: &str) -> &'static str {
    match solver {
        "krylov" => "give lengths in µm and refractive indices of matter, and more points and cells",
        _ => "use strategy = \"krylov\", which converges on the same problem",
    }
}
