//! The seam between the waves and all that solves them: the linear system (1 + A⁻¹V) u = u₀ of one wavelength,
//! direction and polarisation, its yardstick, and the orders that a solution sends out of the layer.
//!
//! The scalar wave's [`Problem`] is one such system; Maxwell's equations give one for each polarisation, with the same
//! shape of unknowns. Strategies that only apply the operator work on every system; those that take it apart ask
//! for [`System::split`].

use super::operator::mean_medium::cells_needed;
use super::operator::scattering::Scatter;
use super::{FarField, Field, Grid, Polarisation, Problem};
use ndarray::ArrayView2;
use num_complex::Complex64;

/// A discrete wave problem: immutable and shared between threads.
pub trait System: Send + Sync {
    /// The grid it was made for.
    fn grid(&self) -> &Grid;

    /// The polarisation of the incident light; none of the scalar wave.
    fn polarisation(&self) -> Option<Polarisation> {
        None
    }

    /// Rows and columns of a field of unknowns.
    fn shape(&self) -> (usize, usize);

    /// False where u₀ solves the problem already: nothing is left to iterate on.
    fn has_contrast(&self) -> bool;

    /// u₀ = A⁻¹ b, the wave in the mean medium.
    fn background_wave(&self) -> Field;

    /// out ← A⁻¹ V u: one operator application, written over whatever `out` held.
    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field);

    /// The same operator in single precision, where the system has it: its roundings are for strategies that measure
    /// the true residual afterwards.
    fn single(&self) -> Option<&dyn Scatter<f32>> {
        None
    }

    /// A and V apart, in values at points: for strategies that treat them in turn, or A's guided modes. None where the
    /// unknowns are moments.
    fn split(&self) -> Option<&Problem> {
        None
    }

    /// k̄² of each cell, 1/µm².
    fn mean_k2(&self) -> &[Complex64];

    /// The orders that a solution sends out of the layer, with their receipt.
    fn far_field(&self, u: &Field) -> FarField;

    /// Bytes held, without solver vectors; systems of s and p light hold them together.
    fn bytes(&self) -> usize;

    /// Number of complex unknowns.
    fn unknowns(&self) -> usize {
        self.shape().0 * self.shape().1
    }

    /// out ← u₀ − (1 + A⁻¹V) u; the yardstick of all strategies is its norm over that of u₀.
    fn residual(&self, background: &Field, u: &Field, out: &mut Field) {
        self.scatter(u.view(), out);
        ndarray::Zip::from(out).and(background).and(u).par_for_each(|r, &b, &x| *r = b - x - *r);
    }

    /// Cells of another grid that a problem of this light would be accepted on: its own, or as many as the wave needs.
    /// Judged by this problem's mean, before a geometry is computed for that grid.
    fn cells_needed(&self, other: &Grid) -> usize {
        cells_needed(self.grid(), self.mean_k2(), other)
    }

    /// A solution of this problem as a first guess on another grid; none where the unknowns do not interpolate.
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
        Some(self.single())
    }

    fn split(&self) -> Option<&Problem> {
        Some(self)
    }

    fn mean_k2(&self) -> &[Complex64] {
        self.mean.mean_k2()
    }

    fn far_field(&self, u: &Field) -> FarField {
        self.far_field(u)
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }
}
