//! Weighted means of spectra beyond colour: tables of weights, their sums on a grid of wavelengths
//! with what the grid leaves open, and what is made of such sums.
//!
//! The mean of a spectrum f with weights w is ∫ w f dλ / ∫ w dλ. The table of weights keeps all of
//! its rows, between which it is linear; the spectrum is interpolated between the wavelengths of
//! the grid, and stays at its end values beyond them. Both errors that follow are estimated.

mod named;
mod table;

pub use named::{NamedWeights, weight_names};
pub use table::{WeightError, WeightTable};

use super::tristimulus::{Guide, lagrange_shares};

/// Wavelength to which the distances below refer, nm: what a layer's spectrum does scales with the
/// wavelength, as grains and films count in wavelengths.
const REFERENCE_NM: f64 = 550.0;
/// Distance of wavelengths, at the reference, from which straight lines count as a guess, nm; as
/// for colours.
const LINEAR_NM: f64 = 40.0;
/// Distance from which every rule counts as a guess, nm; as for colours.
const GUESSED_NM: f64 = 80.0;
/// Share of a spectrum by which it may bend unseen between wavelengths 100 nm apart, …
const BEND: f64 = 0.2;
/// … in proportion to this power of their distance, …
const BEND_POWER: i32 = 4;
/// … up to this share.
const MOST_BEND: f64 = 0.4;
/// Standard error of a spectrum per nm beyond the grid, at the reference; as for colours.
const DRIFT_PER_NM: f64 = 0.003;
/// The most that it drifts.
const MOST_DRIFT: f64 = 0.4;
/// Standard error per nm below the grid: white pigments begin to absorb there, within tens of nm.
const DRIFT_BELOW_PER_NM: f64 = 0.02;
/// The most that a spectrum drifts there: half-way to black from white.
const MOST_DRIFT_BELOW: f64 = 0.5;
/// Widest of four neighbouring intervals over the narrowest, up to which a cubic runs through them;
/// polynomials through more uneven wavelengths swing.
const EVEN: f64 = 2.5;

/// Weighted mean over a grid of wavelengths: Σ_j w_j f_j, 1 for a spectrum of 1.
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedSum {
    wavelengths_nm: Vec<f64>,
    table: WeightTable,
    weights: Vec<f64>,
    /// Wavelengths within the grid, nm, and their weights.
    within: Vec<(f64, f64)>,
    /// Distances beyond either end of the grid, nm, and their weights.
    beyond: [Vec<(f64, f64)>; 2],
}

/// How a spectrum is interpolated between the wavelengths of a grid.
#[derive(Clone, Copy)]
enum Between {
    /// Cubics where the wavelengths are spaced alike, straight lines elsewhere.
    Cubics,
    /// Straight lines.
    Lines,
}

impl WeightedSum {
    /// The sum of a table over a grid of rising wavelengths, nm, of which there is one at least.
    pub fn new(wavelengths_nm: &[f64], table: &WeightTable) -> Self {
        let total = table.total();
        let places = table.places(wavelengths_nm).into_iter().map(|(nm, weight)| (nm, weight / total));
        let first = wavelengths_nm[0];
        let last = wavelengths_nm[wavelengths_nm.len() - 1];
        let mut within = Vec::new();
        let mut beyond = [Vec::new(), Vec::new()];
        for (nm, weight) in places.filter(|(_, weight)| *weight != 0.0) {
            if nm < first {
                beyond[0].push((first - nm, weight));
            } else if nm > last {
                beyond[1].push((nm - last, weight));
            } else {
                within.push((nm, weight));
            }
        }
        let mut weights = shared(wavelengths_nm, &within, Between::Cubics);
        let of = |end: &[(f64, f64)]| end.iter().map(|(_, weight)| weight).sum::<f64>();
        weights[0] += of(&beyond[0]);
        *weights.last_mut().expect("a wavelength") += of(&beyond[1]);
        Self { wavelengths_nm: wavelengths_nm.to_vec(), table: table.clone(), weights, within, beyond }
    }

    /// The mean of a spectrum, one value for each wavelength of the grid.
    pub fn of(&self, values: &[f64]) -> f64 {
        self.weights.iter().zip(values).map(|(weight, value)| weight * value).sum()
    }

    /// Share of the weights beyond the grid.
    pub fn outside(&self) -> f64 {
        self.beyond.iter().flatten().map(|(_, weight)| weight).sum()
    }

    /// Independent errors of the mean due to what a spectrum, known on the grid alone, does between
    /// its wavelengths: differences between rules of interpolation, what it may bend unseen, and,
    /// with a `guide`, what the grid misses of that similar spectrum; the other parts then concern
    /// the difference from it. As for colours, see
    /// [`crate::appearance::tristimulus::Colorimeter::spacing`], with distances relative to the
    /// wavelength.
    pub fn spacing(&self, values: &[f64], guide: Option<&Guide>) -> Vec<f64> {
        let grid = &self.wavelengths_nm;
        let unknown: Vec<f64> = match guide {
            Some(guide) => values.iter().zip(&guide.on_grid).map(|(value, known)| value - known).collect(),
            None => values.to_vec(),
        };
        let sum = |nodes: &[usize], between: Between| {
            let nm: Vec<f64> = nodes.iter().map(|&j| grid[j]).collect();
            let weights = shared(&nm, &self.within, between);
            weights.iter().zip(nodes).map(|(weight, &j)| weight * unknown[j]).sum::<f64>()
        };
        let all: Vec<usize> = (0..grid.len()).collect();
        let best = sum(&all, Between::Cubics);
        let widest = grid.windows(2).map(|pair| relative_nm([pair[0], pair[1]])).fold(0.0, f64::max);
        let mut parts = vec![(widest / LINEAR_NM).powi(2).min(1.0) * (sum(&all, Between::Lines) - best)];
        let weight = (widest / GUESSED_NM).powf(1.5).min(1.0);
        for parity in [0, 1] {
            let last = grid.len() - 1;
            let half: Vec<usize> =
                all.iter().copied().filter(|&j| j % 2 == parity || j == 0 || j == last).collect();
            parts.push(weight * (sum(&half, Between::Cubics) - best));
        }
        let largest = unknown.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        parts.extend(grid.windows(2).map(|pair| largest * self.bend([pair[0], pair[1]])));
        parts.extend(guide.map(|guide| self.missed(guide)));
        parts
    }

    /// What the grid misses of a spectrum that is known between its wavelengths.
    pub fn missed(&self, guide: &Guide) -> f64 {
        let within = Self::new(&guide.fine_nm, &self.table).within;
        let fine = shared(&guide.fine_nm, &within, Between::Cubics);
        let known = fine.iter().zip(&guide.fine).map(|(weight, value)| weight * value).sum::<f64>();
        let coarse = shared(&self.wavelengths_nm, &self.within, Between::Cubics);
        let on_grid = coarse.iter().zip(&guide.on_grid).map(|(weight, value)| weight * value).sum::<f64>();
        known - on_grid
    }

    /// Standard errors of the mean due to light beyond either end of the grid, for a spectrum
    /// between 0 and 1.
    pub fn beyond(&self, values: &[f64]) -> [f64; 2] {
        let ends = [self.wavelengths_nm.first(), self.wavelengths_nm.last()];
        let at_ends = [values.first(), values.last()];
        std::array::from_fn(|k| {
            let end_nm = ends[k].copied().unwrap_or(REFERENCE_NM);
            let end = at_ends[k].copied().unwrap_or(0.0);
            let room = (1.0 - end).max(end).max(0.0);
            let [per_nm, most] = [[DRIFT_BELOW_PER_NM, MOST_DRIFT_BELOW], [DRIFT_PER_NM, MOST_DRIFT]][k];
            let drift = |nm: f64| {
                let free = nm * per_nm * REFERENCE_NM / end_nm;
                (most * (1.0 - (-free / most).exp())).min(room)
            };
            self.beyond[k].iter().map(|(nm, weight)| weight * drift(*nm)).sum()
        })
    }

    /// Mean of an arc between two wavelengths, as high as a spectrum of 1 may bend there.
    fn bend(&self, [from, to]: [f64; 2]) -> f64 {
        let height = (BEND * (relative_nm([from, to]) / 100.0).powi(BEND_POWER)).min(MOST_BEND);
        let inside = self.within.iter().filter(|(nm, _)| (from..to).contains(nm));
        inside.fold(0.0, |sum, (nm, weight)| {
            let t = (nm - from) / (to - from);
            sum + height * 4.0 * t * (1.0 - t) * weight
        })
    }
}

/// Distance of two wavelengths relative to their mean, as one at the reference wavelength, nm.
fn relative_nm([from, to]: [f64; 2]) -> f64 {
    (to - from) * REFERENCE_NM / (0.5 * (from + to))
}

/// The weights of places, shared among the wavelengths of a grid.
fn shared(grid: &[f64], places: &[(f64, f64)], between: Between) -> Vec<f64> {
    let mut weights = vec![0.0; grid.len()];
    if grid.len() == 1 {
        weights[0] = places.iter().map(|(_, weight)| weight).sum();
        return weights;
    }
    for &(nm, weight) in places {
        let after = grid.partition_point(|&x| x < nm).clamp(1, grid.len() - 1);
        let near = &grid[after.saturating_sub(2)..(after + 2).min(grid.len())];
        match between {
            Between::Cubics if is_even(near) => {
                lagrange_shares(grid, nm).into_iter().for_each(|(j, share)| weights[j] += weight * share);
            }
            _ => {
                let t = (nm - grid[after - 1]) / (grid[after] - grid[after - 1]);
                weights[after - 1] += weight * (1.0 - t);
                weights[after] += weight * t;
            }
        }
    }
    weights
}

/// Whether wavelengths are spaced alike.
fn is_even(near: &[f64]) -> bool {
    let steps = || near.windows(2).map(|pair| pair[1] - pair[0]);
    steps().fold(0.0, f64::max) <= EVEN * steps().fold(f64::INFINITY, f64::min)
}

/// Shares of light below this are rounding of sums of order 1: nothing.
const ROUNDING: f64 = 1e-12;

/// What is made of weighted means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum NumberTransform {
    /// The mean itself, such as a solar reflectance.
    #[default]
    Mean,
    /// −log₁₀ of the mean: an optical density.
    Density,
    /// 1 over the mean, such as a sun protection factor of a transmittance.
    Reciprocal,
    /// CIE whiteness W, of weights such as `"D65/10"`.
    Whiteness,
    /// CIE tint T, positive where greenish, of the same weights.
    Tint,
    /// Yellowness index of ASTM E313, of weights `"C/2"`, `"C/10"`, `"D65/2"` or `"D65/10"`.
    Yellowness,
}

impl NumberTransform {
    /// Whether it takes X, Y, Z and not a single mean.
    pub fn of_tristimulus(self) -> bool {
        matches!(self, Self::Whiteness | Self::Tint | Self::Yellowness)
    }

    /// Its key in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Density => "density",
            Self::Reciprocal => "reciprocal",
            Self::Whiteness => "whiteness",
            Self::Tint => "tint",
            Self::Yellowness => "yellowness",
        }
    }

    /// The number of a mean; NaN where there is none, such as the density of a negative mean.
    pub fn of_mean(self, mean: f64) -> f64 {
        match self {
            Self::Density if mean > ROUNDING => -mean.log10(),
            Self::Reciprocal if mean > ROUNDING => 1.0 / mean,
            Self::Mean => mean,
            _ => f64::NAN,
        }
    }

    /// The number of X, Y, Z relative to a white (Y = 100) under an illuminant for an observer.
    ///
    /// CIE 15:2018: W = Y + 800 (xₙ − x) + 1700 (yₙ − y); T = 1000 (xₙ − x) − 650 (yₙ − y), with
    /// 900 in the place of 1000 for the 10° observer. ASTM E313: 100 (C_X X − C_Z Z)/Y.
    pub fn of_xyz(self, xyz: [f64; 3], white: &WhitePoint) -> f64 {
        let [x, y] = chromaticity(xyz);
        let [white_x, white_y] = chromaticity(white.xyz);
        match self {
            Self::Whiteness => xyz[1] + 800.0 * (white_x - x) + 1700.0 * (white_y - y),
            Self::Tint => {
                let of_x = if white.observer == "2" { 1000.0 } else { 900.0 };
                of_x * (white_x - x) - 650.0 * (white_y - y)
            }
            Self::Yellowness => {
                let Some([of_x, of_z]) = white.yellowness() else { return f64::NAN };
                100.0 * (of_x * xyz[0] - of_z * xyz[2]) / xyz[1]
            }
            _ => f64::NAN,
        }
    }
}

fn chromaticity([x, y, z]: [f64; 3]) -> [f64; 2] {
    [x / (x + y + z), y / (x + y + z)]
}

/// A perfect white under an illuminant for an observer.
#[derive(Clone, Debug, PartialEq)]
pub struct WhitePoint {
    /// Its X, Y, Z; Y = 100.
    pub xyz: [f64; 3],
    /// Name of the illuminant.
    pub illuminant: String,
    /// Name of the observer.
    pub observer: String,
}

impl WhitePoint {
    /// C_X and C_Z of ASTM E313; `None` under other conditions than those that it names.
    pub fn yellowness(&self) -> Option<[f64; 2]> {
        match (self.illuminant.as_str(), self.observer.as_str()) {
            ("C", "2") => Some([1.2769, 1.0592]),
            ("D65", "2") => Some([1.2985, 1.1335]),
            ("C", "10") => Some([1.2871, 1.0781]),
            ("D65", "10") => Some([1.3013, 1.1498]),
            _ => None,
        }
    }
}

#[cfg(test)]
#[path = "weighted_tests.rs"]
mod tests;
