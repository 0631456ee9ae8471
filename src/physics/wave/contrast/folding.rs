//! From cells to planes, with the harmonics beyond the grid folded into the contrast to second
//! order.
//!
//! Eliminating a harmonic q outside the grid (u_q ≈ Σ V_{q−l} u_l / q², since Δ dominates there)
//! adds Σ_q V_{l'−q} V_{q−l} / q² to the contrast between l' and l (Löwdin's partitioning, J. Chem.
//! Phys. 19 (1951) 1396). For waves that are smooth on the grid this is a local field, the product
//! of the outer part of V and of its inverse Laplacian. It depends on the geometry alone, costs
//! nothing per step, keeps energy balance and reciprocity, and raises the observed order of
//! convergence in the plane from 3 to about 5.

use crate::numerics::fourier::{Harmonics, PlaneFft, PlaneScratch, Real};
use crate::wave::Grid;
use crate::wave::operator::sharing::by_row;
use ndarray::{Array2, ArrayViewMut1};
use num_complex::Complex;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Ratio of the highest folded harmonic to the grid's; a larger one changes the error by a few per
/// cent only.
pub(super) const REACH: usize = 2;

/// Coefficients of one channel in one cell: plane of the cell → wide harmonics, and their means in
/// full precision.
pub(crate) struct CellCoefficients<T: Real> {
    pub spectra: Vec<Vec<Complex<T>>>,
    pub means: Vec<f64>,
}

/// Coefficients in all cells of all channels, where they are present.
pub(crate) type CellTable<T> = [Vec<Option<CellCoefficients<T>>>];

/// The grid's harmonics, the wider set around them, and the transforms of both.
pub struct Folding<'a, T: Real> {
    grid: &'a Grid,
    /// All harmonics that the coverage is computed for.
    pub harmonics: Harmonics,
    inner: Harmonics,
    /// Compact indices in `harmonics` of the grid's own harmonics, in the order of `inner`.
    kept: Vec<usize>,
    /// 1/(kx² + ky²) of every wide harmonic, 0 for those of the grid.
    inverse_q2: Vec<T>,
    wide: PlaneFft<T>,
    narrow: PlaneFft<T>,
    wide_points: usize,
}

/// Work arrays of one thread.
struct Buffers<T: Real> {
    wide: PlaneScratch<T>,
    narrow: PlaneScratch<T>,
    /// Per channel: wide spectrum; its outer part, plain and over q², on the wide points.
    spectra: Vec<Vec<Complex<T>>>,
    outer: Vec<Vec<Complex<T>>>,
    compact: Vec<Complex<T>>,
}

impl<'a, T: Real> Folding<'a, T> {
    /// Plans the transforms of a grid.
    pub fn new(grid: &'a Grid) -> Self {
        let nx = grid.resolution.nx;
        let ny = grid.resolution.ny;
        let [wx, wy] = [nx, ny].map(|n| if n == 1 { 1 } else { REACH * n });
        let harmonics = Harmonics::new(wx, wy);
        let inner = Harmonics::new(nx, ny);
        let [mmax, nmax] = [nx, ny].map(|n| (n as i32 - 1) / 2);
        let is_inner = |o: &[i32; 2]| o[0].abs() <= mmax && o[1].abs() <= nmax;
        let kept = (0..harmonics.len()).filter(|&i| is_inner(&harmonics.orders[i])).collect();
        let inverse = |o: &[i32; 2]| {
            let q2: f64 = (0..2).map(|i| (TAU * f64::from(o[i]) / grid.period_um[i]).powi(2)).sum();
            T::of(if is_inner(o) { 0.0 } else { 1.0 / q2 })
        };
        let inverse_q2 = harmonics.orders.iter().map(inverse).collect();
        let wide = PlaneFft::new(wx, wy);
        let narrow = PlaneFft::new(nx, ny);
        Folding { grid, harmonics, inner, kept, inverse_q2, wide, narrow, wide_points: wx * wy }
    }

    /// Sums the cells' contributions to each plane, transforms them to points and folds every pair
    /// of channels: on the grid's points (planes × points), ∫ ψ_p χ dz of every channel in µm, and
    /// the fields contributed by the outer harmonics of each pair in µm³.
    pub(super) fn planes(&self, cells: &CellTable<T>, pairs: &[[usize; 2]]) -> [Vec<Array2<f64>>; 2] {
        let channels = cells[0].len();
        let (planes, points) = (self.grid.planes(), self.grid.points());
        let mut moments = vec![Array2::zeros((planes, points)); channels + pairs.len()];
        by_row(&mut moments, planes).into_par_iter().enumerate().for_each_init(
            || self.buffers(channels),
            |buffers, (plane, rows)| {
                self.spectra(cells, plane, buffers);
                let weight = self.plane_weight(plane) * self.wide_points as f64;
                self.fold(pairs, T::of(weight), rows, buffers);
            },
        );
        let folded = moments.split_off(channels);
        [moments, folded]
    }

    /// Computes one plane's wide spectrum and outer fields of every channel in `buffers`.
    fn spectra(&self, cells: &CellTable<T>, plane: usize, buffers: &mut Buffers<T>) {
        for c in 0..buffers.spectra.len() {
            self.plane_spectrum(cells, plane, c, &mut buffers.spectra[c]);
            self.outer_fields(c, buffers);
        }
    }

    /// One plane's moments, then its folded fields on the grid, from the result of
    /// [`Folding::spectra`] in `buffers`.
    fn fold(
        &self,
        pairs: &[[usize; 2]],
        weight: T,
        mut moments: Vec<ArrayViewMut1<f64>>,
        buffers: &mut Buffers<T>,
    ) {
        // A channel's moments and a folded field are both real and share a transform.
        for (p, mut out) in moments.split_off(buffers.spectra.len()).into_iter().enumerate() {
            self.product(pairs[p], weight, buffers);
            let Buffers { narrow, spectra, compact, .. } = &mut *buffers;
            let moment = |i: usize| spectra.get(p).map_or(Complex::default(), |spectrum| spectrum[i]);
            let both = |&i: &usize| moment(i) + Complex::new(-compact[i].im, compact[i].re);
            let kept: Vec<Complex<T>> = self.kept.iter().map(both).collect();
            self.inner.spread(&kept, &mut narrow.spectrum);
            self.narrow.inverse(narrow, &self.inner.rows);
            out.iter_mut().zip(&narrow.plane).for_each(|(o, v)| *o = v.im.wide());
            if let Some(out) = moments.get_mut(p) {
                out.iter_mut().zip(&narrow.plane).for_each(|(o, v)| *o = v.re.wide());
            }
        }
    }

    fn buffers(&self, channels: usize) -> Buffers<T> {
        let zeros = |count: usize| vec![vec![Complex::default(); count]; channels];
        let wide = self.wide.scratch();
        let narrow = self.narrow.scratch();
        let spectra = zeros(self.harmonics.len());
        let outer = zeros(self.wide_points);
        Buffers { wide, narrow, spectra, outer, compact: vec![Complex::default(); self.harmonics.len()] }
    }

    /// Outer part of a channel's spectrum, plain and over q², on the wide set's points, as real and
    /// imaginary part.
    fn outer_fields(&self, channel: usize, buffers: &mut Buffers<T>) {
        for ((out, &value), &inverse) in
            buffers.compact.iter_mut().zip(&buffers.spectra[channel]).zip(&self.inverse_q2)
        {
            let outer = if inverse > T::default() { T::one() } else { T::default() };
            *out = value * Complex::new(outer, inverse);
        }
        self.harmonics.spread(&buffers.compact, &mut buffers.wide.spectrum);
        self.wide.inverse(&mut buffers.wide, &self.harmonics.rows);
        buffers.outer[channel].copy_from_slice(&buffers.wide.plane);
    }

    /// Symmetrised product of two channels' outer fields over `weight`, as a wide spectrum in
    /// `compact`.
    fn product(&self, [a, b]: [usize; 2], weight: T, buffers: &mut Buffers<T>) {
        let half = T::of(0.5) / weight;
        for ((value, a), b) in buffers.wide.plane.iter_mut().zip(&buffers.outer[a]).zip(&buffers.outer[b]) {
            *value = Complex::new(half * (a.re * b.im + a.im * b.re), T::default());
        }
        self.wide.forward(&mut buffers.wide, &self.harmonics.rows);
        self.harmonics.gather(&buffers.wide.spectrum, &mut buffers.compact);
    }

    /// One plane's wide spectrum of a channel, the sum over the cells it touches.
    fn plane_spectrum(&self, cells: &CellTable<T>, plane: usize, channel: usize, sum: &mut [Complex<T>]) {
        sum.fill(Complex::default());
        let degree = self.grid.element.degree;
        // A plane belongs to the cell in which it starts or lies, and a node also to the previous
        // cell.
        let before = plane.is_multiple_of(degree).then(|| (plane / degree).checked_sub(1)).flatten();
        for cell in before.into_iter().chain([plane / degree]).filter(|&j| j < cells.len()) {
            if let Some(part) = &cells[cell][channel] {
                sum.iter_mut().zip(&part.spectra[plane - degree * cell]).for_each(|(s, p)| *s += p);
            }
        }
    }

    /// Integral of the plane's shape functions over the cells it touches.
    fn plane_weight(&self, plane: usize) -> f64 {
        let grid = self.grid;
        let degree = grid.element.degree;
        let in_cell = |j: usize| {
            let point = plane.checked_sub(degree * j)?;
            Some(grid.height_um(j) * grid.element.weights.get(point)?)
        };
        (0..grid.cells()).filter_map(in_cell).sum()
    }
}
