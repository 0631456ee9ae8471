//! Geometry for Maxwell's equations: moments of χ and of the normal-field tensor χN on the Gauss
//! planes.
//!
//! For each material, m_ab = 2∫ψ_q χN_ab dz/h and χ_q = 2∫ψ_q χ dz/h, exact and band-limited in the
//! plane. They are real and independent of wavelength and angle, computed once per scene and grid
//! and shared by both polarisations.

use super::solid_sources::{self, Core};
use super::sources::{self, FIELDS, NormalField, Slab, Source, VALUES};
use crate::ink::{Solid, Sphere};
use crate::numerics::fourier::{Harmonics, PlaneFft, PlaneScratch};
use crate::wave::contrast::coverage::{Precision, find_channels, overlap};
use crate::wave::contrast::nufft::{SourceTransform, Sources, Spreading};
use crate::wave::contrast::section::{Demands, Sampling, extents};
use crate::wave::{Body, BodyShape, Channel, Grid, Layout, Resolution, Scene, Scheme, WaveError};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Deref;

/// All fields of one material at the points of a plane (x fastest).
pub type Fields = Vec<[f64; FIELDS]>;

/// The moments of one channel on a Gauss plane.
pub struct ChannelFields {
    /// Index of the channel.
    pub channel: usize,
    /// χ and the six components of χN at every point.
    pub fields: Fields,
}

/// Moments of every material's indicator and normal tensor on every Gauss plane.
pub struct NormalMoments {
    /// The grid, with two Gauss planes per cell, and the pairs of materials that share a cell.
    pub layout: Layout,
    /// Channels present on each Gauss plane.
    pub planes: Vec<Vec<ChannelFields>>,
}

impl Deref for NormalMoments {
    type Target = Layout;

    fn deref(&self) -> &Layout {
        &self.layout
    }
}

struct MomentBuilder<'a> {
    scene: &'a Scene,
    /// What lies inside every body.
    cores: Vec<Option<Core>>,
    grid: &'a Grid,
    channels: &'a [Channel],
    harmonics: Harmonics,
    transform: SourceTransform,
    fft: PlaneFft,
    sampling: Sampling,
}

/// One channel in one cell: fields on both planes, and mean of χ.
struct CellFields {
    planes: [Fields; 2],
    fraction: f64,
}

impl NormalMoments {
    /// Integrates every body over every cell, nearly exactly. Errors: see [`NormalMoments::with`].
    pub fn new(scene: &Scene, resolution: Resolution) -> Result<NormalMoments, WaveError> {
        NormalMoments::with(scene, resolution, Precision::EXACT)
    }

    /// Integrates every body over every cell with the given precision.
    ///
    /// # Errors
    /// [`WaveError::Stopped`]; errors of [`Grid::new`]; rough surfaces.
    pub fn with(scene: &Scene, resolution: Resolution, precision: Precision) -> Result<Self, WaveError> {
        let stop = precision.stop;
        check(scene, resolution)?;
        let grid = Grid::new(scene, resolution)?;
        let channels = find_channels(scene, &grid);
        let builder = MomentBuilder::new(scene, &grid, &channels, precision.bounded_error());
        let cells = (0..grid.cells()).into_par_iter();
        let cells: Vec<Vec<Option<CellFields>>> =
            cells.map(|j| if stop() { Vec::new() } else { builder.cell(j) }).collect();
        if stop() {
            return Err(WaveError::Stopped);
        }
        let mut planes: Vec<Vec<ChannelFields>> = (0..2 * grid.cells()).map(|_| Vec::new()).collect();
        let layout = Layout::new(scene, grid, channels, |j, c| Some(cells[j][c].as_ref()?.fraction));
        for (j, cell) in cells.into_iter().enumerate() {
            for (channel, sums) in cell.into_iter().enumerate().filter_map(|(c, f)| Some((c, f?))) {
                for (q, fields) in sums.planes.into_iter().enumerate() {
                    planes[2 * j + q].push(ChannelFields { channel, fields });
                }
            }
        }
        Ok(NormalMoments { layout, planes })
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.planes.iter().flatten().map(|channel| size_of_val(channel.fields.as_slice())).sum()
    }
}

/// Rejects scenes for which the tensor is not implemented.
fn check(scene: &Scene, resolution: Resolution) -> Result<(), WaveError> {
    if resolution.scheme != Scheme::Quadratic {
        return Err(WaveError::NotInVectorMode {
            what: "a scheme other than `quadratic`",
            reason: "cells carry two moments of each field component",
            remedy: "leave --scheme out",
        });
    }
    if !solid_sources::are_convex(scene) {
        return Err(WaveError::NotInVectorMode {
            what: "layers of a cluster of spheres, or another body inside or around one",
            reason: "the normal-field tensor between them is not implemented",
            remedy: "use layers of single spheres or convex bodies, or the scalar wave",
        });
    }
    if scene.bodies.iter().any(|b| matches!(b.shape, BodyShape::Open { .. })) {
        return Err(WaveError::NotInVectorMode {
            what: "a rough surface (relief)",
            reason: "its normal-field tensor is not implemented, and averaging without it has an error of several per cent",
            remedy: "use a flat surface, or the scalar wave",
        });
    }
    Ok(())
}

impl<'a> MomentBuilder<'a> {
    fn new(scene: &'a Scene, grid: &'a Grid, channels: &'a [Channel], error: f64) -> MomentBuilder<'a> {
        let nx = grid.resolution.nx;
        let ny = grid.resolution.ny;
        let [mmax, nmax] = [nx, ny].map(|n| (n - 1) / 2);
        let k = |max: usize, period: f64| TAU * max as f64 / period;
        let kmax = k(mmax, grid.period_um[0]).hypot(k(nmax, grid.period_um[1]));
        // All harmonics count, unlike those folded by the scalar scheme: twice as many points as
        // orders.
        let spreading = Spreading { points_per_order: 4, ..Spreading::within(error) };
        let harmonics = Harmonics::new(nx, ny);
        let fft = PlaneFft::new(nx, ny);
        let cores = solid_sources::cores(scene);
        let transform = SourceTransform::new(mmax, nmax, spreading);
        let sampling = Sampling { demands: Demands([(kmax, error); 2]), degree: 3 };
        MomentBuilder { scene, cores, grid, channels, harmonics, transform, fft, sampling }
    }

    fn cell(&self, cell: usize) -> Vec<Option<CellFields>> {
        let here = |c: &Channel| c.background == self.grid.background[cell];
        self.channels.iter().map(|c| if here(c) { self.channel_in_cell(c, cell) } else { None }).collect()
    }

    /// Adds the harmonics of sources on a fine grid, which is overwritten.
    fn add_sources(&self, fine: &mut Vec<Complex64>, scratch: &mut PlaneScratch, spectrum: &mut [Complex64]) {
        std::mem::swap(fine, &mut scratch.plane);
        self.transform.transform(scratch);
        let area = self.grid.period_um[0] * self.grid.period_um[1];
        for (value, &[m, n]) in spectrum.iter_mut().zip(&self.harmonics.orders) {
            let row = self.transform.row(scratch, m);
            *value += row[n.rem_euclid(row.len() as i32) as usize] * (self.transform.correction(m, n) / area);
        }
    }

    fn channel_in_cell(&self, channel: &Channel, cell: usize) -> Option<CellFields> {
        let here = |b: &Body| b.material == channel.material && overlap(b, self.grid, cell).is_some();
        let bodies = self.scene.bodies.iter().zip(&self.cores);
        let present: Vec<(&Body, &Option<Core>)> = bodies.filter(|(b, _)| here(b)).collect();
        if present.is_empty() {
            return None;
        }
        let range_um = [self.grid.nodes_um[cell], self.grid.nodes_um[cell + 1]];
        let mut sum = MomentSum::new(self, Slab { range_um, sampling: &self.sampling });
        present.iter().for_each(|(body, core)| sum.add_body(&body.shape, core.as_ref()));
        Some(sum.finish())
    }
}

/// Partial sums of the moments of one channel in one cell.
struct MomentSum<'a> {
    builder: &'a MomentBuilder<'a>,
    slab: Slab<'a>,
    /// Sources of each field, first plane + i · second plane.
    sources: Sources<'a, f64>,
    /// Directly summed harmonics of each field, first plane + i · second plane.
    direct: Vec<Vec<Complex64>>,
}

impl<'a> MomentSum<'a> {
    fn new(builder: &'a MomentBuilder<'a>, slab: Slab<'a>) -> MomentSum<'a> {
        let direct = vec![vec![Complex64::default(); builder.harmonics.len()]; FIELDS];
        let sources = Sources::new(&builder.transform, builder.grid.period_um, VALUES);
        MomentSum { builder, slab, sources, direct }
    }

    fn add_body(&mut self, shape: &BodyShape, core: Option<&Core>) {
        let slab = self.slab;
        match (shape, core) {
            (BodyShape::Balls(balls), Some(Core::Concentric(core, normal))) => {
                balls.iter().for_each(|ball| self.add_layer(ball, core, *normal));
            }
            (_, Some(Core::Bodies(bodies))) => self.add_solid(bodies),
            (BodyShape::Balls(balls), _) => {
                for (i, ball) in balls.iter().enumerate() {
                    self.spread(extents(ball), |mut push| sources::of_ball(balls, i, &slab, &mut push));
                }
            }
            (BodyShape::Solid(solid), _) => self.add_solid(std::slice::from_ref(solid)),
            (BodyShape::CylinderY { x_um, z_um, radius_um }, _) => {
                for (x, values) in sources::of_cylinder(*z_um, *radius_um, &slab) {
                    self.add_lines(&values, |k, lx| Complex64::cis(-k * (x_um + x)) / lx);
                }
            }
            (BodyShape::BarY { x_um, z_um }, _) => {
                let values = sources::of_block(*z_um, &slab, true);
                self.add_lines(&values, |k, lx| strip_coefficient(*x_um, k, lx));
            }
            (BodyShape::Sheet { z_um }, _) => {
                let values = sources::of_block(*z_um, &slab, false);
                self.add_lines(&values, |k, _| Complex64::from(f64::from(u8::from(k == 0.0))));
            }
            (BodyShape::Open { .. }, _) => unreachable!("rough surfaces are refused first"),
        }
    }

    /// Adds a ball less the core inside it.
    fn add_layer(&mut self, ball: &Sphere, core: &Sphere, normal: NormalField) {
        let slab = self.slab;
        self.spread(extents(ball), |mut push| sources::of_single(ball, normal, &slab, &mut push));
        self.spread(extents(core), |push| {
            sources::of_single(core, normal, &slab, &mut |Source { position, values }| {
                push(Source { position, values: values.map(|v| -v) });
            });
        });
    }

    /// Adds a convex body less those inside it.
    fn add_solid(&mut self, bodies: &[Solid]) {
        let nodes = &self.builder.grid.nodes_um;
        let slab = self.slab;
        let extents = [0, 1].map(|axis| bodies[0].extent_um(axis));
        self.spread(extents, |mut push| solid_sources::of_bodies(bodies, nodes, &slab, &mut push));
    }

    /// Spreads the sources within the given lateral extents, µm, onto the fine grid.
    fn spread(&mut self, extents: [[f64; 2]; 2], sources: impl FnOnce(&mut dyn FnMut(Source))) {
        self.sources.open(extents);
        sources(&mut |source: Source| self.sources.spread(source.position, &source.values));
        self.sources.close();
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

    /// Band-limited fields at the points: both planes of a field are the real and imaginary part of
    /// one complex transform.
    fn finish(mut self) -> CellFields {
        let builder = self.builder;
        let mut narrow = builder.fft.scratch();
        let mut wide = builder.transform.scratch();
        let mut planes = [(); 2].map(|()| vec![[0.0; FIELDS]; builder.grid.points()]);
        for (f, spectrum) in self.direct.iter_mut().enumerate() {
            if let Some(sources) = self.sources.grids.get_mut(f) {
                builder.add_sources(sources, &mut wide, spectrum);
            }
            builder.harmonics.spread(spectrum, &mut narrow.spectrum);
            builder.fft.inverse(&mut narrow, &builder.harmonics.rows);
            for (i, value) in narrow.plane.iter().enumerate() {
                planes[0][i][f] = value.re;
                planes[1][i][f] = value.im;
            }
        }
        // Order (0, 0) comes first; each plane represents half the cell.
        let mean = self.direct[0][0];
        CellFields { planes, fraction: 0.5 * (mean.re + mean.im) }
    }
}

/// Transform (1/Lx) ∫ e^{−ikx} dx of a strip.
fn strip_coefficient([x0, x1]: [f64; 2], k: f64, lx: f64) -> Complex64 {
    let (middle, width) = (0.5 * (x0 + x1), x1 - x0);
    let phase = 0.5 * k * width;
    let sinc = if phase.abs() < 1e-8 { 1.0 } else { phase.sin() / phase };
    Complex64::cis(-k * middle) * (width / lx * sinc)
}
