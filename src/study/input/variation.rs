//! How the realisations of a study vary: cell, thickness, azimuth, directions and wavelengths.
//!
//! A periodic cell samples one Bloch vector of one reciprocal lattice. If it is always the same,
//! the same few guided resonances are hit or missed each time, and a small cell is biased. Quantum
//! Monte Carlo solves the same problem by twist averaging (Lin, Zong, Ceperley 2001). Here the
//! lattice itself varies: area, aspect ratio and azimuth, all drawn uniformly by a
//! [`Sequence`](crate::numerics::Sequence), together with the directions over the
//! hemisphere and the wavelengths. Realisation r has the same draws whatever the number of
//! realisations, so that a study can be extended.
//!
//! Two packings share each cell with its directions and wavelengths: one contains more pigment than
//! requested, the other less, as do windows of the cell's size in a wide layer. Cells that all
//! contain the requested fraction absorb too much where the ink absorbs: T of 30 % yellow, 250 nm,
//! at 460 nm is 0.1693 ± 0.0004 in them, 0.1719 ± 0.0005 in these, 0.1719 ± 0.0004 in cells of
//! 2.4 µm and more.

use gauss_quad::GaussLegendre;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use std::f64::consts::PI;

/// Whether realisations have cells of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CellRule {
    /// Area, aspect ratio and azimuth differ between realisations: the period causes no bias.
    #[default]
    Varied,
    /// Constant period and azimuth, for comparing methods.
    Fixed,
}

/// Which wavelengths a realisation uses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LightRule {
    /// Always those listed.
    Listed,
    /// One in each of equally wide strata, all shifted together by a fraction of the width that
    /// differs between realisations.
    Shifted {
        /// First and last wavelength, nm.
        range_nm: [f64; 2],
        /// Number of wavelengths of a realisation.
        strata: usize,
    },
}

/// What varies, and how much.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Variation {
    /// Whether cells vary.
    pub cell: CellRule,
    /// Standard deviation of the layer's thickness, µm.
    pub thickness_std_um: f64,
    /// Sampling of the wavelengths.
    pub light: LightRule,
}

/// Range of the cell's area over the nominal one.
pub(super) const AREA: [f64; 2] = [0.7, 1.3];
/// Range of Lx/Ly over the nominal ratio.
pub(super) const ASPECT: [f64; 2] = [0.6, 1.4];
/// The distribution of thicknesses is truncated at this many standard deviations.
pub const THICKNESS_CUT: f64 = 3.0;
/// Nodes over it without fringes: absorption by 10 between neighbouring standard deviations is
/// averaged to 1e-12.
const LEAST_THICKNESSES: usize = 24;
/// Fringes are followed up to this harmonic: the next is of (r²)⁷, 1e-6 to 1e-8 where an index of
/// 1.5 to 1.7 borders air.
const HARMONICS: f64 = 6.0;
/// Most nodes: thicker layers have fringes beyond number, whose phases they sample.
const MOST_THICKNESSES: usize = 1200;
/// No layer's mean index is taken to be higher where fringes are counted.
pub const MEAN_INDEX: f64 = 2.0;
/// Strata of μ² are not sampled closer to grazing incidence than 89.4°.
const LEAST_SQUARED_COSINE: f64 = 1e-4;

/// The draws of one realisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Period of its cell, µm.
    pub period_um: [f64; 2],
    /// Thickness of its layer, µm.
    pub thickness_um: f64,
    /// Azimuth of its planes of incidence, degrees from the cell's x.
    pub azimuth_deg: f64,
    /// Position within every stratum of directions, 0–1.
    pub direction: f64,
    /// Position within every stratum of wavelengths, 0–1.
    pub wavelength: f64,
}

/// Polar angles, degrees, one in each of `strata` equal strata of μ² = cos²θ (in which the weight
/// of the hemispherical mean is uniform), at the position `share` of every stratum; increasing.
pub fn stratified_deg(strata: usize, share: f64) -> Vec<f64> {
    let squared = |k: usize| ((k as f64 + share) / strata as f64).max(LEAST_SQUARED_COSINE);
    (0..strata).rev().map(|k| squared(k).sqrt().acos().to_degrees()).collect()
}

/// Sign of the deviation of each pigment's volume in a realisation: opposite in the two of a pair;
/// with several pigments all combinations of signs take turns.
pub(super) fn signs(realisation: usize, pigments: usize) -> Vec<f64> {
    let sign = |bits: usize| if bits.is_multiple_of(2) { 1.0 } else { -1.0 };
    // bits of the pair's number, after a 0 for the first pigment
    let pair = 2 * (realisation / 2);
    (0..pigments).map(|k| sign(realisation) * sign(pair.checked_shr(k as u32).unwrap_or(0))).collect()
}

/// The shortest possible side of a cell of this nominal period, µm.
pub fn shortest_side_um(cell: CellRule, [x, y]: [f64; 2]) -> f64 {
    match cell {
        CellRule::Fixed => x.min(y),
        CellRule::Varied => (AREA[0] * (ASPECT[0] * x * x).min(y * y / ASPECT[1])).sqrt(),
    }
}

pub(super) fn between([low, high]: [f64; 2], share: f64) -> f64 {
    low + (high - low) * share
}

/// A thickness of an uneven layer, and its share of the area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThicknessShare {
    /// Thickness, µm.
    pub um: f64,
    /// Share, 0 to 1.
    pub share: f64,
}

impl ThicknessShare {
    /// An even layer's only one.
    pub fn even(um: f64) -> Vec<Self> {
        vec![Self { um, share: 1.0 }]
    }

    /// Nodes of Gauss and Legendre over the truncated normal distribution, with the density as
    /// their weight: exact to rounding for what absorption makes of it, and as many as fringes over
    /// the range of thicknesses need, seen at the shortest wavelength.
    pub(super) fn uneven(mean_um: f64, std_um: f64, shortest_nm: f64) -> Vec<Self> {
        // phase between the ends of the range by twice the path; degree 2N − 1 is beyond half of it
        let phase = 4.0 * PI * MEAN_INDEX * 2.0 * THICKNESS_CUT * std_um / (1e-3 * shortest_nm);
        let count = LEAST_THICKNESSES + (0.25 * HARMONICS * phase).ceil() as usize;
        let rule = GaussLegendre::new(count.min(MOST_THICKNESSES)).expect("a positive number of nodes");
        let node = |(x, weight): &(f64, f64)| {
            let deviation = THICKNESS_CUT * x;
            Self { um: mean_um + std_um * deviation, share: weight * (-0.5 * deviation * deviation).exp() }
        };
        let nodes: Vec<Self> = rule.iter().map(node).collect();
        let sum: f64 = nodes.iter().map(|node| node.share).sum();
        nodes.into_iter().map(|node| Self { share: node.share / sum, ..node }).collect()
    }
}

/// Truncated normal distribution by its quantiles.
pub(super) fn thickness_um(mean_um: f64, std_um: f64, share: f64) -> f64 {
    let law = Normal::standard();
    let cut = law.cdf(-THICKNESS_CUT);
    mean_um + std_um * law.inverse_cdf(between([cut, 1.0 - cut], share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Means of absorption and of fringes over uneven layers, against a sum over the density.
    /// *Planted*: nodes of equal probability; nodes for the first harmonic alone.
    #[test]
    fn means_over_uneven_layers_are_those_of_the_density() {
        let (mean_um, std_um, nm) = (4.0, 1.0, 300.0);
        let nodes = ThicknessShare::uneven(mean_um, std_um, nm);
        let steps = 60_000;
        let deviation = |k: usize| THICKNESS_CUT * (2.0 * (k as f64 + 0.5) / f64::from(steps) - 1.0);
        let density = |z: f64| (-0.5 * z * z).exp();
        let sum: f64 = (0..steps as usize).map(|k| density(deviation(k))).sum();
        let absorbed = |um: f64| (-2.5 * um).exp();
        let fringes = |um: f64| 0.5 + 0.5 * (4.0 * PI * 1.5 * um / (1e-3 * nm)).cos();
        // R of Airy, with all harmonics of the fringes, of an index of 1.7 in air
        let face = (0.7_f64 / 2.7).powi(2);
        let airy = |um: f64| {
            let sine = (TAU * 1.7 * um / (1e-3 * nm)).sin().powi(2);
            4.0 * face * sine / ((1.0 - face).powi(2) + 4.0 * face * sine)
        };
        for of in [&absorbed as &dyn Fn(f64) -> f64, &fringes, &airy] {
            let mean: f64 = nodes.iter().map(|node| node.share * of(node.um)).sum();
            let z = |k: usize| deviation(k);
            let exact: f64 =
                (0..steps as usize).map(|k| density(z(k)) * of(mean_um + std_um * z(k))).sum::<f64>() / sum;
            // the midpoint rule of the reference at the cut
            assert!((mean - exact).abs() < 1e-7 * exact, "{mean} {exact}");
        }
    }

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
        // a normal distribution truncated at 3σ keeps 98.7 % of its standard deviation
        assert!((mean - 1.0).abs() < 1e-12 && (spread - 0.0987).abs() < 2e-4, "{mean} {spread}");
    }
}
