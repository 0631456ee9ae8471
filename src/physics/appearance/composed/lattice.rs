//! Orders of light at 0°, and the diffuse light that they stand for.
//!
//! Whatever its cell, orders of light at 0° lie on a lattice about the normal. In small cells few
//! of them stand for a hemisphere, and their sum over a smooth distribution D is not its integral,
//! not even in the mean over cells of all shapes: of light scattered alike to all sides 12 % more
//! than there is seem to leave at 45° from cells of one and a half wavelengths. (Oblique light has
//! other orders in every cell, and no such bias.)
//!
//! With a the étendue of an order and l the polynomials of the nodes, D = Σ_j d_j l_j has in all
//! orders G the fluxes F = G d with G_ij = Σ_G a l_i l_j, where the integral has the étendues w_i
//! on the diagonal and 0 beside it: F′ = w G⁻¹ F are the fluxes of the integral.

use super::fraction::function_of;
use super::ordinates::Ordinates;
use crate::wave::Order;
use faer::Mat;
use std::f64::consts::PI;

/// Eigenvalue of G over the étendues below which a lattice says too little of a distribution to be
/// corrected by it.
const LEAST: f64 = 0.3;

/// Sums G over the orders of solves with light at 0°, at the nodes of one medium.
#[derive(Clone, Debug)]
pub(super) struct OrderLattice {
    sums: Mat<f64>,
    solves: f64,
}

impl OrderLattice {
    pub(super) fn new(ordinates: &Ordinates) -> Self {
        let count = ordinates.count();
        Self { sums: Mat::zeros(count, count), solves: 0.0 }
    }

    /// Adds the orders of a solve that propagate in the medium, or a part of them; nothing where
    /// the orders do not span a plane.
    pub(super) fn add(&mut self, ordinates: &Ordinates, orders: &[Order], part: f64) {
        let Some(etendue) = etendue_of_an_order(orders) else { return };
        self.solves += part;
        for order in orders {
            let sine = order.direction[0].hypot(order.direction[1]);
            if sine >= ordinates.index {
                continue;
            }
            let shares = ordinates.shares(sine);
            for (i, own) in &shares {
                for (j, other) in &shares {
                    self.sums[(*i, *j)] += part * etendue * own * other;
                }
            }
        }
    }

    pub(super) fn plus(&mut self, other: &Self) {
        self.sums += &other.sums;
        self.solves += other.solves;
    }

    /// The matrix that makes the integral's fluxes of those of the orders; `None` without orders.
    pub(super) fn correction(&self, ordinates: &Ordinates) -> Option<Mat<f64>> {
        let weights = &ordinates.weights;
        let count = weights.len();
        let scaled = |i: usize, j: usize| self.sums[(i, j)] / self.solves / (weights[i] * weights[j]).sqrt();
        let found = (self.solves > 0.0).then(|| Mat::from_fn(count, count, scaled))?;
        let inverse = function_of(&found, |value| 1.0 / value.max(LEAST))?;
        Some(Mat::from_fn(count, count, |i, j| inverse[(i, j)] * (weights[i] / weights[j]).sqrt()))
    }
}

/// Étendue of the directions nearer to an order than to all others; `None` if all orders lie on a
/// line.
fn etendue_of_an_order(orders: &[Order]) -> Option<f64> {
    let cross = |[a, b]: [f64; 2], [c, d]: [f64; 2]| a * d - b * c;
    let number = |order: &Order| [f64::from(order.m), f64::from(order.n)];
    let first = orders.iter().find(|order| [order.m, order.n] != [0, 0])?;
    let second = orders.iter().find(|order| cross(number(first), number(order)) != 0.0)?;
    let area = cross(first.direction, second.direction) / cross(number(first), number(second));
    (area != 0.0).then(|| area.abs() / PI)
}

#[cfg(test)]
#[path = "lattice_tests.rs"]
mod tests;
