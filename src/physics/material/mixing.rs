//! Mixtures of grains too small to scatter.

use num_complex::Complex64;

/// The homogeneous index a mixture tends to as its grains shrink: η² = Σ f η² + (1 − Σ f)
/// η_binder².
///
/// The scalar equation has no Maxwell Garnett term: the volume average of η² is exact in the limit
/// of vanishing grain size (the molecular mixture of P1 section 5). `shares` are (volume fraction,
/// index) pairs; the fractions sum to at most 1.
pub fn molecular_mixture(binder: Complex64, shares: &[(f64, Complex64)]) -> Complex64 {
    let squared: Complex64 = shares.iter().map(|&(f, eta)| f * (eta * eta - binder * binder)).sum();
    (binder * binder + squared).sqrt()
}

/// How pigments without grains mix with the binder: the limit of vanishing grains of a wave
/// equation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MixingRule {
    /// ε = ⟨ε⟩, the limit of the scalar wave, which feels no surface charge.
    #[default]
    VolumeAverage,
    /// (ε − ε_b)/(ε + 2ε_b) = Σ f_i (ε_i − ε_b)/(ε_i + 2ε_b), the limit of Maxwell's equations for
    /// separate balls (J. C. Maxwell Garnett, Phil. Trans. R. Soc. A 203 (1904) 385): exact to the
    /// first order of f.
    MaxwellGarnett,
}

impl MixingRule {
    /// Index of a mixture of a binder with volume fractions of other materials.
    pub fn mix(self, binder: Complex64, shares: &[(f64, Complex64)]) -> Complex64 {
        match self {
            Self::VolumeAverage => molecular_mixture(binder, shares),
            Self::MaxwellGarnett => {
                let host = binder * binder;
                let polarisability = |eta: Complex64| (eta * eta - host) / (eta * eta + 2.0 * host);
                let beta: Complex64 = shares.iter().map(|&(f, eta)| f * polarisability(eta)).sum();
                (host * (1.0 + 2.0 * beta) / (1.0 - beta)).sqrt()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_molecular_mixture_keeps_its_ends() {
        let (binder, pigment) = (Complex64::new(1.558, 0.0), Complex64::new(1.4, 0.3));
        assert!((molecular_mixture(binder, &[(0.0, pigment)]) - binder).norm() < 1e-15);
        assert!((molecular_mixture(binder, &[(0.4, pigment), (0.6, pigment)]) - pigment).norm() < 1e-15);
    }

    #[test]
    fn maxwell_garnett_keeps_its_ends_and_its_bounds() {
        let (binder, pigment) = (Complex64::from(1.5), Complex64::from(1.8));
        let mix = |f: f64| MixingRule::MaxwellGarnett.mix(binder, &[(f, pigment)]);
        assert!((mix(0.0) - binder).norm() < 1e-15 && (mix(1.0) - pigment).norm() < 1e-15);
        // Hashin and Shtrikman: for balls denser than the binder it is the lower bound, below ⟨ε⟩
        // and above 1/⟨1/ε⟩.
        let (host, grain) = (binder * binder, pigment * pigment);
        let low = 1.0 / (0.7 / host + 0.3 / grain);
        let high = 0.7 * host + 0.3 * grain;
        let mixed = mix(0.3) * mix(0.3);
        assert!(low.re < mixed.re && mixed.re < high.re, "{low} {mixed} {high}");
        // One ball in many: ε = ε_b (1 + 3 f (ε_i − ε_b)/(ε_i + 2 ε_b)) to the first order.
        let f = 1e-6;
        let first = 3.0 * (grain - host) / (grain + 2.0 * host);
        assert!(((mix(f) * mix(f) / host - 1.0) / f - first).norm() < 1e-5);
    }
}
