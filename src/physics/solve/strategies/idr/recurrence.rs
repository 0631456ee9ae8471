//! The recurrence of IDR(s) from one residual.
//!
//! In single precision it needs twice the steps, or stalls: its residual is not the image of its
//! correction any more.

use crate::numerics::Draws;
use crate::solve::basis::{add_combination, dot, scaled, split_dot};
use crate::solve::{Ledger, SolveError};
use crate::wave::{Field, Scatter};
use num_complex::Complex64;

/// Cosine of the angle between a residual and its image below which the step into the next space is
/// lengthened (Sleijpen and van der Vorst 1995).
const COSINE: f64 = 0.7;
/// Entries that follow each other in one shadow vector.
const BLOCK: usize = 16;
const SEED: u64 = 2011;

/// s shadow vectors of random phases: modulus 2 in blocks of entries of its own, 1 elsewhere, with
/// the same phases. Products with all of them read a vector once, and none vanishes where a vector
/// is zero outside a few entries, as the incident wave is.
struct Shadow {
    phases: Vec<f64>,
    block: usize,
    s: usize,
}

impl Shadow {
    fn new(s: usize, entries: usize) -> Self {
        let mut draws = Draws::new(SEED, 0);
        let angles: Vec<f64> = (0..entries).map(|_| draws.between(0.0, std::f64::consts::TAU)).collect();
        let phases = angles.iter().map(|a| a.cos()).chain(angles.iter().map(|a| a.sin()));
        Self { phases: phases.collect(), block: (entries / (8 * s)).clamp(1, BLOCK), s }
    }

    /// ⟨p_i, v⟩ for all i.
    fn products(&self, v: &[f64]) -> Vec<Complex64> {
        let (p_re, p_im) = self.phases.split_at(v.len() / 2);
        let (re, im) = v.split_at(v.len() / 2);
        let mut sums = vec![Complex64::ZERO; self.s];
        for (b, from) in (0..re.len()).step_by(self.block).enumerate() {
            let block = from..re.len().min(from + self.block);
            sums[b % self.s] +=
                dot((&p_re[block.clone()], &p_im[block.clone()]), (&re[block.clone()], &im[block]));
        }
        let all: Complex64 = sums.iter().sum();
        sums.iter_mut().for_each(|sum| *sum += all);
        sums
    }
}

/// The state: vectors are stored as real parts followed by imaginary parts.
pub(super) struct Recurrence {
    shadow: Shadow,
    /// Residual and correction.
    r: Vec<f64>,
    e: Vec<f64>,
    /// Directions d_k and their images g_k = M d_k.
    directions: Vec<Vec<f64>>,
    images: Vec<Vec<f64>>,
    /// ⟨p_i, g_k⟩, zero for i < k.
    small: Vec<Vec<Complex64>>,
    omega: Complex64,
    /// Norm of the first residual.
    size: f64,
    /// What the operator reads and writes.
    work: [Field; 2],
}

impl Recurrence {
    /// Starts from a residual of norm `size`, in units of it.
    pub fn new(s: usize, residual: &Field, size: f64) -> Self {
        let r = scaled(residual.as_slice().expect("fields are contiguous"), size);
        let zeros = || vec![vec![0.0; r.len()]; s];
        let directions = zeros();
        let images = zeros();
        let shadow = Shadow::new(s, r.len() / 2);
        let e = vec![0.0; r.len()];
        let small = (0..s).map(|i| (0..s).map(|k| f64::from(i == k).into()).collect()).collect();
        let work = [Field::zeros(residual.dim()), Field::zeros(residual.dim())];
        Self { shadow, r, e, directions, images, small, omega: Complex64::ONE, size, work }
    }

    /// The correction of the field, in the units of the first residual.
    pub fn correction(&self) -> impl Iterator<Item = Complex64> {
        let (re, im) = self.e.split_at(self.e.len() / 2);
        re.iter().zip(im).map(|(&re, &im)| Complex64::new(re, im))
    }

    /// Iterates until the recursive residual meets the goal, breaks down, or the applications are
    /// used up.
    pub fn run(&mut self, operator: &dyn Scatter<f64>, ledger: &mut Ledger) -> Result<(), SolveError> {
        loop {
            let mut f = self.shadow.products(&self.r);
            for k in 0..=self.shadow.s {
                let norm = match k < self.shadow.s {
                    true => self.step(k, &mut f, operator),
                    false => self.reduce(operator),
                };
                ledger.account.operator_applications += 1;
                let Some(norm) = norm else { return Ok(()) };
                ledger.account.steps += 1;
                let residual = norm * self.size / ledger.scale();
                ledger.note(residual)?;
                // Slightly below the goal, so that the true residual, measured next, meets it too.
                let reached = residual <= 0.9 * ledger.goal.tolerance;
                if reached || norm > 1e4 || ledger.exhausted() {
                    return Ok(());
                }
            }
        }
    }

    /// One step within a space: a new direction whose image is orthogonal to k shadow vectors, and
    /// a residual orthogonal to k + 1, whose norm is returned. `f` = ⟨p_i, r⟩. `None` if the
    /// recurrence breaks down.
    fn step(&mut self, k: usize, f: &mut [Complex64], operator: &dyn Scatter<f64>) -> Option<f64> {
        let s = self.shadow.s;
        let c = self.forward(k, f);
        // d_k ← ω (r − Σ c_i g_i) + Σ c_i d_i, i ≥ k
        let factors: Vec<Complex64> = c.iter().map(|c| -self.omega * c).chain(c.iter().copied()).collect();
        let vectors: Vec<&Vec<f64>> = self.images[k..].iter().chain(&self.directions[k..]).collect();
        let mut direction = vec![0.0; self.r.len()];
        add_combination(&mut direction, &[self.omega], &[&self.r]);
        add_combination(&mut direction, &factors, &vectors);
        let mut image = self.applied(&direction, operator);
        let mut g = self.shadow.products(&image);
        let mut removed = Vec::with_capacity(k);
        for i in 0..k {
            let alpha = g[i] / self.small[i][i];
            (i..s).for_each(|row| g[row] -= alpha * self.small[row][i]);
            removed.push(-alpha);
        }
        add_combination(&mut direction, &removed, &self.directions[..k]);
        add_combination(&mut image, &removed, &self.images[..k]);
        (k..s).for_each(|row| self.small[row][k] = g[row]);
        let beta = f[k] / g[k];
        if !beta.is_finite() {
            return None;
        }
        add_combination(&mut self.e, &[beta], &[&direction]);
        let norm = add_combination(&mut self.r, &[-beta], &[&image]);
        (k + 1..s).for_each(|row| f[row] -= beta * g[row]);
        self.directions[k] = direction;
        self.images[k] = image;
        Some(norm)
    }

    /// Solution c of the lower triangle: Σ_i ⟨p_j, g_i⟩ c_i = f_j for i, j ≥ k.
    fn forward(&self, k: usize, f: &[Complex64]) -> Vec<Complex64> {
        let mut c: Vec<Complex64> = Vec::with_capacity(f.len() - k);
        for j in k..f.len() {
            let known: Complex64 = (k..j).map(|i| self.small[j][i] * c[i - k]).sum();
            c.push((f[j] - known) / self.small[j][j]);
        }
        c
    }

    /// The step into the next, smaller space: r ← (1 − ω M) r. `None` if it breaks down.
    fn reduce(&mut self, operator: &dyn Scatter<f64>) -> Option<f64> {
        let image = self.applied(&self.r.clone(), operator);
        let product = split_dot(&image, &self.r);
        let lengths = [&image, &self.r].map(|v| split_dot(v, v).re.sqrt());
        let cosine = product.norm() / (lengths[0] * lengths[1]);
        self.omega = product / lengths[0].powi(2) * (COSINE / cosine).max(1.0);
        if !self.omega.is_finite() || self.omega.norm() < 1e-14 {
            return None;
        }
        add_combination(&mut self.e, &[self.omega], &[&self.r]);
        Some(add_combination(&mut self.r, &[-self.omega], &[&image]))
    }

    /// (1 + A⁻¹V) v.
    fn applied(&mut self, v: &[f64], operator: &dyn Scatter<f64>) -> Vec<f64> {
        let [field, image] = &mut self.work;
        let (re, im) = v.split_at(v.len() / 2);
        field.iter_mut().zip(re.iter().zip(im)).for_each(|(z, (&re, &im))| *z = Complex64::new(re, im));
        operator.scatter(field.view(), image);
        let mut sum = vec![0.0; v.len()];
        let (re, im) = sum.split_at_mut(v.len() / 2);
        let values = re.iter_mut().zip(im).zip(field.iter().zip(&*image));
        values.for_each(|((re, im), (a, b))| (*re, *im) = (a.re + b.re, a.im + b.im));
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex;

    /// Gives back what it reads, so that 1 + A⁻¹V is 2.
    struct Twice;

    impl Scatter<f64> for Twice {
        fn scatter(&self, u: ndarray::ArrayView2<Complex<f64>>, out: &mut Field) {
            out.assign(&u);
        }
    }

    #[test]
    fn the_step_into_the_next_space_takes_away_what_it_can() {
        let residual = Field::from_shape_fn((2, 3), |(i, j)| Complex64::new(1.0 + i as f64, j as f64));
        let mut recurrence = Recurrence::new(1, &residual, 1.0);
        let left = recurrence.reduce(&Twice).unwrap();
        assert!(left < 1e-12 && (recurrence.omega - 0.5).norm() < 1e-12, "{left} {}", recurrence.omega);
    }
}
