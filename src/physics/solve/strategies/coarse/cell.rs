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
use crate::numerics::fourier::{Real, narrow};
use crate::wave::Problem;
use faer::{ColMut, ColRef, Mat};
use ndarray::Array2;
use num_complex::{Complex, Complex64};

/// Of points and points: something for each of the harmonics, or between them.
type Blocks<T> = Vec<Vec<T>>;

/// A cell with its inner points eliminated; vectors list the harmonics of one point after another.
pub(super) struct CoarseCell<T: Real> {
    /// Number of harmonics.
    count: usize,
    /// P of each inner point.
    pivots: Vec<Mat<Complex<T>>>,
    /// K.
    stiffness: Blocks<Vec<Complex<T>>>,
    /// S of the first and of the second node, and the products K S.
    shares: [Vec<Complex<T>>; 2],
    loads: [Vec<Complex<T>>; 2],
}

impl<T: Real> CoarseCell<T>
where
    Complex<T>: MatrixEntry,
{
    /// Eliminates the inner points of cell number `cell`; also the couplings SᵀTS of its nodes
    /// (0: first, 1: second) by the contrast: of the first with itself, 0 with 1, 1 with 0, 1 with
    /// itself.
    pub fn new(problem: &Problem, columns: &[usize], cell: usize) -> (Self, [Mat<Complex<T>>; 4]) {
        let stiffness = stiffness(problem, columns, cell);
        let contrast =
            |k: usize| contrast_matrix(problem, columns, problem.mean.element.degree * cell + 1 + k);
        let (pivots, inverse) = bordered(&stiffness, contrast);
        let chosen = |table: &Array2<Complex64>| columns.iter().map(|&i| narrow(table[[cell, i]])).collect();
        let left: Vec<Vec<Complex<T>>> = problem.mean.inverse.left_share.iter().map(chosen).collect();
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
    fn coupling(&self, inverse: &Blocks<Mat<Complex<T>>>, [a, b]: [usize; 2]) -> Mat<Complex<T>> {
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
    pub fn bubbles(&self, y: &[Complex<T>]) -> [Vec<Complex<T>>; 2] {
        self.caused(stiff(&self.stiffness, y))
    }

    /// Values at the inner points that one of the nodes causes, and its loads on them.
    pub fn reached(&self, side: usize, node: &[Complex<T>]) -> [Vec<Complex<T>>; 2] {
        let loads = self.loads[side].chunks(self.count);
        self.caused(loads.flat_map(|load| load.iter().zip(node).map(|(l, x)| l * x)).collect())
    }

    fn caused(&self, load: Vec<Complex<T>>) -> [Vec<Complex<T>>; 2] {
        let mut values = load.clone();
        self.solve(self.pivots.len(), &mut values);
        [values, load]
    }

    /// Subtracts from one of the nodes what values at the inner points, and the loads that cause
    /// them, load it with.
    pub fn unload(&self, side: usize, [values, load]: &[Vec<Complex<T>>; 2], node: &mut [Complex<T>]) {
        let share = &self.shares[side];
        let loads = &self.loads[side];
        for r in 0..load.len() {
            node[r % self.count] -= share[r] * load[r] - loads[r] * values[r];
        }
    }

    /// The bubbles' part of the values at the inner points, from those of [`Self::bubbles`] and
    /// from the nodes.
    pub fn expanded(&self, mut values: Vec<Complex<T>>, nodes: [&[Complex<T>]; 2]) -> Vec<Complex<T>> {
        let from_nodes = |table: &[Vec<Complex<T>>; 2], r: usize| {
            table[0][r] * nodes[0][r % self.count] + table[1][r] * nodes[1][r % self.count]
        };
        let [reached, _] = self.caused((0..values.len()).map(|r| from_nodes(&self.loads, r)).collect());
        let rows = values.iter_mut().zip(reached).enumerate();
        rows.for_each(|(r, (v, more))| *v += more - from_nodes(&self.shares, r));
        values
    }

    /// v ← G v on the first `points` points.
    fn solve(&self, points: usize, v: &mut [Complex<T>]) {
        let Some(k) = points.checked_sub(1) else { return };
        let (before, last) = v.split_at_mut(k * self.count);
        self.solve(k, before);
        let rows = before.chunks(self.count).zip(&self.stiffness[k]);
        rows.for_each(|(v, stiff)| (0..self.count).for_each(|g| last[g] -= stiff[g] * v[g]));
        let mut value = vec![Complex::default(); self.count];
        add_product(&mut value, &self.pivots[k], last);
        let mut change: Vec<Complex<T>> =
            self.stiffness[k][..k].iter().flat_map(|stiff| product(stiff, &value)).collect();
        self.solve(k, &mut change);
        before.iter_mut().zip(change).for_each(|(v, change)| *v -= change);
        last.copy_from_slice(&value);
    }
}

/// P of each inner point, and the inverse of K + T by blocks.
fn bordered<T: Real>(
    stiffness: &Blocks<Vec<Complex<T>>>,
    contrast: impl Fn(usize) -> Mat<Complex<T>>,
) -> (Vec<Mat<Complex<T>>>, Blocks<Mat<Complex<T>>>)
where
    Complex<T>: MatrixEntry,
{
    let mut pivots = Vec::new();
    let mut inverse = Blocks::<Mat<Complex<T>>>::new();
    for (k, stiff) in stiffness.iter().enumerate() {
        let diagonal = |p: usize| ColRef::from_slice(&stiff[p]).as_diagonal();
        let mut rest = contrast(k);
        let size = rest.nrows();
        let mut sides = Vec::with_capacity(k);
        for p in 0..k {
            // G K_·k and K_k· G
            let mut column = Mat::<Complex<T>>::zeros(size, size);
            let mut row = Mat::<Complex<T>>::zeros(size, size);
            for q in 0..k {
                column += &inverse[p][q] * diagonal(q);
                row += diagonal(q) * &inverse[q][p];
            }
            rest -= diagonal(p) * &column;
            sides.push((column, row));
        }
        rest.diagonal_mut().column_vector_mut().iter_mut().zip(&stiff[k]).for_each(|(d, k)| *d += k);
        let pivot = Complex::inverse(rest.as_ref());
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

/// Adds out ← out + matrix · v.
pub(super) fn add_product<T: Real>(out: &mut [Complex<T>], matrix: &Mat<Complex<T>>, v: &[Complex<T>])
where
    Complex<T>: MatrixEntry,
{
    let out = ColMut::from_slice_mut(out);
    let v = ColRef::from_slice(v);
    Complex::add_product(out.as_mat_mut(), narrow(Complex64::ONE), matrix.as_ref(), v.as_mat());
}

/// The contrast of one plane between harmonics: Fourier coefficients of W at their differences.
pub(super) fn contrast_matrix<T: Real>(
    problem: &Problem,
    columns: &[usize],
    plane: usize,
) -> Mat<Complex<T>> {
    let spectrum = problem.contrast_spectrum(plane).mapv(narrow::<T>);
    let (nx, ny) = spectrum.dim();
    let order = |i: usize| problem.harmonics.orders[columns[i]];
    Mat::from_fn(columns.len(), columns.len(), |g, h| {
        let [a, b] = order(g);
        let [c, d] = order(h);
        spectrum[[(a - c).rem_euclid(nx as i32) as usize, (b - d).rem_euclid(ny as i32) as usize]]
    })
}

/// The bubbles' part of A between values at the inner points of a cell, diagonal in the harmonics.
fn stiffness<T: Real>(problem: &Problem, columns: &[usize], cell: usize) -> Blocks<Vec<Complex<T>>> {
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
pub(super) fn product<T: Real>(a: &[Complex<T>], b: &[Complex<T>]) -> Vec<Complex<T>> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// K v.
fn stiff<T: Real>(stiffness: &Blocks<Vec<Complex<T>>>, v: &[Complex<T>]) -> Vec<Complex<T>> {
    let count = (v.len() / stiffness.len().max(1)).max(1);
    let entries = (0..v.len()).map(|r| {
        stiffness[r / count].iter().zip(v.chunks(count)).map(|(k, v)| k[r % count] * v[r % count]).sum()
    });
    entries.collect()
}
