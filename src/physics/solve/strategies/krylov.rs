//! GMRES with restart on (1 + A⁻¹V) u = u₀ (Saad and Schultz 1986), implemented here because no
//! maintained crate offers it for complex matrix-free operators.

use super::coarse::{CoarsePlan, CoarseSpace};
use super::guided::{Correction, GuidedModes};
use super::idr::Idr;
use super::least_squares::LeastSquares;
use crate::numerics::fourier::Real;
use crate::solve::basis::Basis;
use crate::solve::demand::Size;
use crate::solve::ledger::{Ledger, flat};
use crate::solve::solver::{Fit, Goal, Solution, SolveError, Solver, Watch};
use crate::solve::vectors::norm;
use crate::wave::operator::scattering::Scatter;
use crate::wave::system::Double;
use crate::wave::{Field, System};
use ndarray::Array2;
use num_complex::{Complex, Complex64};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Restarted GMRES; memory: the basis (at most `restart` vectors) and 4 vectors of 16 bytes per
/// unknown.
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

/// Residuals above which single precision suffices for the basis: its rounding errors are at least
/// ten times smaller, and the decisive residual is always measured in double precision.
pub(super) const SINGLE: f64 = 5e-6;
/// Largest basis in single precision: beyond it, the loss of orthogonality costs more than it
/// saves.
const MOST_SINGLE: usize = 60;
/// If a basis in single precision reduces the true residual by less than this factor, double
/// precision takes over.
const SINGLE_GAIN: f64 = 0.2;
/// Vectors besides the basis: guess, field, residual, incident wave, and work arrays of one step.
const OTHER_VECTORS: f64 = 9.0;
/// Fraction of scarce memory that the guided modes' dense block may use.
const GUIDED_SHARE: f64 = 0.3;
/// Shortest basis with which restarts still converge.
const LEAST_RESTART: usize = 20;
/// A cycle that leaves more than this fraction of the residual has stalled.
const STALLS: f64 = 0.99;
/// A cycle that leaves more than this fraction of the residual hands over to short recurrences, and
/// these to an elimination, in the vector wave, which has no guided modes to correct, and for strong
/// scatterers:
/// orthogonalising against hundreds of vectors costs ten times what an application does (15 % of
/// n = 2.7, 250 nm, 440 nm, κ = 0: 29 s a polarisation with 535 applications, 3 s with 950).
const SLOW: f64 = 0.1;
/// Share of the elimination's cost for which short recurrences are tried before it: with 15 % of
/// n = 2.65, 235 nm, in cells of 1.35 µm they solve 1 µm at half its cost, and 2 µm at four times.
const PATIENCE: f64 = 0.5;
/// Contrast |η² − η_b²| of strong scatterers, where grains resonate by themselves. Below it, the
/// guided modes of the mean slab are what delays the scalar wave, and correcting them is cheaper:
/// with n = 2 in 1.558 (1.6) short recurrences cost 1.7 times as much, with 2.65 (4.6) a tenth.
const STRONG: f64 = 2.5;
/// What to do with strong scatterers that short recurrences do not solve either.
const STRONG_ADVICE: &str = "take a finer grid, allow more applications (solver.max_applications), or compose the layer of \
                             thinner slabs ([layer.composed])";
/// Growth factor on `restart` for a solve that the first cycle has not brought to its goal, memory
/// permitting: restarts cost more applications than a longer basis costs work (5 % of n = 2.6, 250
/// nm, κ = 0: 904 applications against 319).
const HARD_GROWTH: usize = 4;
/// Upper limit on the growth of a basis that is too short, reached at once: applications with short
/// bases are lost. Beyond it, orthogonalisation costs more than another strategy.
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

/// GMRES with the memory available to solves that stall.
struct Growing {
    settings: Gmres,
    /// Largest basis to which a stalled solve may grow; 0 if it may not.
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
        let correction = problem.operator().and_then(|p| self.settings.guided_modes.correction(p));
        let correction = correction.map(RightFactor::Guided);
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
            let after = run.ledger.measure(&run.field, &mut run.work);
            let room = self.longest >= 2 * Idr::default().shadow_space;
            if room && after > SLOW * before && run.is_strong() && !run.is_coarse() {
                run.solve_strong((size_of_val(flat(&run.field)) * self.longest) as f64)?;
                continue;
            }
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

    /// Number of basis vectors that fit into `bytes` besides everything else.
    fn most_vectors(&self, size: &Size, bytes: f64) -> usize {
        let vectors = (bytes - self.bytes_of_modes(size)) / size.fields(1.0) - OTHER_VECTORS;
        vectors.max(0.0) as usize
    }

    /// Largest memory of the guided modes in bytes, for solves of any difficulty.
    fn bytes_of_modes(&self, size: &Size) -> f64 {
        let hard = self.guided_modes.of_hard_solves();
        self.guided_modes.most_bytes(size).max(hard.most_bytes(size))
    }
}

impl Growing {
    /// Remedy for a solve that stalls with `restart` basis vectors.
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
        format!("a basis of {restart} vectors is too short for this problem; {remedy}")
    }
}

/// A solve in progress; `work` holds the residual at the start of a cycle.
struct KrylovRun<'a> {
    ledger: Ledger<'a>,
    field: Field,
    work: Field,
    correction: Option<RightFactor>,
    /// The operator in single precision, as long as that suffices.
    single: Option<&'a dyn Scatter<f32>>,
    /// Number of basis vectors per cycle.
    restart: usize,
    first_cycle: bool,
}

/// What GMRES multiplies the operator with from the right.
enum RightFactor {
    Guided(Correction),
    Coarse(CoarseSpace),
}

impl RightFactor {
    fn bytes(&self) -> usize {
        match self {
            Self::Guided(guided) => guided.bytes(),
            Self::Coarse(coarse) => coarse.bytes(),
        }
    }
}

impl KrylovRun<'_> {
    /// Whether grains resonate by themselves, or nothing is known of the mean slab's guided modes.
    fn is_strong(&self) -> bool {
        self.ledger.problem.operator().is_none_or(|scalar| scalar.media.largest_contrast() > STRONG)
    }

    fn is_coarse(&self) -> bool {
        matches!(self.correction, Some(RightFactor::Coarse(_)))
    }

    /// Continues with short recurrences; if they last longer than the elimination of the lowest
    /// harmonics, and `bytes` suffice for it, with that.
    fn solve_strong(&mut self, bytes: f64) -> Result<(), SolveError> {
        let plan = self.ledger.problem.operator().map(CoarsePlan::new).filter(|plan| plan.bytes() <= bytes);
        let (left, before) = (self.ledger.account.residual, [&self.field, &self.work].map(Field::clone));
        let tried = self.short_recurrences(plan.as_ref().map(CoarsePlan::in_applications));
        let (Err(SolveError::NotConverged { .. } | SolveError::Diverged { .. }), Some(plan)) = (&tried, plan)
        else {
            return tried;
        };
        if self.ledger.account.residual > left {
            [self.field, self.work] = before;
        }
        self.correction = Some(RightFactor::Coarse(plan.carried_out()));
        Ok(())
    }

    /// IDR(s) for a share of what an alternative costs, or until the applications are used up.
    fn short_recurrences(&mut self, alternative: Option<f64>) -> Result<(), SolveError> {
        let (whole, used) = (self.ledger.goal.max_applications, self.ledger.account.operator_applications);
        let left = whole.saturating_sub(used);
        let patience = alternative.map_or(left, |cost| (left / 2).min((PATIENCE * cost) as usize));
        self.ledger.goal.max_applications = used + patience;
        let tried =
            Idr::default().advance(&mut self.ledger, [&mut self.field, &mut self.work], STRONG_ADVICE);
        self.ledger.goal.max_applications = whole;
        tried
    }

    /// One restart cycle: builds a basis from the residual in `work` and corrects the field.
    fn cycle<T: Real>(&mut self, operator: &dyn Scatter<T>, restart: usize) -> Result<(), SolveError> {
        let beta = norm(flat(&self.work));
        // v_1 = r/β; M is the guided modes' correction, M = 1 without it
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
            // Slightly below the goal, so that the true residual, measured next, meets it too.
            let reached = residual <= 0.9 * self.ledger.goal.tolerance;
            if !grows || reached || verdict.is_err() || self.ledger.exhausted() {
                break;
            }
        }
        let held = basis.bytes() + 2 * size_of_val(entries(&last)) + 3 * size_of_val(flat(&self.field));
        let correction = self.correction.as_ref().map_or(0, RightFactor::bytes);
        self.ledger.account.bytes = self.ledger.account.bytes.max(held + correction);
        let change = last.as_slice_mut().expect("fields are contiguous");
        basis.combine(&small.solve(), change); // Σ y_k v_k
        self.correct(change);
        let changes = self.field.iter_mut().zip(change);
        changes.for_each(|(u, c)| *u += Complex64::new(c.re.wide(), c.im.wide())); // u ← u + M Σ y_k v_k
        verdict
    }

    /// Adapts after a cycle that missed the goal, given the residual `before` it: more modes, a
    /// longer basis, double precision, or failure.
    fn adapt(&mut self, solver: &Growing, before: f64) -> Result<(), SolveError> {
        let (after, first) = (self.ledger.account.residual, std::mem::take(&mut self.first_cycle));
        let stalls = self.single.is_none() && after > STALLS * before;
        let advice = solver.advice(self.restart);
        if !first && stalls && self.restart >= solver.longest {
            return Err(self.ledger.not_converged(&advice));
        }
        self.ledger.judge(&format!("allow more applications (solver.max_applications); {advice}"))?;
        if first {
            self.prepare_for_hard_solve(solver);
        } else if self.single.is_none() && self.too_slow(before / after) {
            self.restart = solver.longest.max(self.restart);
        }
        self.single = self.single.filter(|_| after < SINGLE_GAIN * before);
        Ok(())
    }

    /// Settings for a hard solve: guided modes in cells of any size, and a longer basis.
    fn prepare_for_hard_solve(&mut self, solver: &Growing) {
        let more = solver.settings.guided_modes.of_hard_solves();
        let correction = self.correction.take();
        let problem = self.ledger.problem.operator();
        let guided = || problem.and_then(|problem| more.correction(problem)).map(RightFactor::Guided);
        self.correction = correction.or_else(guided);
        self.restart = self.restart.max(solver.longest.min(HARD_GROWTH * self.restart));
    }

    /// Whether the remaining applications cannot reach the goal at the rate of the last cycle,
    /// which divided the residual by `gain`.
    fn too_slow(&self, gain: f64) -> bool {
        let (account, goal) = (&self.ledger.account, &self.ledger.goal);
        let left = goal.max_applications.saturating_sub(account.operator_applications) as f64;
        let cycles = (account.residual / goal.tolerance).ln() / gain.max(1.0).ln();
        cycles * self.restart as f64 > left
    }

    fn correct<T: Real>(&self, v: &mut [Complex<T>]) {
        match &self.correction {
            Some(RightFactor::Guided(guided)) => guided.apply(v),
            Some(RightFactor::Coarse(coarse)) => coarse.apply(v),
            None => {}
        }
    }
}

fn entries<T>(field: &Array2<T>) -> &[T] {
    field.as_slice().expect("fields are contiguous")
}

#[cfg(test)]
#[path = "krylov_tests.rs"]
mod tests;
