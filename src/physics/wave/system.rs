//! Interface between the waves and the solvers: the linear system (1 + A⁻¹V) u = u₀ of one
//! wavelength, direction and polarisation, its residual, and the far field of a solution.
//!
//! The scalar wave's [`Problem`] is one such system; Maxwell's equations give one for each
//! polarisation, with unknowns of the same shape. Strategies that only apply the operator work on
//! every system; those that treat A and V separately use [`System::split`].

use super::maxwell::{Polarised, VectorProblem};
use super::operator::setting::cells_needed;
use super::{FarField, Field, Grid, Polarisation, Problem, Scatter};
use ndarray::ArrayView2;
use num_complex::Complex64;

/// A system's operator in double precision, for code generic over the precision.
pub(crate) struct Double<'a>(pub(crate) &'a dyn System);

impl Scatter<f64> for Double<'_> {
    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field) {
        self.0.scatter(u, out);
    }
}

/// A discrete wave problem: immutable and shared between threads.
pub trait System: Send + Sync {
    /// The grid of the problem.
    fn grid(&self) -> &Grid;

    /// Polarisation of the incident light; `None` for the scalar wave.
    fn polarisation(&self) -> Option<Polarisation> {
        None
    }

    /// Rows and columns of a field of unknowns.
    fn shape(&self) -> (usize, usize);

    /// Whether there is contrast; without it u₀ is the solution, and nothing is left to iterate on.
    fn has_contrast(&self) -> bool;

    /// Background wave u₀ = A⁻¹ b in the mean medium.
    fn background_wave(&self) -> Field;

    /// Applies out ← A⁻¹ V u, overwriting `out`: one operator application.
    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field);

    /// The operator in single precision, if the system has it: its rounding errors suit strategies
    /// that measure the true residual afterwards.
    fn single(&self) -> Option<&dyn Scatter<f32>> {
        None
    }

    /// A and V separately, in values at points: for strategies that alternate between them, or use
    /// guided modes of A. `None` if the unknowns are moments.
    fn split(&self) -> Option<&Problem> {
        None
    }

    /// The problem that both polarisations of the vector wave share, whose lowest harmonics can be
    /// eliminated; `None` for the scalar wave.
    fn vector(&self) -> Option<&VectorProblem> {
        None
    }

    /// Mean k̄² of each cell, 1/µm².
    fn mean_k2(&self) -> &[Complex64];

    /// The far field of a solution, with its energy balance.
    fn far_field(&self, u: &Field) -> FarField;

    /// Memory held without solver vectors, bytes; systems of s and p light share it.
    fn bytes(&self) -> usize;

    /// Number of complex unknowns.
    fn unknowns(&self) -> usize {
        self.shape().0 * self.shape().1
    }

    /// Residual out ← u₀ − (1 + A⁻¹V) u; all strategies measure its norm relative to that of u₀.
    fn residual(&self, background: &Field, u: &Field, out: &mut Field) {
        self.scatter(u.view(), out);
        ndarray::Zip::from(out).and(background).and(u).par_for_each(|r, &b, &x| *r = b - x - *r);
    }

    /// Number of cells with which another grid would be accepted for this light: its own, or as
    /// many as the wave needs. Estimated from the mean of this problem, before a geometry is
    /// computed for that grid.
    fn cells_needed(&self, other: &Grid) -> usize {
        cells_needed(self.grid(), self.mean_k2(), other)
    }

    /// A solution of this problem as an initial guess on another grid; `None` if the unknowns
    /// cannot be interpolated.
    fn transferred(&self, field: &Field, other: &dyn System) -> Option<Field> {
        Some(self.split()?.transferred(field, other.split()?))
    }
}

impl System for Problem {
    fn grid(&self) -> &Grid {
        &self.coverage.grid
    }

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
        self.double().scatter(u, out);
    }

    fn single(&self) -> Option<&dyn Scatter<f32>> {
        Some(self.single.get_or_init(|| self.double().narrowed(self.coverage.fft_single.clone())))
    }

    fn split(&self) -> Option<&Problem> {
        Some(self)
    }

    fn mean_k2(&self) -> &[Complex64] {
        &self.mean.mean_k2
    }

    fn far_field(&self, u: &Field) -> FarField {
        self.far_field(u)
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }
}

impl System for Polarised {
    fn grid(&self) -> &Grid {
        &self.problem.moments.grid
    }

    fn polarisation(&self) -> Option<Polarisation> {
        Some(self.polarisation)
    }

    fn shape(&self) -> (usize, usize) {
        self.problem.shape()
    }

    fn has_contrast(&self) -> bool {
        self.problem.operator().has_contrast()
    }

    fn background_wave(&self) -> Field {
        self.problem.background(self.polarisation)
    }

    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field) {
        self.problem.operator().scatter(u, out);
    }

    fn single(&self) -> Option<&dyn Scatter<f32>> {
        Some(self.problem.narrow_operator())
    }

    fn vector(&self) -> Option<&VectorProblem> {
        Some(&self.problem)
    }

    fn mean_k2(&self) -> &[Complex64] {
        self.problem.mean_k2()
    }

    fn far_field(&self, u: &Field) -> FarField {
        self.problem.far_field(u, self.polarisation)
    }

    fn bytes(&self) -> usize {
        self.problem.bytes()
    }
}
