//! The contrast field's geometry: which share of each plane's neighbourhood each material covers.
//!
//! Computed once per scene and grid and reused for every wavelength and angle: the medium enters only through
//! k² differences ("channels"). Coefficients in the plane are exact and band-limited to the grid's harmonics;
//! along z they are moments against the scheme's shape functions (numerics: W_p = ∫ ψ_p V dz).

use super::folding::{Folding, Planes};
use super::nufft::{Footprint, SourceTransform};
use super::section;
use super::section::{Cut, EdgePoint};
use crate::numerics::fourier::Harmonics;
use crate::wave::{Body, Grid, Material, Resolution, Scene, WaveError};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// One pair of materials: a body's inside a background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Index into [`crate::wave::Media::backgrounds`].
    pub background: usize,
    /// What the bodies consist of.
    pub material: Material,
}

/// Moments of every channel's indicator function on every plane.
pub struct Coverage {
    pub grid: Grid,
    pub channels: Vec<Channel>,
    /// Per channel, planes × points (x fastest) in µm: ∫ ψ_p χ dz, band-limited in the plane.
    pub moments: Vec<Array2<f64>>,
    /// Pairs of channels, and per pair the field that folds the harmonics beyond the grid (µm³), see [`super::folding`].
    pub pairs: Vec<[usize; 2]>,
    pub folded: Vec<Array2<f64>>,
    /// Per channel, mean of χ over each cell of the grid.
    pub fractions: Vec<Vec<f64>>,
    /// Along which axes nothing changes, so that one point is enough.
    pub uniform: [bool; 2],
    /// Seconds spent here.
    pub seconds: f64,
}

/// Coefficients of one cell: channel → plane of the cell → harmonics.
pub(crate) type CellCoefficients = Vec<Vec<Vec<Complex64>>>;

/// What the columns of one cell need to know.
pub(crate) struct CellColumns<'a> {
    pub range_um: [f64; 2],
    pub element: &'a crate::wave::grid::element::Element,
    pub orders: &'a [[i32; 2]],
    /// Largest |m| and |n|.
    pub widest: [usize; 2],
}

struct Builder<'a> {
    scene: &'a Scene,
    grid: &'a Grid,
    channels: &'a [Channel],
    harmonics: &'a Harmonics,
    transform: SourceTransform,
    kmax: f64,
}

impl Coverage {
    /// Integrates every body over every cell. Errors: see [`Grid::new`].
    pub fn new(scene: &Scene, resolution: Resolution) -> Result<Coverage, WaveError> {
        let clock = std::time::Instant::now();
        let grid = Grid::new(scene, resolution)?;
        let channels = find_channels(scene, &grid);
        let folding = Folding::new(&resolution);
        let harmonics = &folding.harmonics;
        let builder = Builder::new(scene, &grid, &channels, harmonics);
        let cells: Vec<CellCoefficients> =
            (0..grid.cells()).into_par_iter().map(|j| builder.cell(j)).collect();
        let Planes { moments, pairs, folded } = folding.planes(&grid, &cells, channels.len());
        let origin = harmonics.find(0, 0).expect("order (0, 0) is always in use");
        let fraction =
            |c: usize, j: usize| cells[j][c].iter().map(|p| p[origin].re).sum::<f64>() / grid.height_um(j);
        let fractions =
            (0..channels.len()).map(|c| (0..grid.cells()).map(|j| fraction(c, j)).collect()).collect();
        Ok(Coverage {
            grid,
            channels,
            moments,
            pairs,
            folded,
            fractions,
            uniform: [scene.uniform_in_plane(), scene.uniform_in_y()],
            seconds: clock.elapsed().as_secs_f64(),
        })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.moments.iter().chain(&self.folded).map(|m| m.len() * size_of::<f64>()).sum()
    }
}

/// All (background, material) pairs that share a cell.
fn find_channels(scene: &Scene, grid: &Grid) -> Vec<Channel> {
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
fn overlap(body: &Body, grid: &Grid, cell: usize) -> Option<[f64; 2]> {
    let [lo, hi] = body.extent_um();
    let range = [lo.max(grid.nodes_um[cell]), hi.min(grid.nodes_um[cell + 1])];
    (range[1] > range[0]).then_some(range)
}

impl<'a> Builder<'a> {
    fn new(
        scene: &'a Scene,
        grid: &'a Grid,
        channels: &'a [Channel],
        harmonics: &'a Harmonics,
    ) -> Builder<'a> {
        let largest =
            |i: usize| harmonics.orders.iter().map(|o| o[i].unsigned_abs() as usize).max().unwrap_or(0);
        let [mmax, nmax] = [largest(0), largest(1)];
        let k = |max: usize, period: f64| TAU * max as f64 / period;
        let kmax = k(mmax, grid.period_um[0]).hypot(k(nmax, grid.period_um[1]));
        Builder { scene, grid, channels, harmonics, transform: SourceTransform::new(mmax, nmax), kmax }
    }

    fn columns(&self, cell: usize) -> CellColumns<'_> {
        let largest =
            |i: usize| self.harmonics.orders.iter().map(|o| o[i].unsigned_abs() as usize).max().unwrap_or(0);
        CellColumns {
            range_um: [self.grid.nodes_um[cell], self.grid.nodes_um[cell + 1]],
            element: &self.grid.element,
            orders: &self.harmonics.orders,
            widest: [largest(0), largest(1)],
        }
    }

    fn cell(&self, cell: usize) -> CellCoefficients {
        let here = |c: &Channel| c.background == self.grid.background[cell];
        let zero =
            || vec![vec![Complex64::default(); self.harmonics.len()]; self.grid.planes_of_cell(cell).count()];
        let integrate = |c: &Channel| if here(c) { self.channel_in_cell(c, cell) } else { None };
        self.channels.iter().map(|c| integrate(c).unwrap_or_else(zero)).collect()
    }

    /// Moments of all bodies of one material within one cell; None where there are none.
    fn channel_in_cell(&self, channel: &Channel, cell: usize) -> Option<Vec<Vec<Complex64>>> {
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
struct CellSum<'a> {
    builder: &'a Builder<'a>,
    cell: usize,
    /// Edge sources on the fine grid, one grid a plane: n_x ds + i n_y ds.
    sources: Vec<Vec<Complex64>>,
    /// Directly summed parts, one a plane.
    direct: Vec<Vec<Complex64>>,
    heights: Vec<(f64, f64)>,
    edge: Vec<EdgePoint>,
}

impl<'a> CellSum<'a> {
    fn new(builder: &'a Builder<'a>, cell: usize) -> CellSum<'a> {
        let planes = builder.grid.planes_of_cell(cell).count();
        let zeros = |n: usize| vec![vec![Complex64::default(); n]; planes];
        let round = builder.scene.bodies.iter().any(|b| matches!(b.shape, crate::wave::Shape::Balls(_)));
        let points = if round { builder.transform.points() } else { 0 };
        let (sources, direct) = (zeros(points), zeros(builder.harmonics.len()));
        CellSum { builder, cell, sources, direct, heights: Vec::new(), edge: Vec::new() }
    }

    fn add_body(&mut self, body: &Body, range: [f64; 2]) {
        if let crate::wave::Shape::Above { surface, balls } = &body.shape {
            let columns = self.builder.columns(self.cell);
            return super::relief::add_vacuum(surface, balls, &columns, &mut self.direct);
        }
        let mut heights = std::mem::take(&mut self.heights);
        let degree = self.builder.grid.element.degree;
        section::heights(&body.shape, range, self.builder.kmax, degree, &mut heights);
        for &(z, weight) in &heights {
            self.add_cut(body, z, weight);
        }
        self.heights = heights;
    }

    fn add_cut(&mut self, body: &Body, z: f64, weight: f64) {
        let grid = self.builder.grid;
        let t = (z - grid.nodes_um[self.cell]) / grid.height_um(self.cell);
        let shares = grid.element.shape_functions(t).map(|psi| psi * weight);
        let mut edge = std::mem::take(&mut self.edge);
        match section::cut(&body.shape, z, self.builder.kmax, &mut edge) {
            Cut::Edge { area, points } => self.add_edge(area, points, &shares),
            Cut::Strip(range) => self.add_strip(range, &shares),
            Cut::Everything => self.add_origin(1.0, &shares),
        }
        self.edge = edge;
    }

    fn add_origin(&mut self, share: f64, shares: &[f64]) {
        // Compact index 0 is order (0, 0).
        self.direct.iter_mut().zip(shares).for_each(|(plane, s)| plane[0] += share * s);
    }

    fn add_edge(&mut self, area: f64, points: &[EdgePoint], shares: &[f64]) {
        let [lx, ly] = self.builder.grid.period_um;
        self.add_origin(area / (lx * ly), shares);
        let transform = &self.builder.transform;
        for point in points {
            let x: Footprint = transform.footprint(0, point.position[0] / lx);
            let y = transform.footprint(1, point.position[1] / ly);
            let source = Complex64::new(point.normal[0], point.normal[1]);
            for (grid, &share) in self.sources.iter_mut().zip(shares) {
                transform.spread(grid, &x, &y, source * share);
            }
        }
    }

    /// (1/Lx) ∫ e^{−ikx} dx over a strip; only orders n = 0.
    fn add_strip(&mut self, [x0, x1]: [f64; 2], shares: &[f64]) {
        let lx = self.builder.grid.period_um[0];
        let (middle, width) = (0.5 * (x0 + x1), x1 - x0);
        for (i, _) in self.builder.harmonics.orders.iter().enumerate().filter(|(_, o)| o[1] == 0) {
            let k = TAU * self.builder.harmonics.orders[i][0] as f64 / lx;
            let phase = 0.5 * k * width;
            let sinc = if phase.abs() < 1e-8 { 1.0 } else { phase.sin() / phase };
            let value = Complex64::cis(-k * middle) * (width / lx * sinc);
            self.direct.iter_mut().zip(shares).for_each(|(plane, s)| plane[i] += value * s);
        }
    }

    fn finish(mut self) -> Vec<Vec<Complex64>> {
        if self.sources.iter().any(|s| !s.is_empty()) {
            let mut scratch = self.builder.transform.scratch();
            for (grid, plane) in self.sources.iter().zip(&mut self.direct) {
                scratch.plane.copy_from_slice(grid);
                self.builder.transform.transform(&mut scratch);
                add_edges(self.builder, &scratch, plane);
            }
        }
        self.direct
    }
}

/// (i/k²) (k_x N_x + k_y N_y)/(Lx Ly) from the packed transform Z = N_x + i N_y of two real fields.
fn add_edges(builder: &Builder, scratch: &crate::numerics::fourier::PlaneScratch, plane: &mut [Complex64]) {
    let [lx, ly] = builder.grid.period_um;
    for (value, &[m, n]) in plane.iter_mut().zip(&builder.harmonics.orders).filter(|(_, o)| **o != [0, 0]) {
        let z = builder.transform.coefficient(scratch, m, n);
        let mirrored = builder.transform.coefficient(scratch, -m, -n).conj();
        let normal_x = 0.5 * (z + mirrored);
        let normal_y = Complex64::new(0.0, -0.5) * (z - mirrored);
        let (kx, ky) = (TAU * m as f64 / lx, TAU * n as f64 / ly);
        *value += Complex64::I * (kx * normal_x + ky * normal_y) / ((kx * kx + ky * ky) * lx * ly);
    }
}

#[cfg(test)]
#[path = "coverage_tests.rs"]
mod tests;
