//! From cells to planes, with the harmonics beyond the grid folded into the contrast to second order.
//!
//! Eliminating a harmonic q outside the grid (u_q ≈ Σ V_{q−l} u_l / q², since Δ dominates there) adds
//! Σ_q V_{l'−q} V_{q−l} / q² to the contrast between l' and l (Löwdin's partitioning, J. Chem. Phys. 19 (1951) 1396).
//! For waves that are smooth on the grid this is a local field, the product of the outer part of V and of its
//! inverse Laplacian. It depends on the geometry alone, costs nothing per step, keeps energy balance and
//! reciprocity, and raises the observed order of convergence in the plane from 3 to about 5.

use super::coverage::CellCoefficients;
use crate::numerics::fourier::{Harmonics, PlaneFft, PlaneScratch};
use crate::wave::{Grid, Resolution};
use ndarray::{Array2, ArrayViewMut1, Axis};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Harmonics up to this many times the grid's are folded; more change the error by a few per cent only.
const REACH: usize = 2;

/// The grid's harmonics, the wider set around them, and both sets' transforms.
pub struct Folding {
    /// All harmonics that the coverage is computed for.
    pub harmonics: Harmonics,
    inner: Harmonics,
    /// Compact indices in `harmonics` of the grid's own harmonics, in the order of `inner`.
    kept: Vec<usize>,
    wide: PlaneFft,
    narrow: PlaneFft,
    wide_points: usize,
}

/// Fields on the grid's points, planes × points, in µm (moments) and µm³ (folded).
pub struct Planes {
    pub moments: Vec<Array2<f64>>,
    pub pairs: Vec<[usize; 2]>,
    pub folded: Vec<Array2<f64>>,
}

/// Buffers of one thread.
struct Buffers {
    wide: PlaneScratch,
    narrow: PlaneScratch,
    spectrum: Vec<Complex64>,
}

impl Folding {
    pub fn new(resolution: &Resolution) -> Folding {
        let [nx, ny] = [resolution.nx, resolution.ny];
        let [wx, wy] = [nx, ny].map(|n| if n == 1 { 1 } else { REACH * n });
        let (harmonics, inner) = (Harmonics::new(wx, wy), Harmonics::new(nx, ny));
        let [mmax, nmax] = [nx, ny].map(|n| (n as i32 - 1) / 2);
        let is_inner =
            |&i: &usize| harmonics.orders[i][0].abs() <= mmax && harmonics.orders[i][1].abs() <= nmax;
        let kept = (0..harmonics.len()).filter(is_inner).collect();
        let (wide, narrow) = (PlaneFft::new(wx, wy), PlaneFft::new(nx, ny));
        Folding { harmonics, inner, kept, wide, narrow, wide_points: wx * wy }
    }

    /// Adds the cells' shares of each plane, transforms them to points and folds every pair of channels.
    pub fn planes(&self, grid: &Grid, cells: &[CellCoefficients], channels: usize) -> Planes {
        let pairs: Vec<[usize; 2]> = (0..channels).flat_map(|a| (a..channels).map(move |b| [a, b])).collect();
        let zeros = |count| vec![Array2::zeros((grid.planes(), grid.points())); count];
        let mut planes = Planes { moments: zeros(channels), folded: zeros(pairs.len()), pairs };
        let pairs = planes.pairs.clone();
        let rows = planes.rows(grid.planes());
        let buffers =
            || Buffers { wide: self.wide.scratch(), narrow: self.narrow.scratch(), spectrum: Vec::new() };
        rows.into_par_iter().enumerate().for_each_init(buffers, |buffers, (plane, (moments, folded))| {
            let spectra: Vec<_> = (0..channels).map(|c| self.plane_spectrum(grid, cells, plane, c)).collect();
            for (spectrum, mut out) in spectra.iter().zip(moments) {
                self.to_grid(spectrum, buffers, &mut out);
            }
            let outer: Vec<_> = spectra.iter().map(|s| self.outer_fields(grid, s, buffers)).collect();
            let weight = plane_weight(grid, plane) * self.wide_points as f64;
            for (&[a, b], mut out) in pairs.iter().zip(folded) {
                self.product([&outer[a], &outer[b]], weight, buffers);
                let spectrum = std::mem::take(&mut buffers.spectrum);
                self.to_grid(&spectrum, buffers, &mut out);
                buffers.spectrum = spectrum;
            }
        });
        planes
    }

    fn plane_spectrum(
        &self,
        grid: &Grid,
        cells: &[CellCoefficients],
        plane: usize,
        channel: usize,
    ) -> Vec<Complex64> {
        let mut sum = vec![Complex64::default(); self.harmonics.len()];
        let degree = grid.element.degree;
        // A plane belongs to the cell it starts or lies in, and a node also to the previous cell.
        let previous = plane.is_multiple_of(degree).then(|| (plane / degree).checked_sub(1)).flatten();
        for cell in previous.into_iter().chain([plane / degree]).filter(|&j| j < cells.len()) {
            let part = &cells[cell][channel][plane - degree * cell];
            sum.iter_mut().zip(part).for_each(|(s, p)| *s += p);
        }
        sum
    }

    /// The part of a wide spectrum that the grid can hold, on the grid's points.
    fn to_grid(&self, spectrum: &[Complex64], buffers: &mut Buffers, out: &mut ArrayViewMut1<f64>) {
        let kept: Vec<Complex64> = self.kept.iter().map(|&i| spectrum[i]).collect();
        self.inner.scatter(&kept, &mut buffers.narrow.spectrum);
        self.narrow.inverse(&mut buffers.narrow, &self.inner.rows);
        out.iter_mut().zip(&buffers.narrow.plane).for_each(|(o, v)| *o = v.re);
    }

    /// Outer part of a spectrum and the same over q², on the wide set's points, as real and imaginary part.
    fn outer_fields(&self, grid: &Grid, spectrum: &[Complex64], buffers: &mut Buffers) -> Vec<Complex64> {
        let mut outer = spectrum.to_vec();
        self.kept.iter().for_each(|&i| outer[i] = Complex64::default());
        for (value, order) in outer.iter_mut().zip(&self.harmonics.orders) {
            let q2: f64 = (0..2).map(|i| (TAU * order[i] as f64 / grid.period_um[i]).powi(2)).sum();
            *value *= Complex64::new(1.0, if q2 > 0.0 { 1.0 / q2 } else { 0.0 });
        }
        self.harmonics.scatter(&outer, &mut buffers.wide.spectrum);
        self.wide.inverse(&mut buffers.wide, &self.harmonics.rows);
        buffers.wide.plane.clone()
    }

    /// Symmetrised product of two channels' outer fields over `weight`, as a wide spectrum.
    fn product(&self, [a, b]: [&[Complex64]; 2], weight: f64, buffers: &mut Buffers) {
        for ((value, a), b) in buffers.wide.plane.iter_mut().zip(a).zip(b) {
            *value = (0.5 * (a.re * b.im + a.im * b.re) / weight).into();
        }
        self.wide.forward(&mut buffers.wide, &self.harmonics.rows);
        buffers.spectrum.resize(self.harmonics.len(), Complex64::default());
        self.harmonics.gather(&buffers.wide.spectrum, &mut buffers.spectrum);
    }
}

impl Planes {
    /// For each plane, its row of every field.
    #[allow(clippy::type_complexity)]
    fn rows(&mut self, planes: usize) -> Vec<(Vec<ArrayViewMut1<'_, f64>>, Vec<ArrayViewMut1<'_, f64>>)> {
        let mut rows: Vec<_> = (0..planes).map(|_| (Vec::new(), Vec::new())).collect();
        for field in &mut self.moments {
            rows.iter_mut().zip(field.axis_iter_mut(Axis(0))).for_each(|(row, view)| row.0.push(view));
        }
        for field in &mut self.folded {
            rows.iter_mut().zip(field.axis_iter_mut(Axis(0))).for_each(|(row, view)| row.1.push(view));
        }
        rows
    }
}

/// ∫ of the plane's shape functions over the cells it touches.
fn plane_weight(grid: &Grid, plane: usize) -> f64 {
    let degree = grid.element.degree;
    let in_cell = |j: usize| {
        let point = plane.checked_sub(degree * j)?;
        Some(grid.height_um(j) * grid.element.weights.get(point)?)
    };
    (0..grid.cells()).filter_map(in_cell).sum()
}
