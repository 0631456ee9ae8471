//! The mean operator A: Δ + k̄² with the half-spaces' exact conditions, one tridiagonal system per
//! harmonic.
//!
//! See [`super::cell`] for the coefficients of each cell. Rows of a field: node j is row `degree ·
//! j`, followed by the cell's bubbles; columns are harmonics.

use super::cell::{cell_factors, increments};
use super::inverse::{MeanInverse, row_of};
use super::sharing::tabulated;
use crate::wave::{Element, Field, Grid, Scheme};
use ndarray::{Array2, s};
use num_complex::Complex64;
use std::sync::Arc;

/// The operator A, factorised: rows of the arrays are cells or nodes, columns harmonics.
pub struct MeanOperator {
    pub(crate) scheme: Scheme,
    pub(crate) element: Element,
    pub(crate) heights: Vec<f64>,
    /// Mean k̄² of each cell, 1/µm².
    pub mean_k2: Vec<Complex64>,
    /// Squared lateral wavenumber kx² + ky² of each harmonic, 1/µm².
    lateral_k2: Vec<f64>,
    off: Array2<Complex64>,
    /// Contribution of a cell to the diagonals of both its nodes.
    diagonal: Array2<Complex64>,
    /// Inverse A⁻¹, shared with the tables of A⁻¹V.
    pub inverse: Arc<MeanInverse>,
}

impl MeanOperator {
    /// Factorises the operator; `kappa` are the normal wavenumbers of the half-spaces (incident
    /// side, exit side) for each harmonic.
    pub fn new(grid: &Grid, mean_k2: Vec<Complex64>, lateral_k2: Vec<f64>, kappa: [&[Complex64]; 2]) -> Self {
        let heights: Vec<f64> = (0..grid.cells()).map(|j| grid.height_um(j)).collect();
        let scheme = grid.resolution.scheme;
        let element = grid.element.clone();
        let shape = (heights.len(), lateral_k2.len());
        let count = element.degree - 1;
        let points = &element.points[1..=count];
        let kz2 = |j: usize, i: usize| mean_k2[j] - lateral_k2[i];
        let exponents = |j: usize, i: usize| increments(kz2(j, i), heights[j], points);
        let mut tables = tabulated(shape, 2 + count, exponents, |j, i, waves| {
            let (node, [a, b, c, d]) = cell_factors(kz2(j, i), heights[j], points, scheme, waves);
            [node.off, node.diagonal, a, b, c, d]
        });
        let left_share = tables.split_off(2);
        let [off, diagonal] = tables.try_into().expect("two tables are left");
        let ends = kappa.map(|kappa| kappa.iter().map(|k| Complex64::I * k).collect());
        let inverse_pivot = inverse_pivots(&off, &diagonal, ends);
        let factor = &off * &inverse_pivot.slice(s![..shape.0, ..]);
        let mut inverse_bubble = Array2::zeros((heights.len() * count, shape.1));
        for (row, mut inverse) in inverse_bubble.outer_iter_mut().enumerate() {
            let cell = row / count;
            let lambda = element.lambda[row % count];
            let entry = |q: f64| 1.0 / bubble_entry(mean_k2[cell] - q, heights[cell], lambda);
            inverse.iter_mut().zip(&lateral_k2).for_each(|(inverse, &q)| *inverse = entry(q));
        }
        let bubbles = element.bubbles.clone();
        let inverse = MeanInverse { bubbles, left_share, factor, inverse_pivot, inverse_bubble }.into();
        MeanOperator { scheme, element, heights, mean_k2, lateral_k2, off, diagonal, inverse }
    }

    pub(crate) fn kz2(&self, cell: usize, harmonic: usize) -> Complex64 {
        self.mean_k2[cell] - self.lateral_k2[harmonic]
    }

    /// Diagonal entry of A for a bubble.
    pub(crate) fn bubble(&self, cell: usize, bubble: usize, harmonic: usize) -> Complex64 {
        bubble_entry(self.kz2(cell, harmonic), self.heights[cell], self.element.lambda[bubble])
    }

    /// Adds out ← out + A u, from the coefficients themselves; `kappa` as in
    /// [`MeanOperator::new`], `None` for the interior part.
    pub fn add_product(&self, u: &Field, kappa: Option<[&[Complex64]; 2]>, out: &mut Field) {
        let faces = [0, self.element.degree * self.heights.len()];
        for (kappa, face) in kappa.into_iter().flatten().zip(faces) {
            let values = out.row_mut(face).into_iter().zip(u.row(face)).zip(kappa);
            values.for_each(|((out, u), k)| *out += Complex64::I * k * u); // iκ u
        }
        for j in 0..self.heights.len() {
            self.add_cell(j, u, out);
        }
    }

    /// Adds out ← out + A u of cell j.
    pub(super) fn add_cell(&self, j: usize, u: &Field, out: &mut Field) {
        let first = self.element.degree * j;
        let last = first + self.element.degree;
        let diagonal = row_of(&self.diagonal, j);
        let off = row_of(&self.off, j);
        for (from, to) in [(first, last), (last, first)] {
            let values = out.row_mut(from).into_iter().zip(row_of(u, from)).zip(row_of(u, to));
            // o u_{j±1} − o cos(kz h) u_j
            let entries = diagonal.iter().zip(off);
            values.zip(entries).for_each(|(((out, a), b), (d, o))| *out += d * a + o * b);
        }
        for row in first + 1..last {
            let values = out.row_mut(row).into_iter().zip(row_of(u, row)).enumerate();
            // (kz² h λ − 1/h) b
            values.for_each(|(i, (out, u))| *out += self.bubble(j, row - first - 1, i) * u);
        }
    }

    /// Largest Im k̄² of any cell, 1/µm².
    pub fn mean_absorption(&self) -> f64 {
        self.mean_k2.iter().map(|k2| k2.im).fold(0.0, f64::max)
    }

    /// Diagonal and off-diagonal of one harmonic's node system; `ends` are iκ of the half-spaces.
    pub fn node_matrix(&self, harmonic: usize, ends: [Complex64; 2]) -> (Vec<Complex64>, Vec<Complex64>) {
        let cells = self.heights.len();
        let mut diagonal = vec![Complex64::default(); cells + 1];
        diagonal[0] = ends[0];
        diagonal[cells] = ends[1];
        for (j, entry) in self.diagonal.column(harmonic).iter().enumerate() {
            diagonal[j] += entry;
            diagonal[j + 1] += entry;
        }
        (diagonal, self.off.column(harmonic).to_vec())
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
        let [left, right] = [point, degree - point].map(|q| self.inverse.left_share[q - 1][[cell, harmonic]]);
        left * nodes[cell] + right * nodes[cell + 1]
    }

    /// Memory held without the inverse, bytes.
    pub fn bytes(&self) -> usize {
        2 * self.off.len() * size_of::<Complex64>()
    }
}

/// Diagonal entry kz² h λ − 1/h of A for a bubble.
fn bubble_entry(kz2: Complex64, h: f64, lambda: f64) -> Complex64 {
    kz2 * (h * lambda) - 1.0 / h
}

/// Reciprocal pivots of the nodes' tridiagonal systems, all harmonics together: from the coupling
/// of each cell's nodes and its contribution to both diagonals (cells × harmonics); `left` and
/// `right` are added to the first and the last diagonal entry.
pub(in crate::wave) fn inverse_pivots(
    off: &Array2<Complex64>,
    diagonal: &Array2<Complex64>,
    [mut left, right]: [Vec<Complex64>; 2],
) -> Array2<Complex64> {
    let (last, harmonics) = off.dim();
    let mut inverse = Array2::zeros((last + 1, harmonics));
    for j in 0..last {
        for i in 0..harmonics {
            let o = off[[j, i]];
            let entry = diagonal[[j, i]];
            let pivot = guarded_inverse(left[i] + entry, o); // 1/d_j
            left[i] = entry - o * o * pivot; // diagonal of the next node minus o²/d_j
            inverse[[j, i]] = pivot;
        }
    }
    for (i, pivot) in inverse.row_mut(last).iter_mut().enumerate() {
        *pivot = guarded_inverse(left[i] + right[i], off[[last - 1, i]]);
    }
    inverse
}

/// Reciprocal pivot; a vanishing pivot (a guided mode exactly on the grid) is shifted by a part in
/// 10¹² of its row. Squares: moduli would cost more than the division.
fn guarded_inverse(pivot: Complex64, scale: Complex64) -> Complex64 {
    let least = 1e-24 * scale.norm_sqr().max(1e-280);
    if pivot.norm_sqr() < least { Complex64::from(1.0 / least.sqrt()) } else { 1.0 / pivot }
}

#[cfg(test)]
#[path = "mean_tests.rs"]
mod tests;
