//! Common setup of the discrete problems of one wavelength and direction: the scalar wave's and
//! Maxwell's.

use super::mean_medium::{Mean, check_phase, mean_wavenumbers};
use crate::numerics::fourier::Harmonics;
use crate::wave::bloch::BlochVector;
use crate::wave::{Incidence, Layout, Media, Side, WaveError};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::sync::Arc;

/// One wavelength and direction on a grid.
pub struct Setting {
    /// The incident light.
    pub incidence: Incidence,
    /// Indices of all media.
    pub media: Media,
    /// Vacuum wavenumber 2π/λ, 1/µm.
    pub k0: f64,
    /// The harmonics in use: columns of a field.
    pub harmonics: Arc<Harmonics>,
    /// Lateral wavevectors of every harmonic, 1/µm: centred on zero, see [`crate::wave::bloch`].
    pub lateral: Vec<[f64; 2]>,
    /// Normal wavenumbers of every harmonic in the half-spaces (incident side, exit side), 1/µm.
    pub kappa: [Vec<Complex64>; 2],
    /// Compact index of the incident harmonic.
    incident: usize,
}

impl Setting {
    /// The setting, and the mean k̄² of every cell, 1/µm²; `normal` is the normal wavenumber for
    /// k0, the index of a half-space and a lateral wavevector.
    ///
    /// # Errors
    /// Lights that [`Incidence::check`] rejects, or incident through an absorber; a grid too coarse
    /// for the propagating orders or for the wavelength.
    pub(in crate::wave) fn new(
        layout: &Layout,
        harmonics: &Arc<Harmonics>,
        (media, incidence): (&Media, &Incidence),
        mean: Mean,
        normal: impl Fn(f64, Complex64, [f64; 2]) -> Complex64,
    ) -> Result<(Setting, Vec<Complex64>), WaveError> {
        incidence.check()?;
        let k0 = TAU / incidence.wavelength_um;
        let bloch = BlochVector::new(layout, media, incidence)?;
        bloch.check_orders(layout, media, k0)?;
        let lateral: Vec<[f64; 2]> = harmonics.orders.iter().map(|&o| bloch.lateral(o)).collect();
        let mean_k2 = mean_wavenumbers(layout, media, k0, mean);
        let [m, n] = bloch.incident;
        let incident = harmonics.find(m, n).expect("the incident order propagates, so it is in use");
        let [x, y] = lateral[incident];
        check_phase(layout, &mean_k2, x * x + y * y)?;
        let kappa = [media.incident, media.exit]
            .map(|eta| lateral.iter().map(|&lateral| normal(k0, eta, lateral)).collect());
        let (harmonics, incidence, media) = (harmonics.clone(), *incidence, media.clone());
        Ok((Setting { incidence, media, k0, harmonics, lateral, kappa, incident }, mean_k2))
    }

    /// Compact index of the incident harmonic, which is the specular order.
    pub fn incident_harmonic(&self) -> usize {
        self.incident
    }

    /// Normal wavenumber κ₀₀ in the half-space of incidence, 1/µm.
    pub fn incident_kappa(&self) -> f64 {
        self.kappa[self.entry_side()][self.incident].re
    }

    /// Illuminated side: 0 at z = 0, 1 at z = H.
    pub fn entry_side(&self) -> usize {
        usize::from(self.incidence.from == Side::Exit)
    }
}
