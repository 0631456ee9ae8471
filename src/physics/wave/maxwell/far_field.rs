//! Far field for one incident polarisation: complex amplitudes and efficiencies of both outgoing
//! ones.
//!
//! With p̂ = k_par/q and s = ẑ × p̂ (p̂ = (cos φ, sin φ) if q = 0) in a half-space of wavenumber k:
//! P(±) = (±κ p̂ − q ẑ)/k for light towards ±z, a_s = E·s, a_p = h/k for both directions of
//! propagation. Reflected amplitudes refer to the illuminated face, transmitted ones to the
//! opposite face, at x = y = 0.

use super::mean::Nodes;
use super::problem::VectorProblem;
use crate::wave::far_field::Leaving;
use crate::wave::{FarField, Field, Polarisation};
use num_complex::Complex64;

impl VectorProblem {
    /// Evaluates the orders at both faces of the solution for one incident polarisation. The first
    /// amplitude of an order has the incident polarisation, the crossed one follows; efficiencies
    /// contain both.
    pub fn far_field(&self, field: &Field, polarisation: Polarisation) -> FarField {
        let (nodes, absorptance) = self.leaving(field, polarisation);
        let orders =
            self.orders(|side, i, incident| self.leaving_order(&nodes, polarisation, [side, i], incident));
        FarField::of_orders(self.incidence, self.moments.grid.period_um, orders, absorptance)
    }

    /// What leaves through a side in harmonic i, less the incident wave.
    fn leaving_order(
        &self,
        nodes: &Nodes,
        own: Polarisation,
        [side, i]: [usize; 2],
        incident: f64,
    ) -> Leaving {
        let face = side * self.moments.grid.cells();
        let mut amplitudes = [nodes[0][[face, i]], nodes[1][[face, i]] / self.k[side]];
        amplitudes[own as usize] -= incident;
        let crossed = amplitudes[1 - own as usize];
        ([amplitudes[own as usize], crossed], self.efficiency(side, i, amplitudes))
    }

    /// Flux relative to the incident one: Re κ for s, Re(κ k*/k) for p (in an absorber E and h are
    /// out of phase).
    fn efficiency(&self, side: usize, harmonic: usize, [s, p]: [Complex64; 2]) -> f64 {
        let (kappa, k) = (self.kappa[side][harmonic], self.k[side]);
        let parallel = (kappa * k.conj() / k).re;
        (kappa.re * s.norm_sqr() + parallel * p.norm_sqr()) / self.incident_kappa()
    }
}
