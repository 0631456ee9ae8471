//! A solve by GMRES in progress: its cycles with their small least-squares problems, and what
//! follows a cycle that is not enough.

use super::Growing;
use crate::numerics::fourier::Real;
use crate::solve::basis::Basis;
use crate::solve::strategies::coarse::{CoarsePlan, CoarseSpace};
use crate::solve::strategies::guided::Correction;
use crate::solve::strategies::idr::Idr;
use crate::solve::vectors::norm;
use crate::solve::{Ledger, SolveError, flat};
use crate::wave::maxwell::VectorProblem;
use crate::wave::maxwell::coarse::{VectorCoarsePlan, VectorCoarseSpace};
use crate::wave::{Field, Scatter, System};
use ndarray::Array2;
use num_complex::{Complex, Complex64};
use std::sync::Arc;

/// If a basis in single precision reduces the true residual by less than this factor, double
/// precision takes over.
const SINGLE_GAIN: f64 = 0.2;
/// A cycle that leaves more than this fraction of the residual has stalled.
const STALLS: f64 = 0.99;
/// Applications that short recurrences need at least where GMRES stalls: an elimination that costs
/// no more is carried out at once. Measured on 5 and 15 % of n = 2.3 and 2.65, 235 nm, 1 and 2 µm,
/// cells of 1.35 µm, 440 and 550 nm: 440 to 620 where they converge, which is in three of seven
/// cases, and 1.3 to 2.1 times the processor time of the elimination.
const LEAST: f64 = 400.0;
/// Share of a dearer elimination's cost for which short recurrences are tried before it.
const PATIENCE: f64 = 0.5;
/// Steps in which strong scatterers of the vector wave show whether they resonate.
const TRIAL: usize = 12;
/// Contrast |η² − η_b²| of strong scatterers, where grains resonate by themselves. Below it, guided
/// modes of the mean slab delay the scalar wave, and correcting them is cheaper: measured, with
/// n = 2 in 1.558 (1.6) short recurrences cost 1.7 times as much, with 2.65 (4.6) a tenth.
const STRONG: f64 = 2.5;
/// What to do with strong scatterers that short recurrences do not solve either.
const ADVICE: &str = "take a finer grid, allow more applications (solver.max_applications), or compose the layer of \
                             thinner slabs ([layer.composed])";
/// Growth factor on `restart` for a solve that the first cycle has not brought to its goal, memory
/// permitting: restarts cost more applications than a longer basis costs work (measured on 5 % of
/// n = 2.6, 250 nm, κ = 0: 904 applications against 319).
const HARD_GROWTH: usize = 4;
/// A cycle with eliminated harmonics that leaves more than this fraction has not helped; those that
/// do help leave a tenth or much less.
const HELPS: f64 = 0.5;
/// Ratio of the residual to what the cycle counted, above which rounding has spoilt the
/// elimination.
const UNTRUE: f64 = 2.0;
/// Steps still to go, at the rate of the last cycle, at which more harmonics of the vector wave are
/// eliminated: bases of hundreds of vectors in double precision cost more.
const FAR: f64 = 240.0;

/// A solve in progress; `work` holds the residual at the start of a cycle.
pub(super) struct KrylovRun<'a> {
    pub ledger: Ledger<'a>,
    pub field: Field,
    pub work: Field,
    pub correction: Option<RightFactor<'a>>,
    /// The operator in single precision, as long as that suffices.
    pub single: Option<&'a dyn Scatter<f32>>,
    /// Number of basis vectors per cycle.
    pub restart: usize,
    pub first_cycle: bool,
}

/// What GMRES multiplies the operator with from the right.
pub(super) enum RightFactor<'a> {
    Guided(Correction),
    Coarse(CoarseSpace),
    Double(CoarseSpace<f64>),
    Vector(&'a VectorProblem, Arc<VectorCoarseSpace>),
}

impl RightFactor<'_> {
    fn bytes(&self) -> usize {
        match self {
            Self::Guided(guided) => guided.bytes(),
            Self::Coarse(coarse) => coarse.bytes(),
            Self::Double(coarse) => coarse.bytes(),
            Self::Vector(_, coarse) => coarse.bytes(),
        }
    }
}

/// An elimination of the lowest harmonics that fits into the memory.
enum Elimination<'a> {
    Scalar(CoarsePlan<'a>),
    Vector(&'a VectorProblem, VectorCoarsePlan),
}

impl<'a> Elimination<'a> {
    /// The elimination for a system that holds at most `bytes`.
    fn within(system: &'a dyn System, bytes: f64) -> Option<Self> {
        if let Some(problem) = system.vector() {
            return Some(Self::Vector(problem, VectorCoarsePlan::within(problem, bytes)?));
        }
        let plan = system.split().map(CoarsePlan::new).filter(|plan| plan.bytes() <= bytes);
        plan.map(Self::Scalar)
    }

    /// Applications of the operator by short recurrences that take as long.
    fn in_applications(&self) -> f64 {
        match self {
            Self::Scalar(plan) => plan.in_applications(),
            Self::Vector(_, plan) => plan.in_applications(),
        }
    }

    fn carried_out(self) -> RightFactor<'a> {
        match self {
            Self::Scalar(plan) => RightFactor::Coarse(plan.carried_out()),
            Self::Vector(problem, plan) => RightFactor::Vector(problem, problem.eliminated(plan)),
        }
    }
}

impl<'a> KrylovRun<'a> {
    /// Whether grains resonate by themselves, or nothing is known of the mean slab's guided modes.
    pub fn is_strong(&self) -> bool {
        self.ledger.problem.split().is_none_or(|scalar| scalar.media.largest_contrast() > STRONG)
    }

    pub fn is_coarse(&self) -> bool {
        self.correction.as_ref().is_some_and(|factor| !matches!(factor, RightFactor::Guided(_)))
    }

    /// Steps of a cycle of at most `most`, with `bytes` for an elimination. Where strong scatterers
    /// of the vector wave allow a cheap one, the first is a trial: a whole cycle costs as much.
    pub fn steps(&self, most: usize, bytes: f64) -> usize {
        let vector = self.ledger.problem.vector().filter(|_| self.first_cycle && !self.is_coarse());
        let is_strong = vector.is_some_and(|vector| vector.media.largest_contrast() > STRONG);
        let is_cheap = || self.elimination(bytes).is_some_and(|plan| plan.in_applications() <= LEAST);
        if is_strong && is_cheap() { most.min(TRIAL) } else { most }
    }

    fn elimination(&self, bytes: f64) -> Option<Elimination<'a>> {
        Elimination::within(self.ledger.problem, bytes)
    }

    /// Continues with the elimination of the lowest harmonics if `bytes` suffice for it; where that
    /// is dear, short recurrences are tried before it.
    pub fn solve_strong(&mut self, bytes: f64) -> Result<(), SolveError> {
        let plan = self.elimination(bytes);
        let cost = plan.as_ref().map(Elimination::in_applications);
        if cost.is_none_or(|cost| cost > LEAST) {
            match (self.short_recurrences(cost), &plan) {
                (Err(SolveError::NotConverged { .. } | SolveError::Diverged { .. }), Some(_)) => {}
                (tried, _) => return tried,
            }
        }
        self.correction = plan.map(Elimination::carried_out);
        Ok(())
    }

    /// Replaces eliminated harmonics that a cycle has shown not to help: those of the scalar wave
    /// by the same in double precision, those of the vector wave by more. The cycle began with the
    /// residual `before` and took `steps`; whether another begins.
    ///
    /// The elimination of nodes cannot exchange them, and a part of the layer, or a high cell, may
    /// resonate by itself: in single precision the factor is then wrong, GMRES believes in a
    /// residual that the field does not have, and the field is useless. Measured on 45 % of zinc
    /// sulphide, 300 nm, 1.5 µm, 405 nm: a residual of 870.
    pub fn eliminate_more(&mut self, before: f64, steps: usize, bytes: f64) -> bool {
        let after = self.ledger.account.residual;
        let gain = (before / after).max(1.0).ln();
        let is_far = (steps as f64 * (after / self.ledger.goal.tolerance).ln()) / gain > FAR;
        let helps = after <= (HELPS * before).max(UNTRUE * self.ledger.goal.tolerance);
        let is_true = self.ledger.account.history.last().is_some_and(|counted| after <= UNTRUE * counted);
        let better = match &self.correction {
            Some(RightFactor::Coarse(_)) if !helps && !is_true => self.in_double_precision(bytes),
            Some(RightFactor::Vector(problem, space)) if is_far || !helps => {
                let wider = space.plan.wider(problem, bytes);
                wider.map(|plan| RightFactor::Vector(problem, problem.eliminated(plan)))
            }
            _ => None,
        };
        let begins = better.is_some();
        if begins {
            self.correction = better;
            if after.is_nan() || after > before {
                self.begin_again();
            }
        }
        begins
    }

    /// The lowest harmonics of the scalar wave eliminated in double precision, if that fits.
    fn in_double_precision(&self, bytes: f64) -> Option<RightFactor<'a>> {
        let plan = self.ledger.problem.split().map(CoarsePlan::new);
        let plan = plan.filter(|plan| 2.0 * plan.bytes() <= bytes);
        plan.map(|plan| RightFactor::Double(plan.carried_out()))
    }

    /// Gives the field up: of no field, the incident wave is the residual.
    fn begin_again(&mut self) {
        self.field.fill(Complex64::ZERO);
        self.work.assign(&self.ledger.background);
        self.ledger.account.residual = 1.0;
    }

    /// Short recurrences without what was eliminated, for the applications left, after a failure of
    /// GMRES with it.
    pub fn last_resort(&mut self, failure: SolveError) -> Result<(), SolveError> {
        let stalls = matches!(failure, SolveError::NotConverged { .. } | SolveError::Diverged { .. });
        if !stalls || !self.is_coarse() || self.ledger.exhausted() {
            return Err(failure);
        }
        let residual = self.ledger.account.residual;
        if residual.is_nan() || residual > 1.0 {
            self.begin_again();
        }
        self.correction = None;
        self.short_recurrences(None)
    }

    /// IDR(s) for a share of what an alternative costs, or until the applications are used up;
    /// without success it leaves the better field.
    pub fn short_recurrences(&mut self, alternative: Option<f64>) -> Result<(), SolveError> {
        let residual = self.ledger.account.residual;
        let before = [&self.field, &self.work].map(Field::clone);
        let whole = self.ledger.goal.max_applications;
        let used = self.ledger.account.operator_applications;
        let left = whole.saturating_sub(used);
        let patience = alternative.map_or(left, |cost| (left / 2).min((PATIENCE * cost) as usize));
        self.ledger.goal.max_applications = used + patience;
        let tried = Idr::default().advance(&mut self.ledger, [&mut self.field, &mut self.work], ADVICE);
        self.ledger.goal.max_applications = whole;
        let now = self.ledger.account.residual;
        if now.is_nan() || now > residual {
            [self.field, self.work] = before;
            self.ledger.account.residual = residual;
        }
        tried
    }

    /// One restart cycle: builds a basis from the residual in `work` and corrects the field.
    pub fn cycle<T: Real>(&mut self, operator: &dyn Scatter<T>, restart: usize) -> Result<(), SolveError> {
        let beta = norm(flat(&self.work));
        // v_1 = r/β; M is the factor from the right, M = 1 without it
        let mut basis = Basis::<T>::new(flat(&self.work), beta);
        let mut small = LeastSquares::new(beta);
        let mut last = Array2::zeros(self.field.dim());
        let mut image = Array2::zeros(self.field.dim());
        let mut verdict = Ok(());
        while basis.len() <= restart {
            let applied = last.as_slice_mut().expect("fields are contiguous");
            basis.last(applied);
            self.correct(applied); // M v_k
            operator.scatter(last.view(), &mut image); // A⁻¹V M v_k
            // h_ik = ⟨v_i, w⟩, v_{k+1} = (w − Σ h_ik v_i)/h_{k+1,k} with w = (1 + A⁻¹V) M v_k
            let (column, grows) = basis.expand(entries(&last), entries(&image));
            // min ‖β e₁ − H y‖ / ‖u₀‖
            let residual = small.add_column(column) / self.ledger.scale();
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
        // u ← u + M Σ y_k v_k
        changes.for_each(|(u, c)| *u += Complex64::new(c.re.wide(), c.im.wide()));
        verdict
    }

    /// Adapts after a cycle that missed the goal, given the residual `before` it: more modes, a
    /// longer basis, double precision, or failure.
    pub fn adapt(&mut self, solver: &Growing, before: f64) -> Result<(), SolveError> {
        let after = self.ledger.account.residual;
        let first = std::mem::take(&mut self.first_cycle);
        let stalls = self.single.is_none() && after > STALLS * before;
        let advice = solver.advice(self.restart);
        if !first && stalls && self.restart >= solver.longest {
            return Err(self.ledger.not_converged(&advice));
        }
        let filled = self.ledger.account.steps >= self.restart;
        let beside = if filled { format!("; {advice}") } else { String::new() };
        self.ledger.judge(&format!("allow more applications (solver.max_applications){beside}"))?;
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
        let problem = self.ledger.problem.split();
        self.correction = correction.or_else(|| Some(RightFactor::Guided(more.correction(problem?)?)));
        self.restart = self.restart.max(solver.longest.min(HARD_GROWTH * self.restart));
    }

    /// Whether the remaining applications cannot reach the goal at the rate of the last cycle,
    /// which divided the residual by `gain`.
    fn too_slow(&self, gain: f64) -> bool {
        let account = &self.ledger.account;
        let goal = &self.ledger.goal;
        let left = goal.max_applications.saturating_sub(account.operator_applications) as f64;
        let cycles = (account.residual / goal.tolerance).ln() / gain.max(1.0).ln();
        cycles * self.restart as f64 > left
    }

    fn correct<T: Real>(&self, v: &mut [Complex<T>]) {
        match &self.correction {
            Some(RightFactor::Guided(guided)) => guided.apply(v),
            Some(RightFactor::Coarse(coarse)) => coarse.apply(v),
            Some(RightFactor::Double(coarse)) => coarse.apply(v),
            Some(RightFactor::Vector(problem, coarse)) => coarse.apply(problem.narrow_operator(), v),
            None => {}
        }
    }
}

fn entries<T>(field: &Array2<T>) -> &[T] {
    field.as_slice().expect("fields are contiguous")
}

/// Solves min ‖β e₁ − H y‖ by Givens rotations, one column at a time.
struct LeastSquares {
    columns: Vec<Vec<Complex64>>,
    rotations: Vec<(f64, Complex64)>,
    right: Vec<Complex64>,
}

impl LeastSquares {
    pub fn new(beta: f64) -> LeastSquares {
        LeastSquares { columns: Vec::new(), rotations: Vec::new(), right: vec![beta.into()] }
    }

    /// Adds a Hessenberg column (its last entry the new norm) and returns the residual's norm.
    pub fn add_column(&mut self, mut column: Vec<Complex64>) -> f64 {
        for (i, &(c, s)) in self.rotations.iter().enumerate() {
            // [h_i; h_{i+1}] ← [[c, s], [−s̄, c]] [h_i; h_{i+1}]
            let a = column[i];
            let b = column[i + 1];
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
        column[k] = c * diagonal + s * below; // the rotation that eliminates h_{k+1,k}
        self.rotations.push((c, s));
        let last = self.right[k];
        self.right[k] = c * last;
        self.right.push(-s.conj() * last);
        self.columns.push(column);
        self.right[k + 1].norm() // the minimum of ‖β e₁ − H y‖
    }

    pub fn solve(&self) -> Vec<Complex64> {
        let n = self.columns.len();
        let mut y = self.right[..n].to_vec();
        for i in (0..n).rev() {
            y[i] /= self.columns[i][i]; // R y = Qᴴ β e₁ by back substitution
            let yi = y[i];
            (0..i).for_each(|r| y[r] -= self.columns[i][r] * yi);
        }
        y
    }
}
