//! Relaxation to the stationary state by Crank–Nicolson splitting (P2 section 3, with (3.13)'s sign corrected).
//!
//! In plane values, with D the lumped mass and c = iτ/2, one step is
//! (D − cV) D⁻¹ (D − cÃ) û = (D + cV) D⁻¹ (D + cÃ) u − 2c b, whose fixed point is (Ã + V) u = b for every τ. The state
//! carried is s = D⁻¹(D − cÃ)u at the points, since (D + cÃ)u = 2Du − Ds: a step costs one inverse and one forward
//! transform. Without absorption trapped waves circulate undamped; replacing the state by its mean over a window
//! ("averaging restart") removes them.

use crate::solve::System;
use crate::solve::demand::Size;
use crate::solve::ledger::{Ledger, flat};
use crate::solve::solver::{Goal, Solution, SolveError, Solver, Watch, scalar};
use crate::solve::vectors::{dot, norm};
use crate::wave::operator::banded::ShiftedMean;
use crate::wave::{Field, Mean, Problem};
use faer::linalg::solvers::Solve;
use faer::{Col, Mat};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Settings; the defaults converge on every reference case with a real mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Relaxation {
    /// τ times the largest |V|.
    pub tau: f64,
    /// Steps between two looks at the residual, and the window over which the state is averaged.
    pub window: usize,
    /// Earlier restarts that the averaging may draw on; 1 averages over one window only.
    pub memory: usize,
}

/// τ is halved at most down to this share of the asked one.
const SHORTEST: f64 = 0.2;
/// A window that multiplies the residual by more than this has too long a τ.
const GROWTH: f64 = 10.0;

impl Default for Relaxation {
    fn default() -> Relaxation {
        Relaxation { tau: 6.0, window: 12, memory: 24 }
    }
}

impl Solver for Relaxation {
    fn name(&self) -> &'static str {
        "relaxation"
    }

    fn suited_mean(&self) -> Mean {
        Mean { absorbing: false, ..Mean::default() }
    }

    fn solve_from(
        &self,
        system: &dyn System,
        start: Option<&Field>,
        goal: Goal,
        watch: &mut dyn Watch,
    ) -> Result<Solution, SolveError> {
        let problem = scalar(system, self.name())?;
        self.check(problem)?;
        let mut ledger = Ledger::new(self.name(), problem, goal, watch);
        if !problem.has_contrast() {
            ledger.note(0.0)?;
            let field = ledger.background.clone();
            return Ok(ledger.finish(field));
        }
        let field = start.cloned().unwrap_or_else(|| ledger.background.clone());
        let mut scratch = Field::zeros(problem.shape());
        let first = ledger.measure(&field, &mut scratch);
        ledger.note(first)?;
        if ledger.reached() {
            return Ok(ledger.finish(field));
        }
        let mut tau = self.tau;
        let mut march = March::new(problem, tau, &field);
        let mut memory = Memory::new(march.candidate(&mut ledger), self.memory);
        ledger.account.bytes = march.bytes() + memory.most_bytes();
        loop {
            let before = ledger.account.residual;
            let mean = march.window(self.window, &mut ledger);
            memory.add(march.candidate_of(mean, &mut ledger));
            memory.add(march.candidate(&mut ledger));
            // A residual that is not a number counts as grown.
            let after = ledger.account.residual;
            if (after.is_nan() || after > GROWTH * before) && 0.5 * tau >= self.tau * SHORTEST {
                // Ringing of the band-limited contrast gives gain in spots: shorter steps split it less.
                tau *= 0.5;
                march = March::new(problem, tau, &memory.base.field);
                memory.start_anew(march.candidate(&mut ledger));
            } else {
                memory.average();
            }
            march.state.assign(&memory.base.state);
            ledger.note(norm(flat(&memory.base.residual)) / ledger.scale())?;
            if ledger.reached() {
                if ledger.measure(&memory.base.field, &mut scratch) <= goal.tolerance {
                    return Ok(ledger.finish(memory.base.field));
                }
                // Rounding has carried the blend's residual away from the field's: go on from the field.
                march = March::new(problem, tau, &memory.base.field);
                memory.start_anew(march.candidate(&mut ledger));
            }
            ledger.judge("try another tau or window, or solver = \"krylov\"")?;
        }
    }

    fn most_bytes(&self, size: &Size) -> f64 {
        // Kept candidates hold four fields with their differences; two more are in the making.
        let candidates = 5.0 * (self.memory.max(1) as f64 + 3.0);
        size.fields(candidates + 9.0 + 2.0 * (size.resolution.scheme.degree() as f64 + 1.0))
    }
}

/// A state of the march, the field that belongs to it, and that field's residual.
#[derive(Clone)]
struct Candidate {
    state: Array2<Complex64>,
    field: Field,
    residual: Field,
}

impl Candidate {
    fn bytes(&self) -> usize {
        (self.state.len() + self.field.len() + self.residual.len()) * size_of::<Complex64>()
    }

    /// The affine combination last + Σ w (other − last) with the smallest residual: states, fields and residuals are
    /// affine in each other.
    fn blend(others: &[&Candidate], last: &Candidate) -> Candidate {
        let differences: Vec<Field> = others.iter().map(|c| &c.residual - &last.residual).collect();
        let weights = least_squares(&differences, &last.residual);
        let mut blend = last.clone();
        for (other, &w) in others.iter().zip(&weights) {
            add_difference(&mut blend.state, w, &other.state, &last.state);
            add_difference(&mut blend.field, w, &other.field, &last.field);
            add_difference(&mut blend.residual, w, &other.residual, &last.residual);
        }
        blend
    }
}

/// out ← out + w (a − b).
fn add_difference(out: &mut Array2<Complex64>, w: Complex64, a: &Array2<Complex64>, b: &Array2<Complex64>) {
    ndarray::Zip::from(out).and(a).and(b).par_for_each(|o, &a, &b| *o += w * (a - b));
}

/// What the averaging restart draws on: the candidate that the march goes on from, and the latest ones of its windows.
/// Earlier bases are not kept: they are combinations of those.
struct Memory {
    base: Candidate,
    /// Two a window, the mean of its states and its last; the oldest first.
    recent: VecDeque<Candidate>,
    /// Most candidates between two windows, the base included.
    most: usize,
}

impl Memory {
    fn new(base: Candidate, most: usize) -> Memory {
        Memory { base, recent: VecDeque::new(), most: most.max(1) }
    }

    fn add(&mut self, candidate: Candidate) {
        self.recent.push_back(candidate);
    }

    /// The best combination becomes the base; the oldest candidates beyond the limit are dropped.
    fn average(&mut self) {
        if let Some(last) = self.recent.pop_back() {
            let others: Vec<&Candidate> = [&self.base].into_iter().chain(&self.recent).collect();
            self.base = Candidate::blend(&others, &last);
            self.recent.push_back(last);
        }
        let beyond = (self.recent.len() + 1).saturating_sub(self.most);
        self.recent.drain(..beyond);
    }

    /// Forgets all candidates but this one.
    fn start_anew(&mut self, base: Candidate) {
        self.recent.clear();
        self.base = base;
    }

    /// Bytes of all candidates, two more that a window adds, and the differences of their residuals while they are
    /// combined.
    fn most_bytes(&self) -> usize {
        let each = self.base.bytes() + self.base.residual.len() * size_of::<Complex64>();
        (self.most + 2) * each
    }
}

/// Weights w that minimise ‖r + Σ w_i d_i‖, from normal equations scaled to unit diagonal.
fn least_squares(differences: &[Field], residual: &Field) -> Vec<Complex64> {
    let n = differences.len();
    let sizes: Vec<f64> = differences.iter().map(|d| norm(flat(d)).max(1e-300)).collect();
    let gram = Mat::from_fn(n, n, |i, j| {
        let ridge = if i == j { 1e-12 } else { 0.0 };
        dot(flat(&differences[i]), flat(&differences[j])) / (sizes[i] * sizes[j]) + ridge
    });
    let right = Col::from_fn(n, |i| -dot(flat(&differences[i]), flat(residual)) / sizes[i]);
    let solved = gram.partial_piv_lu().solve(&right);
    (0..n).map(|i| solved[i] / sizes[i]).collect()
}

impl Relaxation {
    fn check(&self, problem: &Problem) -> Result<(), SolveError> {
        let setting = |field, value: String, allowed: &str, remedy: &str| SolveError::Setting {
            field,
            value,
            allowed: allowed.to_string(),
            remedy: remedy.to_string(),
        };
        if !problem.mean.is_real() {
            let remedy =
                "both halves of the splitting must be dissipative: choose the real mean (--real-mean)";
            return Err(setting("mean", "complex".into(), "a real ⟨k²⟩", remedy));
        }
        if !(self.tau.is_finite() && self.tau > 0.0) {
            return Err(setting("relaxation.tau", self.tau.to_string(), "finite and above 0", "try 6"));
        }
        if self.window == 0 {
            return Err(setting("relaxation.window", "0".into(), "1 or more", "try 12"));
        }
        Ok(())
    }
}

/// The march at the points of all planes.
struct March<'a> {
    problem: &'a Problem,
    shifted: ShiftedMean,
    mass: Vec<f64>,
    /// (1 + cV/D) and 1/(1 − cV/D) at the points.
    factors: [Array2<Complex64>; 2],
    /// Row of the face the light enters by, and 2c b/D/(1 − cV/D) at its points.
    source: (usize, Vec<Complex64>),
    state: Array2<Complex64>,
    harmonics: Field,
    values: Array2<Complex64>,
}

impl<'a> March<'a> {
    fn new(problem: &'a Problem, tau: f64, field: &Field) -> March<'a> {
        let mass = problem.mean.plane_mass();
        let contrast = contrasts(problem, &mass);
        let largest = contrast.iter().map(|v| v.norm()).fold(1e-300, f64::max);
        let c = Complex64::new(0.0, 0.5 * tau / largest);
        let factors = [contrast.mapv(|v| 1.0 + c * v), contrast.mapv(|v| 1.0 / (1.0 - c * v))];
        let shifted = ShiftedMean::new(problem, 1.0.into(), -c);
        let (row, b) = problem.source_at_points();
        let weighted = b.iter().zip(factors[1].row(row)).map(|(b, f)| 2.0 * c * b / mass[row] * f);
        let source = (row, weighted.collect());
        let values = Array2::zeros(contrast.dim());
        let harmonics = Field::zeros(problem.shape());
        let mut march =
            March { problem, shifted, mass, factors, source, state: values.clone(), harmonics, values };
        march.take_up(field);
        march
    }

    fn bytes(&self) -> usize {
        let points = 4 * self.state.len() + 2 * self.harmonics.len();
        points * size_of::<Complex64>() + self.shifted.bytes()
    }

    /// The state whose fixed point a solution u is: s = (1 + cV/D)u − cD⁻¹b at the points, with all that V scatters
    /// beyond the harmonics.
    fn take_up(&mut self, field: &Field) {
        let planes = self.problem.mean.to_planes(field);
        self.problem.planes_to_points(&planes, &mut self.state);
        self.state *= &self.factors[0];
        let (row, source) = &self.source;
        // The source is kept divided by 1 − cV/D and doubled.
        let state = self.state.row_mut(*row);
        let terms = state.into_iter().zip(source).zip(self.factors[1].row(*row));
        terms.for_each(|((s, b), f)| *s -= 0.5 * b / f);
    }

    /// Plane values of u from a state, as harmonics.
    fn solve_mean(&mut self) {
        self.problem.points_to_planes(&self.state, &mut self.harmonics);
        for (mut row, &mass) in self.harmonics.outer_iter_mut().zip(&self.mass) {
            row.iter_mut().for_each(|z| *z *= mass);
        }
        self.shifted.solve(&mut self.harmonics);
    }

    /// Nodes and bubbles of the field that belongs to a state.
    fn unknowns(&self, state: &Array2<Complex64>) -> Field {
        let mut planes = Field::zeros(self.problem.shape());
        self.problem.points_to_planes(state, &mut planes);
        for (mut row, &mass) in planes.outer_iter_mut().zip(&self.mass) {
            row.iter_mut().for_each(|z| *z *= mass);
        }
        self.shifted.solve(&mut planes);
        self.problem.mean.to_unknowns(&mut planes);
        planes
    }

    /// The present state with its field and residual.
    fn candidate(&mut self, ledger: &mut Ledger) -> Candidate {
        let state = self.state.clone();
        self.candidate_of(state, ledger)
    }

    fn candidate_of(&mut self, state: Array2<Complex64>, ledger: &mut Ledger) -> Candidate {
        let field = self.unknowns(&state);
        let mut residual = Field::zeros(self.problem.shape());
        ledger.measure(&field, &mut residual);
        Candidate { state, field, residual }
    }

    /// s ← (1 − cV/D)⁻¹ [(1 + cV/D)(2u − s) − 2c b/D] with u = (D − cÃ)⁻¹ D s: one step of τ.
    fn step(&mut self) {
        self.solve_mean(); // u, from (D − cÃ) u = D s
        self.problem.planes_to_points(&self.harmonics, &mut self.values);
        let [explicit, implicit] = &self.factors;
        let planes = self.state.outer_iter_mut().into_par_iter().zip(self.values.outer_iter());
        planes.enumerate().for_each(|(p, (state, values))| {
            let step = ndarray::Zip::from(state).and(values).and(explicit.row(p)).and(implicit.row(p));
            step.for_each(|s, &u, &e, &i| *s = (2.0 * u - *s) * e * i); // (2u − s)(1 + cV/D) / (1 − cV/D)
        });
        let (row, source) = &self.source;
        self.state.row_mut(*row).iter_mut().zip(source).for_each(|(s, b)| *s -= b); // − 2c b/D / (1 − cV/D)
    }

    /// Marches a window and returns the mean of its states.
    fn window(&mut self, steps: usize, ledger: &mut Ledger) -> Array2<Complex64> {
        let mut mean = Array2::zeros(self.state.dim());
        for _ in 0..steps {
            self.step();
            ledger.account.steps += 1;
            ledger.account.operator_applications += 1;
            mean += &self.state;
        }
        mean.mapv_inplace(|z: Complex64| z / steps as f64);
        mean
    }
}

/// V/D at the points of all planes.
pub(crate) fn contrasts(problem: &Problem, mass: &[f64]) -> Array2<Complex64> {
    let points = problem.coverage.grid.points();
    let mut all = Array2::zeros((mass.len(), points));
    let rows = all.outer_iter_mut().into_par_iter().enumerate();
    rows.for_each(|(p, mut row)| {
        row.iter_mut().zip(problem.contrast_per_mass(p, mass[p])).for_each(|(out, v)| *out = v);
    });
    all
}

#[cfg(test)]
#[path = "relaxation_tests.rs"]
mod tests;
