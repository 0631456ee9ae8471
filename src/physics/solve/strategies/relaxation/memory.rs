//! The averaging restart: the combination of earlier states with the smallest residual.

use crate::numerics::dense::MatrixEntry;
use crate::solve::ledger::flat;
use crate::solve::vectors::{dot, norm};
use crate::wave::Field;
use faer::Mat;
use ndarray::Array2;
use num_complex::Complex64;
use std::collections::VecDeque;

/// A state of the march with its field and residual.
#[derive(Clone)]
pub(super) struct Candidate {
    pub state: Array2<Complex64>,
    pub field: Field,
    pub residual: Field,
}

impl Candidate {
    fn bytes(&self) -> usize {
        (self.state.len() + self.field.len() + self.residual.len()) * size_of::<Complex64>()
    }

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
fn add_difference(out: &mut Array2<Complex64>, w: Complex64, a: &Array2<Complex64>, b: &Array2<Complex64>) {
    ndarray::Zip::from(out).and(a).and(b).par_for_each(|o, &a, &b| *o += w * (a - b));
}

/// Candidates for the averaging restart: the base from which the march continues, and the latest
/// candidates of its windows. Earlier bases are not kept, because they are combinations of those.
pub(super) struct Memory {
    pub base: Candidate,
    /// Two per window, the mean of its states and its last state; oldest first.
    recent: VecDeque<Candidate>,
    /// Largest number of candidates between two windows, including the base.
    most: usize,
}

impl Memory {
    pub fn new(base: Candidate, most: usize) -> Memory {
        Memory { base, recent: VecDeque::new(), most: most.max(1) }
    }

    pub fn add(&mut self, candidate: Candidate) {
        self.recent.push_back(candidate);
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
    let right = Mat::from_fn(n, 1, |i, _| -dot(flat(&differences[i]), flat(residual)) / sizes[i]);
    let solved = Complex64::solve(&Complex64::factors(gram.as_ref()), right.as_ref());
    (0..n).map(|i| solved[(i, 0)] / sizes[i]).collect()
}
