//! Spectra as weighted numbers take them: at the wavelengths that are summed, with all that the
//! errors of their sums follow from.

use crate::appearance::tristimulus::Guide;
use crate::appearance::weighted::WeightTable;
use crate::input::study::{WantedNumber, WantedWeights};

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

/// Steps for every fringe where weights are narrow: with fewer of them cubics, and trapezia between
/// the rows, miss a tenth of a fringe, which only broad weights average out. With these they miss
/// some thousandths.
const STEPS_PER_NARROW_FRINGE: f64 = 32.0;
/// Rows of weights closer than this share of a fringe are summed as they are.
const CLOSE_ROWS: f64 = 1.0 / 32.0;
/// Steps between other rows, so that the sum follows the fringes between them.
const STEPS_BETWEEN_ROWS: f64 = 9.0;
/// No rows of weights ask for closer steps, nm.
const SHORTEST_STEP_NM: f64 = 0.2;
/// Most wavelengths that are added for weights.
const MOST_ADDED: f64 = 5_000.0;
/// What a step may differ from its neighbour, as a share of it: cubics run through wavelengths that
/// are spaced nearly alike.
const GRADING: f64 = 0.3;
/// Weights of this program within a share of their wavelength are narrow; all others are so broad
/// that fringes average out.
const NARROW: f64 = 0.1;

/// Wavelengths that are summed over within a range and closer ones within others.
#[derive(Clone, Copy, Debug)]
struct CloseSteps {
    range_nm: [f64; 2],
    step_nm: f64,
}

impl CloseSteps {
    /// The longest step at a wavelength that these allow.
    fn at(&self, nm: f64) -> f64 {
        let [from, to] = self.range_nm;
        self.step_nm + GRADING * (from - nm).max(nm - to).max(0.0)
    }
}

/// As [`sum_wavelengths_nm`], and closer where one of the numbers has weights that vary more
/// closely than that: those of files, and narrow parts of others.
pub(super) fn number_wavelengths_nm(
    range_nm: [f64; 2],
    fringe_nm: impl Fn(f64) -> f64,
    numbers: &[WantedNumber],
) -> Vec<f64> {
    let wide = sum_wavelengths_nm(range_nm, &fringe_nm);
    let mut close = Vec::new();
    for number in numbers {
        let is_of_file = matches!(number.weights, WantedWeights::Table { .. });
        let tables = number.tables().map_or(Vec::new(), |named| named.tables);
        for table in tables.iter().filter(|table| is_of_file || is_narrow(table)) {
            close.extend(close_steps(table, range_nm, &fringe_nm));
        }
    }
    let usual_nm = |nm: f64| {
        let after = wide.partition_point(|&x| x <= nm).clamp(1, wide.len() - 1);
        wide[after] - wide[after - 1]
    };
    close.retain(|steps| steps.step_nm < usual_nm(steps.range_nm[0].max(range_nm[0])));
    if close.is_empty() {
        return wide;
    }
    let [from, to] = range_nm;
    let mut all = vec![from];
    let mut here = from;
    loop {
        let step = close.iter().fold(usual_nm(here), |least, steps| least.min(steps.at(here)));
        here += step;
        if here + 0.5 * step >= to {
            break;
        }
        all.push(here);
    }
    all.push(to);
    all
}

/// Whether the weights of a table are within few wavelengths.
fn is_narrow(table: &WeightTable) -> bool {
    let ends = table
        .weighted_intervals()
        .fold([f64::INFINITY, 0.0_f64], |[from, to], interval| [from.min(interval[0]), to.max(interval[1])]);
    ends[1] - ends[0] < NARROW * ends[1]
}

/// The steps that a table asks for between its rows, within a range.
fn close_steps(table: &WeightTable, range_nm: [f64; 2], fringe_nm: &impl Fn(f64) -> f64) -> Vec<CloseSteps> {
    let asked = |[from, to]: [f64; 2]| {
        let fringe = fringe_nm(from);
        let apart = to - from;
        let between_rows = if apart > CLOSE_ROWS * fringe {
            apart / STEPS_BETWEEN_ROWS
        } else {
            apart.max(SHORTEST_STEP_NM)
        };
        let range_nm = [from.max(range_nm[0]), to.min(range_nm[1])];
        CloseSteps { range_nm, step_nm: between_rows.min(fringe / STEPS_PER_NARROW_FRINGE) }
    };
    let inside = |steps: &CloseSteps| steps.range_nm[0] < steps.range_nm[1];
    let mut all: Vec<CloseSteps> = table.weighted_intervals().map(asked).filter(inside).collect();
    let count: f64 = all.iter().map(|steps| (steps.range_nm[1] - steps.range_nm[0]) / steps.step_nm).sum();
    let coarser = (count / MOST_ADDED).max(1.0);
    all.iter_mut().for_each(|steps| steps.step_nm *= coarser);
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
