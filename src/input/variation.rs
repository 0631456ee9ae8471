//! How the realisations of a study differ: cell, thickness, azimuth, directions and wavelengths.
//!
//! A periodic cell answers at one Bloch vector of one reciprocal lattice; asked again and again at the same one, the same few guided
//! resonances are hit or missed each time, and a small cell is biased. Quantum Monte Carlo cures the like by twist averaging (Lin, Zong,
//! Ceperley 2001). Here the lattice itself varies: area, aspect and azimuth, all drawn evenly by a
//! [`Sequence`], together with the directions over the hemisphere and the wavelengths. Realisation r has the
//! same draws however many there are, so that a study may be extended.

use super::study::Study;
use crate::ink::{PigmentGrains, SizeDistribution};
use crate::numerics::sequence::Sequence;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// Whether realisations have cells of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellRule {
    /// Area, aspect and azimuth differ from realisation to realisation: no bias from the period.
    #[default]
    Varied,
    /// The same period and azimuth always: for the comparison of methods.
    Fixed,
}

/// Which wavelengths a realisation is solved at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LightRule {
    /// Those listed, always.
    Listed,
    /// One in each of equally wide strata, all shifted together by a share of the width that differs from realisation to realisation.
    Shifted {
        /// First and last wavelength, nm.
        range_nm: [f64; 2],
        /// Wavelengths of a realisation.
        strata: usize,
    },
}

/// What differs, and how much.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Variation {
    /// Whether cells differ.
    pub cell: CellRule,
    /// Standard deviation of the layer's thickness, µm.
    pub thickness_std_um: f64,
    /// Wavelengths.
    pub light: LightRule,
}

/// Area of a cell over the nominal one.
const AREA: [f64; 2] = [0.7, 1.3];
/// Lx/Ly over the nominal ratio.
const ASPECT: [f64; 2] = [0.6, 1.4];
/// Whole grains are sought within this share of the drawn area where several pigments must agree.
const AREA_SEARCH: f64 = 0.04;
/// Thicknesses are cut at this many standard deviations.
pub const THICKNESS_CUT: f64 = 3.0;
/// Strata of μ² are not sampled nearer to grazing: 89.4°.
const LEAST_SQUARED_COSINE: f64 = 1e-4;
/// Steps by this share of the circle fill it evenly: (√5 − 1)/2.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Coordinates of the sequence.
const COORDINATES: usize = 6;

/// What one realisation has drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Period of its cell, µm.
    pub period_um: [f64; 2],
    /// Thickness of its layer, µm.
    pub thickness_um: f64,
    /// Azimuth of its planes of incidence, degrees from the cell's x.
    pub azimuth_deg: f64,
    /// Place within every stratum of directions, 0–1.
    pub direction: f64,
    /// Place within every stratum of wavelengths, 0–1.
    pub wavelength: f64,
}

/// Directions at one wavelength of a realisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Azimuth of the planes of incidence, degrees from the cell's x.
    pub azimuth_deg: f64,
    /// Place within every stratum of directions, 0–1.
    pub direction: f64,
}

impl Study {
    /// What realisation `r` has drawn.
    pub fn draw(&self, r: usize) -> Draw {
        let [area, aspect, azimuth, direction, wavelength, thickness] =
            Sequence::<COORDINATES>::new(self.packing.seed).point(r);
        let layer = &self.layer;
        let thickness_um = thickness_um(layer.thickness_um, self.variation.thickness_std_um, thickness);
        let (period_um, turn) = match self.variation.cell {
            CellRule::Fixed => (layer.period_um, 0.0),
            CellRule::Varied => {
                let [x, y] = layer.period_um;
                let area = self.whole_grains(between(AREA, area) * x * y, thickness_um);
                let side = (area * between(ASPECT, aspect) * x / y).sqrt();
                ([side, area / side], 360.0 * azimuth)
            }
        };
        Draw { period_um, thickness_um, azimuth_deg: self.angles.azimuth_deg + turn, direction, wavelength }
    }

    /// Directions of a realisation at its wavelength number `j`: varied cells are turned on from wavelength to wavelength, so that no two
    /// of them share a Bloch vector and their chances are as independent as one packing allows.
    pub fn turn(&self, draw: &Draw, j: usize) -> Turn {
        match self.variation.cell {
            CellRule::Fixed => Turn { azimuth_deg: draw.azimuth_deg, direction: draw.direction },
            CellRule::Varied => Turn {
                azimuth_deg: draw.azimuth_deg + 360.0 * (j as f64 * GOLDEN).fract(),
                direction: (draw.direction + j as f64 * GOLDEN).fract(),
            },
        }
    }

    /// Wavelengths of a realisation, nm, rising.
    pub fn solved_wavelengths_nm(&self, draw: &Draw) -> Vec<f64> {
        match self.variation.light {
            LightRule::Listed => self.wavelengths_nm.clone(),
            LightRule::Shifted { range_nm: [from, to], strata } => {
                let width = (to - from) / strata as f64;
                (0..strata).map(|j| from + (j as f64 + draw.wavelength) * width).collect()
            }
        }
    }

    /// Number of wavelengths of a realisation.
    pub fn solved_wavelengths(&self) -> usize {
        match self.variation.light {
            LightRule::Listed => self.wavelengths_nm.len(),
            LightRule::Shifted { strata, .. } => strata,
        }
    }

    /// Equally likely thicknesses of the layer, µm: the mean alone where it is even.
    pub fn thicknesses_um(&self) -> Vec<f64> {
        let count = if self.variation.thickness_std_um > 0.0 { 32 } else { 1 };
        let share = |k: usize| (k as f64 + 0.5) / count as f64;
        (0..count)
            .map(|k| thickness_um(self.layer.thickness_um, self.variation.thickness_std_um, share(k)))
            .collect()
    }

    /// The area nearest to `area` (µm²) that whole grains fill to the volume fractions asked.
    fn whole_grains(&self, area: f64, thickness_um: f64) -> f64 {
        let quanta: Vec<f64> = self
            .pigments
            .iter()
            .filter_map(|p| area_of_a_grain(&p.grains, self.dry_um(thickness_um)))
            .collect();
        let Some(largest) = quanta.iter().copied().reduce(f64::max) else { return area };
        let grains = |share: f64| (area * share / largest).round().max(1.0) as usize;
        let miss = |n: usize| {
            let of = |quantum: &f64| {
                let count = n as f64 * largest / quantum;
                (count - count.round()).abs() / count
            };
            quanta.iter().map(of).fold(0.0, f64::max)
        };
        let nearest = grains(1.0);
        let distance = |n: usize| (n as f64 - nearest as f64).abs();
        let key = |&n: &usize| (1e9 * miss(n)).round() as u64;
        let candidates = grains(1.0 - AREA_SEARCH)..=grains(1.0 + AREA_SEARCH);
        let best = candidates.min_by(|a, b| key(a).cmp(&key(b)).then(distance(*a).total_cmp(&distance(*b))));
        best.unwrap_or(nearest) as f64 * largest
    }

    /// Height over which the grains' share is counted, µm.
    fn dry_um(&self, thickness_um: f64) -> f64 {
        self.packing.relief.as_ref().map_or(thickness_um, |relief| thickness_um - relief.depth_um)
    }
}

/// Polar angles, degrees, one in each of `strata` equal strata of μ² = cos²θ (the weight of the hemispherical mean is uniform
/// there), at the place `share` of every stratum; rising.
pub fn stratified_deg(strata: usize, share: f64) -> Vec<f64> {
    let squared = |k: usize| ((k as f64 + share) / strata as f64).max(LEAST_SQUARED_COSINE);
    (0..strata).rev().map(|k| squared(k).sqrt().acos().to_degrees()).collect()
}

/// The shortest side that a cell of this nominal period may get, µm.
pub fn shortest_side_um(cell: CellRule, [x, y]: [f64; 2]) -> f64 {
    match cell {
        CellRule::Fixed => x.min(y),
        CellRule::Varied => (AREA[0] * (ASPECT[0] * x * x).min(y * y / ASPECT[1])).sqrt(),
    }
}

fn between([low, high]: [f64; 2], share: f64) -> f64 {
    low + (high - low) * share
}

/// A cut normal law by its quantiles.
fn thickness_um(mean_um: f64, std_um: f64, share: f64) -> f64 {
    let law = Normal::standard();
    let cut = law.cdf(-THICKNESS_CUT);
    mean_um + std_um * law.inverse_cdf(between([cut, 1.0 - cut], share))
}

/// Area of the cell for one grain of a pigment whose grains are all alike, µm².
fn area_of_a_grain(grains: &PigmentGrains, height_um: f64) -> Option<f64> {
    let SizeDistribution::Constant { value_nm, .. } = grains.size else { return None };
    let template = grains.shape.template();
    let volume = template.volume.um3 * grains.size.radius_um(value_nm, &template).powi(3);
    Some(volume / (grains.volume_fraction * height_um))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strata_are_even_in_the_squared_cosine() {
        let degrees = stratified_deg(4, 0.25);
        assert!(degrees.windows(2).all(|w| w[0] < w[1]));
        let squared: Vec<f64> = degrees.iter().rev().map(|d| d.to_radians().cos().powi(2)).collect();
        for (k, u) in squared.iter().enumerate() {
            assert!((u - (k as f64 + 0.25) / 4.0).abs() < 1e-14);
        }
    }

    #[test]
    fn the_shortest_side_is_that_of_the_smallest_and_longest_cell() {
        assert_eq!(shortest_side_um(CellRule::Fixed, [2.0, 1.5]), 1.5);
        // area 0.7 L², Lx/Ly = 0.6: the shorter side is Lx = √(0.42) L
        assert!((shortest_side_um(CellRule::Varied, [1.0, 1.0]) - 0.42f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn thicknesses_have_their_mean_and_spread() {
        let all: Vec<f64> = (0..400).map(|k| thickness_um(1.0, 0.1, (k as f64 + 0.5) / 400.0)).collect();
        let mean = all.iter().sum::<f64>() / 400.0;
        let spread = (all.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / 400.0).sqrt();
        // a normal law cut at 3σ keeps 98.7 % of its spread
        assert!((mean - 1.0).abs() < 1e-12 && (spread - 0.0987).abs() < 2e-4, "{mean} {spread}");
    }
}
