//! The discrete problem (A + V) u = b, shared by all strategies: mean solve, contrast product,
//! residual.
//!
//! Unknowns are harmonics of the nodes and of the bubbles in each cell; see [`super::mean`].

mod absorption;
mod points;
mod related;

pub use super::setting::Mean;
pub use related::{DIRECTIONS, Medium};

use super::mean::MeanOperator;
use super::scattering::Scattering;
use super::setting::plane_offsets;
use super::sharing::Idle;
use crate::numerics::fourier::PlaneFft;
use crate::wave::{
    Coverage, Field, Incidence, Material, Media, Scatter, Scene, Setting, WaveError, decaying_root,
};
use num_complex::Complex64;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

/// One wave problem (A + V) u = b: immutable and shared between threads. A is the operator of the
/// mean medium ⟨k²⟩ with the boundary conditions of P2 (3.4), V = k² − ⟨k²⟩ the contrast, u the
/// field on the planes as harmonics.
///
/// Shapes: a field has `shape()` = (planes, harmonics) complex numbers; planes = degree · cells +
/// 1.
///
/// ```
/// use inkwave_physics::ink::Sphere;
/// use inkwave_physics::wave::{Body, BodyShape, Field, Incidence, Mean, Media, Problem};
/// use inkwave_physics::wave::{Resolution, Scene, Scheme, Side};
///
/// let ball = Sphere { center_um: [0.1, 0.2, 0.15], radius_um: 0.1 };
/// let scene = Scene::layer([0.5, 0.5], 0.3, vec![Body::new(BodyShape::Balls(vec![ball]), 0)]);
/// let backgrounds = vec![1.558.into()];
/// let inclusions = vec![1.4.into()];
/// let media = Media { incident: 1.0.into(), exit: 1.0.into(), backgrounds, inclusions };
/// let light =
///     Incidence { wavelength_um: 0.6, polar_deg: 20.0, azimuth_deg: 0.0, from: Side::Incident };
/// let grid = Resolution { nx: 9, ny: 9, cells: 4, scheme: Scheme::Cubic };
/// let problem = Problem::from_scene(&scene, &media, &light, grid, Mean::default())?;
/// assert_eq!(problem.shape(), (3 * 4 + 1, 9 * 9));
///
/// // One operator application, A⁻¹V u₀: what the ball scatters out of the wave in the mean medium.
/// let background = problem.background_wave();
/// let mut scattered = Field::zeros(problem.shape());
/// problem.scatter(&background, &mut scattered);
/// let size = |f: &Field| f.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
/// assert!(size(&scattered) < 0.5 * size(&background));
/// # Ok::<(), inkwave_physics::wave::WaveError>(())
/// ```
pub struct Problem {
    /// The geometry, shared with all problems on the same grid.
    pub coverage: Arc<Coverage>,
    /// The light, the media and the harmonics.
    pub setting: Setting,
    /// The mean operator A, factorised.
    pub mean: MeanOperator,
    fft: PlaneFft,
    /// Contrast k0²(η² − η_background²) of each channel, divided by the number of points of a plane
    /// (inverse transforms are unnormalised).
    contrasts: Vec<Complex64>,
    /// Uniform part of each plane's moment, divided in the same way.
    offsets: Vec<Complex64>,
    double: OnceLock<Scattering<f64>>,
    /// The operator A⁻¹V in single precision, built on first use.
    pub(in crate::wave) single: OnceLock<Scattering<f32>>,
    /// Choice of the mean medium.
    choice: Mean,
}

impl Deref for Problem {
    type Target = Setting;

    fn deref(&self) -> &Setting {
        &self.setting
    }
}

impl Problem {
    /// Sets up one wavelength and angle on a geometry.
    ///
    /// Errors: invalid media or angle, a grid too coarse for the propagating orders or for the
    /// wavelength.
    pub fn new(
        coverage: &Arc<Coverage>,
        media: &Media,
        incidence: &Incidence,
        mean: Mean,
    ) -> Result<Problem, WaveError> {
        check_crystals(coverage)?;
        let (setting, mean_k2) =
            Setting::new(coverage, &coverage.harmonics, media, incidence, mean, |k0, eta, [x, y]| {
                decaying_root(k0 * k0 * eta * eta - (x * x + y * y))
            })?;
        let lateral_k2 = setting.lateral.iter().map(|[x, y]| x * x + y * y).collect();
        let kappa = setting.kappa.each_ref().map(Vec::as_slice);
        let contrasts = points::strengths(coverage, media, setting.k0);
        let offsets = plane_offsets(&coverage.grid, media, setting.k0, &mean_k2);
        let choice = mean;
        let mean = MeanOperator::new(&coverage.grid, mean_k2, lateral_k2, kappa);
        let coverage = coverage.clone();
        let fft = coverage.fft.clone();
        let (double, single) = (OnceLock::new(), OnceLock::new());
        Ok(Problem { coverage, setting, mean, fft, contrasts, offsets, double, single, choice })
    }

    /// Coverage and problem in one step, for a scene that is solved once.
    pub fn from_scene(
        scene: &Scene,
        media: &Media,
        incidence: &Incidence,
        resolution: crate::wave::Resolution,
        mean: Mean,
    ) -> Result<Problem, WaveError> {
        scene.check(media)?;
        Problem::new(&Arc::new(Coverage::new(scene, resolution)?), media, incidence, mean)
    }

    /// Rows and columns of a field.
    pub fn shape(&self) -> (usize, usize) {
        (self.coverage.grid.planes(), self.harmonics.len())
    }

    /// Number of complex unknowns.
    pub fn unknowns(&self) -> usize {
        self.shape().0 * self.shape().1
    }

    /// Memory held by the problem itself, bytes: factors of the mean operator and coverage, without
    /// solver vectors.
    pub fn bytes(&self) -> usize {
        let tables = [self.double.get().map(|d| d.bytes()), self.single.get().map(|d| d.bytes())];
        self.mean.bytes() + self.coverage.bytes() + tables.into_iter().flatten().sum::<usize>()
    }

    /// Whether there is contrast; layered media with an exact mean have none, and nothing is left
    /// to iterate on.
    pub fn has_contrast(&self) -> bool {
        let strength = |c: &Complex64| c.norm() > 0.0;
        self.contrasts.iter().any(strength) || self.offsets.iter().any(strength)
    }

    /// Source b: 2iκ₀₀ in the row of the illuminated face, in the incident harmonic (P2 (3.4)).
    pub fn source(&self) -> Field {
        let mut b = Field::zeros(self.shape());
        b[[self.entry_row(), self.incident_harmonic]] = 2.0 * Complex64::I * self.incident_kappa();
        b
    }

    fn entry_row(&self) -> usize {
        self.entry_side() * (self.shape().0 - 1)
    }

    /// Background wave u₀ = A⁻¹ b in the mean medium.
    pub fn background_wave(&self) -> Field {
        let mut b = self.source();
        self.mean.inverse.solve_column(&mut b, self.incident_harmonic);
        b
    }

    /// Applies out ← A⁻¹ V u: one operator application.
    pub fn scatter(&self, u: &Field, out: &mut Field) {
        self.double().scatter(u.view(), out);
    }

    /// The operator A⁻¹V as tables, built on first use.
    pub fn double(&self) -> &Scattering<f64> {
        self.double.get_or_init(|| {
            let harmonics = self.harmonics.clone();
            let fft = self.fft.clone();
            let mean = self.mean.inverse.clone();
            Scattering { harmonics, fft, mean, weights: self.weights(), idle: Idle::default() }
        })
    }

    /// End conditions iκ of both half-spaces for one harmonic.
    pub fn end_conditions(&self, harmonic: usize) -> [Complex64; 2] {
        [0, 1].map(|side| Complex64::I * self.kappa[side][harmonic])
    }
}

/// Rejects crystals: the scalar wave has no polarisation that could tell their indices apart.
fn check_crystals(coverage: &Coverage) -> Result<(), WaveError> {
    if !coverage.channels.iter().any(|channel| matches!(channel.material, Material::Uniaxial(_))) {
        return Ok(());
    }
    let found = "the scalar wave with an extraordinary index, which it has no polarisation to feel";
    let allowed =
        "Maxwell's equations (--wave vector; in studies light.wave = \"unpolarised\", \"s\" or \"p\")";
    let remedy = "solve these, or give one index for both rays";
    Err(WaveError::Unsound(format!("wave: found {found}; allowed is {allowed}; {remedy}")))
}

#[cfg(test)]
#[path = "problem_tests.rs"]
mod tests;
