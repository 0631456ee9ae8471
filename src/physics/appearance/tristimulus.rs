//! Tristimulus weights of a wavelength grid: CIE 1931 2° observer under D65.

mod beyond;
mod emission;
mod spacing;

pub use beyond::{COLOUR_RANGE_NM, MOST_OUTSIDE};
pub use emission::EmissionWeights;
pub use spacing::Guide;

use super::viewing::{ColourError, Summation, Viewing};
use crate::numerics::interpolate::lagrange;
use beyond::SpectrumEnd;
use std::ops::Range;

/// Range of the CIE tables, nm.
pub const TABLE_RANGE_NM: [f64; 2] = [380.0, 780.0];

/// Uniform grids up to this step are summed directly; others are resampled to at most
/// [`RESAMPLED_STEP_NM`].
const LARGEST_DIRECT_STEP_NM: f64 = 10.0;
const RESAMPLED_STEP_NM: f64 = 5.0;
/// Step for lamps: their spectral lines need the full resolution of the table.
const LINES_STEP_NM: f64 = 1.0;

/// IEC 61966-2-1: linear RGB = M · XYZ with Y = 1 for white.
const XYZ_TO_RGB: [[f64; 3]; 3] =
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];

/// Converts spectra on one wavelength grid to tristimulus values: XYZ = Σ_j w_j R_j, white (R = 1)
/// has Y = 100.
///
/// A uniform grid with steps up to 10 nm is summed directly (CIE 15). Any other grid is resampled
/// between its ends to steps of at most 5 nm by Lagrange interpolation through the four nearest
/// points (three in the first and last interval: the rule of ASTM E2022), which keeps XYZ linear in
/// the spectrum. The range of integration is 400–700 nm ([`COLOUR_RANGE_NM`]) or the whole grid if
/// wider: the value at an end is extended to 400 or 700 nm, and [`Colorimeter::beyond`] estimates
/// the resulting error. Under lamps, whose spectra have lines, every grid is resampled to 1 nm:
/// sums over F11 at every tenth nm give a white of Z = 32 instead of 66.
///
/// *Measured* over the 12 spectra of `validation/data/colour.json`, largest ΔE*ab against the 5 nm
/// sum from 400 to 700 nm: 16 points (20 nm) 0.5, 12 points (27 nm) 1.6, 8 points (43 nm) 6.5; a
/// band of σ = 12 nm is lost by such grids (1.3, 7.8, 79). Test `coarse_grids_keep_the_colour`.
#[derive(Clone, Debug, PartialEq)]
pub struct Colorimeter {
    wavelengths_nm: Vec<f64>,
    /// Normalisation of light times observer that makes Y of white 100, per nm.
    scale_per_nm: f64,
    weights: Vec<[f64; 3]>,
    /// XYZ of the perfect white diffuser on this grid; Y = 100.
    pub white_xyz: [f64; 3],
    white_rgb: [f64; 3],
    viewing: Viewing,
    /// Spectral range beyond either end of the grid.
    ends: [SpectrumEnd; 2],
    /// Chromatic adaptation to D65, if the illuminant is another one.
    adaptation: Option<[[f64; 3]; 3]>,
}

impl Colorimeter {
    /// Weights of a grid in nm, increasing, uniform or not, under D65 for the CIE 1931 observer.
    ///
    /// # Errors
    /// Fewer than 3 wavelengths, not increasing, outside 380–780 nm, or so narrow that more than a
    /// quarter of white's X, Y or Z lies outside ([`MOST_OUTSIDE`]).
    pub fn new(wavelengths_nm: &[f64]) -> Result<Self, ColourError> {
        Self::under(wavelengths_nm, &Viewing::default())
    }

    /// Weights of a grid under any illuminant and for any observer. White is then that of the
    /// illuminant: `linear_rgb` shows colours as to an eye adapted to it (Bradford).
    ///
    /// # Errors
    /// See [`Colorimeter::new`].
    pub fn under(wavelengths_nm: &[f64], viewing: &Viewing) -> Result<Self, ColourError> {
        check_grid(wavelengths_nm)?;
        let RawWeights { step_nm, raw, ends } = RawWeights::new(wavelengths_nm, viewing, viewing);
        let scale = 100.0 / raw.iter().map(|w| w[1]).sum::<f64>();
        let weights: Vec<_> = raw.iter().map(|w| w.map(|x| scale * x)).collect();
        let white_xyz = weighted_sum(&weights, &vec![1.0; weights.len()]);
        let adaptation = (*viewing != Viewing::default()).then(|| adaptation(white_xyz));
        let white_rgb = rgb_of(adapted(&adaptation, white_xyz));
        let ends = ends.map(|end| end.scaled(scale));
        check_white(wavelengths_nm, white_xyz, &ends)?;
        let wavelengths_nm = wavelengths_nm.to_vec();
        let viewing = viewing.clone();
        let scale_per_nm = scale / step_nm;
        Ok(Self { wavelengths_nm, scale_per_nm, weights, white_xyz, white_rgb, viewing, ends, adaptation })
    }

    /// The wavelengths, nm, increasing.
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths_nm
    }

    /// Illuminant, observer and summation.
    pub fn viewing(&self) -> &Viewing {
        &self.viewing
    }

    /// Weight of a narrow band at a wavelength, per nm: the integrand that the sum over the grid
    /// approximates. Nothing outside the tables of the observers.
    pub fn weight_per_nm(&self, nm: f64) -> [f64; 3] {
        let [lo, hi] = TABLE_RANGE_NM;
        if !(lo..=hi).contains(&nm) {
            return [0.0; 3];
        }
        light_times_observer(nm, &self.viewing).map(|w| self.scale_per_nm * w)
    }

    /// XYZ of a spectrum of reflectance factors (white = 1), one value per wavelength.
    ///
    /// # Errors
    /// Wrong length, or a value that is not finite.
    pub fn xyz(&self, values: &[f64]) -> Result<[f64; 3], ColourError> {
        if values.len() != self.weights.len() {
            return Err(ColourError::WrongLength { count: values.len(), expected: self.weights.len() });
        }
        let mut places = self.wavelengths_nm.iter().zip(values);
        if let Some((&wavelength_nm, &value)) = places.find(|(_, v)| !v.is_finite()) {
            return Err(ColourError::NotFinite { wavelength_nm, value });
        }
        Ok(weighted_sum(&self.weights, values))
    }

    /// Linear sRGB, divided per channel by the value of white, so that white is exactly (1, 1, 1);
    /// not clipped.
    pub fn linear_rgb(&self, xyz: [f64; 3]) -> [f64; 3] {
        let rgb = rgb_of(adapted(&self.adaptation, xyz));
        std::array::from_fn(|c| rgb[c] / self.white_rgb[c])
    }
}

/// Weights of X, Y, Z of the wavelengths of a grid before white has Y = 100.
struct RawWeights {
    /// Step of the sum, nm.
    step_nm: f64,
    raw: Vec<[f64; 3]>,
    ends: [SpectrumEnd; 2],
}

impl RawWeights {
    /// Sums by the rule of one viewing over the light of another, for the same observer.
    fn new(grid: &[f64], rule: &Viewing, light: &Viewing) -> Self {
        let plain = rule.summation == Summation::Plain && !rule.has_lines();
        let (step_nm, mut raw) = if plain && is_direct(grid) {
            (mean_step(grid), grid.iter().map(|&nm| light_times_observer(nm, light)).collect())
        } else {
            let (step_nm, places) = integrand(grid, rule, light);
            (step_nm, distributed(grid, places, Interpolation::Cubic))
        };
        let ends = SpectrumEnd::both(grid, step_nm, light);
        if rule.summation == Summation::Plain {
            for end in &ends {
                let weight = &mut raw[end.node()];
                let beyond = end.white();
                *weight = std::array::from_fn(|c| weight[c] + beyond[c]);
            }
        }
        Self { step_nm, raw, ends }
    }
}

fn rgb_of(xyz: [f64; 3]) -> [f64; 3] {
    XYZ_TO_RGB.map(|row| row.iter().zip(xyz).map(|(m, x)| m * x / 100.0).sum())
}

/// Cone response matrix of the Bradford adaptation.
const BRADFORD: [[f64; 3]; 3] =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
/// Inverse of [`BRADFORD`].
const BRADFORD_BACK: [[f64; 3]; 3] = [
    [0.986_992_9, -0.147_054_3, 0.159_962_7],
    [0.432_305_3, 0.518_360_3, 0.049_291_2],
    [-0.008_528_7, 0.040_042_8, 0.968_486_7],
];
/// White point of sRGB: D65 for the CIE 1931 observer.
const SCREEN_WHITE: [f64; 3] = [95.047, 100.0, 108.883];

fn times(matrix: &[[f64; 3]; 3], xyz: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row.iter().zip(xyz).map(|(m, x)| m * x).sum())
}

/// Matrix that maps colours under an illuminant of this white to corresponding colours under D65.
fn adaptation(white: [f64; 3]) -> [[f64; 3]; 3] {
    let here = times(&BRADFORD, white);
    let there = times(&BRADFORD, SCREEN_WHITE);
    let scaled: [[f64; 3]; 3] = std::array::from_fn(|i| BRADFORD[i].map(|m| m * there[i] / here[i]));
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| BRADFORD_BACK[i][k] * scaled[k][j]).sum()))
}

fn adapted(matrix: &Option<[[f64; 3]; 3]>, xyz: [f64; 3]) -> [f64; 3] {
    matrix.as_ref().map_or(xyz, |m| times(m, xyz))
}

fn weighted_sum(weights: &[[f64; 3]], values: &[f64]) -> [f64; 3] {
    std::array::from_fn(|c| weights.iter().zip(values).map(|(w, v)| w[c] * v).sum())
}

fn check_grid(grid: &[f64]) -> Result<(), ColourError> {
    if grid.len() < 3 {
        return Err(ColourError::TooFewWavelengths { count: grid.len() });
    }
    let [lo, hi] = TABLE_RANGE_NM;
    let bad = |&i: &usize| !(lo..=hi).contains(&grid[i]) || (i > 0 && grid[i] <= grid[i - 1]);
    let Some(index) = (0..grid.len()).find(bad) else { return Ok(()) };
    Err(ColourError::BadWavelength { index, value: grid[index], lo, hi })
}

fn check_white(grid: &[f64], white: [f64; 3], ends: &[SpectrumEnd; 2]) -> Result<(), ColourError> {
    let [below, above] = ends.each_ref().map(SpectrumEnd::white);
    let least = 1.0 - MOST_OUTSIDE;
    let mut inside = (0..3).map(|c| (["X", "Y", "Z"][c], 1.0 - (below[c] + above[c]) / white[c]));
    let lost = inside.find(|(_, channel)| channel.is_nan() || *channel < least);
    let Some((name, channel)) = lost else { return Ok(()) };
    let first = grid[0];
    let last = grid[grid.len() - 1];
    Err(ColourError::WhiteNotCovered { first, last, name, channel, least })
}

fn mean_step(grid: &[f64]) -> f64 {
    (grid[grid.len() - 1] - grid[0]) / (grid.len() - 1) as f64
}

/// Whether a grid is uniform with a step of at most 10 nm (up to rounding of the input).
fn is_direct(grid: &[f64]) -> bool {
    let step = mean_step(grid);
    let uniform = grid.windows(2).all(|w| (w[1] - w[0] - step).abs() < 1e-6 * step);
    uniform && step <= LARGEST_DIRECT_STEP_NM * (1.0 + 1e-9)
}

/// S(λ) (x̄, ȳ, z̄)(λ), linear between the 1 nm rows of the tables.
fn light_times_observer(nm: f64, viewing: &Viewing) -> [f64; 3] {
    let [lo, hi] = TABLE_RANGE_NM.map(|x| x as usize);
    let below = (nm.floor() as usize).clamp(lo, hi - 1);
    let t = nm - below as f64;
    let a = viewing.row(below);
    let b = viewing.row(below + 1);
    std::array::from_fn(|c| a[c] + t * (b[c] - a[c]))
}

/// Places of the sum over a range, and its weights of X, Y, Z there.
type Integrand = Vec<(f64, [f64; 3])>;

/// The step of the sum to which a grid is resampled, and the light there. By ASTM E308 every
/// nanometre of the tables counts, and the range beyond the grid is assigned to its ends.
fn integrand(grid: &[f64], rule: &Viewing, light: &Viewing) -> (f64, Integrand) {
    let first = grid[0];
    let last = grid[grid.len() - 1];
    if rule.summation == Summation::E308 {
        let [lo, hi] = TABLE_RANGE_NM.map(|x| x as usize);
        return (1.0, (lo..=hi).map(|nm| ((nm as f64).clamp(first, last), light.row(nm))).collect());
    }
    let most_nm = if rule.has_lines() { LINES_STEP_NM } else { RESAMPLED_STEP_NM };
    let intervals = ((last - first) / most_nm - 1e-9).ceil().max(1.0);
    let places = (0..=intervals as usize).map(|k| first + (last - first) * k as f64 / intervals);
    let summed = places.map(|nm| (nm, light_times_observer(nm, light)));
    ((last - first) / intervals, summed.collect())
}

/// How a spectrum is interpolated between the wavelengths of a grid.
#[derive(Clone, Copy)]
enum Interpolation {
    /// Lagrange polynomials through the four nearest wavelengths (ASTM E2022).
    Cubic,
    /// Straight lines.
    Linear,
}

/// Sums of the weights of X, Y, Z at given wavelengths, shared among those of the grid.
fn distributed(
    grid: &[f64],
    light: impl IntoIterator<Item = (f64, [f64; 3])>,
    rule: Interpolation,
) -> Vec<[f64; 3]> {
    let mut weights = vec![[0.0; 3]; grid.len()];
    for (nm, row) in light {
        let shares = match rule {
            Interpolation::Cubic => lagrange_shares(grid, nm),
            Interpolation::Linear => neighbours(grid, nm, 1),
        };
        for (j, share) in shares {
            (0..3).for_each(|c| weights[j][c] += share * row[c]);
        }
    }
    weights
}

/// (index, weight) pairs of the local Lagrange interpolation through up to four neighbours.
pub fn lagrange_shares(grid: &[f64], place: f64) -> Vec<(usize, f64)> {
    neighbours(grid, place, 2)
}

/// Lagrange interpolation through up to `each` neighbours on either side.
fn neighbours(grid: &[f64], place: f64, each: usize) -> Vec<(usize, f64)> {
    let after = grid.partition_point(|&x| x < place).clamp(1, grid.len() - 1);
    let first = after.saturating_sub(each);
    (first..).zip(lagrange(&grid[first..(after + each).min(grid.len())], place)).collect()
}

/// The wavelengths of a rising list that colours can take: those within the tables of the
/// observers ([`TABLE_RANGE_NM`]).
pub fn visible(wavelengths_nm: &[f64]) -> Range<usize> {
    let [lo, hi] = TABLE_RANGE_NM;
    let first = wavelengths_nm.partition_point(|&nm| nm < lo);
    first..wavelengths_nm.partition_point(|&nm| nm <= hi).max(first)
}
