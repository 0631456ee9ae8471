//! The mean operator A: Δ + k̄² with the half-spaces' exact conditions, one tridiagonal system per harmonic.
//!
//! In a cell of height h with kz² = k̄² − kx² − ky² the exact difference scheme (Tikhonov–Samarskii) reads
//! o (U_{j+1} + U_{j−1}) − 2 o cos(kz h) U_j with o = kz / sin(kz h); P2 (3.5) has o = 1/h instead. Only decaying
//! exponentials occur, so strongly evanescent harmonics cannot overflow (the slip of P2 (2.10)).

use super::{Grid, Scheme};
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, s};
use num_complex::Complex64;
use rayon::prelude::*;

/// Harmonics treated together by one thread: a column of some 50 planes stays in the second-level cache.
const BLOCK: usize = 192;

/// Coefficients of one cell for one harmonic.
#[derive(Clone, Copy, Debug)]
pub struct CellCoefficients {
    /// Coupling of the two nodes.
    pub off: Complex64,
    /// The cell's share of each node's diagonal.
    pub diagonal: Complex64,
    /// Midpoint value of the mean medium's solutions over the sum of the nodes' values.
    pub beta: Complex64,
    /// Diagonal of the bubble 4t(1 − t).
    pub bubble: Complex64,
}

impl CellCoefficients {
    pub fn new(kz2: Complex64, h: f64, scheme: Scheme) -> CellCoefficients {
        let bubble = -(16.0 / (3.0 * h) - kz2 * (8.0 * h / 15.0));
        if scheme == Scheme::SecondDifference {
            let off = Complex64::from(1.0 / h);
            return CellCoefficients { off, diagonal: 0.5 * h * kz2 - off, beta: 0.5.into(), bubble };
        }
        let x2 = kz2 * (h * h);
        if x2.norm() < 2.5e-3 {
            return Self::series(x2, h, bubble);
        }
        let kz = decaying_root(kz2);
        let half = (Complex64::I * kz * (0.5 * h)).exp();
        let full = half * half;
        let denominator = full * full - 1.0;
        let off = 2.0 * Complex64::I * kz * full / denominator;
        let diagonal = -Complex64::I * kz * (full * full + 1.0) / denominator;
        CellCoefficients { off, diagonal, beta: half / (full + 1.0), bubble }
    }

    /// Taylor series in (kz h)²; the first term left out is below 1e-16 for |kz h| ≤ 0.05.
    fn series(x2: Complex64, h: f64, bubble: Complex64) -> CellCoefficients {
        let sinc = 1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0 * (1.0 - x2 / 72.0)));
        let cosine =
            |y2: Complex64| 1.0 - y2 / 2.0 * (1.0 - y2 / 12.0 * (1.0 - y2 / 30.0 * (1.0 - y2 / 56.0)));
        let off = 1.0 / (h * sinc);
        CellCoefficients { off, diagonal: -off * cosine(x2), beta: 0.5 / cosine(x2 / 4.0), bubble }
    }
}

/// √z with Im ≥ 0, so that e^{i√z s} decays or stays bounded for s > 0.
pub fn decaying_root(z: Complex64) -> Complex64 {
    let root = z.sqrt();
    if root.im < 0.0 { -root } else { root }
}

/// A, factorised: rows of all arrays are cells or nodes, columns harmonics.
pub struct MeanOperator {
    scheme: Scheme,
    heights: Vec<f64>,
    /// k̄² of each cell.
    mean_k2: Vec<Complex64>,
    /// kx² + ky² of each harmonic.
    lateral_k2: Vec<f64>,
    off: Array2<Complex64>,
    beta: Array2<Complex64>,
    inverse_pivot: Array2<Complex64>,
}

impl MeanOperator {
    /// `kappa` are the half-spaces' normal wavenumbers (above, below) of each harmonic.
    pub fn new(
        grid: &Grid,
        mean_k2: Vec<Complex64>,
        lateral_k2: Vec<f64>,
        kappa: [&[Complex64]; 2],
    ) -> MeanOperator {
        let heights: Vec<f64> = (0..grid.cells()).map(|j| grid.height_um(j)).collect();
        let shape = (heights.len(), lateral_k2.len());
        let scheme = grid.resolution.scheme;
        let (mut off, mut beta) = (Array2::zeros(shape), Array2::zeros(shape));
        let mut inverse_pivot = Array2::zeros((shape.0 + 1, shape.1));
        let columns = off.axis_iter_mut(Axis(1)).into_par_iter().zip(beta.axis_iter_mut(Axis(1)));
        let columns = columns.zip(inverse_pivot.axis_iter_mut(Axis(1)));
        columns.enumerate().with_min_len(BLOCK).for_each(|(i, ((mut off, mut beta), mut pivots))| {
            let ends = [kappa[0][i], kappa[1][i]].map(|k| Complex64::I * k);
            let mut diagonal = ends[0];
            for (j, &h) in heights.iter().enumerate() {
                let cell = CellCoefficients::new(mean_k2[j] - lateral_k2[i], h, scheme);
                let inverse = guarded_inverse(diagonal + cell.diagonal, cell.off);
                (off[j], beta[j], pivots[j]) = (cell.off, cell.beta, inverse);
                diagonal = cell.diagonal - cell.off * cell.off * inverse;
            }
            let last = heights.len();
            pivots[last] = guarded_inverse(diagonal + ends[1], off[last - 1]);
        });
        MeanOperator { scheme, heights, mean_k2, lateral_k2, off, beta, inverse_pivot }
    }

    /// Coefficients of one cell and harmonic, computed afresh.
    pub fn coefficients(&self, cell: usize, harmonic: usize) -> CellCoefficients {
        let kz2 = self.mean_k2[cell] - self.lateral_k2[harmonic];
        CellCoefficients::new(kz2, self.heights[cell], self.scheme)
    }

    fn bubble(&self, cell: usize, harmonic: usize) -> Complex64 {
        let h = self.heights[cell];
        (self.mean_k2[cell] - self.lateral_k2[harmonic]) * (8.0 * h / 15.0) - 16.0 / (3.0 * h)
    }

    fn has_bubbles(&self) -> bool {
        self.scheme == Scheme::Quadratic
    }

    /// Values on a plane from the unknowns: nodes as they are, midpoints β(U_{j−1} + U_j) + B_j.
    pub fn plane_values(&self, u: ArrayView2<Complex64>, plane: usize, out: &mut [Complex64]) {
        if !self.has_bubbles() || plane.is_multiple_of(2) {
            return out.copy_from_slice(row(&u, plane));
        }
        let nodes = row(&u, plane - 1).iter().zip(row(&u, plane + 1));
        let beta = self.beta.row(plane / 2);
        let inner = row(&u, plane).iter().zip(beta);
        for ((out, (a, b)), (bubble, beta)) in out.iter_mut().zip(nodes).zip(inner) {
            *out = beta * (a + b) + bubble;
        }
    }

    /// Loads y_p on planes → right-hand sides of nodes and bubbles, in place (adjoint of the plane values).
    fn load_block(&self, y: &mut ArrayViewMut2<Complex64>, first: usize) {
        if !self.has_bubbles() {
            return;
        }
        let width = y.ncols();
        for cell in 0..self.heights.len() {
            let (mut below, mut rest) = y.view_mut().split_at(Axis(0), 2 * cell + 1);
            let (middle, mut above) = rest.view_mut().split_at(Axis(0), 1);
            let beta = self.beta.slice(s![cell, first..first + width]);
            for i in 0..width {
                let share = beta[i] * middle[[0, i]];
                below[[2 * cell, i]] += share;
                above[[0, i]] += share;
            }
        }
    }

    /// Loads y_p on planes → right-hand sides of nodes and bubbles, in place.
    pub fn load(&self, y: &mut Array2<Complex64>) {
        self.load_block(&mut y.view_mut(), 0);
    }

    /// A⁻¹ applied in place; with `loads`, `y` holds loads on planes, otherwise rows of nodes and bubbles.
    pub fn solve(&self, y: &mut Array2<Complex64>, loads: bool) {
        y.axis_chunks_iter_mut(Axis(1), BLOCK).into_par_iter().enumerate().for_each(|(b, mut block)| {
            let first = b * BLOCK;
            if loads {
                self.load_block(&mut block, first);
            }
            self.solve_nodes(&mut block, first);
            self.solve_bubbles(&mut block, first);
        });
    }

    fn stride(&self) -> usize {
        if self.has_bubbles() { 2 } else { 1 }
    }

    fn solve_nodes(&self, y: &mut ArrayViewMut2<Complex64>, first: usize) {
        let (width, cells, stride) = (y.ncols(), self.heights.len(), self.stride());
        let columns = s![.., first..first + width];
        let (off, pivot) = (self.off.slice(columns), self.inverse_pivot.slice(columns));
        for j in 0..=cells {
            for i in 0..width {
                let coupled =
                    if j > 0 { off[[j - 1, i]] * y[[stride * (j - 1), i]] } else { Complex64::default() };
                y[[stride * j, i]] = (y[[stride * j, i]] - coupled) * pivot[[j, i]];
            }
        }
        for j in (0..cells).rev() {
            for i in 0..width {
                let coupled = off[[j, i]] * y[[stride * (j + 1), i]] * pivot[[j, i]];
                y[[stride * j, i]] -= coupled;
            }
        }
    }

    fn solve_bubbles(&self, y: &mut ArrayViewMut2<Complex64>, first: usize) {
        if !self.has_bubbles() {
            return;
        }
        for cell in 0..self.heights.len() {
            for (i, value) in y.row_mut(2 * cell + 1).iter_mut().enumerate() {
                *value /= self.bubble(cell, first + i);
            }
        }
    }

    /// A u, from the coefficients themselves; `kappa` as in [`MeanOperator::new`], or zeros for the interior part.
    pub fn apply(&self, u: &Array2<Complex64>, kappa: [&[Complex64]; 2]) -> Array2<Complex64> {
        let mut out = Array2::zeros(u.dim());
        let (cells, stride) = (self.heights.len(), self.stride());
        for (i, (u, mut out)) in u.axis_iter(Axis(1)).zip(out.axis_iter_mut(Axis(1))).enumerate() {
            out[0] += Complex64::I * kappa[0][i] * u[0];
            out[stride * cells] += Complex64::I * kappa[1][i] * u[stride * cells];
            for j in 0..cells {
                let cell = self.coefficients(j, i);
                let (a, b) = (u[stride * j], u[stride * (j + 1)]);
                out[stride * j] += cell.diagonal * a + cell.off * b;
                out[stride * (j + 1)] += cell.diagonal * b + cell.off * a;
                if self.has_bubbles() {
                    out[2 * j + 1] += cell.bubble * u[2 * j + 1];
                }
            }
        }
        out
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        (self.off.len() + self.beta.len() + self.inverse_pivot.len()) * size_of::<Complex64>()
    }
}

fn row<'a>(u: &'a ArrayView2<Complex64>, index: usize) -> &'a [Complex64] {
    u.row(index).to_slice().expect("rows are contiguous")
}

/// 1/pivot; a pivot that vanishes (a guided mode exactly on the grid) is moved by a part in 10¹² of its row.
fn guarded_inverse(pivot: Complex64, scale: Complex64) -> Complex64 {
    let least = 1e-12 * scale.norm().max(1e-300);
    if pivot.norm() < least { Complex64::from(1.0 / least) } else { 1.0 / pivot }
}
