//! Far field for one incident polarisation: complex amplitudes and efficiencies of both outgoing
//! ones.
//!
//! With p̂ = k_par/q and s = ẑ × p̂ (p̂ = (cos φ, sin φ) if q = 0) in a half-space of wavenumber k:
//! P(±) = (±κ p̂ − q ẑ)/k for light towards ±z, a_s = E·s, a_p = h/k for both directions of
//! propagation. Reflected amplitudes refer to the illuminated face, transmitted ones to the
//! opposite face, at x = y = 0.

use super::mean::Faces;
use super::problem::VectorProblem;
use crate::wave::far_field::listed_orders;
use crate::wave::{FarField, Field, Order, Polarisation};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Amplitudes s and p of one order that leaves through one face.
type Amplitudes = [Complex64; 2];

impl VectorProblem {
    /// Evaluates the orders at both faces of the solution for one incident polarisation. The first
    /// amplitude of an order has the incident polarisation, the crossed one follows; efficiencies
    /// contain both.
    pub fn far_field(&self, field: &Field, polarisation: Polarisation) -> FarField {
        let (faces, absorptance) = self.leaving(field, polarisation);
        let harmonics = &self.harmonics.orders;
        let specular = harmonics[self.incident_harmonic()];
        let mut listed = listed_orders(harmonics, &self.lateral, &self.media, self.k0(), specular);
        listed.sort_by_key(|&(_, label)| label);
        let order = |(i, label)| self.order(&faces, polarisation, i, label);
        let orders = listed.into_iter().map(order).collect();
        FarField::of_orders(self.incidence, self.moments.grid.period_um, orders, absorptance)
    }

    /// One order: the amplitude of the incident polarisation, then the crossed one.
    fn order(&self, faces: &Faces, polarisation: Polarisation, i: usize, [m, n]: [i32; 2]) -> Order {
        let own = polarisation as usize;
        // Sides of reflected and of transmitted light.
        let [back, onward] = [self.entry_side(), 1 - self.entry_side()];
        let [mut reflected, transmitted] = [back, onward].map(|s| self.amplitudes(faces, s, i));
        if i == self.incident_harmonic() {
            reflected[own] -= 1.0;
        }
        Order {
            m,
            n,
            direction: self.lateral[i].map(|k| k / self.k0()),
            reflected_propagates: self.kappa[back][i].re > 0.0,
            transmitted_propagates: self.kappa[onward][i].re > 0.0,
            reflected: reflected[own],
            transmitted: transmitted[own],
            reflected_efficiency: self.efficiency(back, i, reflected),
            transmitted_efficiency: self.efficiency(onward, i, transmitted),
            further: [[reflected[1 - own], transmitted[1 - own]], Default::default(), Default::default()],
        }
    }

    /// Vacuum wavenumber, 1/µm.
    fn k0(&self) -> f64 {
        TAU / self.incidence.wavelength_um
    }

    /// Amplitudes of one harmonic on a side, including the incident wave.
    fn amplitudes(&self, faces: &Faces, side: usize, i: usize) -> Amplitudes {
        [faces.electric[side][i], faces.magnetic[side][i] / self.k[side]]
    }

    /// Flux relative to the incident one: Re κ for s, Re(κ k*/k) for p (in an absorber E and h are
    /// out of phase).
    fn efficiency(&self, side: usize, harmonic: usize, [s, p]: Amplitudes) -> f64 {
        let (kappa, k) = (self.kappa[side][harmonic], self.k[side]);
        let parallel = (kappa * k.conj() / k).re;
        (kappa.re * s.norm_sqr() + parallel * p.norm_sqr()) / self.incident_kappa()
    }
}
