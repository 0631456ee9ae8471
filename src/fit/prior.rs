//! What an index is expected to be like: n and κ as linear functions of a few unknowns, with the
//! expected value and the precision of these.
//!
//! Kramers–Kronig (time factor e^(−iωt)): n(ω) = c₀ + c₁ p(ω) + (2/π) P∫ ω′κ(ω′)/(ω′² − ω²) dω′. κ
//! is linear in ω = 1/λ between knots, so that the integral is a sum of logarithms; the constant
//! and one pole in the UV stand for absorption beyond the knots.

use super::file::{KnownN, PriorName};
use crate::material::kramers_kronig::{POLE_STRENGTH, POLE_UM, hat, transform};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Distance of the knots of κ, nm: chords of 25 nm miss a pigment's peak by more than the noise.
const KNOTS_NM: f64 = 10.0;
/// Distance of knots to which the strength refers, nm: rougher in proportion to its power of 3/2,
/// as an integrated random walk is, so that the prior does not depend on the knots.
const STRENGTH_NM: f64 = 25.0;
/// Absorption looked for beyond either end of the spectrum, nm.
const BEYOND_NM: f64 = 150.0;
/// Most distances between knots; a wider range has wider ones.
const MOST_PIECES: f64 = 400.0;
/// Shortest wavelength that the Kramers–Kronig prior describes, nm: one distance of knots above its
/// pole. The knots, which lie up to 160 nm lower, are then at positive wavelengths, too.
pub const SHORTEST_NM: f64 = 1e3 * POLE_UM + KNOTS_NM;
/// Expected size of κ, of the constant about the binder's index, and of the pole's strength.
const SIZES: [f64; 3] = [0.5, 0.5, 0.15];
/// Distance of wavelengths to which the smoothness of the prior `smooth` refers, nm.
const SMOOTH_NM: f64 = 20.0;
/// Knots to either side over which κ is averaged where the prior adapts to it.
const NEIGHBOURS: usize = 3;
/// Share of the mean κ that is added to the local one: where κ is 0, it may still bend.
const FLOOR: f64 = 0.1;
/// Standard deviation of the logarithm of a common factor on the thicknesses.
const THICKNESS: f64 = 0.1;

/// Expected size of the light that faces of samples add, which is never negative.
const FACE_LIGHT: f64 = 0.02;

/// Unknowns and how n and κ depend on them.
#[derive(Clone, Debug)]
pub struct IndexPrior {
    /// n at every wavelength: rows of the unknowns' weights.
    pub n: Vec<Vec<f64>>,
    /// κ at every wavelength.
    pub kappa: Vec<Vec<f64>>,
    /// Expected values of the unknowns.
    pub mean: Vec<f64>,
    /// Unknowns that must not be negative.
    pub positive: Vec<bool>,
    /// Expected sizes of the unknowns, whatever their neighbours are.
    sizes: Vec<f64>,
    /// Place of the unknown that is the logarithm of a factor on the thicknesses.
    pub thickness: Option<usize>,
    /// Place of the unknown that is the light which the faces of all samples add.
    pub face_light: Option<usize>,
    /// Rows of differences whose size is the strength of the prior.
    rough: Vec<Vec<(usize, f64)>>,
    /// Knots of κ beyond either end of the data; none where the prior does not adapt to κ.
    beyond: Option<usize>,
    /// n known at a wavelength, with the row of the unknowns' weights there.
    known: Option<(KnownN, Vec<f64>)>,
}

impl IndexPrior {
    /// The prior at some wavelengths, about the binder's index.
    pub fn new(name: PriorName, wavelengths_nm: &[f64], binder: f64, thickness: bool) -> Self {
        let mut prior = match name {
            PriorName::KramersKronig => kramers_kronig(wavelengths_nm, binder),
            PriorName::Smooth => smooth(wavelengths_nm, binder),
        };
        if thickness {
            prior.thickness = Some(prior.beside_index(THICKNESS, false));
        }
        prior
    }

    /// The prior with light that the faces of all samples add.
    #[must_use]
    pub fn with_face_light(mut self) -> Self {
        self.face_light = Some(self.beside_index(FACE_LIGHT, true));
        self
    }

    /// Adds an unknown of this size that changes neither n nor κ, and gives its place.
    fn beside_index(&mut self, size: f64, positive: bool) -> usize {
        self.n.iter_mut().chain(&mut self.kappa).for_each(|row| row.push(0.0));
        self.mean.push(0.0);
        self.positive.push(positive);
        self.sizes.push(size);
        self.count() - 1
    }

    /// The prior of Kramers and Kronig with n known at a wavelength. Elsewhere n then depends on the
    /// ultraviolet: its pole is expected to have the strength of measured materials, since one of 0,
    /// as coats that show n themselves may have, would make n and with it κ too small in the blue.
    #[must_use]
    pub fn with_known(mut self, wavelengths_nm: &[f64], known: KnownN) -> Self {
        let mut row = weights_of_n(&knots(wavelengths_nm), 1e3 / known.n_nm);
        let pole = row.len() - 1;
        [self.mean[pole], self.sizes[pole]] = POLE_STRENGTH;
        row.resize(self.count(), 0.0);
        Self { known: Some((known, row)), ..self }
    }

    /// Number of unknowns.
    pub fn count(&self) -> usize {
        self.mean.len()
    }

    /// \[n, κ\] at every wavelength.
    pub fn index(&self, unknowns: &[f64]) -> Vec<[f64; 2]> {
        let product = |row: &Vec<f64>| row.iter().zip(unknowns).map(|(a, x)| a * x).sum::<f64>();
        self.n.iter().zip(&self.kappa).map(|(n, k)| [product(n), product(k).max(0.0)]).collect()
    }

    /// Logarithm of the factor on the thicknesses.
    pub fn log_thickness(&self, unknowns: &[f64]) -> f64 {
        self.thickness.map_or(0.0, |place| unknowns[place])
    }

    /// Light that the faces of all samples add to their reflectance factors.
    pub fn face_light(&self, unknowns: &[f64]) -> f64 {
        self.face_light.map_or(0.0, |place| unknowns[place])
    }

    /// This prior with differences in proportion to the κ around them: a line of absorption bends
    /// as much as it is high, and between lines κ is smooth. Beyond the data, where nothing is
    /// known, the proportion is at least 1.
    #[must_use]
    pub fn adapted(&self, unknowns: &[f64]) -> Self {
        let Some(beyond) = self.beyond else { return self.clone() };
        let count = self.rough.len();
        let local: Vec<f64> = (0..count).map(|i| around(&unknowns[..count + 2], i + 1)).collect();
        // a single wavelength has the knot nearest to it
        let first = beyond.min((count - 1) / 2);
        let data = first..count.saturating_sub(beyond).max(first + 1);
        let mean = local[data.clone()].iter().sum::<f64>() / data.len().max(1) as f64;
        let mut adapted = self.clone();
        for (i, row) in adapted.rough.iter_mut().enumerate() {
            let relative = (local[i] + FLOOR * mean) / ((1.0 + FLOOR) * mean).max(1e-9);
            let relative = if data.contains(&i) { relative } else { relative.max(1.0) };
            row.iter_mut().for_each(|(_, weight)| *weight /= relative.max(1e-3));
        }
        adapted
    }

    /// Precision and expected values of the unknowns, with what is known of n: P + rrᵀ/σ², and the
    /// mean that this moves. `None` if that is not positive definite.
    pub fn expectation(&self, strength: f64) -> Option<(Mat<f64>, Vec<f64>)> {
        let mut precision = self.precision(strength);
        let Some((known, row)) = &self.known else { return Some((precision, self.mean.clone())) };
        let count = self.count();
        let mean = Mat::from_fn(count, 1, |i, _| self.mean[i]);
        let mut right = &precision * &mean;
        let weight = known.n_error.powi(-2);
        for i in 0..count {
            right[(i, 0)] += weight * row[i] * known.n;
            (0..count).for_each(|j| precision[(i, j)] += weight * row[i] * row[j]);
        }
        let moved = precision.llt(Side::Lower).ok()?.solve(&right);
        Some((precision, (0..count).map(|i| moved[(i, 0)]).collect()))
    }

    /// Precision of the unknowns, with differences of the size `strength`.
    pub fn precision(&self, strength: f64) -> Mat<f64> {
        let mut precision = Mat::zeros(self.count(), self.count());
        for i in 0..self.count() {
            precision[(i, i)] = 1.0 / self.sizes[i].powi(2);
        }
        for row in &self.rough {
            for &(i, a) in row {
                row.iter().for_each(|&(j, b)| precision[(i, j)] += a * b / (strength * strength));
            }
        }
        precision
    }
}

/// Mean of κ about a knot.
fn around(kappa: &[f64], knot: usize) -> f64 {
    let part = &kappa[knot.saturating_sub(NEIGHBOURS)..(knot + 1 + NEIGHBOURS).min(kappa.len())];
    part.iter().sum::<f64>() / part.len() as f64
}

/// Second differences of a run of unknowns, times `factor`.
fn second_differences(from: usize, count: usize, factor: f64) -> Vec<Vec<(usize, f64)>> {
    (from..from + count.saturating_sub(2))
        .map(|i| vec![(i, factor), (i + 1, -2.0 * factor), (i + 2, factor)])
        .collect()
}

/// Ends of the knots, nm, and the number of distances between them.
fn range_of_knots(wavelengths_nm: &[f64]) -> ([f64; 2], f64) {
    let ends = [wavelengths_nm[0] - BEYOND_NM, wavelengths_nm[wavelengths_nm.len() - 1] + BEYOND_NM];
    (ends, ((ends[1] - ends[0]) / KNOTS_NM).round().min(MOST_PIECES))
}

/// Knots of κ as rising ω, with one more on both sides, where κ is 0.
fn knots(wavelengths_nm: &[f64]) -> Vec<f64> {
    let ([from, to], pieces) = range_of_knots(wavelengths_nm);
    let nm: Vec<f64> = (-1..=pieces as i32 + 1).map(|k| from + (to - from) / pieces * f64::from(k)).collect();
    nm.iter().rev().map(|nm| 1e3 / nm).collect()
}

/// Weights of the unknowns in n at ω: those of all knots, the constant and the pole.
fn weights_of_n(omega: &[f64], w: f64) -> Vec<f64> {
    let nodes = omega.windows(3).map(|nodes| [nodes[0], nodes[1], nodes[2]]);
    let pole = w * w * POLE_UM * POLE_UM / (1.0 - w * w * POLE_UM * POLE_UM);
    nodes.map(|nodes| transform(nodes, w)).chain([1.0, pole]).collect()
}

fn kramers_kronig(wavelengths_nm: &[f64], binder: f64) -> IndexPrior {
    let ([from, to], pieces) = range_of_knots(wavelengths_nm);
    let omega = knots(wavelengths_nm);
    let hats = omega.len() - 2;
    let (mut n, mut kappa) = (Vec::new(), Vec::new());
    for w in wavelengths_nm.iter().map(|nm| 1e3 / nm) {
        let nodes = omega.windows(3).map(|nodes| [nodes[0], nodes[1], nodes[2]]);
        n.push(weights_of_n(&omega, w));
        kappa.push(nodes.map(|nodes| hat(nodes, w)).chain([0.0; 2]).collect());
    }
    let factor = (STRENGTH_NM * pieces / (to - from)).powf(1.5);
    let rough = second_differences(0, hats, factor);
    let beyond = Some((BEYOND_NM * pieces / (to - from)).round() as usize);
    let mean = [vec![0.0; hats], vec![binder, 0.0]].concat();
    let positive = [vec![true; hats], vec![false; 2]].concat();
    let sizes = [vec![SIZES[0]; hats], SIZES[1..].to_vec()].concat();
    let (thickness, face_light, known) = (None, None, None);
    IndexPrior { n, kappa, mean, positive, sizes, thickness, face_light, rough, beyond, known }
}

fn smooth(wavelengths_nm: &[f64], binder: f64) -> IndexPrior {
    let count = wavelengths_nm.len();
    let step = (wavelengths_nm[count - 1] - wavelengths_nm[0]) / (count - 1).max(1) as f64;
    let factor = (SMOOTH_NM / step.max(1.0)).powi(2);
    let unit = |k: usize| (0..2 * count).map(|i| f64::from(u8::from(i == k))).collect();
    let mut rough = second_differences(0, count, factor);
    rough.extend(second_differences(count, count, factor));
    IndexPrior {
        n: (0..count).map(unit).collect(),
        kappa: (count..2 * count).map(unit).collect(),
        mean: [vec![binder; count], vec![0.0; count]].concat(),
        positive: [vec![false; count], vec![true; count]].concat(),
        sizes: [vec![SIZES[1]; count], vec![SIZES[0]; count]].concat(),
        thickness: None,
        face_light: None,
        rough,
        beyond: None,
        known: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One wavelength, two within a distance of knots, and the widest range there is: the prior is
    /// finite, and adapts to the κ of the data. *Planted*: the knots of the data as those between
    /// `beyond` and the end, which are none for a single wavelength.
    #[test]
    fn narrow_and_wide_ranges_have_a_prior() {
        for nm in [vec![550.0], vec![550.0, 553.0], vec![SHORTEST_NM, 400.0], vec![400.0, 10_000.0]] {
            let prior = IndexPrior::new(PriorName::KramersKronig, &nm, 1.5, false);
            let unknowns = vec![0.1; prior.count()];
            let adapted = prior.adapted(&unknowns);
            assert!(
                prior.count() < 410
                    && adapted.precision(0.05).diagonal().column_vector().iter().all(|x| x.is_finite())
            );
            // κ equal everywhere changes nothing
            assert!(
                (adapted.precision(0.05) - prior.precision(0.05)).norm_max()
                    < 1e-9 * prior.precision(0.05).norm_max()
            );
            let rows = prior.n.iter().chain(&prior.kappa).flatten();
            assert!(rows.clone().all(|x| x.is_finite()), "{nm:?}");
        }
    }

    #[test]
    fn unknowns_have_their_sizes_and_differences_theirs() {
        let nm: Vec<f64> = (0..16).map(|k| 400.0 + 20.0 * f64::from(k)).collect();
        for (name, thickness) in [(PriorName::KramersKronig, true), (PriorName::Smooth, false)] {
            let prior = IndexPrior::new(name, &nm, 1.5, thickness);
            let precision = prior.precision(1e9);
            for i in 0..prior.count() {
                let size = precision[(i, i)].powf(-0.5);
                assert!((0.05..0.6).contains(&size), "{name:?} {i}: {size}");
            }
            assert!(prior.precision(0.05)[(1, 1)] > 400.0);
            let flat = prior.index(&prior.mean);
            assert!(flat.iter().all(|[n, k]| (n - 1.5).abs() < 1e-12 && *k == 0.0));
        }
    }
}
