//! The mean medium's exact answer to a source, per harmonic: TE for E_s, TM for h = H along s.
//!
//! With the lateral wavevector q p̂, s = ẑ × p̂, kz² = k̄² − q² and the source J = k0²(ε − ε̄)E:
//!
//!   TE   E_s'' + kz² E_s = −J_s
//!   TM   (h'/k̄²)' + (kz²/k̄²) h = q J_z/k̄² + i (J_p/k̄²)'      E_p = (−i h' − J_p)/k̄²,   E_z = (−q h − J_z)/k̄²
//!
//! E_s, E_s', h and E_p are continuous, E_z jumps: unknowns are two moments of E a cell (see [`super::cell`]), none on an
//! interface. Rows of a field: component c (s, p, z) of Gauss plane q in cell j is row 6j + 3q + c; columns are
//! harmonics. Neither kz nor q is divided by.

use super::cell::cell_functions;
use super::kernels::{Constants, Loads, Moments, Tables};
use super::nodes::{BLOCK, NodeSystem};
use crate::numerics::fourier::{Real, narrow};
use crate::wave::operator::inverse::row_of;
use crate::wave::operator::sharing::SHARED;
use crate::wave::{Field, Grid};
use ndarray::{Array2, ArrayView2, ArrayViewMut1, ArrayViewMut2, Axis};
use num_complex::{Complex, Complex64};
use rayon::prelude::*;

/// Rows of one cell: two Gauss planes of three components.
pub const CELL_ROWS: usize = 6;

const I: Complex64 = Complex64::I;

/// E_s (first) and h (second) at all nodes (rows) in every harmonic (columns).
pub(super) type Nodes = [Field; 2];

/// A wave that enters through one face in one harmonic: node rows' right-hand sides of the TE and the TM problem.
#[derive(Clone, Copy, Debug)]
pub struct MeanEntry {
    /// Index of the node that the wave enters by: first or last.
    pub node: usize,
    /// Compact index of the incident harmonic.
    pub harmonic: usize,
    /// Right-hand sides of TE and TM.
    pub source: [Complex64; 2],
}

/// E_s and h of every harmonic on the incident and the exit face.
#[derive(Clone, Debug)]
pub struct Faces {
    /// E_s at z = 0 and z = H.
    pub electric: [Vec<Complex64>; 2],
    /// h = ωµ0 H_s at z = 0 and z = H.
    pub magnetic: [Vec<Complex64>; 2],
}

impl Faces {
    /// The first and the last of all nodes.
    pub(super) fn of(nodes: &Nodes) -> Faces {
        let ends = |field: &Field| [0, field.nrows() - 1].map(|node| field.row(node).to_vec());
        Faces { electric: ends(&nodes[0]), magnetic: ends(&nodes[1]) }
    }
}

/// The mean operator A, factorised; in single precision beside double for strategies that measure the true residual.
pub struct VectorMean<T: Real = f64> {
    heights: Vec<f64>,
    /// k̄² of each cell.
    mean_k2: Vec<Complex64>,
    /// q of each harmonic.
    lateral: Vec<T>,
    electric: NodeSystem<T>,
    magnetic: NodeSystem<T>,
    /// b and c of every cell (rows) and harmonic.
    functions: [Array2<Complex<T>>; 2],
}

impl VectorMean {
    /// `kappa` are the half-spaces' normal wavenumbers and `k` their wavenumbers, incident side first.
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
        let (te, tm) = (ends([Complex64::ONE; 2]), ends(k.map(|k| 1.0 / (k * k))));
        let ones = vec![Complex64::ONE; mean_k2.len()];
        let inverse: Vec<Complex64> = mean_k2.iter().map(|k2| 1.0 / k2).collect();
        let [b, c, off, own] = cell_tables(&heights, &mean_k2, &lateral);
        let electric = NodeSystem::new([&off, &own], &ones, [&te[0], &te[1]]);
        let magnetic = NodeSystem::new([&off, &own], &inverse, [&tm[0], &tm[1]]);
        VectorMean { heights, mean_k2, lateral, electric, magnetic, functions: [b, c] }
    }

    /// The same in another precision.
    pub fn narrowed<T: Real>(&self) -> VectorMean<T> {
        VectorMean {
            heights: self.heights.clone(),
            mean_k2: self.mean_k2.clone(),
            lateral: self.lateral.iter().map(|&q| T::of(q)).collect(),
            electric: self.electric.narrowed(),
            magnetic: self.magnetic.narrowed(),
            functions: [0, 1].map(|k| self.functions[k].mapv(narrow)),
        }
    }

    /// The wave in the mean medium that enters as `entry` says.
    pub fn background(&self, entry: MeanEntry) -> Field {
        let mut y = Field::zeros((CELL_ROWS * self.heights.len(), self.lateral.len()));
        self.sweep(&mut y, Some(entry));
        y
    }

    /// E_s and h at all nodes of A⁻¹ y and of the wave that enters.
    pub(super) fn nodes(&self, y: &Field, entry: MeanEntry) -> Nodes {
        let (nodes, count) = (self.heights.len() + 1, self.lateral.len());
        let mut values = [Field::zeros((nodes, count)), Field::zeros((nodes, count))];
        let [electric, magnetic] = &mut values;
        let blocks = y.axis_chunks_iter(Axis(1), BLOCK).into_par_iter().enumerate();
        let targets = electric.axis_chunks_iter_mut(Axis(1), BLOCK).into_par_iter();
        let targets = targets.zip(magnetic.axis_chunks_iter_mut(Axis(1), BLOCK));
        blocks.zip(targets).for_each(|((b, y), targets)| self.block_nodes(&y, b * BLOCK, entry, targets));
        values
    }

    /// [`VectorMean::nodes`] of the harmonics from `first`.
    fn block_nodes(
        &self,
        y: &ArrayView2<Complex64>,
        first: usize,
        entry: MeanEntry,
        (mut electric, mut magnetic): (ArrayViewMut2<Complex64>, ArrayViewMut2<Complex64>),
    ) {
        let [mut u, mut w] = [0, 1].map(|_| vec![Complex64::default(); electric.len()]);
        self.node_values(y, first, Some(entry), [&mut u, &mut w]);
        electric.iter_mut().zip(u).for_each(|(to, from)| *to = from);
        magnetic.iter_mut().zip(w).for_each(|(to, from)| *to = from);
    }

    /// Height, k̄² of every cell, and q of every harmonic.
    pub(super) fn cells(&self) -> (&[f64], &[Complex64], &[f64]) {
        (&self.heights, &self.mean_k2, &self.lateral)
    }
}

/// b, c, and the nodes' couplings and diagonals of every cell (rows) and harmonic, from one exponential each.
fn cell_tables(heights: &[f64], mean_k2: &[Complex64], lateral: &[f64]) -> [Array2<Complex64>; 4] {
    let mut tables: [_; 4] = std::array::from_fn(|_| Array2::zeros((heights.len(), lateral.len())));
    let [b, c, off, own] = &mut tables;
    let rows = (b.outer_iter_mut().into_par_iter().zip(c.outer_iter_mut()))
        .zip(off.outer_iter_mut().into_par_iter().zip(own.outer_iter_mut()));
    rows.enumerate().for_each(|(j, ((b, c), (off, own)))| {
        cell_row(heights[j], mean_k2[j], lateral, [b, c, off, own]);
    });
    tables
}

/// One cell's row of [`cell_tables`].
fn cell_row(height: f64, mean_k2: Complex64, lateral: &[f64], row: [ArrayViewMut1<Complex64>; 4]) {
    let [mut b, mut c, mut off, mut own] = row;
    for (i, q) in lateral.iter().enumerate() {
        let (cell, node) = cell_functions(mean_k2 - q * q, height);
        (b[i], c[i]) = (cell.b, cell.c);
        (off[i], own[i]) = (node.off, node.diagonal);
    }
}

impl<T: Real> VectorMean<T> {
    /// y ← A⁻¹ y: from V E per Gauss plane to moments of the field it scatters (minus the Green function).
    pub fn solve(&self, y: &mut Array2<Complex<T>>) {
        self.sweep(y, None);
    }

    /// One solve: loads, nodes, moments.
    fn sweep(&self, y: &mut Array2<Complex<T>>, entry: Option<MeanEntry>) {
        let shared = y.len() >= SHARED;
        let length = (self.heights.len() + 1) * BLOCK;
        let buffers = || [vec![Complex::<T>::default(); length], vec![Complex::default(); length]];
        let blocks = y.axis_chunks_iter_mut(Axis(1), BLOCK);
        if shared {
            let blocks = blocks.into_par_iter().enumerate();
            return blocks
                .for_each_init(buffers, |buffers, (b, y)| self.solve_block(y, b * BLOCK, entry, buffers));
        }
        let mut buffers = buffers();
        blocks.into_iter().enumerate().for_each(|(b, y)| self.solve_block(y, b * BLOCK, entry, &mut buffers));
    }

    fn solve_block(
        &self,
        mut y: ArrayViewMut2<Complex<T>>,
        first: usize,
        entry: Option<MeanEntry>,
        [u, w]: &mut [Vec<Complex<T>>; 2],
    ) {
        let length = (self.heights.len() + 1) * y.ncols();
        let (u, w) = (&mut u[..length], &mut w[..length]);
        self.node_values(&y.view(), first, entry, [u, w]);
        self.moments(&mut y, first, u, w);
    }

    /// E_s and h of a block at all nodes, one node after the other.
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
        let [b, c] = [0, 1].map(|k| &row_of(&self.functions[k], j)[first..first + width]);
        Tables { lateral: &self.lateral[first..first + width], b, c }
    }

    /// Right-hand sides of the node systems from F = V E.
    fn loads(&self, y: &ArrayView2<Complex<T>>, first: usize, u: &mut [Complex<T>], w: &mut [Complex<T>]) {
        let width = y.ncols();
        u.fill(Complex::default());
        w.fill(Complex::default());
        for (j, (&h, &k2)) in self.heights.iter().zip(&self.mean_k2).enumerate() {
            let rows = std::array::from_fn(|r| {
                y.row(CELL_ROWS * j + r).to_slice().expect("rows of a block are contiguous")
            });
            let (u0, u1) = u[j * width..(j + 2) * width].split_at_mut(width);
            let (w0, w1) = w[j * width..(j + 2) * width].split_at_mut(width);
            let cell = Loads { constants: Constants::new(h, k2), tables: self.tables(j, first, width), rows };
            cell.add_to(u0, u1, w0, w1);
        }
    }

    /// Moments of the field from node values and F, in place of F.
    fn moments(&self, y: &mut ArrayViewMut2<Complex<T>>, first: usize, u: &[Complex<T>], w: &[Complex<T>]) {
        let width = y.ncols();
        for (j, (&h, &k2)) in self.heights.iter().zip(&self.mean_k2).enumerate() {
            let mut part = y.slice_mut(ndarray::s![CELL_ROWS * j..CELL_ROWS * (j + 1), ..]);
            let mut rows = part.outer_iter_mut();
            let [s0, p0, z0, s1, p1, z1] =
                std::array::from_fn(|_| rows.next().expect("six rows").into_slice().expect("contiguous"));
            let (u0, u1) = u[j * width..(j + 2) * width].split_at(width);
            let (w0, w1) = w[j * width..(j + 2) * width].split_at(width);
            let constants = Constants::new(h, k2);
            let cell = Moments { constants, tables: self.tables(j, first, width), nodes: [u0, u1, w0, w1] };
            cell.write(s0, p0, z0, s1, p1, z1);
        }
    }

    /// k̄² of each cell.
    pub fn mean_k2(&self) -> &[Complex64] {
        &self.mean_k2
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let functions: usize = self.functions.iter().map(|f| f.len()).sum();
        functions * size_of::<Complex<T>>() + self.electric.bytes() + self.magnetic.bytes()
    }
}
