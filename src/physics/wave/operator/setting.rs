//! Common setup of the discrete problems of one wavelength and direction: the scalar wave's and
//! Maxwell's.

use super::mean_medium::{Mean, check_phase, mean_wavenumbers};
use crate::numerics::fourier::Harmonics;
use crate::wave::bloch::BlochVector;
use crate::wave::{Incidence, Layout, Media, WaveError};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Wavenumbers of one wavelength and direction on a grid.
pub(in crate::wave) struct Setting {
    /// Vacuum wavenumber 2π/λ, 1/µm.
    pub k0: f64,
    /// Lateral wavevectors of every harmonic, 1/µm.
    pub lateral: Vec<[f64; 2]>,
    /// Compact index of the incident harmonic.
    pub incident: usize,
    /// Mean k̄² of every cell, 1/µm².
    pub mean_k2: Vec<Complex64>,
}

impl Setting {
    /// Errors: light incident through an absorber, a grid too coarse for the propagating orders or
    /// for the wavelength.
    pub fn new(
        layout: &Layout,
        harmonics: &Harmonics,
        media: &Media,
        incidence: &Incidence,
        mean: Mean,
    ) -> Result<Setting, WaveError> {
        let k0 = TAU / incidence.wavelength_um;
        let bloch = BlochVector::new(layout, media, incidence)?;
        bloch.check_orders(layout, media, k0)?;
        let lateral: Vec<[f64; 2]> = harmonics.orders.iter().map(|&o| bloch.lateral(o)).collect();
        let mean_k2 = mean_wavenumbers(layout, media, k0, mean);
        let [m, n] = bloch.incident;
        let incident = harmonics.find(m, n).expect("the incident order propagates, so it is in use");
        let [x, y] = lateral[incident];
        check_phase(layout, &mean_k2, x * x + y * y)?;
        Ok(Setting { k0, lateral, incident, mean_k2 })
    }
}
