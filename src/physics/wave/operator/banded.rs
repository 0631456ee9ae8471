//! Shifted mean problems in plane values: (a D + b Ã) u = f with D the lumped mass and Ã = E⁻ᵀ A
//! E⁻¹.
//!
//! E maps nodes and bubbles to values on planes. In plane values the contrast is diagonal at every
//! point, so that strategies which split the operator (relaxation, convergent Born) handle both
//! factors pointwise. One banded symmetric system per harmonic, factorised without pivoting: in
//! both uses the real or imaginary part is definite.

use super::cell::NodeCoefficients;
use crate::wave::{Field, MAX_DEGREE, Problem};
use ndarray::{Array2, Array3, ArrayView3, ArrayViewMut1, ArrayViewMut2, Axis, s};
use num_complex::Complex64;
use rayon::prelude::*;

/// Harmonics processed together by one thread.
const BLOCK: usize = 96;
const SIZE: usize = MAX_DEGREE + 1;

/// Factors L D Lᵀ of a shifted mean operator.
pub struct ShiftedMean {
    /// Array of rows × (degree + 1) × harmonics: 1/pivot, then the entries 1 … degree of L to the
    /// left.
    factors: Array3<Complex64>,
    degree: usize,
    /// Lumped mass D of every plane.
    pub(crate) mass: Vec<f64>,
}

impl ShiftedMean {
    /// Factorises a D + b Ã.
    pub fn new(problem: &Problem, mass_factor: Complex64, mean_factor: Complex64) -> ShiftedMean {
        let degree = problem.coverage.grid.element.degree;
        let (rows, harmonics) = problem.shape();
        let mass = problem.mean.plane_mass();
        let mut factors = Array3::zeros((rows, degree + 1, harmonics));
        let columns = factors.axis_iter_mut(Axis(2)).into_par_iter().enumerate();
        columns.with_min_len(BLOCK).for_each(|(i, mut out)| {
            out.assign(&shifted_factors(problem, i, &mass, [mass_factor, mean_factor]));
        });
        ShiftedMean { factors, degree, mass }
    }

    /// Solves in place; rows are planes, columns harmonics.
    pub fn solve(&self, y: &mut Field) {
        y.axis_chunks_iter_mut(Axis(1), BLOCK).into_par_iter().enumerate().for_each(|(b, mut y)| {
            let factors = self.factors.slice(s![.., .., b * BLOCK..b * BLOCK + y.ncols()]);
            self.forward_substitution(&factors, &mut y);
            self.back_substitution(&factors, &mut y);
        });
    }

    /// Forward substitution y ← L⁻¹ y for a block of harmonics, with its columns of the factors.
    #[inline]
    fn forward_substitution(&self, factors: &ArrayView3<Complex64>, y: &mut ArrayViewMut2<Complex64>) {
        for r in 0..y.nrows() {
            for k in 1..=self.degree.min(r) {
                let (before, mut here) = y.multi_slice_mut((s![r - k, ..], s![r, ..]));
                let step = ndarray::Zip::from(&mut here).and(&before).and(factors.slice(s![r, k, ..]));
                step.for_each(|y, &b, &l| *y -= l * b);
            }
        }
    }

    /// Back substitution y ← L⁻ᵀ D⁻¹ y for a block of harmonics, with its columns of the factors.
    #[inline]
    fn back_substitution(&self, factors: &ArrayView3<Complex64>, y: &mut ArrayViewMut2<Complex64>) {
        let rows = y.nrows();
        for r in (0..rows).rev() {
            y.row_mut(r).zip_mut_with(&factors.slice(s![r, 0, ..]), |y, d| *y *= d);
            for k in 1..=self.degree.min(rows - 1 - r) {
                let (mut here, after) = y.multi_slice_mut((s![r, ..], s![r + k, ..]));
                let step = ndarray::Zip::from(&mut here).and(&after).and(factors.slice(s![r + k, k, ..]));
                step.for_each(|y, &a, &l| *y -= l * a);
            }
        }
    }

    /// Applies planes ← (a D + b Ã)⁻¹ D f to values f at the points of all planes.
    pub fn solve_points(&self, problem: &Problem, points: &Field, planes: &mut Field) {
        problem.points_to_planes(points, planes);
        for (mut row, &mass) in planes.outer_iter_mut().zip(&self.mass) {
            row.iter_mut().for_each(|z| *z *= mass); // D f
        }
        self.solve(planes); // (a D + b Ã)⁻¹ ·
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.factors.len() * size_of::<Complex64>()
    }
}

/// Factors L D Lᵀ of a D + b Ã in one harmonic, as a band; `mass` is D, and a and b are the two
/// factors.
fn shifted_factors(problem: &Problem, harmonic: usize, mass: &[f64], [a, b]: [Complex64; 2]) -> Field {
    let mut band = problem.mean.plane_band(harmonic, problem.end_conditions(harmonic));
    band.iter_mut().for_each(|z| *z *= b);
    band.column_mut(0).iter_mut().zip(mass).for_each(|(z, &m)| *z += a * m);
    factorise(&mut band, problem.coverage.grid.element.degree);
    band
}

/// Factorises in place: column 0 becomes 1/pivot, column k the factor L(r, r − k).
fn factorise(band: &mut Field, degree: usize) {
    for r in 0..band.nrows() {
        let reach = degree.min(r);
        // Entries from the leftmost: products L(r, j) d_j first, divided by d_c afterwards.
        for k in (1..=reach).rev() {
            let c = r - k;
            let inner = (1..=reach - k).map(|q| (k + q, q)).filter(|&(_, q)| q <= degree.min(c));
            let sum: Complex64 = inner.map(|(a, q)| band[[r, a]] * band[[c, q]]).sum();
            band[[r, k]] -= sum;
        }
        for k in 1..=reach {
            let scaled = band[[r, k]] * band[[r - k, 0]];
            let product = band[[r, k]] * scaled;
            band[[r, 0]] -= product;
            band[[r, k]] = scaled;
        }
        band[[r, 0]] = 1.0 / band[[r, 0]];
    }
}

impl super::mean::MeanOperator {
    /// Lumped mass of every plane: the Gauss–Lobatto weights of the cells it touches.
    pub fn plane_mass(&self) -> Vec<f64> {
        let degree = self.element.degree;
        let mut mass = vec![0.0; degree * self.heights.len() + 1];
        for (j, h) in self.heights.iter().enumerate() {
            self.element.weights.iter().enumerate().for_each(|(q, w)| mass[degree * j + q] += w * h);
        }
        mass
    }

    /// The operator Ã of one harmonic as a band: rows × (degree + 1), column k the entry (r, r −
    /// k).
    pub fn plane_band(&self, harmonic: usize, ends: [Complex64; 2]) -> Field {
        let degree = self.element.degree;
        let rows = degree * self.heights.len() + 1;
        let mut band = Array2::zeros((rows, degree + 1));
        band[[0, 0]] = ends[0];
        band[[rows - 1, 0]] = ends[1];
        for cell in 0..self.heights.len() {
            let element = self.plane_element(cell, harmonic);
            for a in 0..=degree {
                (0..=a).for_each(|b| band[[degree * cell + a, a - b]] += element[a][b]);
            }
        }
        band
    }

    /// Matrix of one cell between its planes.
    fn plane_element(&self, cell: usize, harmonic: usize) -> [[Complex64; SIZE]; SIZE] {
        let degree = self.element.degree;
        let node = NodeCoefficients::new(self.kz2(cell, harmonic), self.heights[cell], self.scheme);
        let mut matrix = [[Complex64::default(); SIZE]; SIZE];
        matrix[0][0] = node.diagonal;
        matrix[degree][degree] = node.diagonal;
        matrix[0][degree] = node.off;
        matrix[degree][0] = node.off;
        for bubble in 0..degree - 1 {
            let g = self.bubble_functional(cell, bubble, harmonic);
            let d = self.bubble(cell, bubble, harmonic);
            for a in 0..=degree {
                (0..=degree).for_each(|b| matrix[a][b] += d * g[a] * g[b]);
            }
        }
        matrix
    }

    /// A bubble's amplitude as a linear function of the cell's plane values.
    fn bubble_functional(&self, cell: usize, bubble: usize, harmonic: usize) -> [Complex64; SIZE] {
        let degree = self.element.degree;
        let mut g = [Complex64::default(); SIZE];
        for q in 1..degree {
            let amplitude = self.element.amplitudes[bubble][q - 1];
            g[q] = amplitude.into();
            g[0] -= amplitude * self.inverse.left_share[q - 1][[cell, harmonic]];
            g[degree] -= amplitude * self.inverse.left_share[degree - q - 1][[cell, harmonic]];
        }
        g
    }

    /// Converts plane values to nodes and bubbles, in place (E⁻¹).
    pub fn to_unknowns(&self, planes: &mut Field) {
        let degree = self.element.degree;
        for cell in (0..self.heights.len()).filter(|_| degree > 1) {
            let mut part = planes.slice_mut(s![degree * cell..=degree * (cell + 1), ..]);
            let columns = part.axis_iter_mut(Axis(1)).into_par_iter().enumerate().with_min_len(256);
            columns.for_each(|(i, u)| self.cell_to_unknowns(cell, i, u));
        }
    }

    /// Converts one cell's plane values in one harmonic to its nodes and bubbles, in place.
    #[inline]
    fn cell_to_unknowns(&self, cell: usize, harmonic: usize, mut u: ArrayViewMut1<Complex64>) {
        let degree = self.element.degree;
        let values: [Complex64; SIZE] = std::array::from_fn(|q| if q <= degree { u[q] } else { 0.0.into() });
        for bubble in 0..degree - 1 {
            let g = self.bubble_functional(cell, bubble, harmonic);
            u[1 + bubble] = g.iter().zip(&values).map(|(g, v)| g * v).sum();
        }
    }

    /// Converts nodes and bubbles to plane values (E).
    pub fn to_planes(&self, unknowns: &Field) -> Field {
        let mut planes = Array2::zeros(unknowns.dim());
        planes.outer_iter_mut().into_par_iter().enumerate().for_each(|(p, mut row)| {
            self.inverse.plane_values(&unknowns.view(), p, row.as_slice_mut().expect("rows are contiguous"));
        });
        planes
    }
}
