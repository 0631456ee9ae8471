//! The march, successive steps of τ at the points of all planes, and the averaging restart: the
//! combination of earlier states with the smallest residual.

use crate::numerics::dense::MatrixEntry;
use crate::solve::ledger::{Ledger, flat};
use crate::solve::vectors::{dot, norm};
use crate::wave::ShiftedMean;
use crate::wave::{Field, Problem};
use faer::Mat;
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;
use std::collections::VecDeque;

/// State of the march at the points of all planes.
pub(super) struct March<'a> {
    problem: &'a Problem,
    /// Shifted mean operator D − cÃ.
    pub shifted: ShiftedMean,
    /// (1 + cV/D) and 1/(1 − cV/D) at the points.
    factors: [Field; 2],
    /// Row of the illuminated face, and 2c b/D/(1 − cV/D) at its points.
    source: (usize, Vec<Complex64>),
    pub state: Field,
    harmonics: Field,
    values: Field,
}

impl<'a> March<'a> {
    pub fn new(problem: &'a Problem, tau: f64, field: &Field) -> March<'a> {
        let contrast = contrasts(problem);
        let largest = contrast.iter().map(|v| v.norm()).fold(1e-300, f64::max);
        let c = Complex64::new(0.0, 0.5 * tau / largest);
        let factors = [contrast.mapv(|v| 1.0 + c * v), contrast.mapv(|v| 1.0 / (1.0 - c * v))];
        let shifted = ShiftedMean::new(problem, 1.0.into(), -c);
        let (row, b) = problem.source_at_points();
        let weighted = b.iter().zip(factors[1].row(row)).map(|(b, f)| 2.0 * c * b / shifted.mass[row] * f);
        let source = (row, weighted.collect());
        let values = Array2::zeros(contrast.dim());
        let harmonics = Field::zeros(problem.shape());
        let mut march = March { problem, shifted, factors, source, state: values.clone(), harmonics, values };
        march.take_up(field);
        march
    }

    pub fn bytes(&self) -> usize {
        let points = 4 * self.state.len() + 2 * self.harmonics.len();
        points * size_of::<Complex64>() + self.shifted.bytes()
    }

    /// The state whose fixed point a solution u is: s = (1 + cV/D)u − cD⁻¹b at the points,
    /// including what V scatters beyond the harmonics.
    fn take_up(&mut self, field: &Field) {
        self.problem.planes_to_points(&self.problem.mean.to_planes(field), &mut self.state);
        self.state *= &self.factors[0];
        let (row, source) = &self.source;
        // The source is stored divided by 1 − cV/D and doubled.
        let terms = self.state.row_mut(*row).into_iter().zip(source).zip(self.factors[1].row(*row));
        terms.for_each(|((s, b), f)| *s -= 0.5 * b / f);
    }

    /// The present state with its field and residual.
    pub fn candidate(&self, ledger: &mut Ledger) -> Candidate {
        self.candidate_of(self.state.clone(), ledger)
    }

    pub fn candidate_of(&self, state: Field, ledger: &mut Ledger) -> Candidate {
        let mut field = Field::zeros(self.problem.shape());
        let mut residual = Field::zeros(self.problem.shape());
        self.shifted.solve_points(self.problem, &state, &mut field);
        self.problem.mean.to_unknowns(&mut field);
        ledger.measure(&field, &mut residual);
        Candidate { state, field, residual }
    }

    /// One step of τ: s ← (1 − cV/D)⁻¹ [(1 + cV/D)(2u − s) − 2c b/D] with u = (D − cÃ)⁻¹ D s.
    pub fn step(&mut self) {
        // u, from (D − cÃ) u = D s
        self.shifted.solve_points(self.problem, &self.state, &mut self.harmonics);
        self.problem.planes_to_points(&self.harmonics, &mut self.values);
        let [explicit, implicit] = &self.factors;
        let planes = self.state.outer_iter_mut().into_par_iter().zip(self.values.outer_iter());
        planes.enumerate().for_each(|(p, (state, values))| {
            let step = ndarray::Zip::from(state).and(values).and(explicit.row(p)).and(implicit.row(p));
            // (2u − s)(1 + cV/D) / (1 − cV/D)
            step.for_each(|s, &u, &e, &i| *s = (2.0 * u - *s) * e * i);
        });
        let (row, source) = &self.source;
        // − 2c b/D / (1 − cV/D)
        self.state.row_mut(*row).iter_mut().zip(source).for_each(|(s, b)| *s -= b);
    }

    /// Advances by a window and returns the mean of its states.
    pub fn window(&mut self, steps: usize, ledger: &mut Ledger) -> Field {
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
pub(crate) fn contrasts(problem: &Problem) -> Field {
    let mass = problem.mean.plane_mass();
    let points = problem.coverage.grid.points();
    let mut all = Array2::zeros((mass.len(), points));
    all.outer_iter_mut().into_par_iter().enumerate().for_each(|(p, mut row)| {
        row.iter_mut().zip(problem.contrast_per_mass(p, mass[p])).for_each(|(out, v)| *out = v);
    });
    all
}

/// A state of the march with its field and residual.
#[derive(Clone)]
pub(super) struct Candidate {
    pub state: Field,
    pub field: Field,
    pub residual: Field,
}

impl Candidate {
    /// The affine combination last + Σ w (other − last) with the smallest residual: states, fields
    /// and residuals depend affinely on each other.
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

/// Adds out ← out + w (a − b).
fn add_difference(out: &mut Field, w: Complex64, a: &Field, b: &Field) {
    ndarray::Zip::from(out).and(a).and(b).par_for_each(|o, &a, &b| *o += w * (a - b));
}

/// Candidates for the averaging restart: the base from which the march continues, and the latest
/// candidates of its windows. Earlier bases are not kept, because they are combinations of those.
pub(super) struct Memory {
    pub base: Candidate,
    /// Two per window, the mean of its states and its last state; oldest first.
    pub recent: VecDeque<Candidate>,
    /// Largest number of candidates between two windows, including the base.
    most: usize,
}

impl Memory {
    pub fn new(base: Candidate, most: usize) -> Memory {
        Memory { base, recent: VecDeque::new(), most: most.max(1) }
    }

    /// Makes the best combination the base and drops the oldest candidates beyond the limit.
    pub fn average(&mut self) {
        if let Some(last) = self.recent.pop_back() {
            let others: Vec<&Candidate> = [&self.base].into_iter().chain(&self.recent).collect();
            self.base = Candidate::blend(&others, &last);
            self.recent.push_back(last);
        }
        let beyond = (self.recent.len() + 1).saturating_sub(self.most);
        self.recent.drain(..beyond);
    }

    /// Memory in bytes of all candidates, two more from a window, and the differences of their
    /// residuals during a combination.
    pub fn most_bytes(&self) -> usize {
        let Candidate { state, field, residual } = &self.base;
        (self.most + 2) * (state.len() + field.len() + 2 * residual.len()) * size_of::<Complex64>()
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
    let right = Mat::from_fn(n, 1, |i, _| -dot(flat(&differences[i]), flat(residual)) / sizes[i]);
    let solved = Complex64::solve(&Complex64::factors(gram.as_ref()), right.as_ref());
    (0..n).map(|i| solved[(i, 0)] / sizes[i]).collect()
}
