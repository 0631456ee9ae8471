//! The account that every strategy keeps while it runs, in this crate and in others.

use super::account::{Account, Goal, Solution, SolveError, Step, Watch};
use super::vectors::norm;
use crate::wave::{Field, Problem, System};
use num_complex::Complex64;
use std::time::Instant;

/// Residuals above this multiple of the incident wave count as divergence.
const HOPELESS: f64 = 1e4;

/// A solve in progress: residual measure, history and watch.
///
/// A strategy creates a ledger, measures its fields with it, notes every residual, and ends with
/// [`Ledger::finish`] or one of the errors created by the ledger. It adds its own work to
/// [`Ledger::account`]: steps, and further operator applications.
pub struct Ledger<'a> {
    /// The problem being solved.
    pub problem: &'a dyn System,
    /// u₀ = A⁻¹b, the wave in the mean medium: harmonics of every unknown plane.
    pub background: Field,
    /// Tolerance and limits.
    pub goal: Goal,
    /// The account up to now.
    pub account: Account,
    scale: f64,
    /// Whether the source is the problem's own, the incident wave.
    is_lit: bool,
    watch: &'a mut dyn Watch,
    clock: Instant,
}

impl<'a> Ledger<'a> {
    /// Opens the account of a solve by the strategy `name` and starts its clock.
    pub fn new(name: &str, problem: &'a dyn System, goal: Goal, watch: &'a mut dyn Watch) -> Ledger<'a> {
        let clock = Instant::now();
        let background = problem.background_wave();
        let scale = norm(flat(&background));
        let account = Account { solver: name.to_string(), residual: 1.0, ..Account::default() };
        Ledger { problem, background, goal, account, scale, is_lit: true, watch, clock }
    }

    /// The solve with a source of one's own, for tangents and adjoints; `background` is A⁻¹ applied
    /// to it.
    pub fn with_source(self, background: Field) -> Ledger<'a> {
        Ledger { scale: norm(flat(&background)), background, is_lit: false, ..self }
    }

    /// A and V separately, for a strategy that alternates between them.
    ///
    /// # Errors
    /// The system has no values at points, or the source is not the problem's.
    pub(in crate::solve) fn split(&self) -> Result<&'a Problem, SolveError> {
        let allowed = "a strategy that only applies the operator, for Maxwell's equations";
        let remedy = "it works on field values at points, and the unknowns here are moments: use krylov";
        let problem = self.problem.split().filter(|_| self.is_lit);
        problem.ok_or_else(|| SolveError::setting("solver", &self.account.solver, allowed, remedy))
    }

    /// Records the memory of `vectors` fields of the problem's size.
    pub fn holds_vectors(&mut self, vectors: usize) {
        self.account.bytes = vectors * self.background.len() * size_of::<Complex64>();
    }

    /// Norm ‖u₀‖, the unit of relative residuals.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// True relative residual of `u`; the residual vector is written to `out`. One operator
    /// application.
    pub fn measure(&mut self, u: &Field, out: &mut Field) -> f64 {
        self.problem.residual(&self.background, u, out);
        self.account.operator_applications += 1;
        self.account.residual = norm(flat(out)) / self.scale;
        self.account.residual
    }

    /// The initial field, with its residual noted: `start`, or u₀, which is the solution without
    /// contrast. The residual vector is written to `scratch`.
    ///
    /// # Errors
    /// See [`Ledger::note`].
    pub fn first_field(&mut self, start: Option<&Field>, scratch: &mut Field) -> Result<Field, SolveError> {
        if !self.problem.has_contrast() {
            self.note(0.0)?;
            return Ok(self.background.clone());
        }
        let field = start.cloned().unwrap_or_else(|| self.background.clone());
        let residual = self.measure(&field, scratch);
        self.note(residual)?;
        Ok(field)
    }

    /// The initial field and its residual vector, which is noted: `start`, or 0, whose residual u₀
    /// costs nothing.
    ///
    /// # Errors
    /// See [`Ledger::note`].
    pub fn from_zero(&mut self, start: Option<&Field>) -> Result<[Field; 2], SolveError> {
        let field = start.cloned().unwrap_or_else(|| Field::zeros(self.problem.shape()));
        let mut residual = self.background.clone();
        let first = if start.is_some() { self.measure(&field, &mut residual) } else { 1.0 };
        self.note(first)?;
        Ok([field, residual])
    }

    /// Adds a residual to the history and asks the watch whether to continue.
    ///
    /// # Errors
    /// [`SolveError::Cancelled`] if the watch stops the solve.
    pub fn note(&mut self, residual: f64) -> Result<(), SolveError> {
        self.account.residual = residual;
        self.account.history.push(residual);
        self.account.seconds = self.clock.elapsed().as_secs_f64();
        let Account { steps: step, operator_applications: applications, .. } = self.account;
        if self.watch.step(&Step { step, applications, residual }).is_break() {
            return Err(SolveError::Cancelled { account: Box::new(self.account.clone()) });
        }
        Ok(())
    }

    /// Whether the last residual meets the goal.
    pub fn reached(&self) -> bool {
        self.account.residual <= self.goal.tolerance
    }

    /// Whether the operator applications of the goal are used up.
    pub fn exhausted(&self) -> bool {
        self.account.operator_applications >= self.goal.max_applications
    }

    /// Fails if the residual is not finite or far too large, or if the applications are used up.
    ///
    /// # Errors
    /// [`SolveError::Diverged`] or [`SolveError::NotConverged`] with `advice`.
    pub fn judge(&self, advice: &str) -> Result<(), SolveError> {
        if !self.account.residual.is_finite() || self.account.residual > HOPELESS {
            let window = self.account.history.len().saturating_sub(1).min(6);
            return Err(self.diverged(ratio_of_terms(&self.account.history, window).unwrap_or(f64::INFINITY)));
        }
        if self.exhausted() { Err(self.not_converged(advice)) } else { Ok(()) }
    }

    /// The error of an iteration whose terms grow by the factor `ratio` per step.
    pub fn diverged(&self, ratio: f64) -> SolveError {
        SolveError::Diverged { account: Box::new(self.account.clone()), ratio }
    }

    /// The error of an iteration that did not converge, with advice on what to try.
    pub fn not_converged(&self, advice: &str) -> SolveError {
        let account = Box::new(self.account.clone());
        SolveError::NotConverged { account, tolerance: self.goal.tolerance, advice: advice.to_string() }
    }

    /// Closes the account of a converged field.
    pub fn finish(mut self, field: Field) -> Solution {
        self.account.seconds = self.clock.elapsed().as_secs_f64();
        Solution { field, account: self.account }
    }
}

/// Geometric mean of the ratio of successive residuals over the last `window` steps, if there are
/// that many.
pub fn ratio_of_terms(history: &[f64], window: usize) -> Option<f64> {
    let window = window.max(1);
    let last = history.len().checked_sub(1)?;
    Some((history[last] / history[last.checked_sub(window)?]).powf(1.0 / window as f64))
}

/// A field as one long vector.
pub fn flat(field: &Field) -> &[Complex64] {
    field.as_slice().expect("fields are contiguous")
}
