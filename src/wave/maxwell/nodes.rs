//! The tridiagonal systems of all harmonics between the nodes: TE for E_s, TM for h with each cell over its k̄².

use crate::wave::operator::mean::{NodeCoefficients, guarded_inverse};
use crate::wave::{Grid, Scheme};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

/// Harmonics treated together by one thread.
pub(super) const BLOCK: usize = 64;

/// Factors of one tridiagonal matrix per harmonic: rows are cells or nodes, columns harmonics.
pub(super) struct NodeSystem {
    /// Coupling of a cell's two nodes.
    off: Array2<Complex64>,
    /// 1/pivot of each node.
    inverse_pivot: Array2<Complex64>,
}

impl NodeSystem {
    /// Factorises the exact difference scheme of every harmonic; a cell's row entries are multiplied by `weights`,
    /// and `ends` are added to the first and last diagonal entry.
    pub fn new(
        grid: &Grid,
        kz2: &(dyn Fn(usize, usize) -> Complex64 + Sync),
        weights: &[Complex64],
        ends: [&[Complex64]; 2],
    ) -> NodeSystem {
        let (cells, harmonics) = (grid.cells(), ends[0].len());
        let (mut off, mut inverse_pivot) =
            (Array2::zeros((cells, harmonics)), Array2::zeros((cells + 1, harmonics)));
        let columns = off.axis_iter_mut(Axis(1)).into_par_iter().zip(inverse_pivot.axis_iter_mut(Axis(1)));
        columns.enumerate().with_min_len(BLOCK).for_each(|(i, (mut off, mut pivots))| {
            let mut diagonal = ends[0][i];
            for j in 0..cells {
                let cell = NodeCoefficients::new(kz2(j, i), grid.height_um(j), Scheme::Quadratic);
                let (coupling, own) = (cell.off * weights[j], cell.diagonal * weights[j]);
                let inverse = guarded_inverse(diagonal + own, coupling);
                (off[j], pivots[j]) = (coupling, inverse);
                diagonal = own - coupling * coupling * inverse;
            }
            pivots[cells] = guarded_inverse(diagonal + ends[1][i], off[cells - 1]);
        });
        NodeSystem { off, inverse_pivot }
    }

    /// Solves in place for the harmonics from `first`; `nodes` holds `width` of them for one node after the other.
    pub fn solve(&self, nodes: &mut [Complex64], first: usize, width: usize) {
        let cells = self.off.nrows();
        let part = |table: &Array2<Complex64>, row: usize| {
            let from = row * table.ncols() + first;
            from..from + width
        };
        let (off, pivot) = (slice(&self.off), slice(&self.inverse_pivot));
        let start = &pivot[part(&self.inverse_pivot, 0)];
        nodes[..width].iter_mut().zip(start).for_each(|(y, p)| *y *= p);
        for j in 1..=cells {
            let (before, here) = nodes[(j - 1) * width..(j + 1) * width].split_at_mut(width);
            let factors = off[part(&self.off, j - 1)].iter().zip(&pivot[part(&self.inverse_pivot, j)]);
            let rows = here.iter_mut().zip(before.iter()).zip(factors);
            rows.for_each(|((y, b), (o, p))| *y = (*y - o * b) * p);
        }
        for j in (0..cells).rev() {
            let (here, after) = nodes[j * width..(j + 2) * width].split_at_mut(width);
            let factors = off[part(&self.off, j)].iter().zip(&pivot[part(&self.inverse_pivot, j)]);
            let rows = here.iter_mut().zip(after.iter()).zip(factors);
            rows.for_each(|((y, a), (o, p))| *y -= o * a * p);
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        (self.off.len() + self.inverse_pivot.len()) * size_of::<Complex64>()
    }
}

fn slice(table: &Array2<Complex64>) -> &[Complex64] {
    table.as_slice().expect("tables are contiguous")
}
