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
use crate::wave::{Field, Problem};
use faer::linalg::solvers::Solve;
use faer::{Col, Mat};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Settings; the defaults converge on every reference case with a real mean.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
        let field = start.cloned().unwrap_or_else(|| ledger.background.clone());
        let mut scratch = Field::zeros(problem.shape());
        let first = ledger.measure(&field, &mut scratch);
        ledger.note(first)?;
        if ledger.reached() {
            return Ok(ledger.finish(field));
        }
        let mut tau = self.tau;
        let mut march = March::new(problem, tau, &field);
        let mut memory = vec![march.candidate(&mut ledger)];
        // Kept candidates, and the differences of their residuals while they are blended.
        let each = memory[0].bytes() + memory[0].residual.len() * size_of::<Complex64>();
        ledger.account.bytes = march.bytes() + (self.memory.max(1) + 2) * each;
        loop {
            let before = ledger.account.residual;
            let mean = march.window(self.window, &mut ledger);
            memory.push(march.candidate_of(mean, &mut ledger));
            memory.push(march.candidate(&mut ledger));
            // A residual that is not a number counts as grown.
            let after = ledger.account.residual;
            let grows = (after.is_nan() || after > GROWTH * before) && 0.5 * tau >= self.tau * SHORTEST;
            let mut best = if grows { memory.swap_remove(0) } else { Candidate::blend(&memory) };
            if grows {
                // Ringing of the band-limited contrast gives gain in spots: shorter steps split it less.
                tau *= 0.5;
                memory.clear();
                march = March::new(problem, tau, &best.field);
                best = march.candidate(&mut ledger);
            }
            march.state.assign(&best.state);
            ledger.note(norm(flat(&best.residual)) / ledger.scale())?;
            if ledger.reached() {
                if ledger.measure(&best.field, &mut scratch) <= goal.tolerance {
                    return Ok(ledger.finish(best.field));
                }
                // Rounding has carried the blend's residual away from the field's: go on from the field.
                march = March::new(problem, tau, &best.field);
                best = march.candidate(&mut ledger);
                memory.clear();
            }
            memory.drain(..(memory.len() + 1).saturating_sub(self.memory.max(1)));
            memory.insert(0, best);
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
struct Candidate {
    state: Array2<Complex64>,
    field: Field,
    residual: Field,
}

impl Candidate {
    fn bytes(&self) -> usize {
        (self.state.len() + self.field.len() + self.residual.len()) * size_of::<Complex64>()
    }

    /// The affine combination with the smallest residual: states, fields and residuals are affine in each other.
    fn blend(candidates: &[Candidate]) -> Candidate {
        let last = candidates.last().expect("a window leaves two candidates");
        let differences: Vec<Field> =
            candidates[..candidates.len() - 1].iter().map(|c| &c.residual - &last.residual).collect();
        let weights = least_squares(&differences, &last.residual);
        let mut blend = Candidate {
            state: last.state.clone(),
            field: last.field.clone(),
            residual: last.residual.clone(),
        };
        for (candidate, &w) in candidates.iter().zip(&weights) {
            let toward = |out: &mut Array2<Complex64>, own: &Array2<Complex64>, last: &Array2<Complex64>| {
                ndarray::Zip::from(out).and(own).and(last).par_for_each(|o, &c, &l| *o += w * (c - l));
            };
            toward(&mut blend.state, &candidate.state, &last.state);
            toward(&mut blend.field, &candidate.field, &last.field);
            toward(&mut blend.residual, &candidate.residual, &last.residual);
        }
        blend
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

    fn step(&mut self) {
        self.solve_mean();
        self.problem.planes_to_points(&self.harmonics, &mut self.values);
        let [explicit, implicit] = &self.factors;
        let planes = self.state.outer_iter_mut().into_par_iter().zip(self.values.outer_iter());
        planes.enumerate().for_each(|(p, (state, values))| {
            let step = ndarray::Zip::from(state).and(values).and(explicit.row(p)).and(implicit.row(p));
            step.for_each(|s, &u, &e, &i| *s = (2.0 * u - *s) * e * i);
        });
        let (row, source) = &self.source;
        self.state.row_mut(*row).iter_mut().zip(source).for_each(|(s, b)| *s -= b);
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
