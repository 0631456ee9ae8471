//! Geometry of the contrast field: the coverage of every plane's neighbourhood by each material.
//!
//! Computed once per scene and grid and reused for every wavelength and angle: the medium enters
//! only through k² differences ("channels"). Coefficients in the plane are exact and band-limited
//! to the grid's harmonics; along z they are moments against the scheme's shape functions
//! (numerics: W_p = ∫ ψ_p V dz).

mod cell_sum;

use super::folding::{CellCoefficients, Folding, REACH};
use super::nufft::{SourceTransform, Spreading};
use super::section::{Demands, Sampling};
use crate::numerics::fourier::{Harmonics, PlaneFft, Real};
use crate::wave::{Body, Channel, Grid, Layout, Material, Resolution, Scene, WaveError};
use cell_sum::CellSum;
use ndarray::Array2;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Deref;
use std::sync::Arc;

/// Default relative error of the coefficients.
const EXACT: f64 = 1e-10;
/// Largest error accepted: beyond it, the work saved is negligible compared with a solve.
const LOOSEST: f64 = 1e-3;
/// Error from which single precision suffices.
const SINGLE: f64 = 1e-6;
/// Largest contrast of inks.
const INK_LIKE: f64 = 1.2;
/// Factor on the error for harmonics beyond the grid, which enter in second order only; at most 1
/// %.
const OUTER: f64 = 300.0;

/// Polled during the computation of a coverage, which takes long for many grains: true ends it with
/// [`WaveError::Stopped`].
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync + 'a);

/// Precision of a coverage's coefficients, and cancellation of their computation.
#[derive(Clone, Copy)]
pub struct Precision<'a> {
    /// Relative error of the coefficients (10⁻¹⁰ … 10⁻³; other values are clamped). Amplitudes
    /// change by less: by the relative error of the contrast times the fraction of light that is
    /// scattered.
    pub error: f64,
    /// Polled at intervals: true ends the computation with [`WaveError::Stopped`].
    pub stop: Stop<'a>,
}

impl Precision<'_> {
    /// Nearly exact coefficients, without cancellation.
    pub const EXACT: Precision<'static> = Precision::of(EXACT);

    /// Coefficients of the given relative error, without cancellation.
    pub const fn of(error: f64) -> Precision<'static> {
        Precision { error, stop: &|| false }
    }

    /// Error of the coefficients that is negligible beside an error `accuracy` of the amplitudes:
    /// in ink, amplitudes change by less than a hundredth of the coefficients' error. Strong
    /// contrast and its resonances amplify it: see [`Precision::error_among`].
    pub fn error_for(accuracy: f64) -> f64 {
        0.1 * accuracy
    }

    /// Error of the coefficients for bodies whose contrast |η_i² − η_b²| is at most `contrast`; see
    /// [`Precision::error_for`]. *Measured*: for bars of 2.5 in vacuum (5.25), amplitudes changed
    /// by ten times the error of the coefficients, so that differences between companions showed
    /// that error instead of the grids'.
    pub fn error_among(accuracy: f64, contrast: f64) -> f64 {
        Self::error_for(accuracy) / (contrast / INK_LIKE).powi(3).max(1.0)
    }

    /// The error clamped to its bounds.
    pub(in crate::wave) fn bounded_error(&self) -> f64 {
        self.error.clamp(EXACT, LOOSEST)
    }
}

/// Moments of every channel's indicator function on every plane.
pub struct Coverage {
    /// The grid, and the pairs of background and material in the scene.
    pub layout: Layout,
    /// Per channel, planes × points (x fastest) in µm: ∫ ψ_p χ dz, band-limited in the plane.
    pub moments: Vec<Array2<f64>>,
    /// Pairs of channels, and per pair the field that folds the harmonics beyond the grid (µm³):
    /// their effect on the kept harmonics, in second order.
    pub pairs: Vec<[usize; 2]>,
    /// One field per pair: planes × points.
    pub folded: Vec<Array2<f64>>,
    /// Harmonics in use on the grid, shared by all problems.
    pub harmonics: Arc<Harmonics>,
    /// Transforms of the grid's planes.
    pub fft: PlaneFft,
    /// Transforms of the grid's planes in single precision.
    pub fft_single: PlaneFft<f32>,
}

impl Deref for Coverage {
    type Target = Layout;

    fn deref(&self) -> &Layout {
        &self.layout
    }
}

struct Builder<'a, T: Real> {
    scene: &'a Scene,
    grid: &'a Grid,
    channels: &'a [Channel],
    harmonics: &'a Harmonics,
    /// Largest |m| and |n| of the harmonics.
    widest: [usize; 2],
    transform: SourceTransform<T>,
    sampling: Sampling,
    stop: Stop<'a>,
}

impl Coverage {
    /// Integrates every body over every cell, nearly exactly. Errors: see [`Grid::new`].
    pub fn new(scene: &Scene, resolution: Resolution) -> Result<Coverage, WaveError> {
        Coverage::with(scene, resolution, Precision::EXACT)
    }

    /// Integrates every body over every cell with the given precision.
    ///
    /// # Errors
    /// [`WaveError::Stopped`], and the errors of [`Grid::new`].
    pub fn with(scene: &Scene, resolution: Resolution, precision: Precision) -> Result<Coverage, WaveError> {
        if precision.bounded_error() < SINGLE {
            Coverage::of::<f64>(scene, resolution, precision)
        } else {
            Coverage::of::<f32>(scene, resolution, precision)
        }
    }

    fn of<T: Real>(scene: &Scene, resolution: Resolution, precision: Precision) -> Result<Self, WaveError> {
        let grid = Grid::new(scene, resolution)?;
        let channels = find_channels(scene, &grid);
        let folding = Folding::<T>::new(&grid);
        let builder = Builder::<T>::new(scene, &grid, &channels, &folding.harmonics, precision);
        let cells: Vec<_> = (0..grid.cells()).into_par_iter().map(|j| builder.cell(j)).collect();
        if (precision.stop)() {
            return Err(WaveError::Stopped);
        }
        let count = channels.len();
        let pairs: Vec<[usize; 2]> = (0..count).flat_map(|a| (a..count).map(move |b| [a, b])).collect();
        let [moments, folded] = folding.planes(&cells, &pairs);
        let heights: Vec<f64> = (0..grid.cells()).map(|j| grid.height_um(j)).collect();
        let mean = |j: usize, c: usize| Some(cells[j][c].as_ref()?.means.iter().sum::<f64>() / heights[j]);
        let layout = Layout::new(scene, grid, channels, mean);
        let (nx, ny) = (resolution.nx, resolution.ny);
        let fft = PlaneFft::new(nx, ny);
        let fft_single = PlaneFft::new(nx, ny);
        let harmonics = Arc::new(Harmonics::new(nx, ny));
        Ok(Coverage { layout, moments, pairs, folded, harmonics, fft, fft_single })
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.moments.iter().chain(&self.folded).map(|m| m.len() * size_of::<f64>()).sum()
    }
}

/// All (background, material) pairs that share a cell.
pub(in crate::wave) fn find_channels(scene: &Scene, grid: &Grid) -> Vec<Channel> {
    let mut channels = Vec::new();
    for body in &scene.bodies {
        for j in 0..grid.cells() {
            let channel = Channel { background: grid.background[j], material: body.material };
            if overlap(body, grid, j).is_some() && !channels.contains(&channel) {
                channels.push(channel);
            }
        }
    }
    channels
}

/// Sign of a body's indicator in that of a material: what lies within another body takes its volume
/// from that body's material.
fn sign(scene: &Scene, body: &Body, material: Material) -> Option<f64> {
    let displaced = body.within.is_some_and(|host| scene.bodies[host].material == material);
    match (body.material == material, displaced) {
        (true, false) => Some(1.0),
        (false, true) => Some(-1.0),
        _ => None,
    }
}

/// The height range of a cell that a body covers.
pub(in crate::wave) fn overlap(body: &Body, grid: &Grid, cell: usize) -> Option<[f64; 2]> {
    let [lo, hi] = body.extent_um();
    let range = [lo.max(grid.nodes_um[cell]), hi.min(grid.nodes_um[cell + 1])];
    (range[1] > range[0]).then_some(range)
}

impl<'a, T: Real> Builder<'a, T> {
    fn new(
        scene: &'a Scene,
        grid: &'a Grid,
        channels: &'a [Channel],
        harmonics: &'a Harmonics,
        precision: Precision<'a>,
    ) -> Builder<'a, T> {
        let error = precision.bounded_error();
        let largest =
            |i: usize| harmonics.orders.iter().map(|o| o[i].unsigned_abs() as usize).max().unwrap_or(0);
        let widest = [largest(0), largest(1)];
        let k = |i: usize, share: f64| TAU * share * widest[i] as f64 / grid.period_um[i];
        let corner = |share: f64| k(0, share).hypot(k(1, share));
        let loose = (OUTER * error).min(1e-2);
        let demands = Demands([(corner(1.0 / REACH as f64), error), (corner(1.0), loose)]);
        let transform = SourceTransform::new(widest[0], widest[1], Spreading::within(error));
        let sampling = Sampling { demands, degree: grid.element.degree };
        Builder { scene, grid, channels, harmonics, widest, transform, sampling, stop: precision.stop }
    }

    /// Moments of every channel within one cell; `None` for channels absent from it.
    fn cell(&self, cell: usize) -> Vec<Option<CellCoefficients<T>>> {
        let here = |c: &Channel| c.background == self.grid.background[cell];
        self.channels.iter().map(|c| if here(c) { self.channel_in_cell(c, cell) } else { None }).collect()
    }

    fn channel_in_cell(&self, channel: &Channel, cell: usize) -> Option<CellCoefficients<T>> {
        let signed = |b| Some((b, sign(self.scene, b, channel.material)?));
        let bodies = self.scene.bodies.iter().filter_map(signed);
        let present: Vec<_> = bodies.filter_map(|b| Some((b, overlap(b.0, self.grid, cell)?))).collect();
        if present.is_empty() {
            return None;
        }
        let mut sum = CellSum::new(self, cell);
        // Cells skipped by a stop are never used: the whole computation then fails.
        let going = present.iter().take_while(|_| !(self.stop)());
        going.for_each(|&((body, sign), range)| sum.add_body(body, sign, range));
        Some(sum.finish())
    }
}

#[cfg(test)]
#[path = "coverage_tests.rs"]
mod tests;
