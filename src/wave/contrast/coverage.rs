//! The contrast field's geometry: which share of each plane's neighbourhood each material covers.
//!
//! Computed once per scene and grid and reused for every wavelength and angle: the medium enters only through
//! k² differences ("channels"). Coefficients in the plane are exact and band-limited to the grid's harmonics;
//! along z they are moments against the scheme's shape functions (numerics: W_p = ∫ ψ_p V dz).

use super::cell::{CellCoefficients, CellColumns};
pub use super::channel::Channel;
use super::folding::{Folding, Planes, REACH};
use super::nufft::{Patch, SourceTransform, Spreading};
use super::section::{self, Demands, EdgePoint, GaussRules, Sampling};
use crate::numerics::fourier::{Harmonics, PlaneFft, PlaneScratch, Real};
use crate::wave::grid::element::MAX_DEGREE;
use crate::wave::{Ball, Body, Grid, Layout, Resolution, Scene, Shape, WaveError};
use ndarray::Array2;
use num_complex::{Complex, Complex64};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Relative error of coefficients where nothing else is asked for.
pub const EXACT: f64 = 1e-10;
/// The loosest that is of use: what less work would save is nothing beside a solve.
const LOOSEST: f64 = 1e-3;
/// From here on single precision is far below the error allowed.
const SINGLE: f64 = 1e-6;
/// Harmonics beyond the grid enter in second order only: they may be off by this many times the error, and at most by 1 %.
const OUTER: f64 = 300.0;

/// Error of the coefficients that is nothing beside an error `accuracy` of the amplitudes: these move by less than a
/// hundredth of the coefficients' error in ink.
pub fn error_for(accuracy: f64) -> f64 {
    0.1 * accuracy
}

/// Moments of every channel's indicator function on every plane.
pub struct Coverage {
    /// The grid it was computed for.
    pub grid: Grid,
    /// Pairs of background and material that occur.
    pub channels: Vec<Channel>,
    /// Per channel, planes × points (x fastest) in µm: ∫ ψ_p χ dz, band-limited in the plane.
    pub moments: Vec<Array2<f64>>,
    /// Pairs of channels, and per pair the field that folds the harmonics beyond the grid (µm³), see [`super::folding`].
    pub pairs: Vec<[usize; 2]>,
    /// One field for each pair: planes × points.
    pub folded: Vec<Array2<f64>>,
    /// Per channel, mean of χ over each cell of the grid.
    pub fractions: Vec<Vec<f64>>,
    /// Along which axes nothing changes, so that one point is enough.
    pub uniform: [bool; 2],
    /// The harmonics in use on the grid, for all problems.
    pub harmonics: Arc<Harmonics>,
    /// Transforms of the grid's planes.
    pub fft: PlaneFft,
    /// The same in single precision.
    pub fft_single: PlaneFft<f32>,
    /// Seconds spent here.
    pub seconds: f64,
}

struct Builder<'a, T: Real> {
    scene: &'a Scene,
    grid: &'a Grid,
    channels: &'a [Channel],
    harmonics: &'a Harmonics,
    /// Largest |m| and |n|.
    widest: [usize; 2],
    /// None where no body is round in the plane.
    transform: Option<SourceTransform<T>>,
    sampling: Sampling,
}

impl Coverage {
    /// Integrates every body over every cell, to rounding or nearly. Errors: see [`Grid::new`].
    pub fn new(scene: &Scene, resolution: Resolution) -> Result<Coverage, WaveError> {
        Coverage::within(scene, resolution, EXACT)
    }

    /// The same with a relative error of the coefficients of about `error` (10⁻¹⁰ … 10⁻³), in less time.
    ///
    /// Amplitudes then move by less than `error`: they depend on the contrast's relative error times the share of
    /// light that is scattered. Errors: see [`Grid::new`].
    pub fn within(scene: &Scene, resolution: Resolution, error: f64) -> Result<Coverage, WaveError> {
        let error = error.clamp(EXACT, LOOSEST);
        if error < SINGLE {
            build::<f64>(scene, resolution, error)
        } else {
            build::<f32>(scene, resolution, error)
        }
    }

    /// What the mean medium and the Bloch vector are made from.
    pub fn layout(&self) -> Layout<'_> {
        Layout {
            grid: &self.grid,
            channels: &self.channels,
            fractions: &self.fractions,
            uniform: self.uniform,
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.moments.iter().chain(&self.folded).map(|m| m.len() * size_of::<f64>()).sum()
    }
}

fn build<T: Real>(scene: &Scene, resolution: Resolution, error: f64) -> Result<Coverage, WaveError> {
    let clock = std::time::Instant::now();
    let grid = Grid::new(scene, resolution)?;
    let channels = find_channels(scene, &grid);
    let folding = Folding::<T>::new(&resolution, grid.period_um);
    let builder = Builder::<T>::new(scene, &grid, &channels, &folding.harmonics, error);
    let cells: Vec<Vec<Option<CellCoefficients<T>>>> =
        (0..grid.cells()).into_par_iter().map(|j| builder.cell(j)).collect();
    let Planes { moments, pairs, folded } = folding.planes(&grid, &cells, channels.len());
    let fraction = |c: usize, j: usize| {
        let means = cells[j][c].as_ref().map_or(0.0, |cell| cell.means.iter().sum());
        means / grid.height_um(j)
    };
    let fractions =
        (0..channels.len()).map(|c| (0..grid.cells()).map(|j| fraction(c, j)).collect()).collect();
    Ok(Coverage {
        channels,
        moments,
        pairs,
        folded,
        fractions,
        uniform: [scene.uniform_in_plane(), scene.uniform_in_y()],
        harmonics: Arc::new(Harmonics::new(resolution.nx, resolution.ny)),
        fft: PlaneFft::new(resolution.nx, resolution.ny),
        fft_single: PlaneFft::new(resolution.nx, resolution.ny),
        seconds: clock.elapsed().as_secs_f64(),
        grid,
    })
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

/// The part of a cell's height that a body reaches into.
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
        error: f64,
    ) -> Builder<'a, T> {
        let largest =
            |i: usize| harmonics.orders.iter().map(|o| o[i].unsigned_abs() as usize).max().unwrap_or(0);
        let widest = [largest(0), largest(1)];
        let k = |i: usize, share: f64| TAU * share * widest[i] as f64 / grid.period_um[i];
        let corner = |share: f64| k(0, share).hypot(k(1, share));
        let loose = (OUTER * error).min(1e-2);
        let demands = Demands([(corner(1.0 / REACH as f64), error), (corner(1.0), loose)]);
        let round = scene.bodies.iter().any(|b| matches!(b.shape, Shape::Balls(_)));
        let transform = round.then(|| SourceTransform::new(widest[0], widest[1], Spreading::within(error)));
        let sampling = Sampling { demands, degree: grid.element.degree, rules: GaussRules::default() };
        Builder { scene, grid, channels, harmonics, widest, transform, sampling }
    }

    fn columns(&self, cell: usize) -> CellColumns<'_> {
        CellColumns {
            range_um: [self.grid.nodes_um[cell], self.grid.nodes_um[cell + 1]],
            element: &self.grid.element,
            orders: &self.harmonics.orders,
            widest: self.widest,
        }
    }

    /// Moments of every channel within one cell; None where there is nothing of it.
    fn cell(&self, cell: usize) -> Vec<Option<CellCoefficients<T>>> {
        let here = |c: &Channel| c.background == self.grid.background[cell];
        self.channels.iter().map(|c| if here(c) { self.channel_in_cell(c, cell) } else { None }).collect()
    }

    fn channel_in_cell(&self, channel: &Channel, cell: usize) -> Option<CellCoefficients<T>> {
        let bodies = self.scene.bodies.iter().filter(|b| b.material == channel.material);
        let present: Vec<_> = bodies.filter_map(|b| Some((b, overlap(b, self.grid, cell)?))).collect();
        if present.is_empty() {
            return None;
        }
        let mut sum = CellSum::new(self, cell);
        present.iter().for_each(|(body, range)| sum.add_body(body, *range));
        Some(sum.finish())
    }
}

/// The running moments of one channel in one cell.
struct CellSum<'a, T: Real> {
    builder: &'a Builder<'a, T>,
    cell: usize,
    /// Surface sources on the fine grid, one grid a plane: n_x dS + i n_y dS; empty until there are any.
    sources: Vec<Vec<Complex<T>>>,
    /// Directly summed parts, one a plane, and the means.
    direct: CellCoefficients<T>,
    patch: Patch<T>,
    points: Vec<EdgePoint>,
}

impl<'a, T: Real> CellSum<'a, T> {
    fn new(builder: &'a Builder<'a, T>, cell: usize) -> CellSum<'a, T> {
        let planes = builder.grid.planes_of_cell(cell).count();
        let spectra = vec![vec![Complex::default(); builder.harmonics.len()]; planes];
        let direct = CellCoefficients { spectra, means: vec![0.0; planes] };
        CellSum { builder, cell, sources: Vec::new(), direct, patch: Patch::empty(), points: Vec::new() }
    }

    fn add_body(&mut self, body: &Body, range: [f64; 2]) {
        match &body.shape {
            Shape::Balls(balls) => (0..balls.len()).for_each(|i| self.add_ball(balls, i, range)),
            Shape::Above { surface, balls } => {
                let columns = self.builder.columns(self.cell);
                super::relief::add_vacuum(surface, balls, &columns, &mut self.direct);
            }
            shape => {
                for (z, weight) in self.builder.sampling.strip_heights(shape, range) {
                    let shares = self.shares(z, weight);
                    match section::strip(shape, z) {
                        Some(strip) => self.add_strip(strip, &shares),
                        None => add_mean(&mut self.direct.means, 1.0, &shares),
                    }
                }
            }
        }
    }

    /// Values of all ψ_p at a height, times a weight.
    fn shares(&self, z: f64, weight: f64) -> [f64; MAX_DEGREE + 1] {
        let grid = self.builder.grid;
        let t = (z - grid.nodes_um[self.cell]) / grid.height_um(self.cell);
        grid.element.shape_functions(t).map(|psi| psi * weight)
    }

    /// The free surface of one ball of a union.
    fn add_ball(&mut self, balls: &[Ball], i: usize, range: [f64; 2]) {
        let builder = self.builder;
        let [lx, ly] = builder.grid.period_um;
        let (own, planes) = (&balls[i], self.direct.means.len());
        let transform = builder.transform.as_ref().expect("a scene with balls has a transform");
        if self.sources.is_empty() {
            self.sources = vec![vec![Complex::default(); transform.points()]; planes];
        }
        let center = [own.center_um[0] / lx, own.center_um[1] / ly];
        let (mut patch, mut points) =
            (std::mem::replace(&mut self.patch, Patch::empty()), std::mem::take(&mut self.points));
        transform.open(&mut patch, 2 * planes, center, [own.radius_um / lx, own.radius_um / ly]);
        let mut value = [T::default(); 2 * (MAX_DEGREE + 1)];
        let mut ring = |z: f64, weight: f64, points: &[EdgePoint]| {
            let shares = self.shares(z, weight);
            let mut moment = 0.0;
            for EdgePoint { position, normal } in points {
                let [x, y] = [position[0] - balls[0].center_um[0], position[1] - balls[0].center_um[1]];
                moment += x * normal[0] + y * normal[1]; // Gauss: 2 · area = ∮ (x n_x + y n_y) ds
                for (pair, share) in value.as_chunks_mut::<2>().0.iter_mut().zip(&shares) {
                    *pair = [T::of(normal[0] * share), T::of(normal[1] * share)]; // ψ_p(z) n dS
                }
                let (x, y) =
                    (transform.footprint(0, position[0] / lx), transform.footprint(1, position[1] / ly));
                transform.spread(&mut patch, &x, &y, &value[..2 * planes]);
            }
            add_mean(&mut self.direct.means, 0.5 * moment / (lx * ly), &shares);
        };
        builder.sampling.rings(balls, i, range, &mut points, &mut ring);
        transform.close(&patch, &mut self.sources);
        (self.patch, self.points) = (patch, points);
    }

    /// (1/Lx) ∫ e^{−ikx} dx over a strip; only orders n = 0.
    fn add_strip(&mut self, [x0, x1]: [f64; 2], shares: &[f64]) {
        let lx = self.builder.grid.period_um[0];
        add_mean(&mut self.direct.means, (x1 - x0) / lx, shares);
        let turns = [x0, x1].map(|x| Complex64::cis(-TAU * x / lx));
        let mut ends = turns;
        let [mmax, nmax] = self.builder.widest;
        for m in 1..=mmax {
            let value = (ends[0] - ends[1]) / Complex64::new(0.0, TAU * m as f64);
            for (spectrum, share) in self.direct.spectra.iter_mut().zip(shares) {
                let add = narrowed::<T>(value * share);
                spectrum[index_of(m as i32, 0, [mmax, nmax])] += add;
                spectrum[index_of(-(m as i32), 0, [mmax, nmax])] += add.conj();
            }
            ends = [ends[0] * turns[0], ends[1] * turns[1]];
        }
    }

    fn finish(mut self) -> CellCoefficients<T> {
        if let Some(transform) = self.builder.transform.as_ref().filter(|_| !self.sources.is_empty()) {
            let mut scratch = transform.scratch();
            for (grid, spectrum) in self.sources.iter_mut().zip(&mut self.direct.spectra) {
                std::mem::swap(grid, &mut scratch.plane);
                transform.transform(&mut scratch);
                add_surfaces(self.builder, transform, &scratch, spectrum);
            }
        }
        for (spectrum, &mean) in self.direct.spectra.iter_mut().zip(&self.direct.means) {
            spectrum[0] = Complex::new(T::of(mean), T::default());
        }
        self.direct
    }
}

fn narrowed<T: Real>(z: Complex64) -> Complex<T> {
    Complex::new(T::of(z.re), T::of(z.im))
}

fn add_mean(means: &mut [f64], share: f64, shares: &[f64]) {
    means.iter_mut().zip(shares).for_each(|(mean, s)| *mean += share * s);
}

/// Compact index of order (m, n) among all |m| ≤ mmax, |n| ≤ nmax, see [`Harmonics::new`].
fn index_of(m: i32, n: i32, [mmax, nmax]: [usize; 2]) -> usize {
    let place = |k: i32, max: usize| k.rem_euclid(2 * max as i32 + 1) as usize;
    place(m, mmax) * (2 * nmax + 1) + place(n, nmax)
}

/// (i/k²) (k_x N_x + k_y N_y)/(Lx Ly) from the packed transform Z = N_x + i N_y of two real fields.
///
/// Written as i/(2 k²) (κ̄ Z(k) + κ Z̄(−k)) with κ = k_x + i k_y; the field is real, so half of the orders are enough.
fn add_surfaces<T: Real>(
    builder: &Builder<T>,
    transform: &SourceTransform<T>,
    scratch: &PlaneScratch<T>,
    spectrum: &mut [Complex<T>],
) {
    let [lx, ly] = builder.grid.period_um;
    let [mmax, nmax] = builder.widest.map(|k| k as i32);
    for m in 0..=mmax {
        let (row, mirror) = (transform.row(scratch, m), transform.row(scratch, -m));
        let kx = TAU * f64::from(m) / lx;
        for n in if m == 0 { 1..=nmax } else { -nmax..=nmax } {
            let ky = TAU * f64::from(n) / ly;
            let scale = T::of(0.5 * transform.correction(m, n) / ((kx * kx + ky * ky) * lx * ly));
            let kappa = Complex::new(T::of(kx) * scale, T::of(ky) * scale);
            let place = |k: i32| k.rem_euclid(row.len() as i32) as usize;
            let sum = kappa.conj() * row[place(n)] + kappa * mirror[place(-n)].conj();
            let value = Complex::new(-sum.im, sum.re); // times i
            spectrum[index_of(m, n, builder.widest)] += value;
            spectrum[index_of(-m, -n, builder.widest)] += value.conj();
        }
    }
}

#[cfg(test)]
#[path = "coverage_tests.rs"]
mod tests;
