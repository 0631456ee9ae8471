//! The discrete vector problem e + A⁻¹V e = e₀: mean solve, contrast product, incident waves of both polarisations.

use super::contrast::{Averaging, tensors};
use super::mean::{CELL_ROWS, Faces, MeanEntry, VectorMean};
use super::moments::NormalMoments;
use super::scattering::VectorScattering;
use crate::numerics::fourier::{Harmonics, PlaneFft};
use crate::wave::operator::cell::decaying_root;
use crate::wave::operator::scattering::Scatter;
use crate::wave::operator::setting::Setting;
use crate::wave::system::System;
use crate::wave::{FarField, Field, Grid, Incidence, Mean, Media, Polarisation, Resolution, Side, WaveError};
use ndarray::ArrayView2;
use num_complex::Complex64;
use std::sync::{Arc, OnceLock};

/// Maxwell's equations on a scene for one wavelength and direction, both polarisations: immutable, shared by threads.
pub struct VectorProblem {
    /// Geometry, shared by all wavelengths and directions.
    pub moments: Arc<NormalMoments>,
    /// Wavelength and direction of the light.
    pub incidence: Incidence,
    /// Indices of all media.
    pub media: Media,
    /// Harmonics in use.
    pub harmonics: Arc<Harmonics>,
    /// Normal wavenumbers of every harmonic in the half-spaces (incident side, exit side), 1/µm.
    pub kappa: [Vec<Complex64>; 2],
    /// Wavenumbers of the half-spaces, 1/µm.
    pub k: [Complex64; 2],
    /// Lateral wavevectors of every harmonic, 1/µm.
    pub lateral: Vec<[f64; 2]>,
    /// A⁻¹V.
    double: VectorScattering<f64>,
    single: OnceLock<VectorScattering<f32>>,
    incident: usize,
}

/// The problem for one polarisation of the incident wave: what the strategies solve.
#[derive(Clone)]
pub struct Polarised {
    /// The problem that both polarisations share.
    pub problem: Arc<VectorProblem>,
    /// Polarisation of the incident wave, of amplitude 1.
    pub polarisation: Polarisation,
}

impl VectorProblem {
    /// Sets up one wavelength and direction on a geometry.
    ///
    /// Errors: as the scalar problem, and metals (Re ε < 0) beside grains.
    pub fn new(
        moments: &Arc<NormalMoments>,
        media: &Media,
        incidence: &Incidence,
        mean: Mean,
        averaging: Averaging,
    ) -> Result<Arc<VectorProblem>, WaveError> {
        incidence.check()?;
        check_metals(moments, media)?;
        let (grid, layout) = (&moments.grid, moments.layout());
        let harmonics = Arc::new(Harmonics::new(grid.resolution.nx, grid.resolution.ny));
        let Setting { k0, lateral, incident, mean_k2 } =
            Setting::new(&layout, &harmonics, media, incidence, mean)?;
        let q: Vec<f64> = lateral.iter().map(|[x, y]| x.hypot(*y)).collect();
        let azimuth = incidence.azimuth_deg.to_radians();
        let directions = lateral.iter().map(|&l| direction(l, k0, azimuth)).collect();
        let k = [media.incident, media.exit].map(|eta| k0 * eta);
        let kappa = k.map(|k| q.iter().map(|q| decaying_root(k * k - q * q)).collect::<Vec<_>>());
        let contrast = tensors(moments, media, k0, &mean_k2, averaging)?;
        let mean = VectorMean::new(grid, mean_k2, q, [&kappa[0], &kappa[1]], k);
        let fft = PlaneFft::new(grid.resolution.nx, grid.resolution.ny);
        let double = VectorScattering::new(mean, harmonics.clone(), directions, fft, &contrast);
        let (moments, incidence, media) = (moments.clone(), *incidence, media.clone());
        let single = OnceLock::new();
        let problem = VectorProblem {
            moments,
            incidence,
            media,
            harmonics,
            kappa,
            k,
            lateral,
            double,
            single,
            incident,
        };
        Ok(Arc::new(problem))
    }

    /// The problem for light of one polarisation.
    pub fn polarised(self: &Arc<Self>, polarisation: Polarisation) -> Polarised {
        Polarised { problem: self.clone(), polarisation }
    }

    /// Compact index of the harmonic that the incident wave is, and with it the specular order.
    pub fn incident_harmonic(&self) -> usize {
        self.incident
    }

    /// κ of the incident wave.
    pub fn incident_kappa(&self) -> f64 {
        self.kappa[self.entry_side()][self.incident].re
    }

    /// 0 when the light enters at z = 0, 1 when at z = H.
    pub(super) fn entry_side(&self) -> usize {
        usize::from(self.incidence.from == Side::Exit)
    }

    /// p̂ of every harmonic, the incident azimuth's where the wavevector has no lateral part.
    pub fn directions(&self) -> &[[f64; 2]] {
        self.double.directions()
    }

    /// Right-hand sides of the entry face's nodes: TE 2iκ, TM 2iκ/k (a_p = 1 is h = k, over k²).
    fn entry(&self, polarisation: Polarisation) -> MeanEntry {
        let side = self.entry_side();
        let node = if side == 0 { 0 } else { self.moments.grid.cells() };
        let strength = 2.0 * Complex64::I * self.kappa[side][self.incident];
        let zero = Complex64::default();
        let source = match polarisation {
            Polarisation::S => [strength, zero],
            Polarisation::P => [zero, strength / self.k[side]],
        };
        MeanEntry { node, harmonic: self.incident, source }
    }

    /// E_s and h of every harmonic on both faces, from a solution's moments, and the absorbed share of the incident flux.
    ///
    /// A is the volume integral of the loss, (1/κ) ∫ Im E†(k̄² + V)E: V's part from the moments e that were found, the mean's
    /// from the field in the cells that V e makes. R + T + A is 1 as far as e solves the problem.
    pub(super) fn leaving(&self, e: &Field, polarisation: Polarisation) -> (Faces, f64) {
        let mut loads = Field::zeros(e.dim());
        let mut loss = 0.0;
        if self.double.has_contrast() {
            self.double.contrast_product(e.view(), &mut loads);
            loss = self.contrast_loss(e, &loads);
            // The scattered wave is −A⁻¹ V e.
            loads.par_mapv_inplace(|z| -z);
        }
        let nodes = self.double.mean.nodes(&loads, self.entry(polarisation));
        loss += self.double.mean.loss(&loads, &nodes);
        (Faces::of(&nodes), loss / self.incident_kappa())
    }

    /// Σ h w_q Im⟨E†VE⟩ from e and V e: the loss where the index differs from the mean.
    fn contrast_loss(&self, e: &Field, product: &Field) -> f64 {
        let weight = |row: usize| 0.5 * self.moments.grid.height_um(row / CELL_ROWS);
        let rows = e.outer_iter().zip(product.outer_iter()).enumerate();
        rows.map(|(r, (e, v))| weight(r) * e.iter().zip(v).map(|(e, v)| (e.conj() * v).im).sum::<f64>()).sum()
    }
}

impl System for Polarised {
    fn grid(&self) -> &Grid {
        &self.problem.moments.grid
    }

    fn polarisation(&self) -> Option<Polarisation> {
        Some(self.polarisation)
    }

    fn shape(&self) -> (usize, usize) {
        (CELL_ROWS * self.grid().cells(), self.problem.harmonics.len())
    }

    fn has_contrast(&self) -> bool {
        self.problem.double.has_contrast()
    }

    fn background_wave(&self) -> Field {
        self.problem.double.mean.background(self.problem.entry(self.polarisation))
    }

    fn scatter(&self, u: ArrayView2<Complex64>, out: &mut Field) {
        self.problem.double.scatter(u, out);
    }

    fn single(&self) -> Option<&dyn Scatter<f32>> {
        let Resolution { nx, ny, .. } = self.grid().resolution;
        let narrowed = || self.problem.double.narrowed(PlaneFft::new(nx, ny));
        Some(self.problem.single.get_or_init(narrowed))
    }

    fn mean_k2(&self) -> &[Complex64] {
        self.problem.double.mean.mean_k2()
    }

    fn far_field(&self, u: &Field) -> FarField {
        self.problem.far_field(u, self.polarisation)
    }

    fn bytes(&self) -> usize {
        let VectorProblem { moments, double, single, .. } = &*self.problem;
        moments.bytes() + double.bytes() + single.get().map_or(0, VectorScattering::bytes)
    }
}

/// p̂, or the azimuth of incidence where there is no lateral part to speak of.
fn direction([x, y]: [f64; 2], k0: f64, azimuth: f64) -> [f64; 2] {
    let q = x.hypot(y);
    if q < 1e-12 * k0 { [azimuth.cos(), azimuth.sin()] } else { [x / q, y / q] }
}

/// Metals may be films, whose mean is exact; beside grains their tensor may have no inverse.
fn check_metals(moments: &NormalMoments, media: &Media) -> Result<(), WaveError> {
    let metal = |eta: Complex64| (eta * eta).re < 0.0;
    let found = moments
        .channels
        .iter()
        .any(|c| metal(media.index_of(c.material)) || metal(media.backgrounds[c.background]));
    if !found {
        return Ok(());
    }
    Err(WaveError::NotInVectorMode {
        what: "a metal (Re η² < 0) as grain or around grains",
        reason: "the normal-field tensor may be singular there and has not been tested",
        remedy: "use Re η > Im η; metals are solved as homogeneous films alone, and the scalar wave is no way out: it does not \
                 describe metals",
    })
}

#[cfg(test)]
#[path = "problem_tests.rs"]
mod tests;
