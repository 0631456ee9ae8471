//! The mean operator A: Δ + k̄² with the half-spaces' exact conditions, one tridiagonal system per harmonic.
//!
//! Each cell's coefficients are those of [`super::cell`].
//! Rows of a field: node j is row `degree · j`, the cell's bubbles follow it; columns are harmonics.

pub use super::cell::{NodeCoefficients, decaying_root, left_share};

use super::cell::cell_factors;
use crate::wave::grid::element::{Element, MAX_DEGREE};
use crate::wave::{Grid, Scheme};
use ndarray::{Array2, ArrayView1, ArrayView2, ArrayViewMut1, ArrayViewMut2, Axis, s};
use num_complex::Complex64;
use rayon::prelude::*;

/// Harmonics treated together by one thread: a column of some 50 planes stays in the second-level cache.
const BLOCK: usize = 192;

/// A, factorised: rows of the arrays are cells or nodes, columns harmonics.
pub struct MeanOperator {
    pub(crate) scheme: Scheme,
    pub(crate) element: Element,
    pub(crate) heights: Vec<f64>,
    /// k̄² of each cell.
    mean_k2: Vec<Complex64>,
    /// kx² + ky² of each harmonic.
    lateral_k2: Vec<f64>,
    off: Array2<Complex64>,
    /// A cell's share of both its nodes' diagonals.
    diagonal: Array2<Complex64>,
    inverse_pivot: Array2<Complex64>,
    /// One array per inner point of a cell.
    pub(crate) left_share: Vec<Array2<Complex64>>,
}

impl MeanOperator {
    /// `kappa` are the half-spaces' normal wavenumbers (incident side, exit side) of each harmonic.
    pub fn new(
        grid: &Grid,
        mean_k2: Vec<Complex64>,
        lateral_k2: Vec<f64>,
        kappa: [&[Complex64]; 2],
    ) -> MeanOperator {
        let heights: Vec<f64> = (0..grid.cells()).map(|j| grid.height_um(j)).collect();
        let scheme = grid.resolution.scheme;
        let shape = (heights.len(), lateral_k2.len());
        let mut operator = MeanOperator {
            scheme,
            element: grid.element.clone(),
            left_share: vec![Array2::zeros(shape); grid.element.degree - 1],
            off: Array2::zeros(shape),
            diagonal: Array2::zeros(shape),
            inverse_pivot: Array2::zeros((shape.0 + 1, shape.1)),
            heights,
            mean_k2,
            lateral_k2,
        };
        operator.cells();
        operator.factorise(kappa);
        operator
    }

    pub(crate) fn kz2(&self, cell: usize, harmonic: usize) -> Complex64 {
        self.mean_k2[cell] - self.lateral_k2[harmonic]
    }

    /// Coefficients of every cell.
    fn cells(&mut self) {
        let (heights, mean_k2, lateral_k2, scheme) =
            (&self.heights, &self.mean_k2, &self.lateral_k2, self.scheme);
        let points = &self.element.points[1..self.element.degree];
        let mut rows: Vec<Vec<_>> = (0..heights.len()).map(|_| Vec::new()).collect();
        for table in [&mut self.off, &mut self.diagonal].into_iter().chain(&mut self.left_share) {
            rows.iter_mut().zip(table.outer_iter_mut()).for_each(|(row, part)| row.push(part));
        }
        rows.into_par_iter().enumerate().for_each(|(j, mut tables)| {
            let factors = |q: f64| cell_factors(mean_k2[j] - q, heights[j], points, scheme);
            tabulate(lateral_k2, factors, &mut tables);
        });
    }

    /// L D Lᵀ of the nodes' system, all harmonics side by side.
    fn factorise(&mut self, kappa: [&[Complex64]; 2]) {
        let last = self.heights.len();
        let mut diagonal: Vec<Complex64> = kappa[0].iter().map(|k| Complex64::I * k).collect();
        for j in 0..last {
            let (off, own) = (self.off.row(j), self.diagonal.row(j));
            for (i, pivot) in self.inverse_pivot.row_mut(j).iter_mut().enumerate() {
                *pivot = guarded_inverse(diagonal[i] + own[i], off[i]); // 1/d_j
                diagonal[i] = own[i] - off[i] * off[i] * *pivot; // the next one's, less o²/d_j
            }
        }
        for (i, pivot) in self.inverse_pivot.row_mut(last).iter_mut().enumerate() {
            *pivot = guarded_inverse(diagonal[i] + Complex64::I * kappa[1][i], self.off[[last - 1, i]]);
        }
    }

    /// L (each node's coupling with the next over its pivot) and 1/D.
    pub(super) fn factors(&self) -> (Array2<Complex64>, &Array2<Complex64>) {
        let mut lower = self.off.clone();
        lower.zip_mut_with(&self.inverse_pivot.slice(s![..self.off.nrows(), ..]), |l, p| *l *= p);
        (lower, &self.inverse_pivot)
    }

    /// Diagonal of A on a bubble.
    pub(crate) fn bubble(&self, cell: usize, bubble: usize, harmonic: usize) -> Complex64 {
        let h = self.heights[cell];
        self.kz2(cell, harmonic) * (h * self.element.lambda[bubble]) - 1.0 / h
    }

    /// Values on a plane from the unknowns: nodes as they are; inside a cell the mean solution and the bubbles.
    pub fn plane_values(&self, u: ArrayView2<Complex64>, plane: usize, out: &mut [Complex64]) {
        let degree = self.element.degree;
        let (cell, point) = (plane / degree, plane % degree);
        if point == 0 {
            return out.copy_from_slice(row(&u, plane));
        }
        let nodes = row(&u, degree * cell).iter().zip(row(&u, degree * (cell + 1)));
        let [left, right] = [point, degree - point].map(|q| self.left_share[q - 1].row(cell));
        for ((out, (a, b)), (l, r)) in out.iter_mut().zip(nodes).zip(left.iter().zip(right)) {
            *out = l * a + r * b;
        }
        for (i, bubble) in self.element.bubbles.iter().enumerate() {
            let value = bubble[point - 1];
            out.iter_mut().zip(row(&u, degree * cell + 1 + i)).for_each(|(out, b)| *out += value * b);
        }
    }

    /// Loads y_p on planes → right-hand sides of nodes and bubbles, in place (transpose of the plane values).
    pub fn load(&self, y: &mut Array2<Complex64>) {
        let degree = self.element.degree;
        for cell in (0..self.heights.len()).filter(|_| degree > 1) {
            let (mut before, mut rest) = y.view_mut().split_at(Axis(0), degree * cell + 1);
            let (mut inner, mut after) = rest.view_mut().split_at(Axis(0), degree - 1);
            let mut previous = before.row_mut(degree * cell);
            let mut next = after.row_mut(0);
            for point in 1..degree {
                let [left, right] = [point, degree - point].map(|q| self.left_share[q - 1].row(cell));
                let loads = inner.row(point - 1);
                ndarray::Zip::from(&mut previous).and(left).and(loads).for_each(|n, &w, &y| *n += w * y);
                ndarray::Zip::from(&mut next).and(right).and(loads).for_each(|n, &w, &y| *n += w * y);
            }
            self.loads_to_bubbles(&mut inner);
        }
    }

    fn loads_to_bubbles(&self, inner: &mut ArrayViewMut2<Complex64>) {
        let count = self.element.degree - 1;
        for mut column in inner.columns_mut() {
            let mut loads = [Complex64::default(); MAX_DEGREE];
            (0..count).for_each(|q| loads[q] = column[q]);
            for (i, bubble) in self.element.bubbles.iter().enumerate() {
                column[i] = bubble.iter().zip(&loads).map(|(b, y)| b * y).sum();
            }
        }
    }

    /// A⁻¹ applied in place to rows of nodes and bubbles; to loads on planes see [`super::scattering`].
    pub fn solve(&self, y: &mut Array2<Complex64>) {
        y.axis_chunks_iter_mut(Axis(1), BLOCK).into_par_iter().enumerate().for_each(|(b, mut block)| {
            let first = b * BLOCK;
            self.solve_nodes(&mut block, first);
            self.solve_bubbles(&mut block, first);
        });
    }

    fn solve_nodes(&self, y: &mut ArrayViewMut2<Complex64>, first: usize) {
        let (width, cells, stride) = (y.ncols(), self.heights.len(), self.element.degree);
        let columns = s![.., first..first + width];
        let (off, pivot) = (self.off.slice(columns), self.inverse_pivot.slice(columns));
        y.row_mut(0).zip_mut_with(&pivot.row(0), |y, p| *y *= p); // y_0 ← y_0 / d_0
        for j in 1..=cells {
            let (before, here) = y.multi_slice_mut((s![stride * (j - 1), ..], s![stride * j, ..]));
            let step = ndarray::Zip::from(here).and(before).and(off.row(j - 1)).and(pivot.row(j));
            step.for_each(|y, &mut b, &o, &p| *y = (*y - o * b) * p); // y_j ← (y_j − o y_{j−1}) / d_j
        }
        for j in (0..cells).rev() {
            let (here, after) = y.multi_slice_mut((s![stride * j, ..], s![stride * (j + 1), ..]));
            let step = ndarray::Zip::from(here).and(after).and(off.row(j)).and(pivot.row(j));
            step.for_each(|y, &mut a, &o, &p| *y -= o * a * p); // x_j = y_j − o x_{j+1} / d_j
        }
    }

    fn solve_bubbles(&self, y: &mut ArrayViewMut2<Complex64>, first: usize) {
        let degree = self.element.degree;
        for cell in 0..self.heights.len() {
            for bubble in 0..degree - 1 {
                for (i, value) in y.row_mut(degree * cell + 1 + bubble).iter_mut().enumerate() {
                    *value /= self.bubble(cell, bubble, first + i);
                }
            }
        }
    }

    /// A u, from the coefficients themselves; `kappa` as in [`MeanOperator::new`], or zeros for the interior part.
    pub fn apply(&self, u: &Array2<Complex64>, kappa: [&[Complex64]; 2]) -> Array2<Complex64> {
        let mut out = Array2::zeros(u.dim());
        let columns = u.axis_iter(Axis(1)).into_par_iter().zip(out.axis_iter_mut(Axis(1)));
        columns.enumerate().for_each(|(i, (u, mut out))| {
            self.apply_ends(kappa.map(|k| Complex64::I * k[i]), &u, &mut out);
            (0..self.heights.len()).for_each(|j| self.apply_cell(j, i, &u, &mut out));
        });
        out
    }

    /// out ← out + iκ u on both faces, in one harmonic; `ends` are iκ of the half-spaces.
    #[inline]
    fn apply_ends(
        &self,
        ends: [Complex64; 2],
        u: &ArrayView1<Complex64>,
        out: &mut ArrayViewMut1<Complex64>,
    ) {
        let last = self.element.degree * self.heights.len();
        out[0] += ends[0] * u[0];
        out[last] += ends[1] * u[last];
    }

    /// out ← out + A u of cell j in harmonic i.
    #[inline]
    fn apply_cell(&self, j: usize, i: usize, u: &ArrayView1<Complex64>, out: &mut ArrayViewMut1<Complex64>) {
        let stride = self.element.degree;
        let (own, off) = (self.diagonal[[j, i]], self.off[[j, i]]);
        let (a, b) = (u[stride * j], u[stride * (j + 1)]);
        out[stride * j] += own * a + off * b; // −o cos(kz h) u_j + o u_{j+1}
        out[stride * (j + 1)] += own * b + off * a; // o u_j − o cos(kz h) u_{j+1}
        for bubble in 0..stride - 1 {
            let row = stride * j + 1 + bubble;
            out[row] += self.bubble(j, bubble, i) * u[row]; // (kz² h λ − 1/h) b
        }
    }

    /// k̄² of each cell.
    pub fn mean_k2(&self) -> &[Complex64] {
        &self.mean_k2
    }

    /// Largest Im k̄² of any cell.
    pub fn mean_absorption(&self) -> f64 {
        self.mean_k2.iter().map(|k2| k2.im).fold(0.0, f64::max)
    }

    /// True when k̄² is real, as relaxation needs it.
    pub fn is_real(&self) -> bool {
        self.mean_absorption() == 0.0
    }

    /// Diagonal and off-diagonal of one harmonic's node system; `ends` are iκ of the half-spaces.
    pub fn node_matrix(&self, harmonic: usize, ends: [Complex64; 2]) -> (Vec<Complex64>, Vec<Complex64>) {
        let cells = self.heights.len();
        let mut diagonal = vec![Complex64::default(); cells + 1];
        (diagonal[0], diagonal[cells]) = (ends[0], ends[1]);
        let mut off = Vec::with_capacity(cells);
        for j in 0..cells {
            diagonal[j] += self.diagonal[[j, harmonic]];
            diagonal[j + 1] += self.diagonal[[j, harmonic]];
            off.push(self.off[[j, harmonic]]);
        }
        (diagonal, off)
    }

    /// Lumped mass of each node: half of both cells it touches.
    pub fn node_mass(&self) -> Vec<f64> {
        let h = |j: usize| self.heights.get(j).copied().unwrap_or(0.0);
        (0..=self.heights.len()).map(|j| 0.5 * (h(j) + if j > 0 { h(j - 1) } else { 0.0 })).collect()
    }

    /// Values on all planes of the mean solution through given node values.
    pub fn profile_on_planes(&self, harmonic: usize, nodes: &[f64]) -> Vec<Complex64> {
        let last = self.element.degree * self.heights.len();
        (0..=last).map(|plane| self.profile_on_plane(harmonic, nodes, plane)).collect()
    }

    /// Value on one plane of the mean solution through given node values.
    #[inline]
    fn profile_on_plane(&self, harmonic: usize, nodes: &[f64], plane: usize) -> Complex64 {
        let degree = self.element.degree;
        let (cell, point) = (plane / degree, plane % degree);
        if point == 0 {
            return nodes[cell].into();
        }
        let [left, right] = [point, degree - point].map(|q| self.left_share[q - 1][[cell, harmonic]]);
        left * nodes[cell] + right * nodes[cell + 1]
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let shares = self.left_share.iter().map(|s| s.len()).sum::<usize>();
        (2 * self.off.len() + self.inverse_pivot.len() + shares) * size_of::<Complex64>()
    }
}

/// Off-diagonal, diagonal and left shares of one cell, a table each, at every harmonic's kx² + ky².
#[inline]
fn tabulate(
    lateral_k2: &[f64],
    factors: impl Fn(f64) -> (NodeCoefficients, [Complex64; MAX_DEGREE]),
    tables: &mut [ArrayViewMut1<Complex64>],
) {
    for (i, &q) in lateral_k2.iter().enumerate() {
        let (node, shares) = factors(q);
        let values = [node.off, node.diagonal].into_iter().chain(shares);
        tables.iter_mut().zip(values).for_each(|(table, value)| table[i] = value);
    }
}

fn row<'a>(u: &'a ArrayView2<Complex64>, index: usize) -> &'a [Complex64] {
    u.row(index).to_slice().expect("rows are contiguous")
}

/// 1/pivot; a pivot that vanishes (a guided mode exactly on the grid) is moved by a part in 10¹² of its row.
pub(crate) fn guarded_inverse(pivot: Complex64, scale: Complex64) -> Complex64 {
    let least = 1e-12 * scale.norm().max(1e-300);
    if pivot.norm() < least { Complex64::from(1.0 / least) } else { 1.0 / pivot }
}

#[cfg(test)]
#[path = "mean_tests.rs"]
mod tests;
