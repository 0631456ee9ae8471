//! What the scatter between the cells does not show of the choice of directions.
//!
//! All cells of a study share one sequence of shifts of their strata, with one step from cell to
//! cell and another from wavelength to wavelength. An error of the hemispherical mean is a periodic
//! function of the shift, and a colour sums it over the wavelengths: of its harmonics those remain
//! for which the step between wavelengths is nearly whole turns. The third is one, and the step
//! between cells is nearly whole turns for it, too: in eight cells it has nearly the same phase, so
//! that it neither averages out nor scatters. The fitted curves over the angle tell its size.

use super::{InkError, InkOnPaper, Sight};
use crate::evaluate::films::Films;
use crate::evaluate::on_paper::{BENDS, LayerOnPaper, Measured, anchor_weights};
use crate::evaluate::regression::{Fits, Normal};
use crate::evaluate::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength};
use crate::evaluate::wavelengths::{SpectralBasis, nearest};
use crate::input::variation::stratified_deg;
use crate::wave::Side;
use gauss_quad::GaussLegendre;
use ndarray::Array2;

/// Common shifts of all strata over which errors are averaged: twice as many as the harmonics that
/// matter.
const SHIFTS: usize = 16;
/// Functions of the angle on the incident side: those of the curves.
const INCIDENT: usize = 2 + BENDS;
/// Functions of the angle on the exit side: powers of the cosine.
const EXIT: usize = 4;
/// Step of the finite difference along an error of a mean.
const STEP: f64 = 1e-4;
/// Cells beyond which the sequence has filled the strata evenly in every harmonic that matters.
const MOST_CELLS: usize = 64;
/// Shifts of Lab below this are rounding.
const NEGLIGIBLE: f64 = 1e-9;
/// Nodes that integrate these functions times 2μ exactly.
const NODES: usize = 6;

/// The directions of an ensemble over the hemispheres.
#[derive(Clone, Debug, Default)]
pub(super) struct SampledDirections {
    /// Numbers of strata on the incident side and on the exit side.
    strata: [usize; 2],
    /// Wavelengths of every cell, nm, increasing.
    wavelengths_nm: Vec<Vec<f64>>,
    /// Position within every stratum at each of them, 0–1.
    positions: Vec<Vec<f64>>,
    /// Absorptance from the exit side beyond the film against the angle there; none without solves
    /// from that side.
    exit: Option<Array2<f64>>,
}

/// Errors of the means of all functions over a cell's strata at one wavelength.
type MeanErrors = ([f64; INCIDENT], [f64; EXIT]);

impl SampledDirections {
    pub fn new(solved: &[SolvedRealisation], basis: &SpectralBasis, films: &Films) -> Self {
        let Some(first) = solved.first().and_then(|cell| cell.wavelengths.first()) else {
            return Self::default();
        };
        let strata = [first.strata.len(), first.exit.len()];
        let nm = |w: &SolvedWavelength| w.wavelength_nm;
        let place = |w: &SolvedWavelength| position(&w.strata);
        Self {
            strata,
            wavelengths_nm: solved.iter().map(|cell| cell.wavelengths.iter().map(nm).collect()).collect(),
            positions: solved.iter().map(|cell| cell.wavelengths.iter().map(place).collect()).collect(),
            exit: (strata[1] > 0).then(|| exit_curve(solved, basis, films)),
        }
    }

    /// Errors of the means in one cell, by wavelength, with all strata shifted by `shift`.
    fn errors(&self, cell: usize, shift: f64, exact: &MeanErrors) -> Vec<MeanErrors> {
        let errors_at = |position: &f64| {
            let share = (position + shift).fract();
            let [incident, exit] = self.strata.map(|strata| stratified_deg(strata, share));
            let mut errors = (mean(&incident, incident_functions), mean(&exit, exit_functions));
            errors.0.iter_mut().zip(exact.0).for_each(|(error, exact)| *error -= exact);
            errors.1.iter_mut().zip(exact.1).for_each(|(error, exact)| *error -= exact);
            errors
        };
        self.positions[cell].iter().map(errors_at).collect()
    }
}

/// Position of the directions within their strata of μ²: the first stratum is that of the normal.
fn position(strata: &[SolvedDirection]) -> f64 {
    let Some(first) = strata.first() else { return 0.0 };
    let squared = first.polar_deg.to_radians().cos().powi(2);
    (strata.len() as f64 * squared - (strata.len() as f64 - 1.0)).clamp(0.0, 1.0)
}

fn incident_functions(mu: f64) -> [f64; INCIDENT] {
    let (between, bends) = anchor_weights(mu);
    std::array::from_fn(|k| if k < 2 { between[k] } else { bends[k - 2] })
}

fn exit_functions(mu: f64) -> [f64; EXIT] {
    std::array::from_fn(|k| mu.powi(k as i32))
}

/// Plain means of functions over directions.
fn mean<const N: usize>(polar_deg: &[f64], functions: fn(f64) -> [f64; N]) -> [f64; N] {
    let mut sum = [0.0; N];
    for deg in polar_deg {
        let values = functions(deg.to_radians().cos());
        sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value / polar_deg.len() as f64);
    }
    sum
}

/// 2 ∫₀¹ f μ dμ of functions.
fn hemispherical<const N: usize>(functions: fn(f64) -> [f64; N]) -> [f64; N] {
    let rule = GaussLegendre::new(NODES).expect("a positive number of nodes");
    std::array::from_fn(|k| rule.integrate(0.0, 1.0, |mu| 2.0 * mu * functions(mu)[k]))
}

/// Fits the absorptance from the exit side beyond the film, over wavelength and angle.
fn exit_curve(solved: &[SolvedRealisation], basis: &SpectralBasis, films: &Films) -> Array2<f64> {
    let samples = |cell: &SolvedRealisation, w: &SolvedWavelength| {
        let film = films.of_thickness(w.wavelength_nm, cell.thickness_um);
        let mut samples = Normal::new(EXIT, 1);
        for s in &w.exit {
            let [r, t] = film.from(Side::Exit, s.polar_deg);
            let beyond = s.absorptance - (1.0 - r - t);
            samples.sample(&exit_functions(s.polar_deg.to_radians().cos()), &[beyond]);
        }
        (w.wavelength_nm, samples)
    };
    let cells = solved.iter().map(|cell| cell.wavelengths.iter().map(move |w| samples(cell, w)));
    Fits::whole(cells, basis, EXIT, 1)
}

impl InkOnPaper {
    /// Shifts of Lab by errors of the directions that all cells have in common, each independent:
    /// add them in squares. Of every component they hold what the squared error of the fitted
    /// curves' means has beyond the square that the jackknife sees, both averaged over all common
    /// shifts of the strata.
    ///
    /// # Errors
    /// A quantity that is no number.
    pub(in crate::evaluate) fn unseen_directions(
        &self,
        sight: &Sight,
        xyz: [f64; 3],
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Vec<[f64; 3]>, InkError> {
        let cells = self.replicates.len();
        if !(2..=MOST_CELLS).contains(&cells) || self.directions.strata[0] == 0 {
            return Ok(Vec::new());
        }
        let slopes: Vec<MeanErrors> =
            sight.nodes.clone().map(|node| self.slopes_of_means(node, quantity)).collect();
        let exact = (hemispherical(incident_functions), hemispherical(exit_functions));
        let here = sight.meter.colour_of(xyz).lab;
        let mut common = Vec::new();
        let mut squares = [0.0; 3];
        let mut seen = [0.0; 3];
        for shift in (0..SHIFTS).map(|k| k as f64 / SHIFTS as f64) {
            let mut of_cells = Vec::new();
            for cell in 0..cells {
                let errors = self.directions.errors(cell, shift, &exact);
                let by = sight.meter.xyz(&self.changes(sight, cell, &slopes, &errors))?;
                let there = sight.meter.colour_of(std::array::from_fn(|c| (xyz[c] + by[c]).max(0.0))).lab;
                of_cells.push([0, 1, 2].map(|i| there[i] - here[i]));
            }
            let n = cells as f64;
            let mean = [0, 1, 2].map(|i| of_cells.iter().map(|lab| lab[i]).sum::<f64>() / n);
            for i in 0..3 {
                squares[i] += mean[i] * mean[i];
                seen[i] +=
                    of_cells.iter().map(|lab| (lab[i] - mean[i]).powi(2)).sum::<f64>() / (n * (n - 1.0));
            }
            common.push(mean);
        }
        let unseen =
            |i: usize| if squares[i] > NEGLIGIBLE * NEGLIGIBLE { 1.0 - seen[i] / squares[i] } else { 0.0 };
        let scale = [0, 1, 2].map(|i| (unseen(i).max(0.0) / SHIFTS as f64).sqrt());
        if scale == [0.0; 3] {
            return Ok(Vec::new());
        }
        Ok(common.into_iter().map(|lab| [0, 1, 2].map(|i| scale[i] * lab[i])).collect())
    }

    /// Derivatives of a quantity at a node with respect to the mean of every function of the angle.
    fn slopes_of_means(&self, node: usize, quantity: &impl Fn(&LayerOnPaper) -> f64) -> MeanErrors {
        let layer = &self.whole[node];
        let slope = |by: Measured| (quantity(&layer.moved(&by, STEP)) - quantity(layer)) / STEP;
        let by_transmittance = slope(Measured { transmittance: 1.0, ..Measured::default() });
        let by_absorptance = slope(Measured { absorptance: 1.0, ..Measured::default() });
        let [reflected, transmitted] = layer.returned_coefficients();
        let Some(exit) = &self.directions.exit else {
            // A from the exit side is 1 − R − T from the incident side
            let slopes = |k: usize| {
                by_transmittance * transmitted[k] - by_absorptance * (reflected[k] + transmitted[k])
            };
            return (std::array::from_fn(slopes), [0.0; EXIT]);
        };
        let weights = &self.nodes.weights[node];
        let absorbed = |k: usize| SpectralBasis::at(weights, |i| exit[[i * EXIT + k, 0]]);
        (transmitted.map(|t| by_transmittance * t), std::array::from_fn(|k| by_absorptance * absorbed(k)))
    }

    /// Changes of a quantity at the wavelengths that are summed, by the errors of one cell at its
    /// nearest wavelengths.
    fn changes(&self, sight: &Sight, cell: usize, slopes: &[MeanErrors], errors: &[MeanErrors]) -> Vec<f64> {
        let own_nm = &self.directions.wavelengths_nm[cell];
        let change = |(node, slopes): (usize, &MeanErrors)| {
            let errors = &errors[nearest(own_nm.iter().copied(), self.nodes.wavelengths_nm[node])];
            let incident = slopes.0.iter().zip(&errors.0).map(|(slope, error)| slope * error).sum::<f64>();
            incident + slopes.1.iter().zip(&errors.1).map(|(slope, error)| slope * error).sum::<f64>()
        };
        sight.nodes.clone().zip(slopes).map(change).collect()
    }
}

#[cfg(test)]
#[path = "directions_tests.rs"]
mod tests;
