//! Moments of one channel in one cell: balls and convex bodies by sources on their surfaces, other
//! bodies summed directly.

use super::Builder;
use crate::ink::Solid;
use crate::ink::Sphere;
use crate::numerics::fourier::{PlaneScratch, Real, narrow};
use crate::wave::contrast::folding::CellCoefficients;
use crate::wave::contrast::nufft::Sources;
use crate::wave::contrast::relief::{OpenSpace, raster};
use crate::wave::contrast::section::{self, EdgePoint, extents};
use crate::wave::{Body, BodyShape, MAX_DEGREE};
use num_complex::{Complex, Complex64};
use std::f64::consts::TAU;

/// Partial sums of the moments of one channel in one cell.
pub(super) struct CellSum<'a, T: Real> {
    builder: &'a Builder<'a, T>,
    cell: usize,
    /// Factor on what is added, 1 or −1.
    sign: f64,
    /// Surface sources, one grid per plane: n_x dS + i n_y dS.
    sources: Sources<'a, T>,
    /// Directly summed contributions, one per plane, and the means.
    direct: CellCoefficients<T>,
}

impl<'a, T: Real> CellSum<'a, T> {
    pub(super) fn new(builder: &'a Builder<'a, T>, cell: usize) -> CellSum<'a, T> {
        let planes = builder.grid.planes_of_cell(cell).count();
        let spectra = vec![vec![Complex::default(); builder.harmonics.len()]; planes];
        let direct = CellCoefficients { spectra, means: vec![0.0; planes] };
        let sources = Sources::new(&builder.transform, builder.grid.period_um, 2 * planes);
        CellSum { builder, cell, sign: 1.0, sources, direct }
    }

    /// Adds the moments of a body that covers the height range `range` of the cell, times a sign.
    pub(super) fn add_body(&mut self, body: &Body, sign: f64, range: [f64; 2]) {
        self.sign = sign;
        match &body.shape {
            BodyShape::Balls(balls) => (0..balls.len()).for_each(|i| self.add_ball(balls, i, range)),
            BodyShape::Solid(solid) => self.add_solid(solid, range),
            BodyShape::Open { surface, face_um, balls, solids } => {
                let grid = self.builder.grid;
                let count = raster(self.builder.widest);
                let range_um = [grid.nodes_um[self.cell], grid.nodes_um[self.cell + 1]];
                let face_um = *face_um;
                let element = &grid.element;
                let space = OpenSpace { surface, face_um, balls, solids, range_um, element, count };
                space.add_to(&mut self.direct, &self.builder.harmonics.orders);
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
        grid.element.shape_functions(t).map(|psi| psi * weight * self.sign)
    }

    /// Spreads a ring of points on a surface at height z as sources, and adds the area it encloses,
    /// which is computed about `origin`.
    #[inline]
    fn add_cut(&mut self, origin: [f64; 3], z: f64, weight: f64, points: &[EdgePoint]) {
        let [lx, ly] = self.builder.grid.period_um;
        let shares = self.shares(z, weight);
        let mut moment = 0.0;
        for EdgePoint { position, normal } in points {
            let [x, y] = [position[0] - origin[0], position[1] - origin[1]];
            moment += x * normal[0] + y * normal[1]; // Gauss: 2 · area = ∮ (x n_x + y n_y) ds
            self.sources.spread(*position, &source(*normal, &shares)[..2 * self.direct.means.len()]);
        }
        add_mean(&mut self.direct.means, 0.5 * moment / (lx * ly), &shares);
    }

    /// Adds the free surface of one ball of a union.
    fn add_ball(&mut self, balls: &[Sphere], i: usize, range: [f64; 2]) {
        let builder = self.builder;
        self.sources.open(extents(&balls[i]));
        builder.sampling.rings(balls, i, range, &mut |z, weight, points| {
            self.add_cut(balls[0].center_um, z, weight, points);
        });
        self.sources.close();
    }

    /// Adds the surface of a convex body.
    fn add_solid(&mut self, solid: &Solid, range: [f64; 2]) {
        let builder = self.builder;
        self.sources.open([0, 1].map(|axis| solid.extent_um(axis)));
        builder.sampling.cuts(solid, range, 0.0, &mut |z, weight, points| {
            self.add_cut(solid.center_um, z, weight, points);
        });
        self.sources.close();
    }

    /// Adds (1/Lx) ∫ e^{−ikx} dx over a strip; only orders n = 0.
    fn add_strip(&mut self, [x0, x1]: [f64; 2], shares: &[f64]) {
        let lx = self.builder.grid.period_um[0];
        add_mean(&mut self.direct.means, (x1 - x0) / lx, shares);
        let turns = [x0, x1].map(|x| Complex64::cis(-TAU * x / lx));
        let mut ends = turns;
        let [mmax, nmax] = self.builder.widest;
        for m in 1..=mmax {
            let value = (ends[0] - ends[1]) / Complex64::new(0.0, TAU * m as f64);
            for (spectrum, share) in self.direct.spectra.iter_mut().zip(shares) {
                let add = narrow::<T>(value * share);
                spectrum[index_of(m as i32, 0, [mmax, nmax])] += add;
                spectrum[index_of(-(m as i32), 0, [mmax, nmax])] += add.conj();
            }
            ends = [ends[0] * turns[0], ends[1] * turns[1]];
        }
    }

    /// The spectra of all contributions.
    pub(super) fn finish(mut self) -> CellCoefficients<T> {
        let mut scratch = self.builder.transform.scratch();
        for (grid, spectrum) in self.sources.grids.iter_mut().zip(&mut self.direct.spectra) {
            std::mem::swap(grid, &mut scratch.plane);
            self.builder.transform.transform(&mut scratch);
            add_surfaces(self.builder, &scratch, spectrum);
        }
        for (spectrum, &mean) in self.direct.spectra.iter_mut().zip(&self.direct.means) {
            spectrum[0] = Complex::new(T::of(mean), T::default());
        }
        self.direct
    }
}

/// Source ψ_p(z) n dS of a point: components along x and y for each plane in turn.
#[inline]
fn source<T: Real>(normal: [f64; 2], shares: &[f64; MAX_DEGREE + 1]) -> [T; 2 * (MAX_DEGREE + 1)] {
    let mut value = [T::default(); 2 * (MAX_DEGREE + 1)];
    for (pair, share) in value.as_chunks_mut::<2>().0.iter_mut().zip(shares) {
        *pair = [T::of(normal[0] * share), T::of(normal[1] * share)];
    }
    value
}

fn add_mean(means: &mut [f64], share: f64, shares: &[f64]) {
    means.iter_mut().zip(shares).for_each(|(mean, s)| *mean += share * s);
}

/// Compact index of order (m, n) among all |m| ≤ mmax, |n| ≤ nmax, see
/// [`crate::numerics::fourier::Harmonics::new`].
fn index_of(m: i32, n: i32, [mmax, nmax]: [usize; 2]) -> usize {
    let place = |k: i32, max: usize| k.rem_euclid(2 * max as i32 + 1) as usize;
    place(m, mmax) * (2 * nmax + 1) + place(n, nmax)
}

/// Adds (i/k²) (k_x N_x + k_y N_y)/(Lx Ly) from the packed transform Z = N_x + i N_y of two real
/// fields.
///
/// Written as i/(2 k²) (κ̄ Z(k) + κ Z̄(−k)) with κ = k_x + i k_y; the field is real, so half of the
/// orders suffice.
fn add_surfaces<T: Real>(builder: &Builder<T>, scratch: &PlaneScratch<T>, spectrum: &mut [Complex<T>]) {
    let transform = &builder.transform;
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
            let value = Complex::new(-sum.im, sum.re); // multiplied by i
            spectrum[index_of(m, n, builder.widest)] += value;
            spectrum[index_of(-m, -n, builder.widest)] += value.conj();
        }
    }
}
