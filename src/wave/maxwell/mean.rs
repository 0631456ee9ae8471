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

use super::cell::CellFunctions;
use super::nodes::{BLOCK, NodeSystem};
use crate::wave::{Field, Grid};
use ndarray::{Array2, ArrayViewMut2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

/// Rows of one cell: two Gauss planes of three components.
pub const CELL_ROWS: usize = 6;

const SQRT3: f64 = 1.732_050_807_568_877_2;
const I: Complex64 = Complex64::I;

/// A wave that enters through one face in one harmonic: node rows' right-hand sides of the TE and the TM problem.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
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

/// The mean operator A, factorised.
pub struct VectorMean {
    heights: Vec<f64>,
    /// k̄² of each cell.
    mean_k2: Vec<Complex64>,
    /// q of each harmonic.
    lateral: Vec<f64>,
    electric: NodeSystem,
    magnetic: NodeSystem,
    /// b and c of every cell (rows) and harmonic.
    functions: [Array2<Complex64>; 2],
}

/// One cell's constants and the tables of the harmonics in a block.
struct CellBlock<'a> {
    h: f64,
    k2: Complex64,
    inverse_k2: Complex64,
    lateral: &'a [f64],
    b: &'a [Complex64],
    c: &'a [Complex64],
}

/// What a cell needs of one harmonic.
struct Local {
    q: f64,
    x2: Complex64,
    b: Complex64,
    c: Complex64,
    /// l₊ = 1 + x²b and −l₋ = (1 + x²c)/√3.
    sum: Complex64,
    difference: Complex64,
}

impl CellBlock<'_> {
    fn local(&self, i: usize) -> Local {
        let (q, b, c) = (self.lateral[i], self.b[i], self.c[i]);
        let x2 = (self.k2 - q * q) * (self.h * self.h);
        Local { q, x2, b, c, sum: 1.0 + x2 * b, difference: (1.0 + x2 * c) * (1.0 / SQRT3) }
    }
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
        let kz2 = |j: usize, i: usize| mean_k2[j] - lateral[i] * lateral[i];
        let ends = |weights: [Complex64; 2]| {
            [0, 1].map(|side| kappa[side].iter().map(|kappa| I * kappa * weights[side]).collect::<Vec<_>>())
        };
        let (te, tm) = (ends([Complex64::ONE; 2]), ends(k.map(|k| 1.0 / (k * k))));
        let ones = vec![Complex64::ONE; mean_k2.len()];
        let inverse: Vec<Complex64> = mean_k2.iter().map(|k2| 1.0 / k2).collect();
        let electric = NodeSystem::new(grid, &kz2, &ones, [&te[0], &te[1]]);
        let magnetic = NodeSystem::new(grid, &kz2, &inverse, [&tm[0], &tm[1]]);
        let shape = (heights.len(), lateral.len());
        let mut functions = [Array2::zeros(shape), Array2::zeros(shape)];
        let [b, c] = &mut functions;
        let rows = b.outer_iter_mut().into_par_iter().zip(c.outer_iter_mut()).enumerate();
        rows.for_each(|(j, (mut b, mut c))| {
            for i in 0..lateral.len() {
                let cell = CellFunctions::new(kz2(j, i) * (heights[j] * heights[j]));
                (b[i], c[i]) = (cell.b, cell.c);
            }
        });
        VectorMean { heights, mean_k2, lateral, electric, magnetic, functions }
    }

    /// y ← A⁻¹ y: from V E per Gauss plane to moments of the field it scatters (minus the Green function).
    pub fn solve(&self, y: &mut Field) {
        self.sweep(y, None, &mut []);
    }

    /// The wave in the mean medium that enters as `entry` says.
    pub fn background(&self, entry: Entry) -> Field {
        let mut y = Field::zeros((CELL_ROWS * self.heights.len(), self.lateral.len()));
        self.sweep(&mut y, Some(entry), &mut []);
        y
    }

    /// E_s and h on both faces of A⁻¹ y, or of the background where `y` is zero; `y` is overwritten.
    pub fn faces(&self, y: &mut Field, entry: Option<Entry>) -> Faces {
        let count = self.lateral.len();
        let mut values = vec![[Complex64::default(); 4]; count];
        self.sweep(y, entry, &mut values);
        let of = |k: usize| values.iter().map(|v| v[k]).collect();
        Faces { electric: [of(0), of(1)], magnetic: [of(2), of(3)] }
    }

    /// One solve: loads, nodes, moments. `faces` is empty or one entry per harmonic: E_s and h on both faces.
    fn sweep(&self, y: &mut Field, entry: Option<Entry>, faces: &mut [[Complex64; 4]]) {
        let nodes = self.heights.len() + 1;
        let mut parts: Vec<&mut [[Complex64; 4]]> = faces.chunks_mut(BLOCK).collect();
        parts.resize_with(self.lateral.len().div_ceil(BLOCK), Default::default);
        let blocks = y.axis_chunks_iter_mut(Axis(1), BLOCK).into_par_iter().zip(parts).enumerate();
        let scratch =
            || [vec![Complex64::default(); nodes * BLOCK], vec![Complex64::default(); nodes * BLOCK]];
        blocks.for_each_init(scratch, |[u, w], (block, (mut y, faces))| {
            let (first, width) = (block * BLOCK, y.ncols());
            let (u, w) = (&mut u[..nodes * width], &mut w[..nodes * width]);
            self.loads(&y, first, u, w);
            if let Some(e) = entry.filter(|e| (first..first + width).contains(&e.harmonic)) {
                u[e.node * width + e.harmonic - first] += e.source[0];
                w[e.node * width + e.harmonic - first] += e.source[1];
            }
            self.electric.solve(u, first, width);
            self.magnetic.solve(w, first, width);
            let last = (nodes - 1) * width;
            faces.iter_mut().enumerate().for_each(|(i, f)| *f = [u[i], u[last + i], w[i], w[last + i]]);
            self.moments(&mut y, first, u, w);
        });
    }

    fn cell(&self, j: usize, first: usize, width: usize) -> CellBlock<'_> {
        let [b, c] = [0, 1].map(|k| {
            let row = self.functions[k].row(j).to_slice().expect("rows are contiguous");
            &row[first..first + width]
        });
        let (h, k2) = (self.heights[j], self.mean_k2[j]);
        CellBlock { h, k2, inverse_k2: 1.0 / k2, lateral: &self.lateral[first..first + width], b, c }
    }

    /// Right-hand sides of the node systems from F = V E (J = −F):
    /// TE ±: h/4 (l₊F_s₊ ∓ …), TM: −1/(4k̄²) [q h (l₊F_z₊ …) …].
    fn loads(&self, y: &ArrayViewMut2<Complex64>, first: usize, u: &mut [Complex64], w: &mut [Complex64]) {
        let width = y.ncols();
        u.fill(Complex64::default());
        w.fill(Complex64::default());
        for j in 0..self.heights.len() {
            let cell = self.cell(j, first, width);
            let rows: [&[Complex64]; CELL_ROWS] = rows_of(y, j);
            let (u0, u1) = u[j * width..(j + 2) * width].split_at_mut(width);
            let (w0, w1) = w[j * width..(j + 2) * width].split_at_mut(width);
            let (te, tm) = (0.25 * cell.h, -0.25 * cell.inverse_k2);
            for i in 0..width {
                let l = cell.local(i);
                let [s, p, z] = [0, 1, 2].map(|c| sum_and_difference(rows[c][i], rows[c + 3][i]));
                let (even, odd) = (te * l.sum * s[0], te * l.difference * s[1]);
                u0[i] += even - odd;
                u1[i] += even + odd;
                let qh = l.q * cell.h;
                let even = tm * (qh * l.sum * z[0] + 2.0 * SQRT3 * I * l.x2 * l.b * p[1]);
                let odd = tm * (qh * l.difference * z[1] - 2.0 * I * p[0]);
                w0[i] += even - odd;
                w1[i] += even + odd;
            }
        }
    }

    /// Moments of the field from node values and F, in place of F.
    fn moments(&self, y: &mut ArrayViewMut2<Complex64>, first: usize, u: &[Complex64], w: &[Complex64]) {
        let width = y.ncols();
        for j in 0..self.heights.len() {
            let cell = self.cell(j, first, width);
            let mut part = y.slice_mut(ndarray::s![CELL_ROWS * j..CELL_ROWS * (j + 1), ..]);
            let mut rows = part.outer_iter_mut();
            let rows: [&mut [Complex64]; CELL_ROWS] =
                std::array::from_fn(|_| rows.next().expect("six rows").into_slice().expect("contiguous"));
            let (u0, u1) = u[j * width..(j + 2) * width].split_at(width);
            let (w0, w1) = w[j * width..(j + 2) * width].split_at(width);
            let h2 = cell.h * cell.h;
            let slope = 2.0 * I * cell.inverse_k2 / cell.h;
            for i in 0..width {
                let l = cell.local(i);
                let [s, p, z] = [0, 1, 2].map(|c| sum_and_difference(rows[c][i], rows[c + 3][i]));
                let (u_sum, u_step) = (u0[i] + u1[i], u1[i] - u0[i]);
                let (w_sum, w_step) = (w0[i] + w1[i], w1[i] - w0[i]);
                let [gb, gc] = [h2 * l.b, h2 * l.c];
                let cross = 2.0 * SQRT3 * I * (l.q * cell.h) * l.b;
                let q2 = l.q * l.q;
                let e_s = [l.sum * u_sum - gb * s[0], l.difference * u_step - gc * s[1]];
                let e_p = [
                    -slope * w_step + cell.inverse_k2 * p[0],
                    slope * (SQRT3 * l.x2 * l.b) * w_sum
                        + cell.inverse_k2 * (cross * z[0] + (1.0 - 12.0 * l.b) * p[1]),
                ];
                let e_z = [
                    cell.inverse_k2 * (-l.q * l.sum * w_sum + (1.0 - q2 * gb) * z[0] - cross * p[1]),
                    cell.inverse_k2 * (-l.q * l.difference * w_step + (1.0 - q2 * gc) * z[1]),
                ];
                for (c, [sum, difference]) in [e_s, e_p, e_z].into_iter().enumerate() {
                    rows[c][i] = 0.5 * (sum - difference);
                    rows[c + 3][i] = 0.5 * (sum + difference);
                }
            }
        }
    }

    /// k̄² of each cell.
    pub fn mean_k2(&self) -> &[Complex64] {
        &self.mean_k2
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let functions: usize = self.functions.iter().map(|f| f.len()).sum();
        functions * size_of::<Complex64>() + self.electric.bytes() + self.magnetic.bytes()
    }
}

fn sum_and_difference(first: Complex64, second: Complex64) -> [Complex64; 2] {
    [first + second, second - first]
}

fn rows_of<'a>(y: &'a ArrayViewMut2<Complex64>, cell: usize) -> [&'a [Complex64]; CELL_ROWS] {
    std::array::from_fn(|r| y.row(CELL_ROWS * cell + r).to_slice().expect("rows of a block are contiguous"))
}
