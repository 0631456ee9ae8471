//! One cell on the harmonics solved exactly: its inner points are eliminated, which leaves a
//! coupling of its two nodes.
//!
//! With the values v at the inner points, the shares S of the nodes in them, the bubbles'
//! stiffness K and the contrast T at the points: (K + T) v = K (S x + y), where y are the values of
//! the right-hand side's bubbles. The nodes get the loads SᵀTv = SᵀK(S x + y) − SᵀKv.
//!
//! K is diagonal in the harmonics and T in the points. So the inverse G of K + T grows point by
//! point out of one dense matrix each, P = (K_kk + T_k − K_k· G K_·k)⁻¹ with G of the points
//! before; only these are kept.

use crate::numerics::dense::MatrixEntry;
use crate::numerics::fourier::narrow;
use crate::wave::Problem;
use faer::{ColMut, ColRef, Mat, c32};
use ndarray::Array2;
use num_complex::Complex64;

/// Of points and points: something for each of the harmonics, or between them.
type Blocks<T> = Vec<Vec<T>>;

/// A cell with its inner points eliminated; vectors list the harmonics of one point after another.
pub(super) struct CoarseCell {
    /// Number of harmonics.
    count: usize,
    /// P of each inner point.
    pivots: Vec<Mat<c32>>,
    /// K.
    stiffness: Blocks<Vec<c32>>,
    /// S of the first and of the second node, and the products K S.
    shares: [Vec<c32>; 2],
    loads: [Vec<c32>; 2],
}

impl CoarseCell {
    /// Eliminates the inner points of cell number `cell`; also the couplings SᵀTS of its nodes
    /// (0: first, 1: second) by the contrast: of the first with itself, 0 with 1, 1 with 0, 1 with
    /// itself.
    pub fn new(problem: &Problem, columns: &[usize], cell: usize) -> (Self, [Mat<c32>; 4]) {
        let stiffness = stiffness(problem, columns, cell);
        let contrast =
            |k: usize| contrast_matrix(problem, columns, problem.mean.element.degree * cell + 1 + k);
        let (pivots, inverse) = bordered(&stiffness, contrast);
        let chosen = |table: &Array2<Complex64>| columns.iter().map(|&i| narrow(table[[cell, i]])).collect();
        let left: Vec<Vec<c32>> = problem.mean.inverse.left_share.iter().map(chosen).collect();
        let shares = [left.concat(), left.into_iter().rev().collect::<Vec<_>>().concat()];
        let loads = shares.each_ref().map(|share| stiff(&stiffness, share));
        let eliminated = Self { count: columns.len(), pivots, stiffness, shares, loads };
        let couplings = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|sides| eliminated.coupling(&inverse, sides));
        (eliminated, couplings)
    }

    /// Number of complex numbers held.
    pub fn entries(&self) -> usize {
        let inner = self.stiffness.len();
        inner * self.count.pow(2) + (inner + 4) * self.shares[0].len()
    }

    /// Coupling of two of its nodes, given the inverse of K + T.
    fn coupling(&self, inverse: &Blocks<Mat<c32>>, [a, b]: [usize; 2]) -> Mat<c32> {
        let left = self.loads[a].chunks(self.count);
        let right = self.loads[b].chunks(self.count);
        let mut coupling = Mat::zeros(self.count, self.count);
        for (row, left) in inverse.iter().zip(left) {
            for (block, right) in row.iter().zip(right.clone()) {
                coupling -= Mat::from_fn(self.count, self.count, |g, h| left[g] * block[(g, h)] * right[h]);
            }
        }
        let direct = self.shares[a].iter().zip(&self.loads[b]).map(|(share, load)| share * load).enumerate();
        direct.for_each(|(r, value)| coupling[(r % self.count, r % self.count)] += value);
        coupling
    }

    /// Values at the inner points that the bubbles' values `y` cause at nodes of zero, and the
    /// loads Kᵀy, for [`Self::unload`].
    pub fn bubbles(&self, y: &[c32]) -> [Vec<c32>; 2] {
        self.caused(stiff(&self.stiffness, y))
    }

    /// Values at the inner points that one of the nodes causes, and its loads on them.
    pub fn reached(&self, side: usize, node: &[c32]) -> [Vec<c32>; 2] {
        let loads = self.loads[side].chunks(self.count);
        self.caused(loads.flat_map(|load| load.iter().zip(node).map(|(l, x)| l * x)).collect())
    }

    fn caused(&self, load: Vec<c32>) -> [Vec<c32>; 2] {
        let mut values = load.clone();
        self.solve(self.pivots.len(), &mut values);
        [values, load]
    }

    /// Subtracts from one of the nodes what values at the inner points, and the loads that cause
    /// them, load it with.
    pub fn unload(&self, side: usize, [values, load]: &[Vec<c32>; 2], node: &mut [c32]) {
        let share = &self.shares[side];
        let loads = &self.loads[side];
        for r in 0..load.len() {
            node[r % self.count] -= share[r] * load[r] - loads[r] * values[r];
        }
    }

    /// The bubbles' part of the values at the inner points, from those of [`Self::bubbles`] and
    /// from the nodes.
    pub fn expanded(&self, mut values: Vec<c32>, nodes: [&[c32]; 2]) -> Vec<c32> {
        let from_nodes = |table: &[Vec<c32>; 2], r: usize| {
            table[0][r] * nodes[0][r % self.count] + table[1][r] * nodes[1][r % self.count]
        };
        let [reached, _] = self.caused((0..values.len()).map(|r| from_nodes(&self.loads, r)).collect());
        let rows = values.iter_mut().zip(reached).enumerate();
        rows.for_each(|(r, (v, more))| *v += more - from_nodes(&self.shares, r));
        values
    }

    /// v ← G v on the first `points` points.
    fn solve(&self, points: usize, v: &mut [c32]) {
        let Some(k) = points.checked_sub(1) else { return };
        let (before, last) = v.split_at_mut(k * self.count);
        self.solve(k, before);
        let rows = before.chunks(self.count).zip(&self.stiffness[k]);
        rows.for_each(|(v, stiff)| (0..self.count).for_each(|g| last[g] -= stiff[g] * v[g]));
        let mut value = vec![c32::default(); self.count];
        add_product(&mut value, 1.0, &self.pivots[k], last);
        let mut change: Vec<c32> =
            self.stiffness[k][..k].iter().flat_map(|stiff| product(stiff, &value)).collect();
        self.solve(k, &mut change);
        before.iter_mut().zip(change).for_each(|(v, change)| *v -= change);
        last.copy_from_slice(&value);
    }
}

/// P of each inner point, and the inverse of K + T by blocks.
fn bordered(
    stiffness: &Blocks<Vec<c32>>,
    contrast: impl Fn(usize) -> Mat<c32>,
) -> (Vec<Mat<c32>>, Blocks<Mat<c32>>) {
    let mut pivots = Vec::new();
    let mut inverse = Blocks::<Mat<c32>>::new();
    for (k, stiff) in stiffness.iter().enumerate() {
        let diagonal = |p: usize| ColRef::from_slice(&stiff[p]).as_diagonal();
        let mut rest = contrast(k);
        let size = rest.nrows();
        let mut sides = Vec::with_capacity(k);
        for p in 0..k {
            // G K_·k and K_k· G
            let mut column = Mat::<c32>::zeros(size, size);
            let mut row = Mat::<c32>::zeros(size, size);
            for q in 0..k {
                column += &inverse[p][q] * diagonal(q);
                row += diagonal(q) * &inverse[q][p];
            }
            rest -= diagonal(p) * &column;
            sides.push((column, row));
        }
        rest.diagonal_mut().column_vector_mut().iter_mut().zip(&stiff[k]).for_each(|(d, k)| *d += k);
        let pivot = c32::inverse(rest.as_ref());
        for (p, (column, _)) in sides.iter().enumerate() {
            let up = column * &pivot;
            sides.iter().zip(&mut inverse[p]).for_each(|((_, row), block)| *block += &up * row);
            inverse[p].push(-up);
        }
        let last = sides.iter().map(|(_, row)| -(&pivot * row)).chain([pivot.clone()]);
        inverse.push(last.collect());
        pivots.push(pivot);
    }
    (pivots, inverse)
}

/// Adds out ← out + factor · matrix · v.
pub(super) fn add_product(out: &mut [c32], factor: f32, matrix: &Mat<c32>, v: &[c32]) {
    let out = ColMut::from_slice_mut(out);
    let v = ColRef::from_slice(v);
    c32::add_product(out.as_mat_mut(), factor.into(), matrix.as_ref(), v.as_mat());
}

/// The contrast of one plane between harmonics: Fourier coefficients of W at their differences.
pub(super) fn contrast_matrix(problem: &Problem, columns: &[usize], plane: usize) -> Mat<c32> {
    let spectrum = problem.contrast_spectrum(plane).mapv(narrow::<f32>);
    let (nx, ny) = spectrum.dim();
    let order = |i: usize| problem.harmonics.orders[columns[i]];
    Mat::from_fn(columns.len(), columns.len(), |g, h| {
        let [a, b] = order(g);
        let [c, d] = order(h);
        spectrum[[(a - c).rem_euclid(nx as i32) as usize, (b - d).rem_euclid(ny as i32) as usize]]
    })
}

/// The bubbles' part of A between values at the inner points of a cell, diagonal in the harmonics.
fn stiffness(problem: &Problem, columns: &[usize], cell: usize) -> Blocks<Vec<c32>> {
    let amplitudes = &problem.mean.element.amplitudes;
    let points = amplitudes.len();
    let mut sums = vec![vec![vec![Complex64::ZERO; columns.len()]; points]; points];
    for (i, factors) in amplitudes.iter().enumerate() {
        for (g, &column) in columns.iter().enumerate() {
            let bubble = problem.mean.bubble(cell, i, column);
            for (p, q) in (0..points * points).map(|k| (k / points, k % points)) {
                sums[p][q][g] += bubble * factors[p] * factors[q];
            }
        }
    }
    sums.iter()
        .map(|row| row.iter().map(|entries| entries.iter().map(|&z| narrow(z)).collect()).collect())
        .collect()
}

/// Products entry by entry.
pub(super) fn product(a: &[c32], b: &[c32]) -> Vec<c32> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// K v.
fn stiff(stiffness: &Blocks<Vec<c32>>, v: &[c32]) -> Vec<c32> {
    let count = (v.len() / stiffness.len().max(1)).max(1);
    let entries = (0..v.len()).map(|r| {
        stiffness[r / count].iter().zip(v.chunks(count)).map(|(k, v)| k[r % count] * v[r % count]).sum()
    });
    entries.collect()
}
