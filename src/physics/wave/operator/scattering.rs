//! One application of A⁻¹V, in double or in single precision: what every iterative strategy spends its time on.
//!
//! Per plane: values from nodes and bubbles, inverse transform, product with the contrast, forward transform. Then per
//! harmonic: loads to nodes and bubbles (the transpose of the values), and the factors L D Lᵀ of the mean operator.
//! All factors are tables, the loops run over harmonics, and fields too small to share stay on one thread.

use super::mean::MeanOperator;
use super::sharing::{Idle, in_chunks};
use crate::numerics::fourier::{Harmonics, PlaneFft, PlaneScratch, Real, narrow};
use crate::wave::grid::element::MAX_DEGREE;
use multiversion::multiversion;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, s};
use num_complex::Complex;
use std::sync::Arc;

/// Harmonics treated together by one thread: a column of some 50 planes stays in second-level cache.
const BLOCK: usize = 192;

/// Something that applies A⁻¹V.
pub trait Scatter<T: Real>: Sync {
    /// out ← A⁻¹ V u, written over whatever `out` held; rows are planes, columns harmonics.
    fn scatter(&self, u: ArrayView2<Complex<T>>, out: &mut Array2<Complex<T>>);
}

/// A⁻¹V as tables.
pub struct Scattering<T: Real> {
    harmonics: Arc<Harmonics>,
    fft: PlaneFft<T>,
    degree: usize,
    /// Value of each bubble (row) at each inner point of a cell (column).
    bubbles: Vec<Vec<T>>,
    /// W_p over the points of a plane: planes × points.
    weights: Array2<Complex<T>>,
    /// The first node's basis function at each inner point of a cell: point → cells × harmonics.
    left_share: Vec<Array2<Complex<T>>>,
    /// L: coupling of each node with the next over its pivot.
    factor: Array2<Complex<T>>,
    /// 1/D.
    inverse_pivot: Array2<Complex<T>>,
    /// 1/A of each bubble: (cells · bubbles) × harmonics.
    inverse_bubble: Array2<Complex<T>>,
    idle: Idle<PlaneScratch<T>>,
}

impl<T: Real> Scattering<T> {
    /// Copies the mean operator's factors; `weights` are W_p over the points of a plane, planes × points.
    pub fn new(
        mean: &MeanOperator,
        harmonics: &Arc<Harmonics>,
        fft: PlaneFft<T>,
        weights: Array2<Complex<T>>,
    ) -> Self {
        let (factor, inverse_pivot) = mean.factors();
        let degree = mean.element.degree;
        let count = degree - 1;
        let inverse_bubble =
            Array2::from_shape_fn((mean.heights.len() * count, harmonics.len()), |(row, i)| {
                narrow(1.0 / mean.bubble(row / count, row % count, i))
            });
        let numbers = |row: &Vec<f64>| row.iter().map(|&x| T::of(x)).collect();
        Scattering {
            harmonics: harmonics.clone(),
            fft,
            degree,
            bubbles: mean.element.bubbles.iter().map(numbers).collect(),
            weights,
            left_share: mean.left_share.iter().map(|share| share.mapv(narrow)).collect(),
            factor: factor.mapv(narrow),
            inverse_pivot: inverse_pivot.mapv(narrow),
            inverse_bubble,
            idle: Idle::default(),
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let shares: usize = self.left_share.iter().map(|s| s.len()).sum();
        let tables = self.factor.len() + self.inverse_pivot.len() + self.inverse_bubble.len();
        (shares + tables + self.weights.len()) * size_of::<Complex<T>>()
    }

    /// out ← V u as loads on planes (one inverse and one forward transform a plane).
    pub fn contrast_loads(&self, u: ArrayView2<Complex<T>>, out: &mut Array2<Complex<T>>) {
        let scratch = || self.fft.scratch();
        self.idle.in_chunks(out, Axis(0), 1, scratch, |plane, mut row, scratch| {
            self.plane_loads(&u, plane, row.as_slice_mut().expect("rows are contiguous"), scratch);
        });
    }

    fn plane_loads(
        &self,
        u: &ArrayView2<Complex<T>>,
        plane: usize,
        out: &mut [Complex<T>],
        scratch: &mut PlaneScratch<T>,
    ) {
        self.plane_values(u, plane, out); // û_p, from nodes and bubbles
        self.harmonics.scatter(out, &mut scratch.spectrum);
        self.fft.inverse(scratch, &self.harmonics.rows); // u_p(x, y) = Σ û_p e^{i(kx x + ky y)}
        multiply(&mut scratch.plane, row(&self.weights.view(), plane)); // W_p u_p, W_p = ∫ ψ_p (k² − ⟨k²⟩) dz
        self.fft.forward(scratch, &self.harmonics.rows);
        self.harmonics.gather(&scratch.spectrum, out); // y_p, harmonics of W_p u_p
    }

    /// Values on a plane from the unknowns: nodes as they are; inside a cell the mean solution and the bubbles.
    fn plane_values(&self, u: &ArrayView2<Complex<T>>, plane: usize, out: &mut [Complex<T>]) {
        let degree = self.degree;
        let (cell, point) = (plane / degree, plane % degree);
        if point == 0 {
            return out.copy_from_slice(row(u, plane));
        }
        let [left, right] = [point, degree - point].map(|q| row_of(&self.left_share[q - 1], cell));
        // u(t) = u_j sin(kz h (1−t))/sin(kz h) + u_{j+1} sin(kz h t)/sin(kz h) + Σ_i b_i B_i(t)
        between(out, [left, row(u, degree * cell)], [right, row(u, degree * (cell + 1))]);
        for (i, bubble) in self.bubbles.iter().enumerate() {
            add_scaled(out, bubble[point - 1], row(u, degree * cell + 1 + i));
        }
    }

    /// A⁻¹ applied in place to loads on planes.
    pub fn mean_solve(&self, y: &mut Array2<Complex<T>>) {
        in_chunks(y, Axis(1), BLOCK, |b, block| self.solve_block(block, b * BLOCK));
    }

    /// x = L⁻ᵀ D⁻¹ L⁻¹ y on the nodes of a block of harmonics, l_j = o_j/d_j the coupling of node j with the next.
    fn solve_block(&self, mut y: ArrayViewMut2<Complex<T>>, first: usize) {
        let columns = first..first + y.ncols();
        let (degree, cells) = (self.degree, self.factor.nrows());
        for cell in 0..cells {
            self.load_cell(&mut y, cell, columns.clone());
            let (mut here, mut next) =
                y.multi_slice_mut((s![degree * cell, ..], s![degree * (cell + 1), ..]));
            let factor = &row_of(&self.factor, cell)[columns.clone()];
            subtract_product(slice(&mut next), factor, slice(&mut here)); // y_{j+1} ← y_{j+1} − l_j y_j
        }
        for node in (0..=cells).rev() {
            let pivot = &row_of(&self.inverse_pivot, node)[columns.clone()];
            if node == cells {
                multiply(slice(&mut y.row_mut(degree * node)), pivot); // x_N = y_N / d_N
                continue;
            }
            let (mut here, mut next) =
                y.multi_slice_mut((s![degree * node, ..], s![degree * (node + 1), ..]));
            multiply(slice(&mut here), pivot);
            // x_j = y_j / d_j − l_j x_{j+1}
            subtract_product(
                slice(&mut here),
                &row_of(&self.factor, node)[columns.clone()],
                slice(&mut next),
            );
        }
    }

    /// Loads at a cell's inner points → its nodes, and its bubbles' amplitudes.
    fn load_cell(&self, y: &mut ArrayViewMut2<Complex<T>>, cell: usize, columns: std::ops::Range<usize>) {
        let degree = self.degree;
        for point in 1..degree {
            let [left, right] =
                [point, degree - point].map(|q| &row_of(&self.left_share[q - 1], cell)[columns.clone()]);
            let (mut first, mut load, mut last) = y.multi_slice_mut((
                s![degree * cell, ..],
                s![degree * cell + point, ..],
                s![degree * (cell + 1), ..],
            ));
            // y_j += y_p sin(kz h (1−t))/sin(kz h), y_{j+1} += y_p sin(kz h t)/sin(kz h)
            share_load(slice(&mut first), left, slice(&mut last), right, slice(&mut load));
        }
        let mut loads = [[Complex::default(); BLOCK]; MAX_DEGREE - 1];
        for point in 1..degree {
            let mut row = y.row_mut(degree * cell + point);
            loads[point - 1][..columns.len()].copy_from_slice(slice(&mut row));
            row.fill(Complex::default());
        }
        for (b, bubble) in self.bubbles.iter().enumerate() {
            let mut row = y.row_mut(degree * cell + 1 + b);
            let row = slice(&mut row);
            // b_i = Σ_p B_i(t_p) y_p / (kz² h λ_i − 1/h)
            bubble.iter().zip(&loads).for_each(|(&x, load)| add_scaled(row, x, load));
            multiply(row, &row_of(&self.inverse_bubble, cell * (degree - 1) + b)[columns.clone()]);
        }
    }
}

impl<T: Real> Scatter<T> for Scattering<T> {
    fn scatter(&self, u: ArrayView2<Complex<T>>, out: &mut Array2<Complex<T>>) {
        self.contrast_loads(u, out);
        self.mean_solve(out);
    }
}

fn row<'a, T>(u: &'a ArrayView2<T>, index: usize) -> &'a [T] {
    u.row(index).to_slice().expect("rows are contiguous")
}

/// A row of a table.
pub(in crate::wave) fn row_of<T>(u: &Array2<T>, index: usize) -> &[T] {
    &u.as_slice().expect("tables are contiguous")[index * u.ncols()..(index + 1) * u.ncols()]
}

fn slice<'a, T>(row: &'a mut ndarray::ArrayViewMut1<T>) -> &'a mut [T] {
    row.as_slice_mut().expect("parts of rows are contiguous")
}

/// a ← a b.
#[multiversion(targets("x86_64+avx2"))]
fn multiply<T: Real>(a: &mut [Complex<T>], b: &[Complex<T>]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a *= *b);
}

/// out ← w₀ a₀ + w₁ a₁.
#[multiversion(targets("x86_64+avx2"))]
fn between<T: Real>(out: &mut [Complex<T>], [w0, a0]: [&[Complex<T>]; 2], [w1, a1]: [&[Complex<T>]; 2]) {
    let products = w0.iter().zip(a0).zip(w1.iter().zip(a1));
    out.iter_mut().zip(products).for_each(|(out, ((w0, a0), (w1, a1)))| *out = w0 * a0 + w1 * a1);
}

/// out ← out + factor a.
#[multiversion(targets("x86_64+avx2"))]
fn add_scaled<T: Real>(out: &mut [Complex<T>], factor: T, a: &[Complex<T>]) {
    out.iter_mut().zip(a).for_each(|(out, a)| *out += a.scale(factor));
}

/// y ← y − w x.
#[multiversion(targets("x86_64+avx2"))]
fn subtract_product<T: Real>(y: &mut [Complex<T>], w: &[Complex<T>], x: &[Complex<T>]) {
    y.iter_mut().zip(w.iter().zip(x)).for_each(|(y, (w, x))| *y -= w * x);
}

/// first ← first + left load, last ← last + right load.
#[multiversion(targets("x86_64+avx2"))]
fn share_load<T: Real>(
    first: &mut [Complex<T>],
    left: &[Complex<T>],
    last: &mut [Complex<T>],
    right: &[Complex<T>],
    load: &[Complex<T>],
) {
    let nodes = first.iter_mut().zip(left).zip(last.iter_mut().zip(right));
    nodes.zip(load).for_each(|(((first, left), (last, right)), load)| {
        *first += left * load;
        *last += right * load;
    });
}
