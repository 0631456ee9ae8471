//! One cell on the harmonics solved exactly: its inner points are eliminated, which leaves a
//! coupling of its two nodes.
//!
//! With the values v at the inner points, the shares S of the nodes in them, the bubbles'
//! stiffness K and the contrast T at the points: (K + T) v = K (S x + y), where y are the values of
//! the right-hand side's bubbles. The nodes get the loads SᵀTv = SᵀK(S x + y) − SᵀKv.

use crate::numerics::fourier::narrow;
use crate::wave::Problem;
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Accum, ColMut, ColRef, Mat, Par, c32};
use ndarray::Array2;
use num_complex::Complex64;

/// A cell with its inner points eliminated; vectors list the harmonics of one point after another.
pub(super) struct CoarseCell {
    /// Number of harmonics.
    count: usize,
    /// Inverse of K + T.
    inverse: Mat<c32>,
    /// K: point → point → harmonics.
    stiffness: Vec<Vec<Vec<c32>>>,
    /// S of the first and of the second node, and the products K S.
    shares: [Vec<c32>; 2],
    loads: [Vec<c32>; 2],
}

impl CoarseCell {
    /// Eliminates the inner points of cell number `cell`.
    pub fn new(problem: &Problem, columns: &[usize], cell: usize) -> Self {
        let (inner, count) = (problem.mean.element.degree - 1, columns.len());
        let stiffness = stiffness(problem, columns, cell);
        let mut matrix = Mat::<c32>::zeros(inner * count, inner * count);
        for p in 0..inner {
            let plane = problem.mean.element.degree * cell + 1 + p;
            let mut own = matrix.as_mut().submatrix_mut(p * count, p * count, count, count);
            own.copy_from(contrast_matrix(problem, columns, plane));
            for (q, row) in stiffness[p].iter().enumerate() {
                row.iter().enumerate().for_each(|(g, k)| matrix[(p * count + g, q * count + g)] += k);
            }
        }
        let left: Vec<Vec<c32>> =
            problem.mean.inverse.left_share.iter().map(|table| chosen(table, cell, columns)).collect();
        let shares = [left.concat(), left.into_iter().rev().collect::<Vec<_>>().concat()];
        let loads = shares.each_ref().map(|share| stiff(&stiffness, share));
        Self { count, inverse: matrix.partial_piv_lu().inverse(), stiffness, shares, loads }
    }

    /// Number of complex numbers held.
    pub fn entries(&self) -> usize {
        let inner = self.stiffness.len();
        self.inverse.nrows().pow(2) + (inner + 4) * self.shares[0].len()
    }

    /// Coupling SᵀTS of two of its nodes (0: first, 1: second) by the contrast, without inner
    /// points.
    pub fn coupling(&self, [a, b]: [usize; 2]) -> Mat<c32> {
        let (points, count) = (self.stiffness.len(), self.count);
        let [left, right] = [&self.loads[a], &self.loads[b]];
        let through = |g: usize, h: usize| {
            let pairs = (0..points * points).map(|k| (k / points * count + g, k % points * count + h));
            pairs.map(|(r, c)| left[r] * self.inverse[(r, c)] * right[c]).sum::<c32>()
        };
        let mut coupling = Mat::from_fn(count, count, |g, h| -through(g, h));
        let direct = self.shares[a].iter().zip(right).map(|(share, load)| share * load).enumerate();
        direct.for_each(|(r, own)| coupling[(r % count, r % count)] += own);
        coupling
    }

    /// Subtracts from the nodes what the values `y` of bubbles load them with; returns the values
    /// at the inner points that they cause at nodes of zero.
    pub fn condense(&self, y: &[c32], nodes: [&mut Vec<c32>; 2]) -> Vec<c32> {
        let load = stiff(&self.stiffness, y);
        let values = self.inverted(&load);
        for (side, node) in nodes.into_iter().enumerate() {
            let [share, own] = [&self.shares[side], &self.loads[side]];
            for r in 0..load.len() {
                node[r % self.count] -= share[r] * load[r] - own[r] * values[r];
            }
        }
        values
    }

    /// The bubbles' part of the values at the inner points, from those of [`Self::condense`] and
    /// from the nodes.
    pub fn expanded(&self, mut values: Vec<c32>, nodes: [&[c32]; 2]) -> Vec<c32> {
        let of = |table: &[Vec<c32>; 2], r: usize| {
            table[0][r] * nodes[0][r % self.count] + table[1][r] * nodes[1][r % self.count]
        };
        let load: Vec<c32> = (0..values.len()).map(|r| of(&self.loads, r)).collect();
        add_product(&mut values, 1.0, &self.inverse, &load);
        values.iter_mut().enumerate().for_each(|(r, v)| *v -= of(&self.shares, r));
        values
    }

    fn inverted(&self, right: &[c32]) -> Vec<c32> {
        let mut out = vec![c32::default(); right.len()];
        add_product(&mut out, 1.0, &self.inverse, right);
        out
    }
}

/// Adds out ← out + factor · matrix · v.
pub(super) fn add_product(out: &mut [c32], factor: f32, matrix: &Mat<c32>, v: &[c32]) {
    let (out, v) = (ColMut::from_slice_mut(out), ColRef::from_slice(v));
    matmul(out.as_mat_mut(), Accum::Add, matrix, v.as_mat(), factor.into(), Par::Seq);
}

/// The contrast of one plane between harmonics: Fourier coefficients of W at their differences.
pub(super) fn contrast_matrix(problem: &Problem, columns: &[usize], plane: usize) -> Mat<c32> {
    let spectrum = problem.contrast_spectrum(plane).mapv(narrow::<f32>);
    let (nx, ny) = spectrum.dim();
    Mat::from_fn(columns.len(), columns.len(), |g, h| {
        let [[a, b], [c, d]] = [g, h].map(|i| problem.harmonics.orders[columns[i]]);
        spectrum[[(a - c).rem_euclid(nx as i32) as usize, (b - d).rem_euclid(ny as i32) as usize]]
    })
}

/// The bubbles' part of A between values at the inner points of a cell, diagonal in the harmonics.
fn stiffness(problem: &Problem, columns: &[usize], cell: usize) -> Vec<Vec<Vec<c32>>> {
    let amplitudes = &problem.mean.element.amplitudes;
    let points = amplitudes.len();
    let mut sums = vec![vec![vec![Complex64::ZERO; columns.len()]; points]; points];
    for (i, own) in amplitudes.iter().enumerate() {
        for (g, &column) in columns.iter().enumerate() {
            let bubble = problem.mean.bubble(cell, i, column);
            for (p, q) in (0..points * points).map(|k| (k / points, k % points)) {
                sums[p][q][g] += bubble * own[p] * own[q];
            }
        }
    }
    sums.iter().map(|row| row.iter().map(|own| own.iter().map(|&z| narrow(z)).collect()).collect()).collect()
}

/// The chosen columns of one row of a table.
fn chosen(table: &Array2<Complex64>, row: usize, columns: &[usize]) -> Vec<c32> {
    columns.iter().map(|&i| narrow(table[[row, i]])).collect()
}

/// K v.
fn stiff(stiffness: &[Vec<Vec<c32>>], v: &[c32]) -> Vec<c32> {
    let count = (v.len() / stiffness.len().max(1)).max(1);
    let entry = |r: usize| {
        let terms = stiffness[r / count].iter().zip(v.chunks(count));
        terms.map(|(k, v)| k[r % count] * v[r % count]).sum()
    };
    (0..v.len()).map(entry).collect()
}
