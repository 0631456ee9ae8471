//! From orders to flux matrices: what one solve adds, and the ensemble's mean with its symmetries.

use super::lattice::OrderLattice;
use super::ordinates::Ordinates;
use super::plate::Plate;
use crate::wave::{Order, Side};
use faer::Mat;
use num_complex::Complex64;
use std::iter::{once, repeat_n};

/// Most rounds of scaling to the energy balance, and the change at which it is reached: slabs of
/// small reflectance need hundreds.
const ROUNDS: usize = 2000;
const REACHED: f64 = 1e-14;
/// Share of the light that may be missing where rounds end before: clear slabs come within 1e-4.
const MISSING: f64 = 1e-3;

/// States of light in a half-space. State 0 is the beam at 0°; the nodes follow, each with its
/// polarisations; then the beam at an oblique angle, if there is one.
#[derive(Clone, Debug, PartialEq)]
pub struct Hemisphere {
    /// Its directions.
    pub ordinates: Ordinates,
    /// 1 for the scalar wave, 2 for s and p.
    pub polarisations: usize,
    /// Angle of an oblique beam, degrees: light comes from there, none is counted there.
    pub oblique_deg: Option<f64>,
}

impl Hemisphere {
    /// Number of states.
    pub fn states(&self) -> usize {
        1 + self.polarisations * (self.ordinates.count() + usize::from(self.oblique_deg.is_some()))
    }

    /// Angles that light comes from, degrees: 0°, the nodes, the oblique beam.
    pub fn directions_deg(&self) -> Vec<f64> {
        let nodes = (0..self.ordinates.count()).map(|i| self.ordinates.polar_deg(i));
        [0.0].into_iter().chain(nodes).chain(self.oblique_deg).collect()
    }

    /// State of direction number `direction` in a polarisation.
    pub fn state(&self, direction: usize, polarisation: usize) -> usize {
        if direction == 0 { 0 } else { 1 + (direction - 1) * self.polarisations + polarisation }
    }

    /// Étendue of every state; 0 for beams.
    pub fn weights(&self) -> Vec<f64> {
        let nodes = self.ordinates.weights.iter().flat_map(|w| repeat_n(*w, self.polarisations));
        let mut weights: Vec<f64> = once(0.0).chain(nodes).collect();
        weights.resize(self.states(), 0.0);
        weights
    }

    /// Cosine of every state's angle.
    pub fn cosines(&self) -> Vec<f64> {
        let cosines = self.directions_deg().into_iter().skip(1).map(|deg| deg.to_radians().cos());
        once(1.0).chain(cosines.flat_map(|cosine| repeat_n(cosine, self.polarisations))).collect()
    }

    /// Adds light of a direction to its nodes.
    fn spread(&self, column: &mut [f64], sine: f64, fluxes: [f64; 2]) {
        for (node, share) in self.ordinates.shares(sine) {
            (0..self.polarisations).for_each(|p| column[self.state(node + 1, p)] += share * fluxes[p]);
        }
    }
}

/// One solve as the flux matrices need it.
#[derive(Clone, Copy, Debug)]
pub struct Lit<'a> {
    /// Side of the light.
    pub from: Side,
    /// Place among the directions of that side.
    pub direction: usize,
    /// 0 for s and for the scalar wave, 1 for p.
    pub polarisation: usize,
    /// Share absorbed.
    pub absorptance: f64,
    /// Its orders.
    pub orders: &'a [Order],
}

/// Flux matrices of one realisation at one wavelength.
#[derive(Clone, Debug)]
pub struct Fluxes {
    /// Diffuse fluxes, all states of both sides: those of a first.
    all: Mat<f64>,
    /// Absorbed share for every state that light came from.
    absorbed: Vec<f64>,
    /// The specular order of every solve.
    beams: Vec<Beam>,
    /// The orders of light at 0° in both media, by the side of the light.
    lattices: [[OrderLattice; 2]; 2],
}

impl Fluxes {
    /// The mean with another packing in the same cell, solved in the same light.
    pub fn mean_with(&self, other: &Self) -> Self {
        let mut mean = self.clone();
        mean.all = faer::Scale(0.5) * (&self.all + &other.all);
        mean.absorbed.iter_mut().zip(&other.absorbed).for_each(|(a, b)| *a = 0.5 * (*a + b));
        for (beam, other) in mean.beams.iter_mut().zip(&other.beams) {
            beam.amplitudes = [0, 1].map(|k| 0.5 * (beam.amplitudes[k] + other.amplitudes[k]));
        }
        mean
    }
}

/// An ensemble with or without one of its realisations.
fn without(ensemble: &[Fluxes], left_out: Option<usize>) -> impl Iterator<Item = &Fluxes> + Clone {
    ensemble.iter().enumerate().filter(move |(r, _)| Some(*r) != left_out).map(|(_, fluxes)| fluxes)
}

/// A specular order: amplitudes \[reflected, transmitted\] with the flux of a unit amplitude.
#[derive(Clone, Copy, Debug)]
struct Beam {
    side: usize,
    direction: usize,
    polarisation: usize,
    amplitudes: [Complex64; 2],
    fluxes: [f64; 2],
}

/// Mean amplitudes of specular orders, \[side\]\[direction\]\[polarisation\]\[reflected,
/// transmitted\].
pub type Coherent = [Vec<Vec<[Complex64; 2]>>; 2];

/// A slab between two media.
#[derive(Clone, Debug, PartialEq)]
pub struct Sides {
    /// Media in front and behind.
    pub media: [Hemisphere; 2],
    /// Whether light from either side meets the same: then solves from the front suffice.
    pub alike: bool,
}

impl Sides {
    fn states(&self) -> usize {
        self.media[0].states() + self.media[1].states()
    }

    /// Place of a side's first state.
    fn first(&self, side: usize) -> usize {
        side * self.media[0].states()
    }

    /// Étendues of all states.
    fn weights(&self) -> Vec<f64> {
        self.media.iter().flat_map(Hemisphere::weights).collect()
    }

    /// The fluxes of one realisation.
    pub fn fluxes<'a>(&self, solves: impl Iterator<Item = Lit<'a>>) -> Fluxes {
        let n = self.states();
        let lattices =
            [(); 2].map(|()| self.media.each_ref().map(|medium| OrderLattice::new(&medium.ordinates)));
        let mut fluxes =
            Fluxes { all: Mat::zeros(n, n), absorbed: vec![0.0; n], beams: Vec::new(), lattices };
        solves.for_each(|lit| self.add(&mut fluxes, &lit));
        fluxes
    }

    fn add(&self, fluxes: &mut Fluxes, lit: &Lit) {
        let side = usize::from(lit.from == Side::Exit);
        let medium = &self.media[side];
        let mut column = vec![0.0; self.states()];
        // unpolarised light at 0° is the mean of two solves
        let part = if lit.direction == 0 { 1.0 / medium.polarisations as f64 } else { 1.0 };
        if lit.direction == 0 {
            let lattices = fluxes.lattices[side].iter_mut().zip(&self.media);
            lattices.for_each(|(lattice, medium)| lattice.add(&medium.ordinates, lit.orders, part));
        }
        for order in lit.orders {
            let sine = order.direction[0].hypot(order.direction[1]);
            let powers = [order.reflected_efficiency, order.transmitted_efficiency];
            if [order.m, order.n] == [0, 0] {
                fluxes.beams.push(beam(side, order, powers, lit));
                if lit.direction == 0 {
                    continue;
                }
            }
            for (k, to) in [side, 1 - side].into_iter().enumerate().filter(|(k, _)| powers[*k] > 0.0) {
                let fluxes = shared(order, k, powers[k], lit.polarisation);
                self.media[to].spread(&mut column[self.first(to)..], sine, fluxes);
            }
        }
        let state =
            self.first(side) + medium.state(lit.direction, lit.polarisation.min(medium.polarisations - 1));
        fluxes.absorbed[state] += part * lit.absorptance;
        column.iter().enumerate().for_each(|(i, flux)| fluxes.all[(i, state)] += part * flux);
    }

    /// The ensemble's mean, with or without one of its realisations: reciprocal, and R + T = 1 − A
    /// in every column.
    pub fn mean(&self, ensemble: &[Fluxes], left_out: Option<usize>) -> Plate {
        let kept = without(ensemble, left_out);
        let count = kept.clone().count().max(1) as f64;
        let n = self.states();
        let mut all: Mat<f64> = Mat::zeros(n, n);
        let mut absorbed = vec![0.0; n];
        for fluxes in kept.clone() {
            all += &fluxes.all;
            (0..n).for_each(|i| absorbed[i] += fluxes.absorbed[i] / count);
        }
        let mut all = Mat::from_fn(n, n, |i, j| all[(i, j)] / count);
        let mut coherent = self.beams(&mut all, kept.clone());
        self.correct_beams(&mut all, kept);
        if self.alike {
            self.mirror(&mut all, &mut absorbed, &mut coherent);
        }
        self.balance(&mut all, &absorbed, coherent);
        let block = |rows: usize, columns: usize| {
            let i0 = self.first(rows);
            let j0 = self.first(columns);
            let shape = (self.media[rows].states(), self.media[columns].states());
            Mat::from_fn(shape.0, shape.1, |i, j| all[(i0 + i, j0 + j)])
        };
        Plate { reflection: [block(0, 0), block(1, 1)], transmission: [block(1, 0), block(0, 1)] }
    }

    /// Coherent flux \[reflected, transmitted\] of the beam from either side, |⟨a⟩|² without the
    /// bias of few realisations; the rest of the specular order joins the diffuse light.
    fn beams<'a>(&self, all: &mut Mat<f64>, kept: impl Iterator<Item = &'a Fluxes> + Clone) -> [[f64; 2]; 2] {
        let mut coherent = [[0.0; 2]; 2];
        for (side, lobe) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let to = if lobe == 0 { side } else { 1 - side };
            let state = self.first(side);
            let [mean, power] = self.beam_mean(side, lobe, kept.clone());
            let mut column = vec![0.0; self.states()];
            let each = (power - mean) / self.media[to].polarisations as f64;
            self.media[to].spread(&mut column[self.first(to)..], 0.0, [each; 2]);
            column.iter().enumerate().for_each(|(i, flux)| all[(i, state)] += flux);
            coherent[side][lobe] = mean;
        }
        coherent
    }

    /// Makes of the diffuse light from both beams, which is that of orders on a lattice, that of a
    /// smooth distribution.
    fn correct_beams<'a>(&self, all: &mut Mat<f64>, kept: impl Iterator<Item = &'a Fluxes> + Clone) {
        for (side, to) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let medium = &self.media[to];
            let mut lattice = OrderLattice::new(&medium.ordinates);
            kept.clone().for_each(|fluxes| lattice.plus(&fluxes.lattices[side][to]));
            let Some(correction) = lattice.correction(&medium.ordinates) else { continue };
            let beam = self.first(side);
            for polarisation in 0..medium.polarisations {
                let place = |node: usize| self.first(to) + medium.state(node + 1, polarisation);
                let fluxes = Mat::from_fn(medium.ordinates.count(), 1, |node, _| all[(place(node), beam)]);
                let corrected = &correction * fluxes;
                (0..corrected.nrows()).for_each(|node| all[(place(node), beam)] = corrected[(node, 0)]);
            }
        }
    }

    /// \[coherent, whole\] flux of a specular order.
    fn beam_mean<'a>(&self, side: usize, lobe: usize, kept: impl Iterator<Item = &'a Fluxes>) -> [f64; 2] {
        let beams = kept.flat_map(|f| &f.beams).filter(|b| b.side == side && b.direction == 0);
        let polarisations = self.media[side].polarisations;
        let mut sums = vec![(Complex64::ZERO, 0.0, 0.0); polarisations];
        for beam in beams {
            let sum = &mut sums[beam.polarisation];
            sum.0 += beam.amplitudes[lobe] * beam.fluxes[lobe].sqrt();
            sum.1 += beam.amplitudes[lobe].norm_sqr() * beam.fluxes[lobe];
            sum.2 += 1.0;
        }
        let unbiased = |&(sum, power, n): &(Complex64, f64, f64)| match n > 1.0 {
            true => ((sum.norm_sqr() - power) / (n * (n - 1.0))).max(0.0),
            false => power / n.max(1.0),
        };
        let part = 1.0 / polarisations as f64;
        let whole: f64 = sums.iter().map(|&(_, power, n)| power / f64::max(n, 1.0)).sum();
        [part * sums.iter().map(unbiased).sum::<f64>(), part * whole]
    }

    /// Mean amplitudes \[reflected, transmitted\] of the specular order, scaled to the roots of
    /// fluxes: \[side\]\[direction\]\[polarisation\].
    pub fn coherent(&self, ensemble: &[Fluxes], left_out: Option<usize>) -> Coherent {
        let empty = |medium: &Hemisphere| {
            vec![vec![[Complex64::ZERO; 2]; medium.polarisations]; medium.directions_deg().len()]
        };
        let mut sum = self.media.each_ref().map(empty);
        let kept = without(ensemble, left_out);
        let count = kept.clone().count().max(1) as f64;
        for beam in kept.flat_map(|fluxes| &fluxes.beams) {
            let mean = &mut sum[beam.side][beam.direction][beam.polarisation];
            (0..2).for_each(|k| mean[k] += beam.amplitudes[k] * beam.fluxes[k].sqrt() / count);
        }
        if self.alike {
            sum[1] = sum[0].clone();
        }
        sum
    }

    /// What was solved from the front, from behind as well.
    fn mirror(&self, all: &mut Mat<f64>, absorbed: &mut [f64], coherent: &mut [[f64; 2]; 2]) {
        let half = self.media[0].states();
        for j in 0..half {
            absorbed[half + j] = absorbed[j];
            for i in 0..half {
                all[(half + i, half + j)] = all[(i, j)];
                all[(i, half + j)] = all[(half + i, j)];
            }
        }
        coherent[1] = coherent[0];
    }

    /// Imposes reciprocity on the nodes, F_ij/w_i = F_ji/w_j with étendues w, and R + T = 1 − A on
    /// all columns, or the energy alone where no scaling gives both. The beams' coherent parts then
    /// take their places.
    fn balance(&self, all: &mut Mat<f64>, absorbed: &[f64], coherent: [[f64; 2]; 2]) {
        let n = self.states();
        let weights = self.weights();
        let nodes: Vec<usize> = (0..n).filter(|&i| weights[i] > 0.0).collect();
        let mean = |i: usize, j: usize| 0.5 * (all[(i, j)] / weights[i] + all[(j, i)] / weights[j]);
        let mut scales = vec![1.0_f64; n];
        let matrix = Mat::from_fn(n, n, |i, j| if weights[i] * weights[j] > 0.0 { mean(i, j) } else { 0.0 });
        for _ in 0..ROUNDS {
            let mut largest = 0.0_f64;
            for &j in &nodes {
                let sum: f64 = nodes.iter().map(|&i| weights[i] * matrix[(i, j)] * scales[i]).sum();
                let ratio = (1.0 - absorbed[j]) / (sum * scales[j]);
                if ratio.is_finite() && ratio > 0.0 {
                    scales[j] *= ratio.sqrt();
                    largest = largest.max((ratio - 1.0).abs());
                }
            }
            if largest < REACHED {
                break;
            }
        }
        let scaled = |i: usize, j: usize| weights[i] * matrix[(i, j)] * scales[i] * scales[j];
        let is_kept = |&j: &usize| {
            let sum: f64 = nodes.iter().map(|&i| scaled(i, j)).sum();
            (sum - 1.0 + absorbed[j]).abs() <= MISSING
        };
        let is_balanced = nodes.iter().all(is_kept);
        for &j in &nodes {
            if is_balanced {
                nodes.iter().for_each(|&i| all[(i, j)] = scaled(i, j));
                continue;
            }
            // directions that a critical angle lies between: the energy, where both cannot be had
            let share = (1.0 - absorbed[j]) / nodes.iter().map(|&i| all[(i, j)]).sum::<f64>();
            if share.is_finite() && share > 0.0 {
                nodes.iter().for_each(|&i| all[(i, j)] *= share);
            }
        }
        for j in (0..n).filter(|&j| weights[j] == 0.0) {
            self.complete(all, j, absorbed[j], coherent);
        }
    }

    /// A beam's column: its coherent part, and diffuse light scaled to the energy balance.
    fn complete(&self, all: &mut Mat<f64>, j: usize, absorbed: f64, coherent: [[f64; 2]; 2]) {
        let sum: f64 = (0..self.states()).map(|i| all[(i, j)]).sum();
        let side = (0..2).find(|&side| self.first(side) == j);
        let beam = side.map_or([0.0; 2], |side| coherent[side]);
        let rest = 1.0 - absorbed - beam[0] - beam[1];
        if sum > 0.0 && rest > 0.0 {
            (0..self.states()).for_each(|i| all[(i, j)] *= rest / sum);
        }
        if let Some(side) = side {
            all[(self.first(side), j)] = beam[0];
            all[(self.first(1 - side), j)] = beam[1];
        }
    }
}

/// The specular order of a solve.
fn beam(side: usize, order: &Order, powers: [f64; 2], lit: &Lit) -> Beam {
    let amplitudes = [order.reflected, order.transmitted];
    let flux = |k: usize| {
        let all = amplitudes[k].norm_sqr() + order.further[0][k].norm_sqr();
        if all > 0.0 { powers[k] / all } else { 0.0 }
    };
    let direction = lit.direction;
    let polarisation = lit.polarisation;
    Beam { side, direction, polarisation, amplitudes, fluxes: [flux(0), flux(1)] }
}

/// Flux of an order in each polarisation.
fn shared(order: &Order, lobe: usize, power: f64, polarisation: usize) -> [f64; 2] {
    let parallel = [order.reflected, order.transmitted][lobe].norm_sqr();
    let crossed = order.further[0][lobe].norm_sqr();
    let other = if crossed > 0.0 { power * crossed / (parallel + crossed) } else { 0.0 };
    if polarisation == 0 { [power - other, other] } else { [other, power - other] }
}

#[cfg(test)]
#[path = "flux_tests.rs"]
mod tests;
