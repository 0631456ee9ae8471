//! What a strategy needs to know of a wave problem: the linear system (1 + A⁻¹V) u = u₀ and its yardstick.
//!
//! The scalar [`Problem`] is one such system; Maxwell's equations give another with the same shape of
//! unknowns. Strategies that only apply the operator work on every system; those that take the operator apart
//! ask for the parts and refuse systems that have none.

use crate::wave::maxwell::Polarised;
use crate::wave::operator::scattering::Scatter;
use crate::wave::{Field, Problem};
use ndarray::ArrayView2;
use num_complex::Complex64;

/// A discrete wave problem as seen by the strategies: immutable and shared between threads.
pub trait System: Send + Sync {
    /// Rows and columns of a field of unknowns.
    fn shape(&self) -> (usize, usize);

    /// False where u₀ solves the problem already: nothing is left to iterate on.
    fn has_contrast(&self) -> bool;

    /// u₀ = A⁻¹ b, the wave in the mean medium.
    fn background_wave(&self) -> Field;

    /// out ← A⁻¹ V u: one operator application, written over whatever `out` held.
    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field);

    /// The same operator in single precision, where the system has it: its roundings are for strategies that measure the
    /// true residual afterwards.
    fn single(&self) -> Option<&dyn Scatter<f32>> {
        None
    }

    /// The scalar problem, for strategies that split its operator or treat its guided modes; none for other systems.
    fn scalar(&self) -> Option<&Problem> {
        None
    }

    /// Number of complex unknowns.
    fn unknowns(&self) -> usize {
        self.shape().0 * self.shape().1
    }

    /// out ← u₀ − (1 + A⁻¹V) u; the yardstick of all strategies is its norm over that of u₀.
    fn residual(&self, background: &Field, u: &Field, out: &mut Field) {
        self.scatter(u.view(), out);
        ndarray::Zip::from(out).and(background).and(u).par_for_each(|r, &b, &x| *r = b - x - *r);
    }
}

impl System for Problem {
    fn shape(&self) -> (usize, usize) {
        self.shape()
    }

    fn has_contrast(&self) -> bool {
        self.has_contrast()
    }

    fn background_wave(&self) -> Field {
        self.background_wave()
    }

    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field) {
        self.scatter_view(u, out);
    }

    fn single(&self) -> Option<&dyn Scatter<f32>> {
        Some(self.single())
    }

    fn scalar(&self) -> Option<&Problem> {
        Some(self)
    }
}

/// A system's operator in double precision, for code that is written for both.
pub(crate) struct Double<'a>(pub &'a dyn System);

impl Scatter<f64> for Double<'_> {
    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field) {
        self.0.scatter(u, out);
    }
}

impl System for Polarised<'_> {
    fn shape(&self) -> (usize, usize) {
        self.problem.shape()
    }

    fn has_contrast(&self) -> bool {
        self.problem.has_contrast()
    }

    fn background_wave(&self) -> Field {
        self.problem.background_wave(self.polarisation)
    }

    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field) {
        self.problem.scatter(u, out);
    }

    fn single(&self) -> Option<&dyn Scatter<f32>> {
        Some(self.problem.single())
    }
}
