//! A system with a source of one's own: for tangents and adjoints.

use super::operator::scattering::Scatter;
use super::{FarField, Field, Grid, Polarisation, Problem, System};
use ndarray::ArrayView2;
use num_complex::Complex64;

/// The operator of a system with another right-hand side. Strategies that treat A and V separately
/// take the source from the problem and cannot solve it; guided modes are kept.
pub struct Sourced<'a> {
    system: &'a dyn System,
    background: Field,
}

impl<'a> Sourced<'a> {
    /// `background` is A⁻¹ applied to the source.
    pub fn new(system: &'a dyn System, background: Field) -> Self {
        Self { system, background }
    }
}

impl System for Sourced<'_> {
    fn grid(&self) -> &Grid {
        self.system.grid()
    }

    fn polarisation(&self) -> Option<Polarisation> {
        self.system.polarisation()
    }

    fn shape(&self) -> (usize, usize) {
        self.system.shape()
    }

    fn has_contrast(&self) -> bool {
        self.system.has_contrast()
    }

    fn background_wave(&self) -> Field {
        self.background.clone()
    }

    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field) {
        self.system.scatter(u, out);
    }

    fn single(&self) -> Option<&dyn Scatter<f32>> {
        self.system.single()
    }

    fn operator(&self) -> Option<&Problem> {
        self.system.operator()
    }

    fn mean_k2(&self) -> &[Complex64] {
        self.system.mean_k2()
    }

    fn far_field(&self, u: &Field) -> FarField {
        self.system.far_field(u)
    }

    fn bytes(&self) -> usize {
        self.system.bytes()
    }
}
