//! The homogeneous slab (Fresnel–Airy, s-polarised): the baseline that the angles of a layer are compared with.

use crate::wave::Side;
use num_complex::Complex64;
use serde::Serialize;

/// A homogeneous layer of index η = n + iκ between vacuum above and a real index below.
///
/// For an ink layer take √⟨η²⟩ ([`molecular_mixture`](crate::material::spectra::molecular_mixture)): what the layer adds
/// to the slab is smooth in the angle, while the slab carries the interference fringes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slab {
    pub index: Complex64,
    pub thickness_um: f64,
    pub wavelength_um: f64,
}

impl Slab {
    /// (R, T) for light from `side` at a polar angle inside the half-space it comes from; `index_below` is the index
    /// of the lower half-space (the upper one is vacuum). Grazing incidence gives its limit (1, 0).
    pub fn reflectance_transmittance(&self, side: Side, polar_deg: f64, index_below: f64) -> (f64, f64) {
        let (from, to) = match side {
            Side::Incident => (1.0, index_below),
            Side::Exit => (index_below, 1.0),
        };
        let (sin, cos) = polar_deg.to_radians().sin_cos();
        if cos < 1e-12 {
            return (1.0, 0.0);
        }
        let along = from * sin;
        let normal = |squared: Complex64| (squared - along * along).sqrt();
        let (a, c) = (Complex64::from(from * cos), normal(Complex64::from(to * to)));
        let mut b = normal(self.index * self.index);
        if b.norm() < 1e-9 {
            b = Complex64::from(1e-9); // the limit at the slab's own critical angle
        }
        let phase =
            (Complex64::i() * b * self.thickness_um * std::f64::consts::TAU / self.wavelength_um).exp();
        let (r1, r2) = ((a - b) / (a + b), (b - c) / (b + c));
        let denominator = 1.0 + r1 * r2 * phase * phase;
        let r = (r1 + r2 * phase * phase) / denominator;
        let t = 4.0 * a * b * phase / ((a + b) * (b + c) * denominator);
        (r.norm_sqr(), c.re / a.re * t.norm_sqr())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_clear_slab_conserves_energy_and_is_reciprocal(
            n in 1.05..2.0f64, h in 0.1..3.0f64, below in 1.0..1.7f64, deg in 0.0..89.0f64,
        ) {
            let slab = Slab { index: n.into(), thickness_um: h, wavelength_um: 0.5 };
            let (r, t) = slab.reflectance_transmittance(Side::Incident, deg, below);
            let inside = (deg.to_radians().sin() / below).asin().to_degrees();
            let (rb, tb) = slab.reflectance_transmittance(Side::Exit, inside, below);
            // identities; 1/cos θ ≤ 60 amplifies the rounding
            prop_assert!((r + t - 1.0).abs() < 1e-11 && (r - rb).abs() < 1e-11 && (t - tb).abs() < 1e-11);
        }
    }

    #[test]
    fn total_internal_reflection_and_grazing_have_their_limits() {
        let slab = Slab { index: 1.558.into(), thickness_um: 1.0, wavelength_um: 0.5 };
        let (r, t) = slab.reflectance_transmittance(Side::Exit, 60.0, 1.558);
        assert!((r - 1.0).abs() < 1e-14 && t.abs() < 1e-14);
        assert_eq!(slab.reflectance_transmittance(Side::Incident, 90.0, 1.0), (1.0, 0.0));
        let matched = Slab { index: 1.0.into(), ..slab };
        assert!(matched.reflectance_transmittance(Side::Incident, 30.0, 1.0).1 > 1.0 - 1e-14);
    }
}
