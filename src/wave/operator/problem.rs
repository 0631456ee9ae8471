//! The discrete problem (A + V) u = b, shared by all strategies: mean solve, contrast product, residual.
//!
//! Unknowns are harmonics of nodes and, of the bubbles in each cell; see [`super::mean`].

use super::mean::{MeanOperator, decaying_root};
use super::scattering::{Scatter, Scattering, narrow};
use crate::numerics::fourier::{Harmonics, PlaneFft, PlaneScratch, Real};
use crate::wave::bloch::BlochVector;
use crate::wave::{Coverage, Grid, Incidence, Layout, Media, Scene, Side, WaveError};
use ndarray::{Array2, ArrayView2};
use num_complex::{Complex, Complex64};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

/// Unknowns: rows are planes (nodes, with bubbles between them), columns harmonics.
pub type Field = Array2<Complex64>;

/// Largest phase k̄h of a cell with contrast: beyond it the moments no longer resolve the wave.
const PHASE_LIMIT: f64 = 2.9;

/// How ⟨k²⟩ is chosen. It belongs to the discretisation: all strategies on one problem share it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Mean {
    /// Averages each cell over the plane instead of the whole layer (P2, below (3.12)).
    pub depends_on_z: bool,
    /// Keeps the imaginary part; relaxation needs it left in the contrast (real ⟨k²⟩).
    pub absorbing: bool,
}

impl Default for Mean {
    fn default() -> Mean {
        Mean { depends_on_z: true, absorbing: true }
    }
}

/// One wave problem (A + V) u = b: immutable and shared between threads. A is the operator of the mean medium ⟨k²⟩ with the
/// boundary conditions of P2 (3.4), V = k² − ⟨k²⟩ the contrast, u the field on the planes as harmonics.
///
/// Shapes: a field has `shape()` = (planes, harmonics) complex numbers; planes = degree · cells + 1.
///
/// ```
/// use inkwave::wave::{Ball, Body, Field, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Shape, Side};
///
/// let ball = Ball { center_um: [0.1, 0.2, 0.15], radius_um: 0.1 };
/// let scene = Scene::layer([0.5, 0.5], 0.3, vec![Body::new(Shape::Balls(vec![ball]), 0)]);
/// let media =
///     Media { incident: 1.0.into(), exit: 1.0.into(), backgrounds: vec![1.558.into()], inclusions: vec![1.4.into()] };
/// let light = Incidence { wavelength_um: 0.6, polar_deg: 20.0, azimuth_deg: 0.0, from: Side::Incident };
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
/// # Ok::<(), inkwave::wave::WaveError>(())
/// ```
pub struct Problem {
    /// The geometry, shared with all problems on the same grid.
    pub coverage: Arc<Coverage>,
    /// The light.
    pub incidence: Incidence,
    /// Indices of all media.
    pub media: Media,
    /// The harmonics in use: columns of a field.
    pub harmonics: Arc<Harmonics>,
    /// A, factorised.
    pub mean: MeanOperator,
    /// Normal wavenumbers of every harmonic in the half-spaces above and below, 1/µm.
    pub kappa: [Vec<Complex64>; 2],
    /// Lateral wavevectors of every harmonic, 1/µm: centred on zero, see [`crate::wave::bloch`].
    pub lateral: Vec<[f64; 2]>,
    fft: PlaneFft,
    /// k0²(η² − η_background²) of each channel over the points of a plane (inverse transforms are unnormalised).
    contrasts: Vec<Complex64>,
    /// Uniform part of each plane's moment, equally divided.
    offsets: Vec<Complex64>,
    double: OnceLock<Scattering<f64>>,
    single: OnceLock<Scattering<f32>>,
    /// Compact index of the incident harmonic.
    incident: usize,
}

impl Problem {
    /// Sets up one wavelength and angle on a geometry.
    ///
    /// Errors: media or angle out of range, grid too coarse for the propagating orders or for the wavelength.
    pub fn new(
        coverage: &Arc<Coverage>,
        media: &Media,
        incidence: &Incidence,
        mean: Mean,
    ) -> Result<Problem, WaveError> {
        incidence.check()?;
        let (grid, layout) = (&coverage.grid, coverage.layout());
        let harmonics = coverage.harmonics.clone();
        let k0 = TAU / incidence.wavelength_um;
        let bloch = BlochVector::new(&layout, media, incidence)?;
        bloch.check_orders(&layout, media, k0)?;
        let lateral: Vec<[f64; 2]> = harmonics.orders.iter().map(|&o| bloch.lateral(o)).collect();
        let lateral_k2: Vec<f64> = lateral.iter().map(|[x, y]| x * x + y * y).collect();
        let kappa_in =
            |eta: Complex64| lateral_k2.iter().map(|&q| decaying_root(k0 * k0 * eta * eta - q)).collect();
        let kappa: [Vec<Complex64>; 2] = [kappa_in(media.incident), kappa_in(media.exit)];
        let mean_k2 = mean_wavenumbers(&layout, media, k0, mean);
        let [m, n] = bloch.incident;
        let incident = harmonics.find(m, n).expect("the incident order propagates, so it is in use");
        check_phase(&layout, &mean_k2, lateral_k2[incident])?;
        let points = grid.points() as f64;
        let contrast = |c: &crate::wave::contrast::coverage::Channel| {
            let [inclusion, background] = [media.index_of(c.material), media.backgrounds[c.background]];
            (inclusion * inclusion - background * background) * (k0 * k0)
        };
        let single: Vec<Complex64> = coverage.channels.iter().map(contrast).collect();
        let folded =
            coverage.pairs.iter().map(|&[a, b]| single[a] * single[b] * if a == b { 1.0 } else { 2.0 });
        let contrasts = single.iter().copied().chain(folded).map(|c| c / points);
        Ok(Problem {
            contrasts: contrasts.collect(),
            offsets: plane_offsets(coverage, media, k0, &mean_k2),
            mean: MeanOperator::new(grid, mean_k2, lateral_k2, [&kappa[0], &kappa[1]]),
            fft: coverage.fft.clone(),
            double: OnceLock::new(),
            single: OnceLock::new(),
            coverage: coverage.clone(),
            incidence: *incidence,
            media: media.clone(),
            harmonics,
            kappa,
            lateral,
            incident,
        })
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

    /// Cells of another grid that [`Problem::new`] would accept: its own, or as many as the wave needs.
    ///
    /// Judged by this problem's mean, before a coverage is computed for that grid.
    pub fn cells_needed(&self, other: &Grid) -> usize {
        cells_needed(&self.coverage.grid, self.mean.mean_k2(), other)
    }

    /// Rows and columns of a field.
    pub fn shape(&self) -> (usize, usize) {
        (self.coverage.grid.planes(), self.harmonics.len())
    }

    /// Number of complex unknowns.
    pub fn unknowns(&self) -> usize {
        self.shape().0 * self.shape().1
    }

    /// Bytes held by the problem itself: factors of the mean operator and coverage, without solver vectors.
    pub fn bytes(&self) -> usize {
        let tables = [self.double.get().map(|d| d.bytes()), self.single.get().map(|d| d.bytes())];
        self.mean.bytes() + self.coverage.bytes() + tables.into_iter().flatten().sum::<usize>()
    }

    /// False for layered media whose mean is exact: nothing is left to iterate on.
    pub fn has_contrast(&self) -> bool {
        let strength = |c: &Complex64| c.norm() > 0.0;
        self.contrasts.iter().any(strength) || self.offsets.iter().any(strength)
    }

    /// b: 2iκ₀₀ in the row of the face that the light enters by, in the incident harmonic (P2 (3.4)).
    pub fn source(&self) -> Field {
        let mut b = Field::zeros(self.shape());
        b[[self.entry_row(), self.incident]] = 2.0 * Complex64::I * self.incident_kappa();
        b
    }

    /// Row of the face that the light enters by, and b at its points.
    pub fn source_at_points(&self) -> (usize, Vec<Complex64>) {
        let (row, mut scratch) = (self.entry_row(), self.fft.scratch());
        self.to_points(self.source().row(row).to_slice().expect("rows are contiguous"), &mut scratch);
        (row, scratch.plane)
    }

    fn entry_row(&self) -> usize {
        if self.incidence.from == Side::Incident { 0 } else { self.shape().0 - 1 }
    }

    /// u₀ = A⁻¹ b, the wave in the mean medium.
    pub fn background_wave(&self) -> Field {
        let mut b = self.source();
        self.mean.solve(&mut b);
        b
    }

    /// out ← A⁻¹ V u: one operator application.
    pub fn scatter(&self, u: &Field, out: &mut Field) {
        self.scatter_view(u.view(), out);
    }

    /// [`Problem::scatter`] of a borrowed field.
    pub fn scatter_view(&self, u: ArrayView2<Complex64>, out: &mut Field) {
        self.double().scatter(u, out);
    }

    /// out ← V u as loads y_p on planes (one inverse and one forward transform a plane).
    pub fn contrast_loads(&self, u: ArrayView2<Complex64>, out: &mut Field) {
        self.double().contrast_loads(u, out);
    }

    /// A⁻¹V as tables, made when first asked for.
    pub fn double(&self) -> &Scattering<f64> {
        let fft = || self.fft.clone();
        self.double.get_or_init(|| Scattering::new(&self.mean, &self.harmonics, fft(), self.weights()))
    }

    /// The same in single precision.
    pub fn single(&self) -> &Scattering<f32> {
        let fft = || self.coverage.fft_single.clone();
        self.single.get_or_init(|| Scattering::new(&self.mean, &self.harmonics, fft(), self.weights()))
    }

    /// W_p over the points of a plane, planes × points.
    fn weights<T: Real>(&self) -> Array2<Complex<T>> {
        let grid = &self.coverage.grid;
        let mut weights = Array2::zeros((grid.planes(), grid.points()));
        let mut sum = vec![Complex64::default(); grid.points()];
        for (plane, mut row) in weights.outer_iter_mut().enumerate() {
            self.contrast_weights(plane, &mut sum);
            row.iter_mut().zip(&sum).for_each(|(w, &z)| *w = narrow(z));
        }
        weights
    }

    /// W_p of one plane over its points.
    fn contrast_weights(&self, plane: usize, sum: &mut [Complex64]) {
        // W_p = ∫ ψ_p (k²_background − ⟨k²⟩) dz + Σ_c (k²_c − k²_background) ∫ ψ_p χ_c dz, and what folds back
        sum.fill(self.offsets[plane]);
        let fields = self.coverage.moments.iter().chain(&self.coverage.folded);
        for (moments, &contrast) in fields.zip(&self.contrasts) {
            sum.iter_mut().zip(moments.row(plane)).for_each(|(w, &m)| *w += contrast * m);
        }
    }

    /// iκ of both half-spaces for one harmonic.
    pub fn end_conditions(&self, harmonic: usize) -> [Complex64; 2] {
        [0, 1].map(|side| Complex64::I * self.kappa[side][harmonic])
    }

    /// Fourier coefficients of W_p at (m mod nx, n mod ny).
    pub fn contrast_spectrum(&self, plane: usize) -> Array2<Complex64> {
        let mut scratch = self.fft.scratch();
        scratch.plane.fill(Complex64::ONE);
        self.multiply_contrast(plane, &mut scratch.plane);
        let resolution = self.coverage.grid.resolution;
        self.fft.forward(&mut scratch, std::slice::from_ref(&(0..resolution.nx)));
        Array2::from_shape_vec((resolution.nx, resolution.ny), scratch.spectrum).expect("a full spectrum")
    }

    /// V/D at every point of a plane, so that the largest modulus is a physical k² contrast.
    pub fn contrast_per_mass(&self, plane: usize, mass: f64) -> Vec<Complex64> {
        let points = self.coverage.grid.points();
        let mut values = vec![Complex64::from(points as f64 / mass); points];
        self.multiply_contrast(plane, &mut values);
        values
    }

    /// Harmonics of every plane → values at its points, unnormalised.
    pub fn planes_to_points(&self, harmonics: &Field, points: &mut Array2<Complex64>) {
        let rows = points.outer_iter_mut().into_par_iter().zip(harmonics.outer_iter());
        rows.for_each_init(
            || self.fft.scratch(),
            |scratch, (mut out, row)| {
                self.to_points(row.to_slice().expect("rows are contiguous"), scratch);
                out.as_slice_mut().expect("rows are contiguous").copy_from_slice(&scratch.plane);
            },
        );
    }

    /// Values at points → harmonics of every plane (inverse of [`Problem::planes_to_points`] on the harmonics in use).
    pub fn points_to_planes(&self, points: &Array2<Complex64>, harmonics: &mut Field) {
        let scale = 1.0 / self.coverage.grid.points() as f64;
        let rows = harmonics.outer_iter_mut().into_par_iter().zip(points.outer_iter());
        rows.for_each_init(
            || self.fft.scratch(),
            |scratch, (mut out, row)| {
                scratch.plane.iter_mut().zip(row).for_each(|(p, v)| *p = v * scale);
                self.fft.forward(scratch, &self.harmonics.rows);
                let out = out.as_slice_mut().expect("rows are contiguous");
                self.harmonics.gather(&scratch.spectrum, out);
            },
        );
    }

    fn to_points(&self, harmonics: &[Complex64], scratch: &mut PlaneScratch) {
        self.harmonics.scatter(harmonics, &mut scratch.spectrum);
        self.fft.inverse(scratch, &self.harmonics.rows);
    }

    /// Multiplies by W_p over the points of a plane.
    fn multiply_contrast(&self, plane: usize, values: &mut [Complex64]) {
        let mut weights = vec![Complex64::default(); values.len()];
        self.contrast_weights(plane, &mut weights);
        values.iter_mut().zip(weights).for_each(|(v, w)| *v *= w);
    }

    /// Im⟨u, (A_interior + V) u⟩/κ₀₀, the absorbed share of the incident flux.
    pub fn absorptance(&self, u: &Field) -> f64 {
        let zeros = vec![Complex64::default(); self.harmonics.len()];
        let interior = self.mean.apply(u, [&zeros, &zeros]);
        let mean_part: f64 = u.iter().zip(&interior).map(|(u, a)| (u.conj() * a).im).sum();
        (mean_part + self.contrast_absorption(u)) / self.incident_kappa()
    }

    fn contrast_absorption(&self, u: &Field) -> f64 {
        let mut loads = Field::zeros(self.shape());
        self.contrast_loads(u.view(), &mut loads);
        self.mean.load(&mut loads);
        u.iter().zip(&loads).map(|(u, y)| (u.conj() * y).im).sum()
    }

    /// κ₀₀ of the half-space that the light comes from.
    pub fn incident_kappa(&self) -> f64 {
        let side = if self.incidence.from == Side::Incident { 0 } else { 1 };
        self.kappa[side][self.incident].re
    }

    /// Compact index of the harmonic that the incident wave is, and with it the specular order.
    pub fn incident_harmonic(&self) -> usize {
        self.incident
    }
}

/// k̄² of every cell: the background's k² plus the covered shares of the contrasts.
pub(in crate::wave) fn mean_wavenumbers(
    layout: &Layout,
    media: &Media,
    k0: f64,
    mean: Mean,
) -> Vec<Complex64> {
    let grid = layout.grid;
    let square = |eta: Complex64| eta * eta * (k0 * k0);
    let in_cell = |j: usize| {
        let background = square(media.backgrounds[grid.background[j]]);
        let parts = layout.channels.iter().zip(layout.fractions);
        let parts = parts.filter(|(c, _)| c.background == grid.background[j]);
        background
            + parts.map(|(c, f)| (square(media.index_of(c.material)) - background) * f[j]).sum::<Complex64>()
    };
    let mut values: Vec<Complex64> = (0..grid.cells()).map(in_cell).collect();
    if !mean.depends_on_z {
        let weighted = values.iter().enumerate().map(|(j, v)| v * grid.height_um(j)).sum::<Complex64>();
        values.fill(weighted / grid.nodes_um[grid.cells()]);
    }
    if !mean.absorbing {
        values.iter_mut().for_each(|v| v.im = 0.0);
    }
    values
}

/// Moments of (background − mean) k² on each plane, over the points of a plane.
fn plane_offsets(coverage: &Coverage, media: &Media, k0: f64, mean_k2: &[Complex64]) -> Vec<Complex64> {
    let grid = &coverage.grid;
    let mut offsets = vec![Complex64::default(); grid.planes()];
    for j in 0..grid.cells() {
        let eta = media.backgrounds[grid.background[j]] * k0;
        // A difference of rounding size is none: homogeneous layers then need no iteration at all.
        let raw = eta * eta - mean_k2[j];
        let shift = if raw.norm() < 1e-14 * mean_k2[j].norm() { Complex64::default() } else { raw };
        for (plane, weight) in grid.planes_of_cell(j).zip(&grid.element.weights) {
            offsets[plane] += shift * (grid.height_um(j) * weight / grid.points() as f64);
        }
    }
    offsets
}

/// Cells of a grid `other` that the phase limit allows, from k̄² of the cells of a grid that it has allowed.
pub(in crate::wave) fn cells_needed(own: &Grid, means: &[Complex64], other: &Grid) -> usize {
    let phase = |j: usize| {
        let [lo, hi] = [other.nodes_um[j], other.nodes_um[j + 1]];
        let common = |i: usize| (own.nodes_um[i + 1].min(hi) - own.nodes_um[i].max(lo)).max(0.0);
        let sum: Complex64 = (0..own.cells()).map(|i| means[i] * common(i)).sum();
        (sum / (hi - lo)).sqrt().re * (hi - lo)
    };
    let largest = (0..other.cells()).map(phase).fold(0.0, f64::max);
    let needed = (largest / PHASE_LIMIT * other.cells() as f64).ceil() as usize;
    if largest > PHASE_LIMIT { needed.max(other.cells() + 1) } else { other.cells() }
}

/// Refuses cells that are too high for the wave: with contrast by accuracy, without it only near kz h = mπ.
pub(in crate::wave) fn check_phase(
    layout: &Layout,
    mean_k2: &[Complex64],
    lateral_k2: f64,
) -> Result<(), WaveError> {
    let grid = layout.grid;
    let exact = layout.channels.is_empty();
    for (j, &k2) in mean_k2.iter().enumerate() {
        let h = grid.height_um(j);
        let phase = (if exact { k2 - lateral_k2 } else { k2 }).sqrt().re * h;
        let near_pole =
            exact && (k2 - lateral_k2).im.abs() * h < 1e-3 && phase > 1.0 && phase.sin().abs() < 1e-5;
        let needed = (phase / PHASE_LIMIT * grid.cells() as f64).ceil() as usize;
        if near_pole || (!exact && phase > PHASE_LIMIT) {
            let needed = needed.max(grid.cells() + 1);
            return Err(WaveError::CellTooHigh { cell: j, height_um: h, phase, limit: PHASE_LIMIT, needed });
        }
    }
    Ok(())
}

#[cfg(test)]
#[path = "problem_tests.rs"]
mod tests;
