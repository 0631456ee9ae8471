//! The discrete vector problem e + A⁻¹V e = e₀: mean solve, contrast product, incident waves of
//! both polarisations, and the far field of each: complex amplitudes and efficiencies of both
//! outgoing ones.
//!
//! With p̂ = k_par/q and s = ẑ × p̂ (p̂ = (cos φ, sin φ) if q = 0) in a half-space of wavenumber k:
//! P(±) = (±κ p̂ − q ẑ)/k for light towards ±z, a_s = E·s, a_p = h/k for both directions of
//! propagation. Reflected amplitudes refer to the illuminated face, transmitted ones to the
//! opposite face, at x = y = 0.

pub(crate) mod coarse;

use super::contrast::{Averaging, tensors};
use super::mean::{CELL_ROWS, MeanEntry, Nodes, VectorMean};
use super::moments::NormalMoments;
use super::scattering::VectorScattering;
use crate::numerics::fourier::{Harmonics, PlaneFft};
use crate::wave::far_field::Leaving;
use crate::wave::{
    Channel, FarField, Field, Incidence, Mean, Media, Polarisation, Resolution, Setting, WaveError,
    decaying_root,
};
use coarse::{VectorCoarsePlan, VectorCoarseSpace};
use num_complex::Complex64;
use std::ops::Deref;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Maxwell's equations on a scene for one wavelength and direction, both polarisations: immutable,
/// shared by threads.
pub struct VectorProblem {
    /// Geometry, shared by all wavelengths and directions.
    pub moments: Arc<NormalMoments>,
    /// The light, the media and the harmonics.
    pub setting: Setting,
    /// Wavenumbers of the half-spaces, 1/µm.
    pub k: [Complex64; 2],
    /// The operator A⁻¹V.
    double: VectorScattering<f64>,
    single: OnceLock<VectorScattering<f32>>,
    /// What one polarisation eliminated and the other will need.
    coarse: Mutex<Option<Arc<VectorCoarseSpace>>>,
}

impl Deref for VectorProblem {
    type Target = Setting;

    fn deref(&self) -> &Setting {
        &self.setting
    }
}

/// The problem for one polarisation of the incident wave, as the strategies solve it.
#[derive(Clone)]
pub struct Polarised {
    /// The problem that both polarisations share.
    pub problem: Arc<VectorProblem>,
    /// Polarisation of the incident wave, of amplitude 1.
    pub polarisation: Polarisation,
}

/// Absorbed fractions of the incident flux.
pub(super) struct Losses {
    /// Of all cells.
    absorptance: f64,
    /// Of the cells of every background; empty with a single one.
    absorbed: Vec<f64>,
}

impl VectorProblem {
    /// Sets up one wavelength and direction on a geometry.
    ///
    /// Errors: those of the scalar problem, and metals (Re ε < 0) beside grains.
    pub fn new(
        moments: &Arc<NormalMoments>,
        media: &Media,
        incidence: &Incidence,
        mean: Mean,
        averaging: Averaging,
    ) -> Result<Arc<VectorProblem>, WaveError> {
        check_metals(moments, media)?;
        let Resolution { nx, ny, .. } = moments.grid.resolution;
        let harmonics = Arc::new(Harmonics::new(nx, ny));
        let (setting, mean_k2) =
            Setting::new(moments, &harmonics, media, incidence, mean, |k0, eta, [x, y]| {
                let k = k0 * eta;
                let q = x.hypot(y);
                decaying_root(k * k - q * q)
            })?;
        let q: Vec<f64> = setting.lateral.iter().map(|[x, y]| x.hypot(*y)).collect();
        let azimuth = incidence.azimuth_deg.to_radians();
        let directions = setting.lateral.iter().map(|&l| direction(l, setting.k0, azimuth)).collect();
        let k = [media.incident, media.exit].map(|eta| setting.k0 * eta);
        let contrast = tensors(moments, media, setting.k0, &mean_k2, averaging)?;
        let mean = VectorMean::new(&moments.grid, mean_k2, q, setting.kappa.each_ref().map(Vec::as_slice), k);
        let double = VectorScattering::new(mean, harmonics, directions, PlaneFft::new(nx, ny), &contrast);
        let (moments, single, coarse) = (moments.clone(), OnceLock::new(), Mutex::default());
        Ok(Arc::new(VectorProblem { moments, setting, k, double, single, coarse }))
    }

    /// Rows and columns of a field.
    pub(in crate::wave) fn shape(&self) -> (usize, usize) {
        (CELL_ROWS * self.moments.grid.cells(), self.harmonics.len())
    }

    /// Mean k̄² of each cell, 1/µm².
    pub(in crate::wave) fn mean_k2(&self) -> &[Complex64] {
        &self.double.mean.mean_k2
    }

    /// The wave in the mean medium.
    pub(in crate::wave) fn background(&self, polarisation: Polarisation) -> Field {
        self.double.mean.background(self.entry(polarisation))
    }

    /// Memory held without solver vectors, bytes.
    pub(in crate::wave) fn bytes(&self) -> usize {
        let single = self.single.get().map_or(0, VectorScattering::bytes);
        self.moments.bytes() + self.double.bytes() + single
    }

    /// The operator A⁻¹V.
    pub(in crate::wave) fn operator(&self) -> &VectorScattering<f64> {
        &self.double
    }

    /// The operator in single precision, built on first use.
    pub(crate) fn narrow_operator(&self) -> &VectorScattering<f32> {
        let Resolution { nx, ny, .. } = self.moments.grid.resolution;
        self.single.get_or_init(|| self.double.narrowed(PlaneFft::new(nx, ny)))
    }

    /// The lowest harmonics eliminated as planned. What is made for one polarisation is kept for
    /// the other, which takes it away.
    pub(crate) fn eliminated(&self, plan: VectorCoarsePlan) -> Arc<VectorCoarseSpace> {
        let kept = || self.coarse.lock().unwrap_or_else(PoisonError::into_inner);
        let left = kept().take();
        left.filter(|space| space.plan == plan).unwrap_or_else(|| {
            let space = Arc::new(plan.carried_out(self));
            *kept() = Some(space.clone());
            space
        })
    }

    /// The problem for light of one polarisation.
    pub fn polarised(self: &Arc<Self>, polarisation: Polarisation) -> Polarised {
        Polarised { problem: self.clone(), polarisation }
    }

    /// Right-hand sides at the node of the illuminated face: TE 2iκ, TM 2iκ/k (a_p = 1 is h = k,
    /// over k²).
    fn entry(&self, polarisation: Polarisation) -> MeanEntry {
        let side = self.entry_side();
        let harmonic = self.incident_harmonic;
        let node = side * self.moments.grid.cells();
        let strength = 2.0 * Complex64::I * self.kappa[side][harmonic];
        let source = match polarisation {
            Polarisation::S => [strength, Complex64::ZERO],
            Polarisation::P => [Complex64::ZERO, strength / self.k[side]],
        };
        MeanEntry { node, harmonic, source }
    }

    /// Fields E_s and h of every harmonic at the nodes, from a solution's moments, and the absorbed
    /// fraction of the incident flux in every cell.
    ///
    /// A is the volume integral of the loss, (1/κ) ∫ Im E†(k̄² + V)E: the part of V from the
    /// moments e of the solution, that of the mean from the field in the cells due to V e. R + T +
    /// A is 1 to the accuracy with which e solves the problem.
    pub(super) fn leaving(&self, e: &Field, polarisation: Polarisation) -> (Nodes, Losses) {
        let mut loads = Field::zeros(e.dim());
        let mut of_contrast = vec![0.0; self.moments.grid.cells()];
        let mut loss = 0.0;
        if self.double.has_contrast() {
            self.double.contrast_product(e.view(), &mut loads);
            loss = self.contrast_loss(e, &loads, &mut of_contrast);
            // The scattered wave is −A⁻¹ V e.
            loads.par_mapv_inplace(|z| -z);
        }
        let nodes = self.double.mean.nodes(&loads, self.entry(polarisation));
        let of_mean = self.double.mean.losses(&loads, &nodes);
        loss += of_mean.iter().sum::<f64>();
        let backgrounds = self.media.backgrounds.len();
        let mut absorbed = vec![0.0; if backgrounds > 1 { backgrounds } else { 0 }];
        for (cell, &background) in self.moments.grid.background.iter().enumerate() {
            let own = (of_contrast[cell] + of_mean[cell]) / self.incident_kappa();
            absorbed.get_mut(background).into_iter().for_each(|sum| *sum += own);
        }
        (nodes, Losses { absorptance: loss / self.incident_kappa(), absorbed })
    }

    /// Loss Σ h w_q Im⟨E†VE⟩ from e and V e: the part due to the deviation of the index from the
    /// mean; and the same of every cell.
    fn contrast_loss(&self, e: &Field, product: &Field, of_cells: &mut [f64]) -> f64 {
        let weight = |row: usize| 0.5 * self.moments.grid.height_um(row / CELL_ROWS);
        let rows = e.outer_iter().zip(product.outer_iter()).enumerate();
        let of_rows = rows.map(|(r, (e, v))| {
            let loss = weight(r) * e.iter().zip(v).map(|(e, v)| (e.conj() * v).im).sum::<f64>();
            of_cells[r / CELL_ROWS] += loss;
            loss
        });
        of_rows.sum()
    }

    /// Evaluates the orders at both faces of the solution for one incident polarisation. The first
    /// amplitude of an order has the incident polarisation, the crossed one follows; efficiencies
    /// contain both.
    pub fn far_field(&self, field: &Field, polarisation: Polarisation) -> FarField {
        let (nodes, Losses { absorptance, absorbed }) = self.leaving(field, polarisation);
        let far = self.far_field_of(self.moments.grid.period_um, absorptance, |side, i, incident| {
            self.emitted(&nodes, polarisation, side, i, incident)
        });
        FarField { absorbed, ..far }
    }

    /// What leaves through a side in harmonic i, less the incident wave.
    fn emitted(
        &self,
        nodes: &Nodes,
        polarisation: Polarisation,
        side: usize,
        i: usize,
        incident: f64,
    ) -> Leaving {
        let face = side * self.moments.grid.cells();
        let mut amplitudes = [nodes[0][[face, i]], nodes[1][[face, i]] / self.k[side]];
        amplitudes[polarisation as usize] -= incident;
        let [s, p] = amplitudes;
        let kappa = self.kappa[side][i];
        let k = self.k[side];
        // Flux relative to the incident one: Re κ for s, Re(κ k*/k) for p (in an absorber E and h
        // are out of phase).
        let parallel = (kappa * k.conj() / k).re;
        let efficiency = (kappa.re * s.norm_sqr() + parallel * p.norm_sqr()) / self.incident_kappa();
        ([amplitudes[polarisation as usize], amplitudes[1 - polarisation as usize]], efficiency)
    }
}

/// Unit vector p̂, or that of the azimuth of incidence if the lateral part is negligible.
fn direction([x, y]: [f64; 2], k0: f64, azimuth: f64) -> [f64; 2] {
    let q = x.hypot(y);
    if q < 1e-12 * k0 { [azimuth.cos(), azimuth.sin()] } else { [x / q, y / q] }
}

/// Metals may be films, whose mean is exact; beside grains the tensor may have no inverse.
fn check_metals(moments: &NormalMoments, media: &Media) -> Result<(), WaveError> {
    let indices = |c: &Channel| {
        let [ordinary, extraordinary] = media.rays_of(c.material);
        [ordinary, extraordinary, media.backgrounds[c.background]]
    };
    if !moments.channels.iter().flat_map(indices).any(|eta| (eta * eta).re < 0.0) {
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
