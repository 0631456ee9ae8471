//! One order, and all orders of one side, averaged over an ensemble.

use crate::numerics::estimate::Estimate;
use crate::wave::{FURTHER, Order};
use ndarray::Array2;
use num_complex::Complex64;

/// The half-space into which the light leaves, relative to its source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobe {
    /// Back to the side the light came from.
    Reflected,
    /// To the opposite side.
    Transmitted,
}

/// One order on one side, averaged over the ensemble. Efficiencies are fractions of the incident
/// power.
///
/// `coherent` w|⟨a⟩|² and `diffuse` w(⟨|a|²⟩ − |⟨a⟩|²) are the unbiased estimates (variance over n
/// − 1) and sum to the mean efficiency; one realisation cannot separate them (`None`). An unbiased
/// coherent part may be slightly negative: noise around zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderMean {
    /// Index along x; the specular order has 0.
    pub m: i32,
    /// Index along y.
    pub n: i32,
    /// Direction cosines (kx, ky)/k0.
    pub direction: [f64; 2],
    /// Mean fraction of the incident power.
    pub efficiency: Estimate,
    /// Fraction that survives averaging of the amplitudes.
    pub coherent: Option<f64>,
    /// Remainder of the efficiency.
    pub diffuse: Option<f64>,
    /// Distribution function at the order, 1/sr in vacuum; in a medium of index n it is n² times as
    /// large.
    pub bdf: Estimate,
}

/// Totals of one side, as fractions of the incident power.
///
/// `specular` is the whole order (0, 0), `diffuse` all others. `coherent` is the part of the
/// specular order that survives averaging of the amplitude (unbiased, jackknife error; unknown for
/// one realisation).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Totals {
    /// All orders.
    pub total: Estimate,
    /// The order (0, 0).
    pub specular: Estimate,
    /// All other orders.
    pub diffuse: Estimate,
    /// Coherent part of the specular order.
    pub coherent: Option<Estimate>,
}

/// Sampled amplitudes and efficiencies of one order on one side.
#[derive(Clone, Copy)]
pub(super) struct View {
    pub(super) propagates: bool,
    /// Mutually incoherent amplitudes.
    amplitudes: [Complex64; 1 + FURTHER],
    pub(super) efficiency: f64,
}

pub(super) fn view(order: &Order, lobe: Lobe) -> View {
    let side = lobe as usize;
    let propagates = [order.reflected_propagates, order.transmitted_propagates][side];
    let efficiency = [order.reflected_efficiency, order.transmitted_efficiency][side];
    let mut amplitudes = [Complex64::ZERO; 1 + FURTHER];
    amplitudes.iter_mut().zip(order.amplitudes()).for_each(|(amplitude, pair)| *amplitude = pair[side]);
    View { propagates, amplitudes, efficiency }
}

impl OrderMean {
    /// The mean of an order's efficiencies; `density` is the number of orders in dα dβ.
    pub(super) fn new(
        m: i32,
        n: i32,
        direction: [f64; 2],
        samples: &[f64],
        coherent: Option<f64>,
        density: f64,
    ) -> Self {
        let efficiency = Estimate::of_mean(samples);
        let standard_error = efficiency.standard_error.map(|s| s * density);
        let bdf = Estimate { value: efficiency.value * density, standard_error };
        Self { m, n, direction, efficiency, coherent, diffuse: coherent.map(|c| efficiency.value - c), bdf }
    }
}

/// Unbiased w|⟨a⟩|² = w(|ā|² − s²/n), with w = Σe/Σ|a|² the flux factor of the order, summed over
/// mutually incoherent amplitudes. `None` for one sample.
pub(super) fn coherent_efficiency<'a>(views: impl Iterator<Item = &'a View>) -> Option<f64> {
    let mut n = 0.0;
    let mut sum = [Complex64::ZERO; 1 + FURTHER];
    let mut square = 0.0;
    let mut power = 0.0;
    for v in views {
        n += 1.0;
        sum.iter_mut().zip(v.amplitudes).for_each(|(sum, a)| *sum += a);
        square += v.amplitudes.iter().map(Complex64::norm_sqr).sum::<f64>();
        power += v.efficiency;
    }
    if n < 2.0 {
        return None;
    }
    let flux = if square > 0.0 { power / square } else { 0.0 };
    let mean = sum.iter().map(|sum| (sum / n).norm_sqr()).sum::<f64>();
    let variance = (square - n * mean) / (n - 1.0);
    Some(flux * (mean - variance / n))
}

pub(super) fn totals(efficiencies: &Array2<f64>, specular: Option<usize>, column: &[View]) -> Totals {
    let sums: Vec<f64> = efficiencies.outer_iter().map(|row| row.sum()).collect();
    let mirrored: Vec<f64> = efficiencies.outer_iter().map(|row| specular.map_or(0.0, |k| row[k])).collect();
    let scattered: Vec<f64> = sums.iter().zip(&mirrored).map(|(s, m)| s - m).collect();
    Totals {
        total: Estimate::of_mean(&sums),
        specular: Estimate::of_mean(&mirrored),
        diffuse: Estimate::of_mean(&scattered),
        coherent: coherent_total(column),
    }
}

/// The coherent part of the specular order; a jackknife error needs at least three realisations.
fn coherent_total(column: &[View]) -> Option<Estimate> {
    let others = |r: usize| column.iter().enumerate().filter(move |(s, _)| *s != r).map(|(_, v)| v);
    let replicates: Vec<f64> = (0..column.len()).map_while(|r| coherent_efficiency(others(r))).collect();
    coherent_efficiency(column.iter()).map(|value| Estimate::jackknife(value, &replicates))
}
