//! The geometry as Maxwell's equations see it: moments of χ and of the normal-field tensor χN on the Gauss planes.
//!
//! m_ab = 2∫ψ_q χN_ab dz/h and χ_q = 2∫ψ_q χ dz/h per material, exact and band-limited in the plane; real, without
//! wavelength or angle, made once per scene and grid and shared by both polarisations.

use super::sources::{self, FIELDS, Slab, Source, VALUES};
use crate::numerics::fourier::{Harmonics, PlaneFft};
use crate::wave::contrast::coverage::{Channel, find_channels, overlap, strip_coefficient};
use crate::wave::contrast::nufft::SourceTransform;
use crate::wave::{Body, Grid, Layout, Resolution, Scene, Scheme, Shape, WaveError};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// All fields of one material at the points of a plane (x fastest).
pub type Fields = Vec<[f64; FIELDS]>;

/// Moments of every material's indicator and normal tensor on every Gauss plane.
pub struct NormalMoments {
    /// Points and cells; two Gauss planes a cell.
    pub grid: Grid,
    /// Pairs of materials that share a cell.
    pub channels: Vec<Channel>,
    /// Per Gauss plane, the channels present there and their fields.
    pub planes: Vec<Vec<(usize, Fields)>>,
    /// Per channel, mean of χ over each cell of the grid.
    pub fractions: Vec<Vec<f64>>,
    /// Along which axes nothing changes, so that one point is enough.
    pub uniform: [bool; 2],
    /// Seconds spent here.
    pub seconds: f64,
}

struct Builder<'a> {
    scene: &'a Scene,
    grid: &'a Grid,
    channels: &'a [Channel],
    harmonics: Harmonics,
    transform: SourceTransform,
    fft: PlaneFft,
    kmax: f64,
}

/// One channel in one cell: fields on both planes, and mean of χ.
struct CellFields {
    planes: [Fields; 2],
    fraction: f64,
}

impl NormalMoments {
    /// Integrates every body over every cell. Errors: see [`Grid::new`]; rough surfaces are refused.
    pub fn new(scene: &Scene, resolution: Resolution) -> Result<NormalMoments, WaveError> {
        let clock = std::time::Instant::now();
        check(scene, resolution)?;
        let grid = Grid::new(scene, resolution)?;
        let channels = find_channels(scene, &grid);
        let builder = Builder::new(scene, &grid, &channels);
        let cells: Vec<Vec<Option<CellFields>>> =
            (0..grid.cells()).into_par_iter().map(|j| builder.cell(j)).collect();
        let mut planes: Vec<Vec<(usize, Fields)>> = (0..2 * grid.cells()).map(|_| Vec::new()).collect();
        let mut fractions = vec![vec![0.0; grid.cells()]; channels.len()];
        for (j, cell) in cells.into_iter().enumerate() {
            for (c, fields) in cell.into_iter().enumerate().filter_map(|(c, f)| Some((c, f?))) {
                fractions[c][j] = fields.fraction;
                let [first, second] = fields.planes;
                planes[2 * j].push((c, first));
                planes[2 * j + 1].push((c, second));
            }
        }
        let uniform = [scene.uniform_in_plane(), scene.uniform_in_y()];
        let seconds = clock.elapsed().as_secs_f64();
        Ok(NormalMoments { grid, channels, planes, fractions, uniform, seconds })
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
        self.planes.iter().flatten().map(|(_, fields)| size_of_val(fields.as_slice())).sum()
    }
}

/// Refuses what the tensor is not known for.
fn check(scene: &Scene, resolution: Resolution) -> Result<(), WaveError> {
    if resolution.scheme != Scheme::Quadratic {
        return Err(WaveError::NotInVectorMode {
            what: "a scheme other than `quadratic`",
            reason: "cells carry two moments of each field component",
            remedy: "leave --scheme out",
        });
    }
    if scene.bodies.iter().any(|b| matches!(b.shape, Shape::Above { .. })) {
        return Err(WaveError::NotInVectorMode {
            what: "a rough surface (relief)",
            reason: "its normal-field tensor is not written yet, and averaging without it errs by several per cent",
            remedy: "take a flat surface, or the scalar wave",
        });
    }
    Ok(())
}

impl<'a> Builder<'a> {
    fn new(scene: &'a Scene, grid: &'a Grid, channels: &'a [Channel]) -> Builder<'a> {
        let [nx, ny] = [grid.resolution.nx, grid.resolution.ny];
        let [mmax, nmax] = [nx, ny].map(|n| (n - 1) / 2);
        let k = |max: usize, period: f64| TAU * max as f64 / period;
        Builder {
            scene,
            grid,
            channels,
            harmonics: Harmonics::new(nx, ny),
            transform: SourceTransform::new(mmax, nmax),
            fft: PlaneFft::new(nx, ny),
            kmax: k(mmax, grid.period_um[0]).hypot(k(nmax, grid.period_um[1])),
        }
    }

    fn cell(&self, cell: usize) -> Vec<Option<CellFields>> {
        let here = |c: &Channel| c.background == self.grid.background[cell];
        self.channels.iter().map(|c| if here(c) { self.channel_in_cell(c, cell) } else { None }).collect()
    }

    fn channel_in_cell(&self, channel: &Channel, cell: usize) -> Option<CellFields> {
        let bodies = self.scene.bodies.iter();
        let present: Vec<&Body> = bodies
            .filter(|b| b.inclusion == channel.inclusion && overlap(b, self.grid, cell).is_some())
            .collect();
        if present.is_empty() {
            return None;
        }
        let slab = Slab { range_um: [self.grid.nodes_um[cell], self.grid.nodes_um[cell + 1]] };
        let mut sum = CellSum::new(self, slab);
        present.iter().for_each(|body| sum.add_body(&body.shape));
        Some(sum.finish())
    }
}

/// The running moments of one channel in one cell.
struct CellSum<'a> {
    builder: &'a Builder<'a>,
    slab: Slab,
    /// Sources on the fine grid, all values of a point together; empty while there are none.
    fine: Vec<f64>,
    /// Directly summed harmonics of each field, first plane + i · second plane.
    direct: Vec<Vec<Complex64>>,
}

impl<'a> CellSum<'a> {
    fn new(builder: &'a Builder<'a>, slab: Slab) -> CellSum<'a> {
        let direct = vec![vec![Complex64::default(); builder.harmonics.len()]; FIELDS];
        CellSum { builder, slab, fine: Vec::new(), direct }
    }

    fn add_body(&mut self, shape: &Shape) {
        let (slab, kmax) = (self.slab, self.builder.kmax);
        match shape {
            Shape::Balls(balls) => {
                self.fine.resize(self.builder.transform.points() * VALUES, 0.0);
                sources::of_balls(balls, &slab, kmax, &mut |source| self.spread(&source));
            }
            Shape::CylinderY { x_um, z_um, radius_um } => {
                for (x, values) in sources::of_cylinder(*z_um, *radius_um, &slab, kmax) {
                    self.add_lines(&values, |k, lx| Complex64::cis(-k * (x_um + x)) / lx);
                }
            }
            Shape::BarY { x_um, z_um } => {
                let values = sources::of_block(*z_um, &slab, true);
                self.add_lines(&values, |k, lx| strip_coefficient(*x_um, k, lx));
            }
            Shape::Sheet { z_um } => {
                let values = sources::of_block(*z_um, &slab, false);
                self.add_lines(&values, |k, _| Complex64::from(f64::from(u8::from(k == 0.0))));
            }
            Shape::Above { .. } => unreachable!("rough surfaces are refused first"),
        }
    }

    fn spread(&mut self, source: &Source) {
        let [lx, ly] = self.builder.grid.period_um;
        let transform = &self.builder.transform;
        let x = transform.footprint(0, source.position[0] / lx);
        let y = transform.footprint(1, source.position[1] / ly);
        transform.spread_values(&mut self.fine, &x, &y, &source.values);
    }

    /// Adds a part that is uniform in y; `coefficient` is its transform at kx.
    fn add_lines(&mut self, values: &[f64; VALUES], coefficient: impl Fn(f64, f64) -> Complex64) {
        let lx = self.builder.grid.period_um[0];
        for (i, order) in self.builder.harmonics.orders.iter().enumerate().filter(|(_, o)| o[1] == 0) {
            let transform = coefficient(TAU * f64::from(order[0]) / lx, lx);
            for (field, pair) in self.direct.iter_mut().zip(values.chunks_exact(2)) {
                field[i] += transform * Complex64::new(pair[0], pair[1]);
            }
        }
    }

    /// Band-limited fields at the points: both planes of a field are the parts of one complex transform.
    fn finish(mut self) -> CellFields {
        let builder = self.builder;
        let [lx, ly] = builder.grid.period_um;
        let mut wide = (!self.fine.is_empty()).then(|| builder.transform.scratch());
        let mut narrow = builder.fft.scratch();
        let points = builder.grid.points();
        let mut planes = [vec![[0.0; FIELDS]; points], vec![[0.0; FIELDS]; points]];
        for (f, spectrum) in self.direct.iter_mut().enumerate() {
            if let Some(wide) = &mut wide {
                let values = self.fine.chunks_exact(VALUES);
                let pairs = values.map(|v| Complex64::new(v[2 * f], v[2 * f + 1]));
                wide.plane.iter_mut().zip(pairs).for_each(|(p, v)| *p = v);
                builder.transform.transform(wide);
                for (value, &[m, n]) in spectrum.iter_mut().zip(&builder.harmonics.orders) {
                    *value += builder.transform.coefficient(wide, m, n) / (lx * ly);
                }
            }
            builder.harmonics.scatter(spectrum, &mut narrow.spectrum);
            builder.fft.inverse(&mut narrow, &builder.harmonics.rows);
            for (i, value) in narrow.plane.iter().enumerate() {
                (planes[0][i][f], planes[1][i][f]) = (value.re, value.im);
            }
        }
        // Order (0, 0) comes first; each plane stands for half the cell.
        let mean = self.direct[0][0];
        CellFields { planes, fraction: 0.5 * (mean.re + mean.im) }
    }
}
