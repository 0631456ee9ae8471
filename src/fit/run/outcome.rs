//! The numbers of a fit: the index with its errors, whether they can be trusted, and predictions.

use super::fitted::{FaceLight, FittedIndex};
use super::forecast::Forecast;
use crate::fit::data::Data;
use crate::fit::file::AlsoFitted;
use crate::fit::law::{FitStep, rms};
use crate::fit::load::{Drawdown, FitTask, MeasuredNumber};
use faer::Mat;
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Differences of n between solutions, and errors of n, from which n is not determined.
pub(super) const UNDETERMINED: f64 = 0.06;
/// Error of the light that faces add from which it is not determined: half of what is expected.
const UNDETERMINED_LIGHT: f64 = 0.01;
/// Quantile of χ² beyond which the errors are not those stated.
const UNLIKELY: f64 = 0.999;
/// χ² per degree of freedom beyond which no error is stated.
const REFUSED: f64 = 4.0;
/// Data whose errors are this many times those stated must be found by χ² ...
const NOTICED: f64 = 2.0;
/// ... with at least this probability; otherwise a small χ² confirms nothing.
const POWER: f64 = 0.5;

/// A second solution that fits the spectra as well as the first, at another n.
#[derive(Clone, Debug, Serialize)]
pub struct OtherSolution {
    /// Its index, with the errors about it.
    pub index: Vec<FittedIndex>,
    /// χ² of the data.
    pub chi_squared: f64,
    /// Unknowns that the data determine.
    pub effective_unknowns: f64,
    /// Linearisations on all cells.
    pub linearisations: usize,
    /// Logarithm of the factor on the thicknesses.
    pub log_thickness: f64,
    /// Measured and fitted spectra.
    pub spectra: Vec<FittedSpectrum>,
}

/// Whether the stated errors can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Trust {
    /// χ² is that of the stated noise.
    Consistent,
    /// χ² is small, but so few degrees of freedom are left that it would be with wrong errors, too:
    /// no verdict.
    Untested,
    /// χ² is larger; errors are multiplied by its root per degree of freedom.
    Inflated,
    /// χ² is so large that the study must be wrong: no errors.
    Contradicted,
    /// The least χ² is not reached: no verdict, and errors as large as the way that seems left.
    Unconverged,
}

/// A measured spectrum beside the fitted one.
#[derive(Clone, Debug, Serialize)]
pub struct FittedSpectrum {
    /// File and layer.
    pub name: String,
    /// Measured values.
    pub measured: Vec<f64>,
    /// Fitted values.
    pub fitted: Vec<f64>,
    /// Standard deviation of the difference.
    pub sigma: Vec<f64>,
}

/// A measured number beside the fitted one.
#[derive(Clone, Debug, Serialize)]
pub struct FittedNumber {
    /// Sample and number.
    pub name: String,
    /// Measured value.
    pub measured: f64,
    /// Fitted value.
    pub fitted: f64,
    /// Standard deviation of the difference.
    pub sigma: f64,
}

/// The result of a fit.
#[derive(Clone, Debug, Serialize)]
pub struct FitOutcome {
    /// Whether the errors can be trusted.
    pub trust: Trust,
    /// χ² of the data.
    pub chi_squared: f64,
    /// Number of data.
    pub data: usize,
    /// Unknowns that the data determine.
    pub effective_unknowns: f64,
    /// Data less effective unknowns.
    pub degrees_of_freedom: f64,
    /// Minus twice the logarithm of the probability of the data, up to a constant that all
    /// solutions of one fit share.
    #[serde(skip)]
    pub(super) evidence_cost: f64,
    /// Size of the second differences of the prior, chosen by the evidence.
    pub strength: f64,
    /// Linearisations on all cells.
    pub linearisations: usize,
    /// Whether the data determine n.
    pub n_is_determined: bool,
    /// The index.
    pub index: Vec<FittedIndex>,
    /// A second solution that fits as well; none where the first is the only one.
    pub other_solution: Option<OtherSolution>,
    /// Logarithm of the factor on the thicknesses; 0 where it is not fitted.
    pub log_thickness: f64,
    /// Standard error of it.
    pub log_thickness_error: Option<f64>,
    /// Light that the faces of all samples add, where it is fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub face_light: Option<FaceLight>,
    /// Root mean square change of n and κ if the thickness were 1 % larger.
    pub per_percent_of_thickness: [f64; 2],
    /// Measured and fitted spectra.
    pub spectra: Vec<FittedSpectrum>,
    /// Measured and fitted numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub numbers: Vec<FittedNumber>,
    /// Other layers.
    pub forecasts: Vec<Forecast>,
    /// What else is to be known.
    pub remarks: Vec<String>,
}

impl Data<'_> {
    /// The numbers of a fit whose last linearisation these are, with the strength chosen and its
    /// step. Whether there is another solution is not known here.
    pub fn outcome(&self, strength: f64, step: &FitStep, linearisations: usize) -> FitOutcome {
        let data = self.residual.len();
        let degrees_of_freedom = data as f64 - step.effective;
        let trust = Trust::of(step.chi_squared, degrees_of_freedom);
        let is_there = step.to_go() < super::CLOSE;
        // a study is wrong only if it stays so with what the step left would gain
        let reachable = Trust::of(step.chi_squared - step.promised.max(0.0), degrees_of_freedom);
        let is_sure = is_there || reachable == Trust::Contradicted;
        let trust = if is_sure { trust } else { Trust::Unconverged };
        let stated = trust != Trust::Contradicted;
        let is_large = matches!(trust, Trust::Inflated | Trust::Unconverged);
        let ratio = (step.chi_squared / degrees_of_freedom.max(1.0)).max(1.0);
        let factor = if is_large { ratio } else { 1.0 };
        let covariance = self.covariance(step);
        let index = self.index(step, stated.then_some((&covariance, factor)));
        let n_error = rms(index.iter().filter_map(|row| row.n_error));
        let error = |place: usize| (factor * covariance[(place, place)]).sqrt();
        let mut outcome = FitOutcome {
            trust,
            chi_squared: step.chi_squared,
            data,
            effective_unknowns: step.effective,
            degrees_of_freedom,
            evidence_cost: -2.0 * step.log_evidence,
            strength,
            linearisations,
            n_is_determined: stated && is_there && n_error < UNDETERMINED,
            log_thickness: self.prior.log_thickness(&step.unknowns),
            log_thickness_error: self.prior.thickness.filter(|_| stated).map(error),
            face_light: self.prior.face_light.map(|place| FaceLight {
                value: step.unknowns[place],
                standard_error: stated.then(|| error(place)),
            }),
            per_percent_of_thickness: self.per_percent(step),
            spectra: self.spectra(step),
            numbers: self.numbers(step),
            index,
            other_solution: None,
            forecasts: Vec::new(),
            remarks: Vec::new(),
        };
        outcome.remarks = remarks(&outcome, self.task, step.to_go());
        outcome
    }

    fn index(&self, step: &FitStep, errors: Option<(&Mat<f64>, f64)>) -> Vec<FittedIndex> {
        let values = self.prior.index(&step.unknowns);
        let mut all = Vec::new();
        for (w, &wavelength_nm) in self.task.wavelengths_nm().iter().enumerate() {
            let n_row = &self.prior.n[w];
            let kappa_row = &self.prior.kappa[w];
            let covariance_of = |one: &[f64], other: &[f64]| {
                errors.map(|(covariance, factor)| factor * product(one, other, covariance))
            };
            let n_error = covariance_of(n_row, n_row).map(|variance| variance.max(0.0).sqrt());
            let kappa_error = covariance_of(kappa_row, kappa_row).map(|variance| variance.max(0.0).sqrt());
            let common = covariance_of(n_row, kappa_row);
            let correlation =
                common.zip(n_error.zip(kappa_error)).map(|(common, (a, b))| common / (a * b).max(1e-300));
            let [n, kappa] = values[w];
            let outside_search =
                is_outside(n, self.task.settings.n) || is_outside(kappa, self.task.settings.kappa);
            all.push(FittedIndex {
                wavelength_nm,
                n,
                kappa,
                n_error,
                kappa_error,
                correlation,
                outside_search,
            });
        }
        all
    }

    /// Root mean square change of n and κ for 1 % more thickness.
    fn per_percent(&self, step: &FitStep) -> [f64; 2] {
        let data = &self.thickness;
        let change = &step.gain * Mat::from_fn(data.len(), 1, |i, _| 0.01 * data[i]);
        [&self.prior.n, &self.prior.kappa].map(|rows| {
            rms(rows.iter().map(|row| row.iter().enumerate().map(|(i, a)| a * change[(i, 0)]).sum()))
        })
    }

    /// Fitted values and standard deviations of data less fit, of all data.
    fn left_and_sigma(&self, step: &FitStep) -> (Vec<f64>, Vec<f64>) {
        let left = self.left(&step.unknowns);
        let sigma = (0..left.len()).map(|i| self.weights[(i, i)].sqrt()).collect();
        (left, sigma)
    }

    fn spectra(&self, step: &FitStep) -> Vec<FittedSpectrum> {
        let (left, sigma) = self.left_and_sigma(step);
        let waves = self.task.wavelengths_nm().len();
        let with_spectra = self.task.measured.iter().filter(|drawdown| drawdown.values.is_some());
        let mut all = Vec::new();
        for ((drawdown, left), sigma) in with_spectra.zip(left.chunks(waves)).zip(sigma.chunks(waves)) {
            let name = drawdown.name.clone();
            let measured = drawdown.values.clone().unwrap_or_default();
            let fitted = measured.iter().zip(left).map(|(m, left)| m - left).collect();
            all.push(FittedSpectrum { name, measured, fitted, sigma: sigma.to_vec() });
        }
        all
    }

    /// The numbers, which stand after the spectra.
    fn numbers(&self, step: &FitStep) -> Vec<FittedNumber> {
        let (left, sigma) = self.left_and_sigma(step);
        let numbers: Vec<(&Drawdown, &MeasuredNumber)> = self
            .task
            .measured
            .iter()
            .flat_map(|drawdown| drawdown.numbers.iter().map(move |number| (drawdown, number)))
            .collect();
        let first = left.len() - numbers.len();
        let fitted = |(k, (drawdown, number)): (usize, &(&Drawdown, &MeasuredNumber))| FittedNumber {
            name: format!("{}: {}", drawdown.name, number.wanted.name),
            measured: number.value,
            fitted: number.value - left[first + k],
            sigma: sigma[first + k],
        };
        numbers.iter().enumerate().map(fitted).collect()
    }
}

/// aᵀ C b.
fn product(a: &[f64], b: &[f64], covariance: &Mat<f64>) -> f64 {
    a.iter().enumerate().map(|(i, a)| a * (0..b.len()).map(|j| covariance[(i, j)] * b[j]).sum::<f64>()).sum()
}

impl Trust {
    /// Verdict of χ² on a study, given the degrees of freedom.
    pub(super) fn of(chi_squared: f64, degrees_of_freedom: f64) -> Self {
        let freedom = degrees_of_freedom.max(1.0);
        let limit = ChiSquared::new(freedom).map_or(f64::INFINITY, |law| law.inverse_cdf(UNLIKELY));
        match () {
            () if chi_squared <= limit && is_a_test(degrees_of_freedom) => Self::Consistent,
            () if chi_squared <= limit => Self::Untested,
            () if chi_squared / freedom <= REFUSED => Self::Inflated,
            () => Self::Contradicted,
        }
    }
}

/// Whether χ² with these degrees of freedom would find errors larger than stated.
fn is_a_test(degrees_of_freedom: f64) -> bool {
    let Ok(law) = ChiSquared::new(degrees_of_freedom) else { return false };
    1.0 - law.cdf(law.inverse_cdf(UNLIKELY) / NOTICED.powi(2)) >= POWER
}

/// Whether a value lies outside a range, by more than rounding.
fn is_outside(value: f64, [from, to]: [f64; 2]) -> bool {
    value < from - 1e-9 || value > to + 1e-9
}

/// What is to be known besides whether n is determined.
fn remarks(outcome: &FitOutcome, task: &FitTask, to_go: f64) -> Vec<String> {
    let mut all = Vec::new();
    let FitOutcome { chi_squared, data, degrees_of_freedom, .. } = outcome;
    let ratio = chi_squared / degrees_of_freedom.max(1.0);
    match outcome.trust {
        Trust::Consistent | Trust::Unconverged => {}
        Trust::Untested => all.push(format!(
            "no verdict on the study: {data} data less {:.1} effective unknowns leave {degrees_of_freedom:.1} degrees of freedom, too few \
             for χ² ({chi_squared:.0}) to reveal a wrong thickness, binder or noise; the errors are valid only if all of these are right. Measure \
             at more wavelengths or on another card",
            outcome.effective_unknowns
        )),
        Trust::Inflated => all.push(format!(
            "χ² is {chi_squared:.0} for {data} data and {degrees_of_freedom:.1} degrees of freedom: something in the study is slightly \
             wrong, or the noise is larger than fit.noise = {}; all errors are multiplied by {:.1}",
            task.settings.noise,
            ratio.sqrt()
        )),
        Trust::Contradicted => all.push(format!(
            "χ² is {chi_squared:.0} for {data} data and {degrees_of_freedom:.1} degrees of freedom: no index fits these spectra, so no \
             errors are stated. Check thickness (an error of 10 % is enough where the layer is even; also = [\"thickness\"] fits it), its \
             spread, the backings' albedos, the binder's index, coupling and geometry"
        )),
    }
    all.extend(outside("n", task.settings.n, outcome, |row| (row.n, row.n_error)));
    all.extend(outside("kappa", task.settings.kappa, outcome, |row| (row.kappa, row.kappa_error)));
    let [dn, dk] = outcome.per_percent_of_thickness;
    if let Some(FaceLight { value, standard_error: Some(error) }) = outcome.face_light {
        all.push(format!("light that the faces add: {value:.4} ± {error:.4} in every reflectance factor"));
        if error > UNDETERMINED_LIGHT {
            all.push(
                "the light of the faces is not determined: one masstone tells it not from κ; add a tint with a known white or another \
                 loading, or give it as face.light"
                    .into(),
            );
        }
    }
    let has_thickness = !task.measured.iter().all(|drawdown| drawdown.is_opaque);
    if has_thickness && !task.settings.also.contains(&AlsoFitted::Thickness) {
        all.push(format!(
            "1 % more thickness than stated would change n by {dn:.3} and κ by {dk:.4} (root mean square)"
        ));
    } else if let Some(error) = outcome.log_thickness_error {
        let percent = 100.0 * (outcome.log_thickness.exp() - 1.0);
        all.push(format!(
            "thickness: {percent:+.1} ± {:.1} % of what the study states; n and thickness are correlated: fringes determine only their product",
            100.0 * error
        ));
    }
    if outcome.trust == Trust::Unconverged {
        all.push(format!(
            "the fit has not converged: n and κ have the least χ² of all that were solved, but their derivatives promise a better fit at \
             {to_go:.1} standard errors from there, which the solves do not confirm; errors are as large as this. Take more realisations \
             or a larger period"
        ));
    }
    all.push("the grain size is taken from the study: these spectra hardly constrain it".into());
    all
}

/// Says where a value lies outside the range that was searched for it, farthest first.
fn outside(
    key: &str,
    range: [f64; 2],
    outcome: &FitOutcome,
    value: impl Fn(&FittedIndex) -> (f64, Option<f64>),
) -> Option<String> {
    let beyond = |row: &FittedIndex| (range[0] - value(row).0).max(value(row).0 - range[1]);
    let rows = outcome.index.iter().filter(|row| is_outside(value(row).0, range));
    let count = rows.clone().count();
    let worst = rows.max_by(|a, b| beyond(a).total_cmp(&beyond(b)))?;
    let (found, error) = value(worst);
    let error = error.map_or(String::new(), |error| format!(" ± {error:.3}"));
    let name = if key == "n" { "n" } else { "κ" };
    Some(format!(
        "{name} = {found:.3}{error} at {} nm lies outside fit.{key} = [{}, {}] (so do {count} of {} wavelengths): the search began inside, and \
         a solution farther out may fit better; widen fit.{key} and fit again",
        worst.wavelength_nm,
        range[0],
        range[1],
        outcome.index.len()
    ))
}
