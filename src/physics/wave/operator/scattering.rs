//! One application of A⁻¹V, in double or in single precision: the main cost of every iterative
//! strategy.
//!
//! Per plane: values from nodes and bubbles, inverse transform, product with the contrast, forward
//! transform. Then per harmonic: loads to nodes and bubbles (the transpose of the values), and the
//! mean operator's factors.

use super::inverse::{MeanInverse, multiply, row};
use super::sharing::Idle;
use crate::numerics::fourier::{Harmonics, PlaneFft, PlaneScratch, Real, narrow};
use ndarray::{Array2, ArrayView2, Axis};
use num_complex::Complex;
use std::sync::Arc;

/// Operators that apply A⁻¹V.
pub trait Scatter<T: Real>: Sync {
    /// Applies out ← A⁻¹ V u, overwriting `out`; rows are planes, columns harmonics.
    fn scatter(&self, u: ArrayView2<Complex<T>>, out: &mut Array2<Complex<T>>);
}

/// The operator A⁻¹V as tables.
pub struct Scattering<T: Real> {
    pub(super) harmonics: Arc<Harmonics>,
    pub(super) fft: PlaneFft<T>,
    pub(super) mean: Arc<MeanInverse<T>>,
    /// Weights W_p divided by the number of points of a plane: planes × points.
    pub(super) weights: Array2<Complex<T>>,
    pub(super) idle: Idle<PlaneScratch<T>>,
}

impl Scattering<f64> {
    /// The operator in another precision, with its own transforms.
    pub fn narrowed<T: Real>(&self, fft: PlaneFft<T>) -> Scattering<T> {
        let mean = self.mean.narrowed().into();
        let weights = self.weights.mapv(narrow);
        Scattering { harmonics: self.harmonics.clone(), fft, mean, weights, idle: Idle::default() }
    }
}

impl<T: Real> Scattering<T> {
    /// Memory held including the mean operator's inverse, bytes.
    pub fn bytes(&self) -> usize {
        self.mean.bytes() + self.weights.len() * size_of::<Complex<T>>()
    }

    /// Applies out ← V u as loads on planes (one inverse and one forward transform per plane).
    pub fn contrast_loads(&self, u: ArrayView2<Complex<T>>, out: &mut Array2<Complex<T>>) {
        let scratch = || self.fft.scratch();
        self.idle.in_chunks(out, Axis(0), 1, scratch, |plane, mut row, scratch| {
            self.plane_loads(&u, plane, row.as_slice_mut().expect("rows are contiguous"), scratch);
        });
    }

    fn plane_loads(
        &self,
        u: &ArrayView2<Complex<T>>,
        plane: usize,
        out: &mut [Complex<T>],
        scratch: &mut PlaneScratch<T>,
    ) {
        self.mean.plane_values(u, plane, out); // û_p, from nodes and bubbles
        self.harmonics.spread(out, &mut scratch.spectrum);
        self.fft.inverse(scratch, &self.harmonics.rows); // u_p(x, y) = Σ û_p e^{i(kx x + ky y)}
        // W_p u_p, W_p = ∫ ψ_p (k² − ⟨k²⟩) dz
        multiply(&mut scratch.plane, row(&self.weights.view(), plane));
        self.fft.forward(scratch, &self.harmonics.rows);
        self.harmonics.gather(&scratch.spectrum, out); // y_p, harmonics of W_p u_p
    }
}

impl<T: Real> Scatter<T> for Scattering<T> {
    fn scatter(&self, u: ArrayView2<Complex<T>>, out: &mut Array2<Complex<T>>) {
        self.contrast_loads(u, out);
        self.mean.solve_loads(out);
    }
}
