//! Studies of which part of the contrast scatters: the real or imaginary part of η² is replaced by
//! its mean.

use crate::material::mixing::molecular_mixture;
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The part of the contrast in η² that is kept. The other part is replaced by its mean over the
/// layer, so that the mean medium is the same in all three (P1 conclusion 4 asks which fluctuations
/// make large grains pale).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContrastPart {
    /// The materials are unchanged.
    #[default]
    Full,
    /// Only Re η² varies; Im η² is the same everywhere.
    Real,
    /// Only Im η² varies; Re η² is the same everywhere.
    Imaginary,
}

impl ContrastPart {
    /// True if nothing is replaced.
    pub fn is_full(&self) -> bool {
        *self == ContrastPart::Full
    }

    /// Indices of binder and pigments with the part that is kept; `shares` are the pigments' volume
    /// fractions.
    pub fn of(self, binder: Complex64, shares: &[f64], grains: &[Complex64]) -> (Complex64, Vec<Complex64>) {
        let all: Vec<_> = shares.iter().copied().zip(grains.iter().copied()).collect();
        let mean = molecular_mixture(binder, &all).powi(2);
        let keep = |eta: Complex64| match self {
            ContrastPart::Full => eta,
            ContrastPart::Real => Complex64::new((eta * eta).re, mean.im).sqrt(),
            ContrastPart::Imaginary => Complex64::new(mean.re, (eta * eta).im).sqrt(),
        };
        (keep(binder), grains.iter().copied().map(keep).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_stays_and_one_part_differs() {
        let (binder, pigment) = (Complex64::new(1.558, 0.0), Complex64::new(1.8, 0.2));
        let mean = molecular_mixture(binder, &[(0.3, pigment)]);
        for part in [ContrastPart::Full, ContrastPart::Real, ContrastPart::Imaginary] {
            let (b, p) = part.of(binder, &[0.3], &[pigment]);
            let difference = p[0] * p[0] - b * b;
            assert!((molecular_mixture(b, &[(0.3, p[0])]) - mean).norm() < 1e-14);
            assert_eq!(difference.im.abs() < 1e-14, part == ContrastPart::Real);
            assert_eq!(difference.re.abs() < 1e-14, part == ContrastPart::Imaginary);
        }
    }
}
