//! GMRES with restart on (1 + A⁻¹V) u = u₀ (Saad and Schultz 1986): our own, since no maintained crate offers
//! it for complex operators that are never assembled.

use super::guided::{Correction, GuidedModes};
use super::least_squares::LeastSquares;
use crate::numerics::fourier::Real;
use crate::solve::basis::Basis;
use crate::solve::demand::Size;
use crate::solve::ledger::{Ledger, flat};
use crate::solve::solver::{Fit, Goal, Solution, SolveError, Solver, Watch};
use crate::solve::vectors::norm;
use crate::wave::operator::scattering::Scatter;
use crate::wave::{Field, System};
use ndarray::{Array2, ArrayView2};
use num_complex::{Complex, Complex64};
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

/// Residuals from which single precision is enough for the basis: its roundings are ten times smaller and more, and the
/// residual that counts is always measured in double precision.
const SINGLE: f64 = 5e-6;
/// Most vectors of a basis in single precision: where more are needed, their loss of orthogonality costs more.
const MOST_SINGLE: usize = 60;
/// A basis in single precision must reduce the true residual by this factor, or double precision takes over.
const SINGLE_GAIN: f64 = 0.2;
/// Vectors besides the basis: guess, field, residual, the incident wave, the work of one step.
const OTHER_VECTORS: f64 = 9.0;
/// Share of scarce memory that the guided modes' dense block may take.
const GUIDED_SHARE: f64 = 0.3;
/// Fewest basis vectors that restarts still converge with.
const LEAST_RESTART: usize = 20;
/// A cycle that leaves more than this share of the residual stalls.
const STALLS: f64 = 0.99;
/// A solve that a first cycle has not brought to its goal may take so many times `restart` vectors, where there is room: restarts
/// cost more applications than a longer basis does work (5 % of n = 2.6, 250 nm, κ = 0: 904 applications against 319).
const HARD_GROWTH: usize = 4;
/// A basis that is too short grows to so many times `restart`, at once: applications made with short ones are lost. Beyond,
/// orthogonalisation costs more than another strategy.
const MOST_GROWTH: usize = 8;

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
        Growing { settings: *self, longest: 0 }.solve_from(problem, start, goal, watch)
    }

    fn fit(&self, size: &Size, bytes: f64) -> Fit {
        let needs = |settings: &Gmres| settings.vectors_bytes(size) + settings.bytes_of_modes(size);
        let mut settings = *self;
        if needs(self) > bytes {
            settings.guided_modes = self.guided_modes.within(GUIDED_SHARE * bytes);
            settings.restart = self.restart.min(settings.most_vectors(size, bytes));
            if settings.restart < LEAST_RESTART.min(self.restart) {
                return Fit::fixed(needs(self));
            }
        }
        let longest = settings.most_vectors(size, bytes).min(MOST_GROWTH * settings.restart);
        let grows = longest > settings.restart;
        let fitted = Growing { settings, longest: if grows { longest } else { 0 } };
        let solver = (grows || settings != *self).then(|| Box::new(fitted) as Box<dyn Solver>);
        Fit { bytes: needs(&settings), solver }
    }
}

/// GMRES with what the memory leaves for solves that stall.
struct Growing {
    settings: Gmres,
    /// Basis vectors that a solve which stalls may grow to; 0 where it may not.
    longest: usize,
}

impl Solver for Growing {
    fn name(&self) -> &'static str {
        self.settings.name()
    }

    fn fit(&self, size: &Size, bytes: f64) -> Fit {
        self.settings.fit(size, bytes)
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
        let correction = problem.split().and_then(|p| self.settings.guided_modes.correction(p));
        let single = if goal.tolerance >= SINGLE { problem.single() } else { None };
        let (restart, first_cycle) = (self.settings.restart.max(1), true);
        let mut run = KrylovRun { ledger, field, work, correction, single, restart, first_cycle };
        let first = if start.is_some() { run.ledger.measure(&run.field, &mut run.work) } else { 1.0 };
        run.ledger.note(first)?;
        while !run.ledger.reached() {
            let before = run.ledger.account.residual;
            match run.single {
                Some(operator) => run.cycle(operator, run.restart.min(MOST_SINGLE))?,
                None => run.cycle(&Double(problem), run.restart)?,
            }
            run.ledger.measure(&run.field, &mut run.work);
            if !run.ledger.reached() {
                run.adapt(self, before)?;
            }
        }
        Ok(run.ledger.finish(run.field))
    }
}

impl Gmres {
    fn vectors_bytes(&self, size: &Size) -> f64 {
        size.fields(self.restart as f64 + OTHER_VECTORS)
    }

    /// Basis vectors that `bytes` hold beside all else.
    fn most_vectors(&self, size: &Size, bytes: f64) -> usize {
        let vectors = (bytes - self.bytes_of_modes(size)) / size.fields(1.0) - OTHER_VECTORS;
        vectors.max(0.0) as usize
    }

    /// Most bytes of guided modes, however hard the solve turns out to be.
    fn bytes_of_modes(&self, size: &Size) -> f64 {
        let hard = self.guided_modes.of_hard_solves();
        self.guided_modes.most_bytes(size).max(hard.most_bytes(size))
    }
}

impl Growing {
    /// What helps a solve that stalls with so many basis vectors, and has not been tried.
    fn advice(&self, restart: usize) -> String {
        let more = 2 * restart;
        let by_hand = format!("raise restart: strategy = {{ krylov = {{ restart = {more} }} }}");
        let remedy = match self.longest {
            0 => by_hand,
            most if most < MOST_GROWTH * self.settings.restart => {
                format!(
                    "allow more memory (--memory-gb) or fewer solves at a time (--jobs): the basis may not grow beyond {most}"
                )
            }
            _ => format!("take strategy = \"bicgstab\", a finer grid, or {by_hand}"),
        };
        format!("a basis of {restart} vectors is too short for it; {remedy}")
    }
}

/// A system's operator in double precision, for code that is written for both.
struct Double<'a>(&'a dyn System);

impl Scatter<f64> for Double<'_> {
    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field) {
        self.0.scatter(u, out);
    }
}

/// One solve under way; `work` holds the residual at the start of a cycle.
struct KrylovRun<'a> {
    ledger: Ledger<'a>,
    field: Field,
    work: Field,
    correction: Option<Correction>,
    /// The operator in single precision, as long as that serves.
    single: Option<&'a dyn Scatter<f32>>,
    /// Basis vectors of a cycle.
    restart: usize,
    first_cycle: bool,
}

impl KrylovRun<'_> {
    /// One restart cycle: builds a basis from the residual in `work` and corrects the field.
    fn cycle<T: Real>(&mut self, operator: &dyn Scatter<T>, restart: usize) -> Result<(), SolveError> {
        let beta = norm(flat(&self.work));
        // v_1 = r/β; M the guided modes' correction, M = 1 without one
        let (mut basis, mut small) = (Basis::<T>::new(flat(&self.work), beta), LeastSquares::new(beta));
        let (mut last, mut image) = (Array2::zeros(self.field.dim()), Array2::zeros(self.field.dim()));
        let mut verdict = Ok(());
        while basis.len() <= restart {
            let applied = last.as_slice_mut().expect("fields are contiguous");
            basis.last(applied);
            self.correct(applied); // M v_k
            operator.scatter(last.view(), &mut image); // A⁻¹V M v_k
            // h_ik = ⟨v_i, w⟩, v_{k+1} = (w − Σ h_ik v_i)/h_{k+1,k} with w = (1 + A⁻¹V) M v_k
            let (column, grows) = basis.expand(entries(&last), entries(&image));
            let residual = small.add_column(column) / self.ledger.scale(); // min ‖β e₁ − H y‖ / ‖u₀‖
            self.ledger.account.steps += 1;
            self.ledger.account.operator_applications += 1;
            verdict = self.ledger.note(residual);
            // A little below the goal, so that the true residual, measured next, meets it too.
            let reached = residual <= 0.9 * self.ledger.goal.tolerance;
            if !grows || reached || verdict.is_err() || self.ledger.exhausted() {
                break;
            }
        }
        let held = basis.bytes() + 2 * size_of_val(entries(&last)) + 3 * size_of_val(flat(&self.field));
        let correction = self.correction.as_ref().map_or(0, Correction::bytes);
        self.ledger.account.bytes = self.ledger.account.bytes.max(held + correction);
        let change = last.as_slice_mut().expect("fields are contiguous");
        basis.combine(&small.solve(), change); // Σ y_k v_k
        self.correct(change);
        let changes = self.field.iter_mut().zip(change);
        changes.for_each(|(u, c)| *u += Complex64::new(c.re.wide(), c.im.wide())); // u ← u + M Σ y_k v_k
        verdict
    }

    /// After a cycle that has left the goal, from the residual `before` it: more modes, a longer basis, double precision, or the end.
    fn adapt(&mut self, solver: &Growing, before: f64) -> Result<(), SolveError> {
        let (after, first) = (self.ledger.account.residual, std::mem::take(&mut self.first_cycle));
        let stalls = self.single.is_none() && after > STALLS * before;
        let advice = solver.advice(self.restart);
        if !first && stalls && self.restart >= solver.longest {
            return Err(self.ledger.not_converged(&advice));
        }
        self.ledger.judge(&format!("allow more applications (solver.max_applications); {advice}"))?;
        if first {
            self.take_pains(solver);
        } else if self.single.is_none() && self.too_slow(before / after) {
            self.restart = solver.longest.max(self.restart);
        }
        self.single = self.single.filter(|_| after < SINGLE_GAIN * before);
        Ok(())
    }

    /// For a solve that has turned out to be hard: guided modes wherever they lie, and a longer basis.
    fn take_pains(&mut self, solver: &Growing) {
        let more = solver.settings.guided_modes.of_hard_solves();
        let correction = self.correction.take();
        let problem = self.ledger.problem.split();
        self.correction = correction.or_else(|| problem.and_then(|problem| more.correction(problem)));
        self.restart = self.restart.max(solver.longest.min(HARD_GROWTH * self.restart));
    }

    /// True where the goal is beyond the applications left at the pace of the last cycle, which has divided the residual by `gain`.
    fn too_slow(&self, gain: f64) -> bool {
        let (account, goal) = (&self.ledger.account, &self.ledger.goal);
        let left = goal.max_applications.saturating_sub(account.operator_applications) as f64;
        let cycles = (account.residual / goal.tolerance).ln() / gain.max(1.0).ln();
        cycles * self.restart as f64 > left
    }

    fn correct<T: Real>(&self, v: &mut [Complex<T>]) {
        self.correction.iter().for_each(|c| c.apply(v));
    }
}

fn entries<T>(field: &Array2<T>) -> &[T] {
    field.as_slice().expect("fields are contiguous")
}

#[cfg(test)]
#[path = "krylov_tests.rs"]
mod tests;
