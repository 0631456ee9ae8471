//! Exact response of the mean medium to a source, per harmonic: TE for E_s, TM for h = H along s.
//!
//! With the lateral wavevector q p̂, s = ẑ × p̂, kz² = k̄² − q² and the source J = k0²(ε − ε̄)E:
//!
//! TE   E_s'' + kz² E_s = −J_s TM   (h'/k̄²)' + (kz²/k̄²) h = q J_z/k̄² + i (J_p/k̄²)'      E_p =
//! (−i h' − J_p)/k̄²,   E_z = (−q h − J_z)/k̄²
//!
//! E_s, E_s', h and E_p are continuous, E_z jumps: the unknowns are two moments of E per cell (see
//! [`super::cell`]), none on an interface. Rows of a field: component c (s, p, z) of Gauss plane q
//! in cell j is row 6j + 3q + c; columns are harmonics. Neither kz nor q is used as a divisor.

use super::cell::cell_functions;
use super::kernels::{
    BLOCK, Constants, NodeSystem, Tables, UnitResponses, across, add_loads, selected, within,
};
use crate::numerics::fourier::{Real, narrow};
use crate::wave::operator::inverse::{row, row_of};
use crate::wave::operator::sharing::{Idle, tabulated};
use crate::wave::{Field, Grid, decaying_root};
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};
use num_complex::{Complex, Complex64};
use rayon::prelude::*;

/// Rows of one cell: two Gauss planes of three components.
pub const CELL_ROWS: usize = 6;

const I: Complex64 = Complex64::I;

/// Fields E_s (first) and h (second) at all nodes (rows) in every harmonic (columns).
pub(super) type Nodes = [Field; 2];

/// A wave incident through one face in one harmonic: right-hand sides of the TE and TM problem at
/// its node.
#[derive(Clone, Copy, Debug)]
pub struct MeanEntry {
    /// Index of the node of the illuminated face: first or last.
    pub node: usize,
    /// Compact index of the incident harmonic.
    pub harmonic: usize,
    /// Right-hand sides of TE and TM.
    pub source: [Complex64; 2],
}

/// The mean operator A, factorised; also in single precision for strategies that measure the true
/// residual.
pub struct VectorMean<T: Real = f64> {
    pub(super) heights: Vec<f64>,
    /// Mean k̄² of each cell, 1/µm².
    pub(super) mean_k2: Vec<Complex64>,
    /// Lateral wavenumber q of each harmonic, 1/µm.
    pub(super) lateral: Vec<T>,
    electric: NodeSystem<T>,
    magnetic: NodeSystem<T>,
    /// Functions b and c of every cell (rows) and harmonic.
    functions: [Array2<Complex<T>>; 2],
    /// Values at the nodes of a block of harmonics.
    idle: Idle<[Vec<Complex<T>>; 2]>,
}

impl VectorMean {
    /// Factorises the operator; `kappa` are the normal wavenumbers of the half-spaces and `k` their
    /// wavenumbers, incident side first.
    pub fn new(
        grid: &Grid,
        mean_k2: Vec<Complex64>,
        lateral: Vec<f64>,
        kappa: [&[Complex64]; 2],
        k: [Complex64; 2],
    ) -> VectorMean {
        let heights: Vec<f64> = (0..grid.cells()).map(|j| grid.height_um(j)).collect();
        let ends = |weights: [Complex64; 2]| {
            [0, 1].map(|side| kappa[side].iter().map(|kappa| I * kappa * weights[side]).collect::<Vec<_>>())
        };
        let kz2 = |j: usize, i: usize| mean_k2[j] - lateral[i] * lateral[i];
        let exponent = |j: usize, i: usize| [Complex64::I * decaying_root(kz2(j, i)) * heights[j]];
        let tables = tabulated((heights.len(), lateral.len()), 4, exponent, |j, i, [step]| {
            let (cell, node) = cell_functions(kz2(j, i), heights[j], step);
            [cell.b, cell.c, node.off, node.diagonal]
        });
        let [b, c, mut off, mut diagonal] = tables.try_into().expect("four tables");
        let electric = NodeSystem::new(off.clone(), &diagonal, ends([Complex64::ONE; 2]));
        for (j, k2) in mean_k2.iter().enumerate() {
            let inverse = 1.0 / k2;
            [&mut off, &mut diagonal].into_iter().for_each(|t| t.row_mut(j).mapv_inplace(|z| z * inverse));
        }
        let magnetic = NodeSystem::new(off, &diagonal, ends(k.map(|k| 1.0 / (k * k))));
        VectorMean { heights, mean_k2, lateral, electric, magnetic, functions: [b, c], idle: Idle::default() }
    }

    /// The operator on some of the harmonics.
    pub(super) fn restricted(&self, columns: &[usize]) -> VectorMean {
        let chosen = |table: &Array2<Complex64>| selected(table, columns);
        VectorMean {
            heights: self.heights.clone(),
            mean_k2: self.mean_k2.clone(),
            lateral: columns.iter().map(|&i| self.lateral[i]).collect(),
            electric: self.electric.restricted(columns),
            magnetic: self.magnetic.restricted(columns),
            functions: self.functions.each_ref().map(chosen),
            idle: Idle::default(),
        }
    }

    /// What unit sources in a cell and unit values at its nodes cause, in all harmonics.
    pub(super) fn unit_responses(&self, cell: usize) -> UnitResponses {
        let width = self.lateral.len();
        let constants = Constants::new(self.heights[cell], self.mean_k2[cell]);
        UnitResponses::new(&constants, &self.tables(cell, 0, width), width)
    }

    /// An entry of the nodes' systems in every harmonic: of TE, then of TM for h in a `unit`.
    pub(super) fn node_entries(
        &self,
        entry: impl Fn(&NodeSystem<f64>, usize) -> Complex64,
        unit: f64,
    ) -> Vec<Complex64> {
        let harmonics = 0..self.lateral.len();
        let electric = harmonics.clone().map(|i| entry(&self.electric, i));
        electric.chain(harmonics.map(|i| unit * unit * entry(&self.magnetic, i))).collect()
    }

    /// The operator in another precision.
    pub fn narrowed<T: Real>(&self) -> VectorMean<T> {
        let heights = self.heights.clone();
        let mean_k2 = self.mean_k2.clone();
        let (electric, magnetic) = (self.electric.narrowed(), self.magnetic.narrowed());
        let lateral = self.lateral.iter().map(|&q| T::of(q)).collect();
        let functions = self.functions.each_ref().map(|table| table.mapv(narrow));
        VectorMean { heights, mean_k2, lateral, electric, magnetic, functions, idle: Idle::default() }
    }

    /// The wave in the mean medium for the incident wave `entry`.
    pub fn background(&self, entry: MeanEntry) -> Field {
        let mut y = Field::zeros((CELL_ROWS * self.heights.len(), self.lateral.len()));
        self.sweep(&mut y, Some(entry));
        y
    }

    /// Fields E_s and h at all nodes of A⁻¹ y plus the incident wave's.
    pub(super) fn nodes(&self, y: &Field, entry: MeanEntry) -> Nodes {
        let blocks = y.axis_chunks_iter(Axis(1), BLOCK).into_par_iter().enumerate();
        let blocks: Vec<Nodes> = blocks.map(|(b, y)| self.block_nodes(&y, b * BLOCK, entry)).collect();
        [0, 1].map(|k| {
            let parts: Vec<_> = blocks.iter().map(|block| block[k].view()).collect();
            ndarray::concatenate(Axis(1), &parts).expect("blocks have as many nodes")
        })
    }

    /// Part of [`VectorMean::nodes`] for a block of harmonics from `first`.
    fn block_nodes(&self, y: &ArrayView2<Complex64>, first: usize, entry: MeanEntry) -> Nodes {
        let mut block = [0, 1].map(|_| Field::zeros((self.heights.len() + 1, y.ncols())));
        let values = block.each_mut().map(|field| field.as_slice_mut().expect("new fields are contiguous"));
        self.node_values(y, first, Some(entry), values);
        block
    }
}

impl<T: Real> VectorMean<T> {
    /// Applies y ← A⁻¹ y: from V E per Gauss plane to moments of the scattered field (minus the
    /// Green function).
    pub fn solve(&self, y: &mut Array2<Complex<T>>) {
        self.sweep(y, None);
    }

    /// One solve: source terms, nodes, moments.
    fn sweep(&self, y: &mut Array2<Complex<T>>, entry: Option<MeanEntry>) {
        let nodes = self.heights.len() + 1;
        let buffers = || [(); 2].map(|()| vec![Complex::default(); nodes * BLOCK]);
        self.idle.in_chunks(y, Axis(1), BLOCK, buffers, |b, mut y, buffers| {
            let [u, w] = buffers.each_mut().map(|values| &mut values[..nodes * y.ncols()]);
            self.node_values(&y.view(), b * BLOCK, entry, [u, w]);
            self.moments(&mut y, b * BLOCK, u, w);
        });
    }

    /// Right-hand sides of the node systems from F = V E: TE and TM, node by node.
    pub(super) fn node_loads(&self, y: &Array2<Complex<T>>) -> [Vec<Complex<T>>; 2] {
        let zeros = || vec![Complex::default(); (self.heights.len() + 1) * self.lateral.len()];
        let mut loads = [zeros(), zeros()];
        let [u, w] = &mut loads;
        self.loads(&y.view(), 0, u, w);
        loads
    }

    /// Fields E_s and h of a block at all nodes, node by node.
    fn node_values(
        &self,
        y: &ArrayView2<Complex<T>>,
        first: usize,
        entry: Option<MeanEntry>,
        [u, w]: [&mut [Complex<T>]; 2],
    ) {
        let width = y.ncols();
        self.loads(y, first, u, w);
        if let Some(e) = entry.filter(|e| (first..first + width).contains(&e.harmonic)) {
            let place = e.node * width + e.harmonic - first;
            u[place] += narrow::<T>(e.source[0]);
            w[place] += narrow::<T>(e.source[1]);
        }
        self.electric.solve(u, first, width);
        self.magnetic.solve(w, first, width);
    }

    fn tables(&self, j: usize, first: usize, width: usize) -> Tables<'_, T> {
        let [b, c] = self.functions.each_ref().map(|table| &row_of(table, j)[first..first + width]);
        Tables { lateral: &self.lateral[first..first + width], b, c }
    }

    /// Right-hand sides of the node systems from F = V E.
    fn loads(&self, y: &ArrayView2<Complex<T>>, first: usize, u: &mut [Complex<T>], w: &mut [Complex<T>]) {
        let width = y.ncols();
        u.fill(Complex::default());
        w.fill(Complex::default());
        for (j, (&h, &k2)) in self.heights.iter().zip(&self.mean_k2).enumerate() {
            let rows = std::array::from_fn(|r| row(y, CELL_ROWS * j + r));
            let (u0, u1) = u[j * width..(j + 2) * width].split_at_mut(width);
            let (w0, w1) = w[j * width..(j + 2) * width].split_at_mut(width);
            add_loads(&Constants::new(h, k2), &self.tables(j, first, width), &rows, u0, u1, w0, w1);
        }
    }

    /// Replaces F by the moments of the field, from node values and F.
    fn moments(&self, y: &mut ArrayViewMut2<Complex<T>>, first: usize, u: &[Complex<T>], w: &[Complex<T>]) {
        let width = y.ncols();
        for (j, (&h, &k2)) in self.heights.iter().zip(&self.mean_k2).enumerate() {
            let mut part = y.slice_mut(ndarray::s![CELL_ROWS * j..CELL_ROWS * (j + 1), ..]);
            let mut rows = part.outer_iter_mut();
            let [s0, p0, z0, s1, p1, z1] =
                std::array::from_fn(|_| rows.next().expect("six rows").into_slice().expect("contiguous"));
            let [electric, magnetic] =
                [u, w].map(|values| [j, j + 1].map(|node| &values[node * width..(node + 1) * width]));
            let constants = Constants::new(h, k2);
            let tables = self.tables(j, first, width);
            across(&constants, &tables, electric, s0, s1);
            within(&constants, &tables, magnetic, p0, z0, p1, z1);
        }
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let functions: usize = self.functions.iter().map(|f| f.len()).sum();
        functions * size_of::<Complex<T>>() + self.electric.bytes() + self.magnetic.bytes()
    }
}
