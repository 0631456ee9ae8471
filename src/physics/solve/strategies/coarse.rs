//! The lowest harmonics solved exactly, for grains that resonate by themselves.
//!
//! Resonances of strong scatterers live in the lateral harmonics below the wavenumber in the
//! grains; higher ones decay, and the mean medium's inverse treats them well. On the lower ones,
//! (A + V) is block tridiagonal along z: eliminated once in single precision, it gives the operator
//! Q = (1 + A⁻¹V)⁻¹ restricted to them, which GMRES applies from the right. The residual remains
//! the true one. It costs the cube of the number of these harmonics per cell, once (15 % of
//! n = 2.65, 235 nm, 2 µm, 550 nm, κ = 0: 281 harmonics, and 35 steps instead of 1650 of IDR(12)).

mod cell;

use crate::numerics::dense::MatrixEntry;
use crate::numerics::fourier::{Real, narrow};
use crate::wave::Problem;
use cell::{CoarseCell, add_product, product};
use faer::{Mat, c32};
use num_complex::{Complex, Complex64};
use std::f64::consts::TAU;

/// Largest lateral wavenumber of the harmonics solved exactly, over that in the grains: with 1.0
/// the solve above takes 135 steps, with 1.3 it takes 35.
const CUT: f64 = 1.3;

/// Operations of dense elimination that take as long as one unknown's share in one application with
/// the vector sums of IDR(12): 45 a nanosecond of a core against 80 ns.
const APPLICATION: f64 = 3600.0;

/// The operator Q, ready to be applied to fields.
pub(super) struct CoarseSpace<S: Real = f32> {
    /// Columns of the harmonics solved exactly, and number of all.
    columns: Vec<usize>,
    harmonics: usize,
    /// At each inner point, the value of each bubble; of each bubble, its share in each value.
    bubbles: Vec<Vec<f64>>,
    amplitudes: Vec<Vec<f64>>,
    /// The mean operator on the nodes: diagonal of each, coupling of each with the next.
    diagonal: Vec<Vec<Complex<S>>>,
    off: Vec<Vec<Complex<S>>>,
    cells: Vec<CoarseCell<S>>,
    /// Elimination of the nodes D_j − F_{j−1} D′⁻¹_{j−1} E_{j−1} = D′_j: D′⁻¹ of each node. The
    /// cells apply F and E.
    pivots: Vec<Mat<Complex<S>>>,
}

impl<S: Real> CoarseSpace<S>
where
    Complex<S>: MatrixEntry,
{
    /// Eliminates cells and nodes from the illuminated face on.
    fn eliminate(&mut self, problem: &Problem) {
        let mut before: Option<Mat<Complex<S>>> = None;
        for j in 0..self.diagonal.len() {
            let mut block = cell::contrast_matrix(problem, &self.columns, self.degree() * j);
            add_diagonal(&mut block, &self.diagonal[j]);
            if let Some(taken) = before.take() {
                block += taken;
            }
            let next = self.eliminate_cell(problem, j);
            if let Some([first, ..]) = &next {
                block += first;
            }
            self.pivots.push(Complex::inverse(block.as_ref()));
            before = next.map(|[_, upper, lower, second]| second - lower * (&self.pivots[j] * upper));
        }
    }

    /// Eliminates the inner points of the cell behind a node, if there is one, which leaves
    /// couplings of its nodes.
    fn eliminate_cell(&mut self, problem: &Problem, node: usize) -> Option<[Mat<Complex<S>>; 4]> {
        let off = self.off.get(node)?;
        let (cell, mut couplings) = CoarseCell::new(problem, &self.columns, node);
        couplings[1..3].iter_mut().for_each(|coupling| add_diagonal(coupling, off));
        self.cells.push(cell);
        Some(couplings)
    }

    fn degree(&self) -> usize {
        self.bubbles.len() + 1
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let nodes = self.pivots.len() * self.columns.len().pow(2);
        (nodes + self.cells.iter().map(CoarseCell::<S>::entries).sum::<usize>()) * size_of::<Complex<S>>()
    }

    /// Applies v ← Q v on the harmonics solved exactly; the others stay.
    pub fn apply<T: Real>(&self, v: &mut [Complex<T>]) {
        let read = |row: &[Complex<T>]| -> Vec<Complex<S>> {
            self.columns.iter().map(|&i| narrow(Complex::new(row[i].re.wide(), row[i].im.wide()))).collect()
        };
        let mut field: Vec<Vec<Complex<S>>> = v.chunks(self.harmonics).map(read).collect();
        self.solve(&mut field);
        for (p, row) in field.iter().enumerate() {
            for (&i, z) in self.columns.iter().zip(row) {
                v[p * self.harmonics + i] = narrow(Complex::new(z.re.wide(), z.im.wide()));
            }
        }
    }

    /// Solves (A + V) u = A w; planes of w are replaced by those of u.
    fn solve(&self, field: &mut [Vec<Complex<S>>]) {
        let degree = self.degree();
        let mut nodes = self.node_products(field);
        // loads of the bubbles of w on the nodes, the inner points eliminated
        let mut inner = Vec::with_capacity(self.cells.len());
        for (j, cell) in self.cells.iter().enumerate() {
            let values = combined(&self.bubbles, &field[degree * j + 1..degree * (j + 1)]).concat();
            let caused = cell.bubbles(&values);
            [0, 1].into_iter().for_each(|side| cell.unload(side, &caused, &mut nodes[j + side]));
            let [values, _] = caused;
            inner.push(values);
        }
        self.solve_nodes(&mut nodes);
        for (j, (cell, inner)) in self.cells.iter().zip(inner).enumerate() {
            let values = cell.expanded(inner, [&nodes[j], &nodes[j + 1]]);
            let values: Vec<_> = values.chunks(self.columns.len()).map(<[Complex<S>]>::to_vec).collect();
            field[degree * j + 1..degree * (j + 1)].clone_from_slice(&combined(&self.amplitudes, &values));
        }
        nodes.into_iter().enumerate().for_each(|(j, row)| field[degree * j] = row);
    }

    /// The mean operator's product with the nodes of w.
    fn node_products(&self, field: &[Vec<Complex<S>>]) -> Vec<Vec<Complex<S>>> {
        let node = |j: usize| &field[self.degree() * j];
        let mut out: Vec<Vec<Complex<S>>> =
            self.diagonal.iter().enumerate().map(|(j, diagonal)| product(diagonal, node(j))).collect();
        for (j, off) in self.off.iter().enumerate() {
            for (to, from) in [(j, j + 1), (j + 1, j)] {
                out[to].iter_mut().zip(off.iter().zip(node(from))).for_each(|(out, (o, w))| *out += o * w);
            }
        }
        out
    }

    fn solve_nodes(&self, nodes: &mut [Vec<Complex<S>>]) {
        for j in 0..nodes.len() {
            if j > 0 {
                let [before, here] = nodes.get_disjoint_mut([j - 1, j]).expect("two nodes");
                self.couple(j - 1, [0, 1], before, here);
            }
            let mut solved = self.none();
            add_product(&mut solved, &self.pivots[j], &nodes[j]);
            nodes[j] = solved;
        }
        for j in (0..self.cells.len()).rev() {
            let [here, after] = nodes.get_disjoint_mut([j, j + 1]).expect("two nodes");
            let mut load = self.none();
            self.couple(j, [1, 0], after, &mut load);
            add_product(here, &self.pivots[j], &load);
        }
    }

    /// Subtracts from the load of one node of a cell what the other couples into it.
    fn couple(&self, cell: usize, [from, to]: [usize; 2], node: &[Complex<S>], load: &mut [Complex<S>]) {
        self.cells[cell].unload(to, &self.cells[cell].reached(from, node), load);
        load.iter_mut().zip(self.off[cell].iter().zip(node)).for_each(|(load, (off, x))| *load -= off * x);
    }

    fn none(&self) -> Vec<Complex<S>> {
        vec![Complex::default(); self.columns.len()]
    }
}

/// The harmonics below the cut, with what solving them exactly costs.
pub(super) struct CoarsePlan<'a> {
    pub problem: &'a Problem,
    pub columns: Vec<usize>,
}

impl<'a> CoarsePlan<'a> {
    /// The plan for a problem.
    pub fn new(problem: &'a Problem) -> Self {
        let media = &problem.media;
        let highest = media.inclusions.iter().chain(&media.backgrounds).map(|eta| eta.re).fold(0.0, f64::max);
        let limit = (CUT * highest * TAU / problem.incidence.wavelength_um).powi(2);
        let square = |&i: &usize| problem.lateral[i].iter().map(|k| k * k).sum::<f64>();
        let columns = (0..problem.harmonics.len()).filter(|i| square(i) < limit).collect();
        Self { problem, columns }
    }

    /// Memory of the operator and of its construction, bytes.
    pub fn bytes(&self) -> f64 {
        // on top: the inverse of one cell by blocks, its couplings and what they are made of
        let [cells, inner] = self.sizes();
        let blocks = cells * (inner + 1.0) + inner * inner + 2.0 * inner + 8.0;
        (self.columns.len().pow(2) * size_of::<c32>()) as f64 * blocks
    }

    /// Applications of the operator by short recurrences that take as long as the elimination.
    pub fn in_applications(&self) -> f64 {
        let [cells, inner] = self.sizes();
        // an inverse each point and each node; products of the nodes; products of the blocks
        let blocks = (0..inner as usize).map(|k| (k * (k + 2)) as f64).sum::<f64>();
        let operations = 8.0 * (self.columns.len() as f64).powi(3) * cells * (inner + 1.0 + 2.0 + blocks);
        operations / (APPLICATION * self.problem.unknowns() as f64)
    }

    /// Eliminates.
    pub fn carried_out<S: Real>(self) -> CoarseSpace<S>
    where
        Complex<S>: MatrixEntry,
    {
        let Self { problem, columns } = self;
        let node = |&i: &usize| problem.mean.node_matrix(i, problem.end_conditions(i));
        let (diagonal, off): (Vec<_>, Vec<_>) = columns.iter().map(node).unzip();
        let element = &problem.mean.element;
        let value = |p: usize| element.bubbles.iter().map(|bubble| bubble[p - 1]).collect();
        let harmonics = problem.harmonics.len();
        let amplitudes = element.amplitudes.clone();
        let bubbles = (1..element.degree).map(value).collect();
        let diagonal = transposed(&diagonal);
        let off = transposed(&off);
        let cells = Vec::new();
        let pivots = Vec::new();
        let mut space = CoarseSpace { columns, harmonics, bubbles, amplitudes, diagonal, off, cells, pivots };
        space.eliminate(problem);
        space
    }

    /// Number of cells, and of inner points of each.
    fn sizes(&self) -> [f64; 2] {
        [self.problem.coverage.grid.cells() as f64, self.problem.mean.element.degree as f64 - 1.0]
    }
}

/// Node or cell → column.
fn transposed<S: Real>(table: &[Vec<Complex64>]) -> Vec<Vec<Complex<S>>> {
    (0..table[0].len()).map(|j| table.iter().map(|column| narrow(column[j])).collect()).collect()
}

/// Sums of rows with the factors of each row of a table.
fn combined<S: Real>(table: &[Vec<f64>], rows: &[Vec<Complex<S>>]) -> Vec<Vec<Complex<S>>> {
    let entry = |factors: &[f64], g: usize| factors.iter().zip(rows).map(|(&x, row)| row[g] * S::of(x)).sum();
    table.iter().map(|factors| (0..rows[0].len()).map(|g| entry(factors, g)).collect()).collect()
}

fn add_diagonal<S: Real>(matrix: &mut Mat<Complex<S>>, diagonal: &[Complex<S>])
where
    Complex<S>: MatrixEntry,
{
    diagonal.iter().enumerate().for_each(|(g, d)| matrix[(g, g)] += d);
}
