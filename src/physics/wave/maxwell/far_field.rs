//! What leaves the layer in both polarisations: complex amplitudes, efficiencies, and the share of each.
//!
//! With p̂ = k_par/q and s = ẑ × p̂ (p̂ = (cos φ, sin φ) where q = 0) in a half-space of wavenumber k:
//! P(±) = (±κ p̂ − q ẑ)/k for light towards ±z, a_s = E·s, a_p = h/k for both directions of travel. Reflected
//! amplitudes refer to the face the light enters by, transmitted ones to the opposite face, at x = y = 0.

use super::mean::Faces;
use super::problem::{Polarisation, VectorProblem};
use crate::wave::far_field::{FURTHER, listed_orders};
use crate::wave::{FarField, Field, Incidence, Order};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Amplitudes of one order that leaves by one face: s and p.
pub type Amplitudes = [Complex64; 2];

/// One diffraction order (m, n), counted from the specular direction; outer index: incident polarisation (s, p).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VectorOrder {
    /// Order along x.
    pub m: i32,
    /// Order along y.
    pub n: i32,
    /// (kx, ky)/k0.
    pub direction: [f64; 2],
    /// Whether light of this order travels in the half-space that the light comes from.
    pub reflected_propagates: bool,
    /// The same in the opposite half-space.
    pub transmitted_propagates: bool,
    /// R\[in\]\[out\].
    pub reflected: [Amplitudes; 2],
    /// T\[in\]\[out\].
    pub transmitted: [Amplitudes; 2],
    /// Flux over the incident one, both outgoing polarisations together, per incident one.
    pub reflected_efficiency: [f64; 2],
    /// The same for transmission.
    pub transmitted_efficiency: [f64; 2],
}

impl VectorOrder {
    /// What incident polarisation `i` sends into this order.
    fn polarised(&self, i: usize) -> Order {
        Order {
            m: self.m,
            n: self.n,
            direction: self.direction,
            reflected_propagates: self.reflected_propagates,
            transmitted_propagates: self.transmitted_propagates,
            reflected: self.reflected[i][i],
            transmitted: self.transmitted[i][i],
            reflected_efficiency: self.reflected_efficiency[i],
            transmitted_efficiency: self.transmitted_efficiency[i],
            further: crossed(self.reflected[i][1 - i], self.transmitted[i][1 - i]),
        }
    }

    fn difference(&self, other: &VectorOrder) -> f64 {
        let amplitudes = |o: &VectorOrder| [o.reflected, o.transmitted];
        let own = amplitudes(self).into_iter().flatten().flatten();
        let pairs = own.zip(amplitudes(other).into_iter().flatten().flatten());
        pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    }
}

/// All orders of both polarisations; totals are indexed by the incident polarisation (s, p).
#[derive(Clone, Debug, PartialEq)]
pub struct VectorFarField {
    /// The light.
    pub incidence: Incidence,
    /// Lateral periods, µm.
    pub period_um: [f64; 2],
    /// Orders sorted by (m, n).
    pub orders: Vec<VectorOrder>,
    /// R by incident polarisation.
    pub reflectance: [f64; 2],
    /// T by incident polarisation.
    pub transmittance: [f64; 2],
    /// A by incident polarisation: the volume integral of the loss, not what R and T leave.
    pub absorptance: [f64; 2],
}

impl VectorFarField {
    /// R + T + A − 1 by incident polarisation: zero to the solver's residual at any resolution.
    pub fn energy_error(&self) -> [f64; 2] {
        [0, 1].map(|i| self.reflectance[i] + self.transmittance[i] + self.absorptance[i] - 1.0)
    }

    /// Largest difference of any amplitude that leaves the layer or belongs to a neighbour of the specular order, in all
    /// four pairs of polarisations.
    pub fn largest_difference(&self, other: &VectorFarField) -> f64 {
        let counts = |o: &&VectorOrder| {
            o.reflected_propagates || o.transmitted_propagates || (o.m.abs() <= 1 && o.n.abs() <= 1)
        };
        let same = |m, n| other.orders.iter().find(|o| o.m == m && o.n == n);
        let pairs = self.orders.iter().filter(counts).filter_map(|o| Some((o, same(o.m, o.n)?)));
        pairs.map(|(a, b)| a.difference(b)).fold(0.0, f64::max)
    }

    /// The far field of one incident polarisation as the appearance stages read it: efficiencies of both outgoing
    /// polarisations together; the first complex amplitude is the one whose polarisation is unchanged.
    pub fn polarised(&self, polarisation: Polarisation) -> FarField {
        let i = polarisation as usize;
        FarField {
            incidence: self.incidence,
            period_um: self.period_um,
            orders: self.orders.iter().map(|o| o.polarised(i)).collect(),
            reflectance: self.reflectance[i],
            transmittance: self.transmittance[i],
            absorptance: self.absorptance[i],
        }
    }
}

/// The amplitudes of the other polarisation in their place of [`Order::further`].
fn crossed(reflected: Complex64, transmitted: Complex64) -> [[Complex64; 2]; FURTHER] {
    [[reflected, transmitted], Default::default(), Default::default()]
}

impl VectorProblem {
    /// Reads the orders off both faces from the solutions for s and p light.
    pub fn far_field(&self, [s, p]: [&Field; 2]) -> VectorFarField {
        let ((s, absorbed_s), (p, absorbed_p)) =
            (self.leaving(s, Polarisation::S), self.leaving(p, Polarisation::P));
        let faces = [s, p];
        let orders: Vec<VectorOrder> = self.listed().map(|(i, label)| self.order(&faces, i, label)).collect();
        let total = |of: &dyn Fn(&VectorOrder) -> [f64; 2]| {
            [0, 1].map(|i| orders.iter().map(|o| of(o)[i]).sum::<f64>())
        };
        VectorFarField {
            incidence: self.incidence,
            period_um: self.moments.grid.period_um,
            reflectance: total(&|o| o.reflected_efficiency),
            transmittance: total(&|o| o.transmitted_efficiency),
            absorptance: [absorbed_s, absorbed_p],
            orders,
        }
    }

    /// One order of one incident polarisation: its own amplitudes, and beside them those of the crossed polarisation.
    fn polarised_order(
        &self,
        faces: &Faces,
        polarisation: Polarisation,
        i: usize,
        [m, n]: [i32; 2],
    ) -> Order {
        let own = polarisation as usize;
        let [reflected, transmitted] = self.amplitudes(faces, polarisation, i);
        let [back, onward] = self.sides();
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
            further: crossed(reflected[1 - own], transmitted[1 - own]),
        }
    }

    /// The far field of one incident polarisation from its solution alone, see [`VectorFarField::polarised`].
    pub fn polarised_far_field(&self, field: &Field, polarisation: Polarisation) -> FarField {
        let (faces, absorptance) = self.leaving(field, polarisation);
        let order = |(i, label)| self.polarised_order(&faces, polarisation, i, label);
        let orders: Vec<Order> = self.listed().map(order).collect();
        let reflectance: f64 = orders.iter().map(|o| o.reflected_efficiency).sum();
        let transmittance: f64 = orders.iter().map(|o| o.transmitted_efficiency).sum();
        FarField {
            incidence: self.incidence,
            period_um: self.moments.grid.period_um,
            reflectance,
            transmittance,
            absorptance,
            orders,
        }
    }

    /// Vacuum wavenumber, 1/µm.
    fn k0(&self) -> f64 {
        TAU / self.incidence.wavelength_um
    }

    /// Sides that light is reflected and transmitted to.
    fn sides(&self) -> [usize; 2] {
        [self.entry_side(), 1 - self.entry_side()]
    }

    /// Compact indices of the harmonics that are listed with their orders, sorted by these.
    fn listed(&self) -> impl Iterator<Item = (usize, [i32; 2])> {
        let harmonics = &self.harmonics.orders;
        let specular = harmonics[self.incident_harmonic()];
        let mut listed = listed_orders(harmonics, &self.lateral, &self.media, self.k0(), specular);
        listed.sort_by_key(|&(_, label)| label);
        listed.into_iter()
    }

    /// Amplitudes of one harmonic in reflection and transmission.
    fn amplitudes(&self, faces: &Faces, polarisation: Polarisation, i: usize) -> [Amplitudes; 2] {
        let mut leaving =
            self.sides().map(|side| [faces.electric[side][i], faces.magnetic[side][i] / self.k[side]]);
        if i == self.incident_harmonic() {
            leaving[0][polarisation as usize] -= 1.0;
        }
        leaving
    }

    fn order(&self, faces: &[Faces; 2], i: usize, [m, n]: [i32; 2]) -> VectorOrder {
        let [back, onward] = self.sides();
        let [s, p] = [0, 1].map(|k| self.amplitudes(&faces[k], Polarisation::BOTH[k], i));
        let (reflected, transmitted) = ([s[0], p[0]], [s[1], p[1]]);
        VectorOrder {
            m,
            n,
            direction: self.lateral[i].map(|k| k / self.k0()),
            reflected_propagates: self.kappa[back][i].re > 0.0,
            transmitted_propagates: self.kappa[onward][i].re > 0.0,
            reflected_efficiency: reflected.map(|a| self.efficiency(back, i, a)),
            transmitted_efficiency: transmitted.map(|a| self.efficiency(onward, i, a)),
            reflected,
            transmitted,
        }
    }

    /// Flux over the incident one: Re κ for s, Re(κ k*/k) for p (in an absorber E and h are out of phase).
    fn efficiency(&self, side: usize, harmonic: usize, [s, p]: Amplitudes) -> f64 {
        let (kappa, k) = (self.kappa[side][harmonic], self.k[side]);
        let parallel = (kappa * k.conj() / k).re;
        (kappa.re * s.norm_sqr() + parallel * p.norm_sqr()) / self.incident_kappa()
    }
}
