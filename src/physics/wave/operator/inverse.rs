//! The inverse A⁻¹ as tables, in double or in single precision: values on planes from the unknowns,
//! their transpose, and the factors L D Lᵀ of the nodes' systems. All loops run over harmonics;
//! small fields are processed by one thread.
//!
//! Rows of a field: node j is row `degree · j`, followed by the cell's bubbles; columns are
//! harmonics.

use super::sharing::in_chunks;
use crate::numerics::fourier::{Real, narrow};
use crate::wave::grid::element::MAX_DEGREE;
use multiversion::multiversion;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, s};
use num_complex::Complex;
use std::ops::Range;

/// A line of a field or table: numbers of all harmonics or points.
pub(in crate::wave) type Line<T> = [Complex<T>];

/// Harmonics processed together by one thread: a column of some 50 planes stays in the second-level
/// cache.
const BLOCK: usize = 192;

/// The mean operator's inverse: rows of the tables are cells, nodes or bubbles, columns harmonics.
pub struct MeanInverse<T: Real = f64> {
    /// Value of each bubble (row) at each inner point of a cell (column).
    pub(super) bubbles: Vec<Vec<T>>,
    /// The first node's basis function at each inner point of a cell: point → cells × harmonics.
    pub(crate) left_share: Vec<Array2<Complex<T>>>,
    /// Factor L: coupling of each node with the next over its pivot.
    pub(super) factor: Array2<Complex<T>>,
    /// Reciprocal of D.
    pub(super) inverse_pivot: Array2<Complex<T>>,
    /// Reciprocal of A for each bubble: (cells · bubbles) × harmonics.
    pub(super) inverse_bubble: Array2<Complex<T>>,
}

impl MeanInverse {
    /// The inverse in another precision.
    pub fn narrowed<T: Real>(&self) -> MeanInverse<T> {
        let bubbles = self.bubbles.iter().map(|row| row.iter().map(|&x| T::of(x)).collect()).collect();
        let left_share = self.left_share.iter().map(|share| share.mapv(narrow)).collect();
        let factor = self.factor.mapv(narrow);
        let inverse_pivot = self.inverse_pivot.mapv(narrow);
        let inverse_bubble = self.inverse_bubble.mapv(narrow);
        MeanInverse { bubbles, left_share, factor, inverse_pivot, inverse_bubble }
    }
}

impl<T: Real> MeanInverse<T> {
    fn degree(&self) -> usize {
        self.left_share.len() + 1
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let shares: usize = self.left_share.iter().map(|s| s.len()).sum();
        let tables = self.factor.len() + self.inverse_pivot.len() + self.inverse_bubble.len();
        (shares + tables) * size_of::<Complex<T>>()
    }

    /// Values on a plane from the unknowns: nodes unchanged; inside a cell the mean solution plus
    /// the bubbles.
    pub fn plane_values(&self, u: &ArrayView2<Complex<T>>, plane: usize, out: &mut [Complex<T>]) {
        let degree = self.degree();
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

    /// Converts loads y_p on planes to right-hand sides of nodes and bubbles, in place (transpose
    /// of the plane values).
    pub fn load(&self, y: &mut Array2<Complex<T>>) {
        in_chunks(y, Axis(1), BLOCK, |b, mut block| {
            let columns = b * BLOCK..b * BLOCK + block.ncols();
            let mut loads = empty_loads();
            let cells = 0..self.factor.nrows();
            cells.for_each(|cell| self.load_cell(&mut block, cell, columns.clone(), &mut loads));
        });
    }

    /// Applies A⁻¹ in place to rows of nodes and bubbles.
    pub fn solve(&self, y: &mut Array2<Complex<T>>) {
        in_chunks(y, Axis(1), BLOCK, |b, block| self.solve_block(block, b * BLOCK, false));
    }

    /// Applies A⁻¹ in place to the rows of one harmonic.
    pub fn solve_column(&self, y: &mut Array2<Complex<T>>, harmonic: usize) {
        self.solve_block(y.slice_mut(s![.., harmonic..=harmonic]), harmonic, false);
    }

    /// Applies A⁻¹ in place to loads on planes.
    pub fn solve_loads(&self, y: &mut Array2<Complex<T>>) {
        in_chunks(y, Axis(1), BLOCK, |b, block| self.solve_block(block, b * BLOCK, true));
    }

    /// Solves x = L⁻ᵀ D⁻¹ L⁻¹ y on the nodes of a block of harmonics, with l_j = o_j/d_j the
    /// coupling of node j with the next; bubbles are decoupled.
    fn solve_block(&self, mut y: ArrayViewMut2<Complex<T>>, first: usize, of_loads: bool) {
        let columns = first..first + y.ncols();
        let degree = self.degree();
        let cells = self.factor.nrows();
        let mut loads = empty_loads();
        for cell in 0..cells {
            if of_loads {
                self.load_cell(&mut y, cell, columns.clone(), &mut loads);
            }
            for bubble in 0..degree - 1 {
                let inverse = &row_of(&self.inverse_bubble, cell * (degree - 1) + bubble)[columns.clone()];
                // b_i = y_i / (kz² h λ_i − 1/h)
                multiply(slice(&mut y.row_mut(degree * cell + 1 + bubble)), inverse);
            }
            let [here, next] = nodes(&mut y, degree, cell);
            let factor = &row_of(&self.factor, cell)[columns.clone()];
            subtract_product(next, factor, here); // y_{j+1} ← y_{j+1} − l_j y_j
        }
        for node in (0..=cells).rev() {
            let pivot = &row_of(&self.inverse_pivot, node)[columns.clone()];
            if node == cells {
                multiply(slice(&mut y.row_mut(degree * node)), pivot); // x_N = y_N / d_N
                continue;
            }
            let [here, next] = nodes(&mut y, degree, node);
            multiply(here, pivot);
            // x_j = y_j / d_j − l_j x_{j+1}
            subtract_product(here, &row_of(&self.factor, node)[columns.clone()], next);
        }
    }

    /// Converts loads at a cell's inner points to right-hand sides of its nodes and bubbles.
    fn load_cell(
        &self,
        y: &mut ArrayViewMut2<Complex<T>>,
        cell: usize,
        columns: Range<usize>,
        loads: &mut PointLoads<T>,
    ) {
        let degree = self.degree();
        for point in 1..degree {
            let mut row = y.row_mut(degree * cell + point);
            loads[point - 1][..columns.len()].copy_from_slice(slice(&mut row));
            row.fill(Complex::default());
        }
        let [first, last] = nodes(y, degree, cell);
        for point in 1..degree {
            let [left, right] =
                [point, degree - point].map(|q| &row_of(&self.left_share[q - 1], cell)[columns.clone()]);
            // y_j += y_p sin(kz h (1−t))/sin(kz h), y_{j+1} += y_p sin(kz h t)/sin(kz h)
            share(first, left, last, right, &loads[point - 1]);
        }
        for (b, bubble) in self.bubbles.iter().enumerate() {
            let mut row = y.row_mut(degree * cell + 1 + b);
            let row = slice(&mut row);
            // Σ_p B_i(t_p) y_p
            bubble.iter().zip(&*loads).for_each(|(&x, load)| add_scaled(row, x, load));
        }
    }
}

/// The loads at a cell's inner points, for one block of harmonics.
type PointLoads<T> = [[Complex<T>; BLOCK]; MAX_DEGREE - 1];

fn empty_loads<T: Real>() -> PointLoads<T> {
    [[Complex::default(); BLOCK]; MAX_DEGREE - 1]
}

/// The rows of a cell's nodes. Split rather than sliced: it is done thousands of times a
/// millisecond.
fn nodes<'a, T>(y: &'a mut ArrayViewMut2<T>, degree: usize, cell: usize) -> [&'a mut [T]; 2] {
    let (upper, lower) = y.view_mut().split_at(Axis(0), degree * (cell + 1));
    [(upper, degree * cell), (lower, 0)].map(|(part, row)| {
        part.index_axis_move(Axis(0), row).into_slice().expect("parts of rows are contiguous")
    })
}

pub(in crate::wave) fn row<'a, T>(u: &'a ArrayView2<T>, index: usize) -> &'a [T] {
    u.row(index).to_slice().expect("rows are contiguous")
}

/// A row of a table.
pub(in crate::wave) fn row_of<T>(u: &Array2<T>, index: usize) -> &[T] {
    &u.as_slice().expect("tables are contiguous")[index * u.ncols()..(index + 1) * u.ncols()]
}

fn slice<'a, T>(row: &'a mut ndarray::ArrayViewMut1<T>) -> &'a mut [T] {
    row.as_slice_mut().expect("parts of rows are contiguous")
}

/// Multiplies a ← a b.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2"))]
pub(super) fn multiply<T: Real>(a: &mut [Complex<T>], b: &[Complex<T>]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a *= *b);
}

/// Combines out ← w₀ a₀ + w₁ a₁.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2"))]
fn between<T: Real>(out: &mut [Complex<T>], [w0, a0]: [&[Complex<T>]; 2], [w1, a1]: [&[Complex<T>]; 2]) {
    let products = w0.iter().zip(a0).zip(w1.iter().zip(a1));
    out.iter_mut().zip(products).for_each(|(out, ((w0, a0), (w1, a1)))| *out = w0 * a0 + w1 * a1);
}

/// Adds out ← out + factor a.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2"))]
fn add_scaled<T: Real>(out: &mut [Complex<T>], factor: T, a: &[Complex<T>]) {
    out.iter_mut().zip(a).for_each(|(out, a)| *out += a.scale(factor));
}

/// Subtracts y ← y − w x.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2"))]
fn subtract_product<T: Real>(y: &mut [Complex<T>], w: &[Complex<T>], x: &[Complex<T>]) {
    y.iter_mut().zip(w.iter().zip(x)).for_each(|(y, (w, x))| *y -= w * x);
}

/// Adds the load to both: first ← first + left load, last ← last + right load.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2", "x86_64+avx2"))]
fn share<T: Real>(first: &mut Line<T>, left: &Line<T>, last: &mut Line<T>, right: &Line<T>, load: &Line<T>) {
    let nodes = first.iter_mut().zip(left).zip(last.iter_mut().zip(right));
    nodes.zip(load).for_each(|(((first, left), (last, right)), load)| {
        *first += left * load;
        *last += right * load;
    });
}
