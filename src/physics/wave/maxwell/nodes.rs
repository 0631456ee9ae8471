//! Tridiagonal systems of all harmonics between the nodes: TE for E_s, TM for h with each cell
//! divided by its k̄².

use crate::numerics::fourier::{Real, narrow};
use crate::wave::operator::inverse::row_of;
use crate::wave::operator::mean::inverse_pivots;
use multiversion::multiversion;
use ndarray::Array2;
use num_complex::{Complex, Complex64};

/// Harmonics treated together by one thread.
pub(super) const BLOCK: usize = 64;

/// Factors of one tridiagonal matrix per harmonic: rows are cells or nodes, columns harmonics.
pub(super) struct NodeSystem<T: Real> {
    /// Coupling of a cell's two nodes.
    off: Array2<Complex<T>>,
    /// Reciprocal pivot of each node.
    inverse_pivot: Array2<Complex<T>>,
}

impl NodeSystem<f64> {
    /// Factorises the exact difference scheme of every harmonic; see [`inverse_pivots`].
    pub fn new(off: Array2<Complex64>, diagonal: &Array2<Complex64>, ends: [Vec<Complex64>; 2]) -> Self {
        NodeSystem { inverse_pivot: inverse_pivots(&off, diagonal, ends), off }
    }

    /// The factors in another precision.
    pub fn narrowed<T: Real>(&self) -> NodeSystem<T> {
        NodeSystem { off: self.off.mapv(narrow), inverse_pivot: self.inverse_pivot.mapv(narrow) }
    }
}

impl<T: Real> NodeSystem<T> {
    /// Solves in place for the harmonics from `first`; `nodes` holds `width` of them, node by node.
    pub fn solve(&self, nodes: &mut [Complex<T>], first: usize, width: usize) {
        let cells = self.off.nrows();
        let off = |cell: usize| &row_of(&self.off, cell)[first..first + width];
        let pivot = |node: usize| &row_of(&self.inverse_pivot, node)[first..first + width];
        nodes[..width].iter_mut().zip(pivot(0)).for_each(|(y, p)| *y *= *p);
        for j in 1..=cells {
            let (before, here) = nodes[(j - 1) * width..(j + 1) * width].split_at_mut(width);
            forward(here, before, off(j - 1), pivot(j));
        }
        for j in (0..cells).rev() {
            let (here, after) = nodes[j * width..(j + 2) * width].split_at_mut(width);
            backward(here, after, off(j), pivot(j));
        }
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        (self.off.len() + self.inverse_pivot.len()) * size_of::<Complex<T>>()
    }
}

/// Forward elimination y ← (y − o b) p.
#[multiversion(targets("x86_64+avx2"))]
fn forward<T: Real>(y: &mut [Complex<T>], b: &[Complex<T>], off: &[Complex<T>], pivot: &[Complex<T>]) {
    let rows = y.iter_mut().zip(b).zip(off.iter().zip(pivot));
    rows.for_each(|((y, b), (o, p))| *y = (*y - o * b) * p);
}

/// Back substitution y ← y − o p a.
#[multiversion(targets("x86_64+avx2"))]
fn backward<T: Real>(y: &mut [Complex<T>], a: &[Complex<T>], off: &[Complex<T>], pivot: &[Complex<T>]) {
    let rows = y.iter_mut().zip(a).zip(off.iter().zip(pivot));
    rows.for_each(|((y, a), (o, p))| *y -= o * a * p);
}
