//! Spectra as weighted numbers take them: at the wavelengths that are summed, with all that the
//! errors of their sums follow from.

use crate::appearance::tristimulus::Guide;

/// Step of the wavelengths that numbers are summed over, as a share of the wavelength: some 5 nm in
/// the visible range.
const SUM_STEP: f64 = 0.01;
/// Steps for every fringe of the film, at least.
const STEPS_PER_FRINGE: f64 = 4.0;
/// Most wavelengths that are summed over.
const MOST_SUMMED: f64 = 20_000.0;

/// Wavelengths over a range, nm, in equal ratios, close enough for the fringes of a film whose
/// fringes are `fringe_nm` apart at a wavelength.
pub(super) fn sum_wavelengths_nm([from, to]: [f64; 2], fringe_nm: impl Fn(f64) -> f64) -> Vec<f64> {
    let step = SUM_STEP.min(fringe_nm(from) / (STEPS_PER_FRINGE * from));
    let steps = ((to / from).ln() / step).ceil().clamp(1.0, MOST_SUMMED) as usize;
    let place = |k: usize| from * (to / from).powf(k as f64 / steps as f64);
    let mut all: Vec<f64> = (0..=steps).map(place).collect();
    all[steps] = to;
    all
}

/// A spectrum at the wavelengths that are summed, with all that the errors of its sums follow from.
pub struct SummedSpectrum {
    /// Wavelengths, nm.
    pub wavelengths_nm: Vec<f64>,
    /// Its values.
    pub values: Vec<f64>,
    /// \[realisation left out\]\[wavelength\]
    pub replicates: Vec<Vec<f64>>,
    /// Changes by errors of R and T that all realisations share: \[part\]\[wavelength\].
    pub shared: Vec<Vec<f64>>,
    /// Standard errors by tables of indices, each independent: \[move\]\[wavelength\].
    pub inputs: Vec<Vec<f64>>,
    /// The coherent film's spectrum at and between the wavelengths of a list.
    pub guide: Option<Guide>,
    /// Whether the spectrum is known at the wavelengths of a list alone.
    pub is_sampled: bool,
    /// What the solves have beyond the fit.
    pub residuals: Residuals,
}

/// What the solves at shifted wavelengths have beyond the fitted spectrum, to which a sum is
/// corrected, so that the smoothness of the fit does not bias it.
#[derive(Default)]
pub struct Residuals {
    /// \[realisation\]\[its wavelengths\], nm
    wavelengths_nm: Vec<Vec<f64>>,
    /// Width of the range that a realisation's wavelengths share, nm.
    range_nm: f64,
    /// \[whole ensemble, then each realisation left out\]\[realisation\]\[wavelength\]
    beyond: Vec<Vec<Vec<f64>>>,
}

impl Residuals {
    /// From the residual of a realisation at one of its wavelengths, for the whole ensemble or with
    /// one left out of `replicates`.
    pub fn new(
        wavelengths_nm: Vec<Vec<f64>>,
        range_nm: f64,
        replicates: usize,
        residual: &dyn Fn(Option<usize>, usize, usize) -> f64,
    ) -> Self {
        let of = |left_out: Option<usize>| {
            let realisation = |(r, nm): (usize, &Vec<f64>)| {
                (0..nm.len()).map(|j| residual(left_out, r, j)).collect::<Vec<f64>>()
            };
            wavelengths_nm.iter().enumerate().map(realisation).collect::<Vec<_>>()
        };
        let all = std::iter::once(None).chain((0..replicates).map(Some));
        let beyond = if wavelengths_nm.is_empty() { Vec::new() } else { all.map(of).collect() };
        Self { wavelengths_nm, range_nm, beyond }
    }

    /// What a sum with weights lacks: the mean over the realisations of the residuals, each with
    /// the weights of its stratum of wavelengths.
    pub(super) fn sums(&self, band: &dyn Fn(f64, f64) -> f64) -> Vec<f64> {
        let mut bands = Vec::new();
        for nm in &self.wavelengths_nm {
            let half = 0.5 * self.range_nm / nm.len().max(1) as f64;
            bands.push(nm.iter().map(|nm| band(nm - half, nm + half)).collect::<Vec<f64>>());
        }
        let sum = |(place, beyond): (usize, &Vec<Vec<f64>>)| {
            let kept = (0..beyond.len()).filter(|r| place != r + 1);
            let of = |r: usize| bands[r].iter().zip(&beyond[r]).map(|(w, x)| w * x).sum::<f64>();
            let each: Vec<f64> = kept.map(of).collect();
            each.iter().sum::<f64>() / each.len().max(1) as f64
        };
        self.beyond.iter().enumerate().map(sum).collect()
    }
}
