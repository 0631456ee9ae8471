//! The lowest harmonics of the vector wave eliminated, for grains that resonate by themselves.
//!
//! A⁻¹ = G + P T⁻¹ L: sources act within their cell (G) and load its nodes (L), whose values (T the
//! nodes' system) reach the cell's moments (P). With X = (1 + G V)⁻¹ P and S = T + L V X on the
//! lowest harmonics,
//!
//! (1 + A⁻¹V) (1 − X S⁻¹ L V) = 1 + G V
//!
//! there: all that is left of them acts within single cells, and GMRES, which applies the second
//! factor from the right, has done with it in a few steps. S is block tridiagonal; L V is applied
//! on all harmonics. (1 + G V)⁻¹ itself would be half as large again, and serves worse: 18 instead
//! of 12 steps, as it takes the highest of its harmonics for the last ones there are.
//!
//! Measured on 15 % of n = 2.7, 250 nm, 1 µm, 560 nm, cells of 0.8 µm, to 1e-3: 16 steps instead of
//! 126, with the 45 harmonics below the wavenumber in the grains of 361.

use super::VectorProblem;
use crate::numerics::dense::MatrixEntry;
use crate::numerics::fourier::{Real, narrow};
use crate::wave::Resolution;
use crate::wave::maxwell::kernels::UnitResponses;
use crate::wave::maxwell::mean::{CELL_ROWS, VectorMean};
use crate::wave::maxwell::scattering::VectorScattering;
use crate::wave::operator::inverse::row_of;
use faer::{ColMut, ColRef, Mat, c32};
use ndarray::Array2;
use num_complex::{Complex, Complex64};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Lateral wavenumbers of the harmonics eliminated, over that in the grains. On 15 % of n = 2.7,
/// 250 nm, 1 µm, 440 nm, a residual of 1e-3 takes 72 steps with the fourth, 34 with the second and
/// 16 with 1.15, which costs three times the second's elimination.
const CUTS: [f64; 6] = [1.1, 1.0, 0.9, 0.8, 0.7, 0.6];
/// Cuts where the steps after a cheap elimination remain many.
const WIDE_CUTS: [f64; 2] = [1.1, 1.3];
/// Applications that an elimination may cost before a lower cut is preferred.
const AMPLE: f64 = 60.0;
/// Operations of dense elimination that take as long as one unknown's share in one application with
/// the vector sums of IDR(12): 45 a nanosecond of a core against 80 ns.
const APPLICATION: f64 = 3600.0;
/// Cells eliminated at a time.
const TOGETHER: usize = 2;
/// Planes of a cell.
const PLANES: usize = 2;
/// Components of a plane's field.
const COMPONENTS: usize = 3;
/// Number of harmonics squared times this: what is held of a cell, and what eliminating it takes.
const KEPT: f64 = 24.0 + 3.0 * 4.0;
const PASSING: f64 = 160.0;
/// Number of harmonics cubed times this: operations for a cell. Factors of 6 N rows, their
/// solution for 4 N columns, two products of the contrast, inverse and products of a node.
const OPERATIONS: f64 = 8.0 * (72.0 + 144.0 + 72.0 + 32.0);

/// The harmonics to be eliminated, with what that costs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct VectorCoarsePlan {
    columns: Vec<usize>,
    cells: usize,
    unknowns: usize,
}

impl VectorCoarsePlan {
    /// The plan with the highest cut that costs little and holds at most `bytes`; if all are dear,
    /// that with the lowest.
    pub fn within(problem: &VectorProblem, bytes: f64) -> Option<Self> {
        let plans = CUTS.iter().map(|&cut| Self::new(problem, cut));
        let mut last = None;
        for plan in plans.filter(|plan| !plan.columns.is_empty() && plan.bytes() <= bytes) {
            if plan.in_applications() <= AMPLE {
                return Some(plan);
            }
            last = Some(plan);
        }
        last
    }

    /// The next plan with more harmonics that holds at most `bytes`, whatever it costs.
    pub fn wider(&self, problem: &VectorProblem, bytes: f64) -> Option<Self> {
        let plans = WIDE_CUTS.iter().map(|&cut| Self::new(problem, cut));
        plans.filter(|plan| plan.bytes() <= bytes).find(|plan| plan.columns.len() > self.columns.len())
    }

    /// The harmonics below `cut` times the wavenumber in the densest medium.
    pub fn new(problem: &VectorProblem, cut: f64) -> Self {
        let media = &problem.media;
        let highest = media.inclusions.iter().chain(&media.backgrounds).map(|eta| eta.re).fold(0.0, f64::max);
        let limit = (cut * highest * TAU / problem.incidence.wavelength_um).powi(2);
        let square = |&i: &usize| problem.lateral[i].iter().map(|k| k * k).sum::<f64>();
        let columns = (0..problem.harmonics.len()).filter(|i| square(i) < limit).collect();
        let cells = problem.moments.grid.cells();
        VectorCoarsePlan { columns, cells, unknowns: CELL_ROWS * cells * problem.harmonics.len() }
    }

    /// Memory of the operator and of its construction, bytes.
    pub fn bytes(&self) -> f64 {
        let squares = self.cells as f64 * KEPT + TOGETHER as f64 * PASSING;
        let vectors = 3.0 * (self.unknowns * size_of::<c32>()) as f64;
        (self.columns.len().pow(2) * size_of::<c32>()) as f64 * squares + vectors
    }

    /// Applications of the operator by short recurrences that take as long as the elimination.
    pub fn in_applications(&self) -> f64 {
        let operations = OPERATIONS * (self.columns.len() as f64).powi(3) * self.cells as f64;
        operations / (APPLICATION * self.unknowns as f64)
    }

    /// Eliminates.
    pub fn carried_out(self, problem: &VectorProblem) -> VectorCoarseSpace {
        let mean = problem.operator().mean.restricted(&self.columns);
        let elimination = VectorElimination {
            problem,
            columns: &self.columns,
            mean: &mean,
            unit: mean.mean_k2[0].norm().sqrt(),
        };
        let (shares, nodes) = elimination.carried_out();
        let work = Mutex::new(CoarseWork::default());
        let unit = elimination.unit as f32;
        VectorCoarseSpace {
            mean: mean.narrowed(),
            harmonics: problem.harmonics.len(),
            plan: self,
            unit,
            shares,
            nodes,
            work,
        }
    }
}

/// The operator 1 − X S⁻¹ L V, ready to be applied to fields.
pub(crate) struct VectorCoarseSpace {
    /// What was eliminated.
    pub plan: VectorCoarsePlan,
    /// The mean operator on the harmonics eliminated.
    mean: VectorMean<f32>,
    /// Number of all harmonics.
    harmonics: usize,
    /// Wavenumber by which h is divided, so that it is as large as E.
    unit: f32,
    /// X of each cell: moments due to E_s and h at the first and at the second node.
    shares: Vec<Mat<c32>>,
    nodes: Vec<EliminatedNode>,
    work: Mutex<CoarseWork>,
}

/// A node of S eliminated, vectors of E_s and h one after the other.
struct EliminatedNode {
    /// Inverse D of its pivot.
    inverse: Mat<c32>,
    /// Its coupling into the next node, and D times that of the next node into it; none at the
    /// last.
    next: Option<[Mat<c32>; 2]>,
}

/// Arrays of one application.
#[derive(Default)]
struct CoarseWork {
    field: Array2<c32>,
    product: Array2<c32>,
}

impl VectorCoarseSpace {
    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let entries = |matrix: &Mat<c32>| matrix.nrows() * matrix.ncols();
        let node = |node: &EliminatedNode| {
            entries(&node.inverse) + node.next.iter().flatten().map(entries).sum::<usize>()
        };
        let matrices =
            self.shares.iter().map(entries).sum::<usize>() + self.nodes.iter().map(node).sum::<usize>();
        (matrices + 2 * self.plan.unknowns) * size_of::<c32>()
    }

    /// Applies v ← v − X S⁻¹ L V v, with the operator in single precision.
    pub fn apply<T: Real>(&self, operator: &VectorScattering<f32>, v: &mut [Complex<T>]) {
        let mut nodes = self.loads(operator, v);
        self.solve_nodes(&mut nodes);
        let cells = v.par_chunks_mut(CELL_ROWS * self.harmonics).zip(&self.shares).enumerate();
        cells.for_each(|(j, (rows, share))| {
            let mut moments = vec![c32::default(); share.nrows()];
            add_product(&mut moments, share, &nodes[j..j + 2].concat());
            for (row, moments) in rows.chunks_mut(self.harmonics).zip(moments.chunks(self.plan.columns.len()))
            {
                for (&i, z) in self.plan.columns.iter().zip(moments) {
                    row[i] -= Complex::new(T::of(z.re.into()), T::of(z.im.into()));
                }
            }
        });
    }

    /// Loads L V v of the nodes.
    fn loads<T: Real>(&self, operator: &VectorScattering<f32>, v: &[Complex<T>]) -> Vec<Vec<c32>> {
        // Not locked during the product: its parallel loops may begin another application while
        // they wait.
        let mut work = std::mem::take(&mut *self.lock_work());
        let CoarseWork { field, product } = &mut work;
        let shape = (v.len() / self.harmonics, self.harmonics);
        if field.dim() != shape {
            *field = Array2::zeros(shape);
            *product = Array2::zeros(shape);
        }
        field.iter_mut().zip(v).for_each(|(f, z)| *f = c32::new(z.re.wide() as f32, z.im.wide() as f32));
        operator.contrast_product(field.view(), product);
        let count = self.plan.columns.len();
        let lowest = |(r, g): (usize, usize)| row_of(product, r)[self.plan.columns[g]];
        let lowest = Array2::from_shape_fn((shape.0, count), lowest);
        *self.lock_work() = work;
        let [u, w] = self.mean.node_loads(&lowest);
        let node =
            |(u, w): (&[c32], &[c32])| u.iter().copied().chain(w.iter().map(|w| w * self.unit)).collect();
        u.chunks(count).zip(w.chunks(count)).map(node).collect()
    }

    fn lock_work(&self) -> MutexGuard<'_, CoarseWork> {
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn solve_nodes(&self, nodes: &mut [Vec<c32>]) {
        for j in 0..nodes.len() {
            let mut solved = vec![c32::default(); nodes[j].len()];
            add_product(&mut solved, &self.nodes[j].inverse, &nodes[j]);
            nodes[j] = solved;
            if let Some([lower, _]) = &self.nodes[j].next {
                let taken = multiplied(lower, &nodes[j]);
                nodes[j + 1].iter_mut().zip(taken).for_each(|(load, taken)| *load -= taken);
            }
        }
        for (j, node) in self.nodes.iter().enumerate().rev() {
            if let Some([_, upper]) = &node.next {
                let taken = multiplied(upper, &nodes[j + 1]);
                nodes[j].iter_mut().zip(taken).for_each(|(value, taken)| *value -= taken);
            }
        }
    }
}

/// The matrices of the elimination being made.
struct VectorElimination<'a> {
    problem: &'a VectorProblem,
    columns: &'a [usize],
    /// The mean operator on these harmonics.
    mean: &'a VectorMean,
    /// As in [`VectorCoarseSpace`].
    unit: f64,
}

impl VectorElimination<'_> {
    /// X of each cell, and the nodes eliminated from the illuminated face on:
    /// D_j = (S_jj − S_{j,j−1} D_{j−1} S_{j−1,j})⁻¹.
    fn carried_out(&self) -> (Vec<Mat<c32>>, Vec<EliminatedNode>) {
        let count = 2 * self.columns.len();
        let cells: Vec<usize> = (0..self.mean.heights.len()).collect();
        let mut shares = Vec::with_capacity(cells.len());
        let mut nodes = Vec::with_capacity(cells.len() + 1);
        let mut left = self.diagonal(0);
        for group in cells.chunks(TOGETHER) {
            let eliminated: Vec<_> = group.par_iter().map(|&j| self.cell(j)).collect();
            for (&j, (share, coupling)) in group.iter().zip(eliminated) {
                let block = |r: usize, c: usize| coupling.submatrix(r * count, c * count, count, count);
                let off = self.off(j);
                let inverse = c32::inverse((&left + block(0, 0)).as_ref());
                let upper = &inverse * with_diagonal(block(0, 1).to_owned(), &off);
                let lower = with_diagonal(block(1, 0).to_owned(), &off);
                left = self.diagonal(j + 1) + block(1, 1) - &lower * &upper;
                nodes.push(EliminatedNode { inverse, next: Some([lower, upper]) });
                shares.push(share);
            }
        }
        nodes.push(EliminatedNode { inverse: c32::inverse(left.as_ref()), next: None });
        (shares, nodes)
    }

    /// X of a cell, and its part L V X of S.
    fn cell(&self, j: usize) -> (Mat<c32>, Mat<c32>) {
        let count = self.columns.len();
        let responses = self.mean.unit_responses(j);
        let units = [1.0, self.unit, 1.0, self.unit];
        let contrast = [0, 1].map(|q| self.contrast(PLANES * j + q));
        let factors = c32::factors(local(&responses, &contrast, count).as_ref());
        let mut share = Mat::<c32>::zeros(CELL_ROWS * count, 4 * count);
        for (node, unit) in units.iter().enumerate() {
            for (row, values) in responses.nodes[node].iter().enumerate() {
                for (g, &value) in values.iter().enumerate() {
                    share[(row * count + g, node * count + g)] = narrow(value * unit);
                }
            }
        }
        let share = c32::solve(&factors, share.as_ref());
        let rows = COMPONENTS * count;
        let mut coupling = Mat::<c32>::zeros(4 * count, 4 * count);
        for (q, contrast) in contrast.iter().enumerate() {
            let product = contrast * share.subrows(q * rows, rows);
            for column in 0..4 * count {
                let from = product.col_as_slice(column);
                for (node, to) in coupling.col_as_slice_mut(column).chunks_mut(count).enumerate() {
                    for (component, from) in from.chunks(count).enumerate() {
                        let loads = &responses.loads[COMPONENTS * q + component][node];
                        let terms = to.iter_mut().zip(from.iter().zip(loads));
                        terms.for_each(|(to, (z, load))| *to += z * narrow::<f32>(load * units[node]));
                    }
                }
            }
        }
        (share, coupling)
    }

    /// The contrast of a plane between harmonics and components s, p, z.
    fn contrast(&self, plane: usize) -> Mat<c32> {
        let count = self.columns.len();
        let operator = self.problem.operator();
        let Some(spectrum) = operator.spectrum(plane) else {
            return Mat::zeros(COMPONENTS * count, COMPONENTS * count);
        };
        let Resolution { nx, ny, .. } = self.problem.moments.grid.resolution;
        let order = |g: usize| self.problem.harmonics.orders[self.columns[g]];
        let axes: Vec<[[f64; 3]; 3]> = self.columns.iter().map(|&i| operator.axes(i)).collect();
        let mut matrix = Mat::zeros(COMPONENTS * count, COMPONENTS * count);
        for h in 0..count {
            for g in 0..count {
                let [m, n] = [0, 1].map(|k| order(g)[k] - order(h)[k]);
                let place = m.rem_euclid(nx as i32) as usize * ny + n.rem_euclid(ny as i32) as usize;
                let [xx, xy, yy, xz, yz, zz] = spectrum.each_ref().map(|component| component[place]);
                let tensor = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
                for (b, to) in axes[h].iter().enumerate() {
                    // V times the unit vector of component b
                    let product = tensor.map(|row| (0..3).map(|k| row[k] * to[k]).sum::<Complex64>());
                    for (a, from) in axes[g].iter().enumerate() {
                        let entry = (0..3).map(|k| product[k] * from[k]).sum::<Complex64>();
                        matrix[(a * count + g, b * count + h)] = narrow(entry);
                    }
                }
            }
        }
        matrix
    }

    /// The mean operator's part of S on a node, and between the nodes of a cell: of E_s, then of h.
    fn diagonal(&self, node: usize) -> Mat<c32> {
        let diagonal = self.mean.node_entries(|system, i| system.diagonal(node, i), self.unit);
        let count = diagonal.len();
        with_diagonal(Mat::zeros(count, count), &diagonal)
    }

    fn off(&self, cell: usize) -> Vec<Complex64> {
        self.mean.node_entries(|system, i| system.off(cell, i), self.unit)
    }
}

/// The matrix 1 + G V of a cell.
fn local(responses: &UnitResponses, contrast: &[Mat<c32>; PLANES], count: usize) -> Mat<c32> {
    let narrowed = |source: &[Vec<Complex64>; CELL_ROWS]| -> Vec<Vec<c32>> {
        source.iter().map(|row| row.iter().map(|&z| narrow(z)).collect()).collect()
    };
    let green: Vec<_> = responses.sources.iter().map(narrowed).collect();
    let mut matrix = Mat::<c32>::identity(CELL_ROWS * count, CELL_ROWS * count);
    let rows = COMPONENTS * count;
    for column in 0..PLANES * rows {
        let plane = column / rows;
        let from = contrast[plane].col_as_slice(column % rows);
        for (r, to) in matrix.col_as_slice_mut(column).chunks_mut(count).enumerate() {
            for (component, from) in from.chunks(count).enumerate() {
                let green = &green[COMPONENTS * plane + component][r];
                to.iter_mut().zip(from.iter().zip(green)).for_each(|(to, (z, g))| *to += z * g);
            }
        }
    }
    matrix
}

fn with_diagonal(mut matrix: Mat<c32>, diagonal: &[Complex64]) -> Mat<c32> {
    diagonal.iter().enumerate().for_each(|(g, &d)| matrix[(g, g)] += narrow::<f32>(d));
    matrix
}

/// Adds out ← out + matrix · v.
fn add_product(out: &mut [c32], matrix: &Mat<c32>, v: &[c32]) {
    let out = ColMut::from_slice_mut(out);
    c32::add_product(out.as_mat_mut(), 1.0.into(), matrix.as_ref(), ColRef::from_slice(v).as_mat());
}

fn multiplied(matrix: &Mat<c32>, v: &[c32]) -> Vec<c32> {
    let mut out = vec![c32::default(); matrix.nrows()];
    add_product(&mut out, matrix, v);
    out
}

#[cfg(test)]
#[path = "coarse_tests.rs"]
mod tests;
