//! Interpolation points and bubble functions of one cell in z, for every degree of the exact
//! scheme.
//!
//! A field in a cell is the mean medium's exact solution through the two node values, plus `degree
//! − 1` bubbles that vanish at the nodes. Bubbles are eigenfunctions of the mass matrix among
//! integrated Legendre polynomials, so that the mean operator is diagonal on them: −1/h + kz² h λ.
//! The contrast acts at the Gauss–Lobatto points (degree 1: the nodes, "tents"; degree 2: nodes and
//! midpoints) with moments of V against their Lagrange functions.

use crate::numerics::dense::{MatrixEntry, symmetric_eigen};
use faer::Mat;
use gauss_quad::GaussLegendre;

/// Largest degree supported.
pub const MAX_DEGREE: usize = 4;

/// Interpolation points and bubbles on the unit cell 0 ≤ t ≤ 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Degree of the polynomials; a cell has `degree` − 1 inner points.
    pub degree: usize,
    /// Gauss–Lobatto points, the nodes included.
    pub points: Vec<f64>,
    /// Integral of each point's Lagrange function.
    pub weights: Vec<f64>,
    /// Ratio λ of mass to stiffness of each bubble on the unit cell.
    pub lambda: Vec<f64>,
    /// Value of each bubble (row) at each inner point (column).
    pub bubbles: Vec<Vec<f64>>,
    /// Inverse of `bubbles`: amplitude of each bubble (row) from the values at the inner points.
    pub amplitudes: Vec<Vec<f64>>,
}

impl Element {
    /// Tables for `degree` from 1 to 4.
    pub fn new(degree: usize) -> Element {
        let points = lobatto_points(degree);
        let rule = GaussLegendre::new(degree + 2).expect("at least two nodes");
        let weights = (0..=degree).map(|q| rule.integrate(0.0, 1.0, |t| lagrange(&points, q, t))).collect();
        let (lambda, modes) = bubble_modes(degree - 1, &rule);
        let value = |mode: &[f64], t: f64| {
            mode.iter().enumerate().map(|(i, c)| c * integrated_legendre(i + 1, t)).sum()
        };
        let bubbles: Vec<Vec<f64>> =
            modes.iter().map(|m| points[1..degree].iter().map(|&t| value(m, t)).collect()).collect();
        Element { degree, points, weights, lambda, amplitudes: inverse(&bubbles), bubbles }
    }

    /// Values of all Lagrange functions at t.
    pub fn shape_functions(&self, t: f64) -> [f64; MAX_DEGREE + 1] {
        std::array::from_fn(|q| if q <= self.degree { lagrange(&self.points, q, t) } else { 0.0 })
    }
}

fn lobatto_points(degree: usize) -> Vec<f64> {
    let inner: &[f64] = match degree {
        1 => &[],
        2 => &[0.0],
        3 => &[0.447_213_595_499_957_9],      // 1/√5
        4 => &[0.0, 0.654_653_670_707_977_1], // √(3/7)
        _ => unreachable!("degrees are 1 to MAX_DEGREE"),
    };
    let mirrored = inner.iter().filter(|&&x| x > 0.0).map(|x| -x);
    let mut points: Vec<f64> = inner.iter().copied().chain(mirrored).chain([-1.0, 1.0]).collect();
    points.sort_by(f64::total_cmp);
    points.iter().map(|x| 0.5 * (x + 1.0)).collect()
}

fn lagrange(points: &[f64], q: usize, t: f64) -> f64 {
    points.iter().enumerate().filter(|&(i, _)| i != q).map(|(_, &p)| (t - p) / (points[q] - p)).product()
}

/// Legendre polynomial P_n(x).
pub(crate) fn legendre(n: usize, x: f64) -> f64 {
    let mut a = 1.0;
    let mut b = x;
    for k in 1..=n {
        (a, b) = (b, ((2 * k + 1) as f64 * x * b - k as f64 * a) / (k + 1) as f64);
    }
    a
}

/// Integrated Legendre polynomial i ≥ 1 on the unit cell, of unit stiffness ∫ (dN/dt)² dt.
fn integrated_legendre(i: usize, t: f64) -> f64 {
    let x = 2.0 * t - 1.0;
    (legendre(i + 1, x) - legendre(i - 1, x)) / (2.0 * ((2 * i + 1) as f64).sqrt())
}

/// Amplitudes from values: the inverse of the transposed table.
fn inverse(table: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = table.len();
    if n == 0 {
        return Vec::new();
    }
    let inverse = f64::inverse(Mat::from_fn(n, n, |point, bubble| table[bubble][point]).as_ref());
    (0..n).map(|i| (0..n).map(|j| inverse[(i, j)]).collect()).collect()
}

/// Eigenvalues and eigenvectors of the bubbles' mass matrix.
fn bubble_modes(count: usize, rule: &GaussLegendre) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mass = |i: usize, j: usize| {
        rule.integrate(0.0, 1.0, |t| integrated_legendre(i + 1, t) * integrated_legendre(j + 1, t))
    };
    if count == 0 {
        return (Vec::new(), Vec::new());
    }
    let matrix = Mat::from_fn(count, count, mass);
    let (lambda, vectors) = symmetric_eigen(&matrix).expect("a small symmetric matrix has eigenvalues");
    (lambda, vectors.col_iter().map(|vector| vector.iter().copied().collect()).collect())
}

#[cfg(test)]
#[path = "element_tests.rs"]
mod tests;
