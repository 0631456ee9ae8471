//! Interface of the strategies: goal, account and errors.

use super::size::Size;
use crate::wave::{Field, Mean, Problem, Resolution, System};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::ControlFlow;
use thiserror::Error;

/// Goal of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
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
#[derive(Clone, Debug, Default, Serialize)]
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
    /// Adds the account of another polarisation: sums of steps, applications and seconds, the larger
    /// residual.
    pub fn join(&mut self, other: &Account) {
        self.steps += other.steps;
        self.operator_applications += other.operator_applications;
        self.seconds += other.seconds;
        self.residual = self.residual.max(other.residual);
        self.bytes = self.bytes.max(other.bytes);
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

/// A strategy with its memory demand.
pub struct Fit {
    /// Largest memory besides the problem in bytes, unless a stalled solve lets it grow.
    pub bytes: f64,
    /// The strategy with less memory, or with permission to grow; `None` if it is unchanged.
    pub solver: Option<Box<dyn Solver>>,
}

impl Fit {
    /// The demand of a strategy with constant memory.
    pub fn fixed(bytes: f64) -> Fit {
        Fit { bytes, solver: None }
    }
}

/// A strategy: it controls its iteration, while the problem defines the residual. Strategies of
/// other crates implement this trait, keep their account in a [`Ledger`](super::Ledger) and are
/// added to a [`Registry`](super::Registry).
///
/// ```
/// use inkwave_physics::solve::{Gmres, Goal, Silent, Solver};
/// use inkwave_physics::wave::{Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
///
/// // A plate of glass, 0.4 µm: nothing varies along x and y, so that one point is enough.
/// let scene = Scene::layer([1.0, 1.0], 0.4, vec![]);
/// let media = Media { incident: 1.0.into(), exit: 1.0.into(), backgrounds: vec![1.5.into()], inclusions: vec![] };
/// let light = Incidence { wavelength_um: 0.6, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
/// let grid = Resolution { nx: 1, ny: 1, cells: 4, scheme: Scheme::Cubic };
/// let problem = Problem::from_scene(&scene, &media, &light, grid, Mean::default())?;
///
/// // λ/n = 0.4 µm: a full wavelength in the plate, which therefore transmits everything (Fresnel and Airy).
/// let solution = Gmres::default().solve(&problem, Goal::default(), &mut Silent)?;
/// let far = problem.far_field(&solution.field);
/// assert!((far.transmittance - 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Solver: Send + Sync {
    /// Name in tables and in [`Account::solver`].
    fn name(&self) -> &'static str;

    /// Solves to `goal.tolerance`, or fails with the reason. `start` is an optional initial guess
    /// of u.
    ///
    /// # Errors
    /// [`SolveError`]: not converged, diverged, cancelled by the watch, or settings that do not
    /// suit the problem.
    fn solve_from(
        &self,
        problem: &dyn System,
        start: Option<&Field>,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<Solution, SolveError>;

    /// Calls [`Solver::solve_from`] without an initial guess: most strategies start from the wave
    /// in the mean medium.
    fn solve(&self, problem: &dyn System, goal: Goal, watch: &mut dyn Watch) -> Result<Solution, SolveError> {
        self.solve_from(problem, None, goal, watch)
    }

    /// Mean medium that the strategy can use: relaxation needs a real one, most accept any.
    fn suited_mean(&self) -> Mean {
        Mean::default()
    }

    /// Memory demand besides a problem of the given size if `bytes` are available; more than that
    /// if the strategy cannot run with less.
    fn fit(&self, size: &Size, _bytes: f64) -> Fit {
        Fit::fixed(size.fields(50.0))
    }

    /// Largest number of unknowns of strategies that store a dense matrix; comparisons omit larger
    /// cases by default.
    fn most_unknowns(&self) -> Option<usize> {
        None
    }
}

/// A and V separately, for a strategy that alternates between them.
///
/// # Errors
/// The system has no values at points.
pub(in crate::solve) fn split<'a>(system: &'a dyn System, name: &str) -> Result<&'a Problem, SolveError> {
    system.split().ok_or_else(|| SolveError::Setting {
        field: "solver",
        value: name.to_string(),
        allowed: "a strategy that only applies the operator, for Maxwell's equations".to_string(),
        remedy: "it works on field values at points, and the unknowns here are moments: use krylov"
            .to_string(),
    })
}

/// Remedy if a strategy diverges.
fn instead_of(solver: &str) -> &'static str {
    match solver {
        "krylov" => "give lengths in µm and refractive indices of matter, and more points and cells",
        _ => "use strategy = \"krylov\", which converges on the same problem",
    }
}
