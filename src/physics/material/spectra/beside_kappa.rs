//! What is known beside a table of κ: n, or a dilution whose absorbance stands for κ.

use crate::material::kramers_kronig::KnownIndex;
use std::f64::consts::{LN_10, PI};

/// What is known of n beside a table of κ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BesideKappa {
    /// One n at all wavelengths.
    Constant(f64),
    /// n by the relation of Kramers and Kronig.
    KramersKronig {
        /// n at one wavelength, or far from all absorption.
        known: KnownIndex,
        /// Its standard error.
        n_error: f64,
    },
}

/// A dilution whose absorbance was measured: molecules, or grains far smaller than the wavelength,
/// that neither scatter nor change each other's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dilution {
    /// Path of the light, mm.
    pub path_mm: f64,
    /// Mass of the pigment in a volume of the dilution, g/l.
    pub concentration_g_per_l: f64,
    /// Density of the pigment, g/cm³.
    pub density_g_per_cm3: f64,
}

impl Dilution {
    /// κ of the pigment by a decadic absorbance A at a wavelength: A ln 10 = 4πκ φ d/λ, with φ the
    /// pigment's share of the volume.
    pub fn kappa(&self, absorbance: f64, wavelength_nm: f64) -> f64 {
        let fraction = 1e-3 * self.concentration_g_per_l / self.density_g_per_cm3;
        absorbance * LN_10 * 1e-6 * wavelength_nm / (4.0 * PI * fraction * self.path_mm)
    }
}
