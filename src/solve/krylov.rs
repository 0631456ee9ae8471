//! GMRES with restart on (1 + A⁻¹V) u = u₀ (Saad and Schultz 1986): our own, since no maintained crate offers
//! it for complex operators that are never assembled.

use super::solver::{Account, Goal, Solution, SolveError, Solver, Step, Watch};
use super::vectors::{add_combination, dots, norm, scale};
use crate::wave::{Field, Problem};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Restarted GMRES; memory: `restart` + 4 vectors of 16 bytes per unknown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Gmres {
    /// Basis vectors kept before a restart.
    pub restart: usize,
}

impl Default for Gmres {
    fn default() -> Gmres {
        Gmres { restart: 120 }
    }
}

/// A second orthogonalisation pays when the first one removed nearly everything (Kahan, Parlett).
const REORTHOGONALISE: f64 = 0.05;

impl Solver for Gmres {
    fn name(&self) -> &'static str {
        "krylov"
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
        let field = start.cloned().unwrap_or_else(|| Field::zeros(problem.shape()));
        let account = Account { solver: self.name().into(), ..Account::default() };
        let scale = norm(flat(&background));
        let work = Field::zeros(problem.shape());
        let mut run = Run { problem, background, field, work, scale, goal, account, clock };
        if !problem.has_contrast() {
            run.field.assign(&run.background);
            run.account.history.push(0.0);
            return Ok(run.finish());
        }
        run.start(start.is_some());
        while run.account.residual > goal.tolerance {
            let before = run.account.residual;
            run.cycle(self.restart.max(1), watch)?;
            run.measure();
            run.check_progress(before)?;
        }
        Ok(run.finish())
    }
}

/// One solve under way.
struct Run<'a> {
    problem: &'a Problem,
    background: Field,
    field: Field,
    work: Field,
    scale: f64,
    goal: Goal,
    account: Account,
    clock: std::time::Instant,
}

impl Run<'_> {
    fn finish(mut self) -> Solution {
        self.account.seconds = self.clock.elapsed().as_secs_f64();
        Solution { field: self.field, account: self.account }
    }

    /// The first residual; that of u = 0 is u₀ itself and costs nothing.
    fn start(&mut self, guessed: bool) {
        if guessed {
            self.measure();
        } else {
            self.work.assign(&self.background);
            self.account.residual = 1.0;
        }
        self.account.history.push(self.account.residual);
    }

    /// True residual into `work` and the account.
    fn measure(&mut self) {
        self.problem.residual(&self.background, &self.field, &mut self.work);
        self.account.operator_applications += 1;
        self.account.residual = norm(flat(&self.work)) / self.scale;
    }

    /// One restart cycle: builds a basis from the residual in `work` and corrects the field.
    fn cycle(&mut self, restart: usize, watch: &mut dyn Watch) -> Result<(), SolveError> {
        let beta = self.account.residual * self.scale;
        let mut first = flat(&self.work).to_vec();
        scale(&mut first, 1.0 / beta);
        let mut basis = vec![first];
        let mut small = LeastSquares::new(beta);
        let mut cancelled = false;
        while basis.len() <= restart {
            let (column, next) = self.expand(&basis);
            let breakdown = next.is_none();
            self.account.residual = small.add_column(column) / self.scale;
            self.note();
            let step = Step {
                step: self.account.steps,
                applications: self.account.operator_applications,
                residual: self.account.residual,
            };
            cancelled = watch.step(&step).is_break();
            // A little below the goal, so that the true residual, measured next, meets it too.
            let reached = self.account.residual <= 0.9 * self.goal.tolerance;
            basis.extend(next);
            if breakdown || reached || cancelled || self.exhausted() {
                break;
            }
        }
        self.account.bytes = (basis.len() + 3) * self.field.len() * size_of::<Complex64>();
        let coefficients = small.solve();
        let field = self.field.as_slice_mut().expect("fields are contiguous");
        add_combination(field, &coefficients, &basis[..coefficients.len()]);
        if cancelled {
            return Err(SolveError::Cancelled { account: Box::new(self.account.clone()) });
        }
        Ok(())
    }

    fn note(&mut self) {
        self.account.steps += 1;
        self.account.operator_applications += 1;
        self.account.history.push(self.account.residual);
        self.account.seconds = self.clock.elapsed().as_secs_f64();
    }

    fn exhausted(&self) -> bool {
        self.account.operator_applications >= self.goal.max_applications
    }

    /// Applies the operator to the last basis vector and orthogonalises: Hessenberg column and new vector.
    fn expand(&mut self, basis: &[Vec<Complex64>]) -> (Vec<Complex64>, Option<Vec<Complex64>>) {
        let last = basis.last().expect("a cycle starts with one vector");
        // The field's buffer holds u, so the vector is viewed in its shape instead of copied there.
        let view =
            ndarray::ArrayView2::from_shape(self.problem.shape(), last).expect("same number of unknowns");
        self.problem.scatter_view(view, &mut self.work);
        let mut w: Vec<Complex64> = flat(&self.work).to_vec();
        add_combination(&mut w, &[Complex64::ONE], std::slice::from_ref(last));
        let before = norm(&w);
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

    fn check_progress(&mut self, before: f64) -> Result<(), SolveError> {
        let stalled = self.account.residual > 0.999 * before;
        let done = self.account.residual <= self.goal.tolerance;
        if done || (!self.exhausted() && !stalled && self.account.residual.is_finite()) {
            return Ok(());
        }
        let advice =
            if stalled { "it stalls; raise restart or the resolution" } else { "allow more applications" };
        let account = Box::new(self.account.clone());
        Err(SolveError::NotConverged { account, tolerance: self.goal.tolerance, advice: advice.to_string() })
    }
}

fn subtract(w: &mut [Complex64], column: &[Complex64], basis: &[Vec<Complex64>]) -> f64 {
    let negative: Vec<Complex64> = column.iter().map(|c| -c).collect();
    add_combination(w, &negative, basis)
}

fn flat(field: &Field) -> &[Complex64] {
    field.as_slice().expect("fields are contiguous")
}

/// min ‖β e₁ − H y‖ by Givens rotations, one column at a time.
struct LeastSquares {
    columns: Vec<Vec<Complex64>>,
    rotations: Vec<(f64, Complex64)>,
    right: Vec<Complex64>,
}

impl LeastSquares {
    fn new(beta: f64) -> LeastSquares {
        LeastSquares { columns: Vec::new(), rotations: Vec::new(), right: vec![beta.into()] }
    }

    /// Adds a Hessenberg column (its last entry the new norm) and returns the residual's norm.
    fn add_column(&mut self, mut column: Vec<Complex64>) -> f64 {
        for (i, &(c, s)) in self.rotations.iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            column[i] = c * a + s * b;
            column[i + 1] = -s.conj() * a + c * b;
        }
        let k = self.rotations.len();
        let below = column.pop().expect("a column ends with its norm");
        let diagonal = column[k];
        let length = diagonal.norm().hypot(below.norm());
        let (c, s) = match diagonal.norm() {
            0.0 => (0.0, Complex64::ONE),
            d => (d / length, diagonal / d * below.conj() / length),
        };
        column[k] = c * diagonal + s * below;
        self.rotations.push((c, s));
        let last = self.right[k];
        self.right[k] = c * last;
        self.right.push(-s.conj() * last);
        self.columns.push(column);
        self.right[k + 1].norm()
    }

    fn solve(&self) -> Vec<Complex64> {
        let n = self.columns.len();
        let mut y = self.right[..n].to_vec();
        for i in (0..n).rev() {
            y[i] /= self.columns[i][i];
            let yi = y[i];
            (0..i).for_each(|r| y[r] -= self.columns[i][r] * yi);
        }
        y
    }
}

#[cfg(test)]
#[path = "krylov_tests.rs"]
mod tests;
