//! GMRES with restart on (1 + A⁻¹V) u = u₀ (Saad and Schultz 1986): our own, since no maintained crate offers
//! it for complex operators that are never assembled.

use super::guided::{Correction, GuidedModes};
use super::least_squares::LeastSquares;
use crate::solve::System;
use crate::solve::demand::Size;
use crate::solve::ledger::{Ledger, flat};
use crate::solve::solver::{Goal, Solution, SolveError, Solver, Watch};
use crate::solve::vectors::{add_combination, dots, norm, scale};
use crate::wave::Field;
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Restarted GMRES; memory: the basis (at most `restart` vectors) and 4 vectors of 16 bytes per unknown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Gmres {
    /// Basis vectors kept before a restart.
    pub restart: usize,
    /// Treatment of the mean slab's guided modes.
    pub guided_modes: GuidedModes,
}

impl Default for Gmres {
    fn default() -> Gmres {
        Gmres { restart: 150, guided_modes: GuidedModes::default() }
    }
}

/// Vectors besides the basis: field, residual, the incident wave, the work of one step.
const OTHER_VECTORS: f64 = 7.0;
/// Share of scarce memory that the guided modes' dense block may take.
const GUIDED_SHARE: f64 = 0.3;
/// Fewest basis vectors that restarts still converge with.
const LEAST_RESTART: usize = 20;

/// A second orthogonalisation pays when the first one removed nearly everything (Kahan, Parlett).
const REORTHOGONALISE: f64 = 0.05;

impl Solver for Gmres {
    fn name(&self) -> &'static str {
        "krylov"
    }

    fn solve_from(
        &self,
        problem: &dyn System,
        start: Option<&Field>,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<Solution, SolveError> {
        let mut ledger = Ledger::new(self.name(), problem, goal, watch);
        if !problem.has_contrast() {
            ledger.note(0.0)?;
            let field = ledger.background.clone();
            return Ok(ledger.finish(field));
        }
        let field = start.cloned().unwrap_or_else(|| Field::zeros(problem.shape()));
        // The residual of u = 0 is u₀ itself and costs nothing.
        let work = ledger.background.clone();
        let correction = problem.scalar().and_then(|p| self.guided_modes.correction(p));
        let mut run = Run { ledger, field, work, correction };
        let first = if start.is_some() { run.ledger.measure(&run.field, &mut run.work) } else { 1.0 };
        run.ledger.note(first)?;
        while !run.ledger.reached() {
            let before = run.ledger.account.residual;
            run.cycle(self.restart.max(1))?;
            let after = run.ledger.measure(&run.field, &mut run.work);
            if !run.ledger.reached() && after > 0.99 * before {
                return Err(run.ledger.not_converged("it stalls; raise restart or the resolution"));
            }
            if !run.ledger.reached() {
                run.ledger.judge("allow more applications or raise restart")?;
            }
        }
        Ok(run.ledger.finish(run.field))
    }

    fn most_bytes(&self, size: &Size) -> f64 {
        size.fields(self.restart as f64 + OTHER_VECTORS) + self.guided_modes.most_bytes(size)
    }

    fn within(&self, size: &Size, bytes: f64) -> Option<Box<dyn Solver>> {
        let mut smaller = *self;
        smaller.guided_modes = self.guided_modes.within(GUIDED_SHARE * bytes);
        let left = bytes - smaller.guided_modes.most_bytes(size);
        let vectors = left / size.fields(1.0) - OTHER_VECTORS;
        smaller.restart = self.restart.min(vectors.max(0.0) as usize);
        (smaller.restart >= LEAST_RESTART.min(self.restart)).then(|| Box::new(smaller) as Box<dyn Solver>)
    }
}

/// One solve under way; `work` holds the residual at the start of a cycle.
struct Run<'a> {
    ledger: Ledger<'a>,
    field: Field,
    work: Field,
    correction: Option<Correction>,
}

impl Run<'_> {
    fn correct(&self, v: &mut [Complex64]) {
        self.correction.iter().for_each(|c| c.apply(v));
    }

    /// One restart cycle: builds a basis from the residual in `work` and corrects the field.
    fn cycle(&mut self, restart: usize) -> Result<(), SolveError> {
        let mut first = flat(&self.work).to_vec();
        let beta = norm(&first);
        scale(&mut first, 1.0 / beta);
        let (mut basis, mut small) = (vec![first], LeastSquares::new(beta));
        let mut verdict = Ok(());
        while basis.len() <= restart {
            let (column, next) = self.expand(&basis);
            let residual = small.add_column(column) / self.ledger.scale();
            self.ledger.account.steps += 1;
            self.ledger.account.operator_applications += 1;
            verdict = self.ledger.note(residual);
            let breakdown = next.is_none();
            basis.extend(next);
            // A little below the goal, so that the true residual, measured next, meets it too.
            let reached = residual <= 0.9 * self.ledger.goal.tolerance;
            if breakdown || reached || verdict.is_err() || self.ledger.exhausted() {
                break;
            }
        }
        self.ledger.holds_vectors(basis.len() + 3);
        self.ledger.account.bytes += self.correction.as_ref().map_or(0, Correction::bytes);
        let coefficients = small.solve();
        let mut change = vec![Complex64::default(); self.field.len()];
        add_combination(&mut change, &coefficients, &basis[..coefficients.len()]);
        self.correct(&mut change);
        let field = self.field.as_slice_mut().expect("fields are contiguous");
        add_combination(field, &[Complex64::ONE], std::slice::from_ref(&change));
        verdict
    }

    /// Applies the operator to the last basis vector and orthogonalises: Hessenberg column and new vector.
    fn expand(&mut self, basis: &[Vec<Complex64>]) -> (Vec<Complex64>, Option<Vec<Complex64>>) {
        let mut last = std::borrow::Cow::Borrowed(basis.last().expect("a cycle starts with one vector"));
        if self.correction.is_some() {
            self.correct(last.to_mut());
        }
        let problem = self.ledger.problem;
        let view = ndarray::ArrayView2::from_shape(problem.shape(), &last).expect("same number of unknowns");
        problem.scatter(view, &mut self.work);
        // The work array becomes the new basis vector; the next step writes into a fresh one.
        let work = std::mem::replace(&mut self.work, Field::zeros(problem.shape()));
        let mut w = work.into_raw_vec_and_offset().0;
        let before = add_combination(&mut w, &[Complex64::ONE], std::slice::from_ref(&last));
        let mut column = dots(basis, &w);
        let mut after = subtract(&mut w, &column, basis);
        if after < REORTHOGONALISE * before {
            let correction = dots(basis, &w);
            after = subtract(&mut w, &correction, basis);
            column.iter_mut().zip(correction).for_each(|(c, d)| *c += d);
        }
        column.push(after.into());
        if after <= 1e-14 * before {
            return (column, None);
        }
        scale(&mut w, 1.0 / after);
        (column, Some(w))
    }
}

fn subtract(w: &mut [Complex64], column: &[Complex64], basis: &[Vec<Complex64>]) -> f64 {
    let negative: Vec<Complex64> = column.iter().map(|c| -c).collect();
    add_combination(w, &negative, basis)
}

#[cfg(test)]
#[path = "krylov_tests.rs"]
mod tests;
