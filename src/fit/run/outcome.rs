//! The numbers of a fit: the index with its errors, whether they can be trusted, and predictions.

use crate::appearance::colour::Colorimeter;
use crate::appearance::kubelka_munk::KubelkaMunk;
use crate::fit::law::{Data, FitStep, few_cells, jackknife, rms};
use crate::fit::load::{Drawdown, FitTask};
use crate::fit::response::Response;
use faer::Mat;
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// χ² of a branch above the best one's within which it fits as well (3 σ).
pub(super) const AS_GOOD: f64 = 9.0;
/// Differences of n between branches, and errors of n, from which n is not determined.
const UNDETERMINED: f64 = 0.06;
/// Standard errors of n that cover another branch.
const COVERED: f64 = 2.0;
/// Quantile of χ² beyond which the errors are not those stated.
const UNLIKELY: f64 = 0.999;
/// χ² per degree of freedom beyond which no error is stated.
const REFUSED: f64 = 4.0;

/// The index at one wavelength.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FittedIndex {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Real part.
    pub n: f64,
    /// Imaginary part.
    pub kappa: f64,
    /// Standard error of n; none where the data contradict the study.
    pub n_error: Option<f64>,
    /// Standard error of κ.
    pub kappa_error: Option<f64>,
    /// Correlation of both errors.
    pub correlation: Option<f64>,
}

/// Whether the stated errors can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Trust {
    /// χ² is that of the stated noise.
    Consistent,
    /// χ² is larger; errors are multiplied by its root per degree of freedom.
    Inflated,
    /// χ² is so large that the study must be wrong: no errors.
    Contradicted,
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

/// A layer predicted from the fitted index.
#[derive(Clone, Debug, Serialize)]
pub struct Forecast {
    /// File and layer.
    pub name: String,
    /// Predicted reflectance factors.
    pub values: Vec<f64>,
    /// Their standard errors; the index's part is missing where it has none.
    pub errors: Vec<f64>,
    /// What Kubelka and Munk predict from two of the measured spectra of one layer.
    pub kubelka_munk: Option<Vec<f64>>,
    /// Measured values, where there are any.
    pub measured: Option<Vec<f64>>,
    /// ΔE₀₀ to the measured colour (D65, 2°).
    pub delta_e_2000: Option<f64>,
    /// ΔE₀₀ to the measured colour of what Kubelka and Munk predict.
    pub delta_e_2000_kubelka_munk: Option<f64>,
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
    /// Size of the second differences of the prior, chosen by the evidence.
    pub strength: f64,
    /// Linearisations on all cells.
    pub linearisations: usize,
    /// Whether the data determine n.
    pub n_is_determined: bool,
    /// The index.
    pub index: Vec<FittedIndex>,
    /// Logarithm of the factor on the thicknesses; 0 where it is not fitted.
    pub log_thickness: f64,
    /// Standard error of it.
    pub log_thickness_error: Option<f64>,
    /// Root mean square change of n and κ if the thickness were 1 % larger.
    pub per_percent_of_thickness: [f64; 2],
    /// Measured and fitted spectra.
    pub spectra: Vec<FittedSpectrum>,
    /// Other layers.
    pub forecasts: Vec<Forecast>,
    /// What else is to be known.
    pub remarks: Vec<String>,
}

impl Data<'_> {
    /// The numbers of a fit whose last linearisation these are, with the strength chosen and its
    /// step.
    pub fn outcome(
        &self,
        (strength, step): (f64, &FitStep),
        linearisations: usize,
        alternative: Option<Vec<[f64; 2]>>,
    ) -> FitOutcome {
        let data = self.residual.len();
        let freedom = (data as f64 - step.effective).max(1.0);
        let ratio = step.chi_squared / freedom;
        let limit = ChiSquared::new(freedom).map_or(f64::INFINITY, |law| law.inverse_cdf(UNLIKELY));
        let trust = match () {
            () if step.chi_squared <= limit => Trust::Consistent,
            () if ratio <= REFUSED => Trust::Inflated,
            () => Trust::Contradicted,
        };
        let covariance = step.covariance(&self.weights, &self.errors);
        let factor = if trust == Trust::Inflated { ratio } else { 1.0 };
        let index = self.index(step, (trust != Trust::Contradicted).then_some((&covariance, factor)));
        let n_error = rms(index.iter().filter_map(|row| row.n_error));
        let branches = alternative.filter(|other| {
            let apart = rms(other.iter().zip(&index).map(|(a, b)| a[0] - b.n));
            apart > UNDETERMINED.max(COVERED * n_error)
        });
        let last = self.prior.count() - 1;
        let thickness = self.prior.thickness.then(|| (factor * covariance[(last, last)]).sqrt());
        let mut outcome = FitOutcome {
            trust,
            chi_squared: step.chi_squared,
            data,
            effective_unknowns: step.effective,
            strength,
            linearisations,
            n_is_determined: n_error < UNDETERMINED && branches.is_none(),
            log_thickness: self.prior.log_thickness(&step.unknowns),
            log_thickness_error: thickness.filter(|_| trust != Trust::Contradicted),
            per_percent_of_thickness: self.per_percent(step),
            spectra: self.spectra(step),
            index,
            forecasts: Vec::new(),
            remarks: Vec::new(),
        };
        let moved = self.moved(&step.unknowns) / self.task.settings.noise;
        outcome.remarks = remarks(&outcome, self.task, branches.as_deref(), (n_error, moved));
        outcome
    }

    fn index(&self, step: &FitStep, errors: Option<(&Mat<f64>, f64)>) -> Vec<FittedIndex> {
        let values = self.prior.index(&step.unknowns);
        let mut all = Vec::new();
        for (w, &wavelength_nm) in self.task.wavelengths_nm().iter().enumerate() {
            let [a, b] = [&self.prior.n[w], &self.prior.kappa[w]];
            let [nn, kk, nk] = [(a, a), (b, b), (a, b)]
                .map(|(x, y)| errors.map(|(covariance, factor)| factor * product(x, y, covariance)));
            let [n_error, kappa_error] = [nn, kk].map(|variance| Some(variance?.max(0.0).sqrt()));
            let correlation = nk.zip(n_error.zip(kappa_error)).map(|(nk, (a, b))| nk / (a * b).max(1e-300));
            let [n, kappa] = values[w];
            all.push(FittedIndex { wavelength_nm, n, kappa, n_error, kappa_error, correlation });
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

    fn spectra(&self, step: &FitStep) -> Vec<FittedSpectrum> {
        let left = self.left(&step.unknowns);
        let sigma: Vec<f64> = (0..left.len()).map(|i| self.weights[(i, i)].sqrt()).collect();
        let waves = self.task.wavelengths_nm().len();
        let mut all = Vec::new();
        for ((drawdown, left), sigma) in
            self.task.measured.iter().zip(left.chunks(waves)).zip(sigma.chunks(waves))
        {
            let (name, measured) = (drawdown.name.clone(), drawdown.values.clone().unwrap_or_default());
            let fitted = measured.iter().zip(left).map(|(m, left)| m - left).collect();
            all.push(FittedSpectrum { name, measured, fitted, sigma: sigma.to_vec() });
        }
        all
    }
}

/// aᵀ C b.
fn product(a: &[f64], b: &[f64], covariance: &Mat<f64>) -> f64 {
    a.iter().enumerate().map(|(i, a)| a * (0..b.len()).map(|j| covariance[(i, j)] * b[j]).sum::<f64>()).sum()
}

fn remarks(
    outcome: &FitOutcome,
    task: &FitTask,
    branches: Option<&[[f64; 2]]>,
    (n_error, moved): (f64, f64),
) -> Vec<String> {
    let mut all = Vec::new();
    let ratio = outcome.chi_squared / (outcome.data as f64 - outcome.effective_unknowns).max(1.0);
    match outcome.trust {
        Trust::Consistent => {}
        Trust::Inflated => all.push(format!(
            "χ² is {:.0} for {} data, {ratio:.1} per degree of freedom: something in the study is slightly wrong, or the noise is larger \
             than fit.noise = {}; all errors are multiplied by {:.1}",
            outcome.chi_squared, outcome.data, task.settings.noise, ratio.sqrt()
        )),
        Trust::Contradicted => all.push(format!(
            "χ² is {:.0} for {} data, {ratio:.0} per degree of freedom: no index fits these spectra, so no errors are stated. Check thickness \
             (a thickness 10 % wrong does this to an even layer; also = [\"thickness\"] fits it), its spread, the backings' albedos, the \
             binder's index, coupling and geometry",
            outcome.chi_squared, outcome.data
        )),
    }
    if let Some(other) = branches {
        let mean = other.iter().map(|row| row[0]).sum::<f64>() / other.len() as f64;
        all.push(format!(
            "n is not determined: another branch with n ≈ {mean:.2} on the mean fits as well; a second backing or another loading tells them apart"
        ));
    } else if !outcome.n_is_determined {
        all.push(format!(
            "n is not determined: its standard error is {n_error:.2} (root mean square); measure the layer on black card as well, or another loading"
        ));
    }
    let [dn, dk] = outcome.per_percent_of_thickness;
    if task.settings.also.is_empty() {
        all.push(format!(
            "1 % more thickness than stated would change n by {dn:.3} and κ by {dk:.4} (root mean square)"
        ));
    } else if let Some(error) = outcome.log_thickness_error {
        let percent = 100.0 * (outcome.log_thickness.exp() - 1.0);
        all.push(format!(
            "thickness: {percent:+.1} ± {:.1} % of what the study states; it is confounded with n, of which fringes know the product alone",
            100.0 * error
        ));
    }
    if moved > super::SMALL_STEP && outcome.linearisations == super::LINEARISATIONS[1] {
        all.push(format!(
            "the last step still moved the spectra by {moved:.1} of the noise: the fit has not settled"
        ));
    }
    all.push("the size of the grains is taken as stated: spectra of this kind hardly contain it".into());
    all
}

impl Forecast {
    /// Drawdown number `k` of the predicted ones.
    pub fn new(task: &FitTask, own: &Drawdown, response: &Response, (k, fit): (usize, &FitOutcome)) -> Self {
        let values = response.values[k].clone();
        let errors = fit.index.iter().enumerate().map(|(w, row)| forecast_error(response, k, w, row));
        let kubelka_munk = kubelka_munk(task, own);
        let delta_e_2000 = difference(task, own, Some(&values));
        let delta_e_2000_kubelka_munk = difference(task, own, kubelka_munk.as_ref());
        let (name, errors, measured) = (own.name.clone(), errors.collect(), own.values.clone());
        Self { name, values, errors, kubelka_munk, measured, delta_e_2000, delta_e_2000_kubelka_munk }
    }
}

/// ΔE₀₀ of a predicted spectrum to the measured one, where both have colours.
fn difference(task: &FitTask, own: &Drawdown, predicted: Option<&Vec<f64>>) -> Option<f64> {
    let meter = Colorimeter::new(task.wavelengths_nm()).ok()?;
    let measured = meter.colour(own.values.as_ref()?).ok()?;
    Some(meter.colour(predicted?).ok()?.delta_e_2000(&measured).value)
}

/// Standard error of a predicted value: the few cells, and the index.
fn forecast_error(response: &Response, k: usize, w: usize, row: &FittedIndex) -> f64 {
    let replicates = &response.replicates[k];
    let ensemble = few_cells(replicates.len()) * jackknife(replicates, replicates, w, w);
    let [dn, dk] = [0, 1].map(|i| response.slopes[i][k][w]);
    let [a, b] = [row.n_error, row.kappa_error].map(Option::unwrap_or_default);
    let common = 2.0 * dn * dk * a * b * row.correlation.unwrap_or(0.0);
    (ensemble + ((dn * a).powi(2) + (dk * b).powi(2) + common).max(0.0)).sqrt()
}

/// Kubelka and Munk's prediction: K and S of a layer measured in the same geometry on two backings,
/// in proportion to the share and the thickness.
fn kubelka_munk(task: &FitTask, own: &Drawdown) -> Option<Vec<f64>> {
    let nm = task.wavelengths_nm();
    let middle = nm[nm.len() / 2];
    let alike: Vec<&Drawdown> = task.measured.iter().filter(|d| d.geometry == own.geometry).collect();
    let mut pairs = alike.iter().flat_map(|one| alike.iter().map(move |other| [*one, *other]));
    let [dark, light] =
        pairs.find(|[one, other]| other.coat == one.coat && other.albedo(middle) > one.albedo(middle))?;
    let [share, own_share] = [dark, own].map(|d| d.study.pigments[task.pigment].grains.volume_fraction);
    let [thick, own_thick] = [dark, own].map(|d| d.study.layer.thickness_um);
    let mut values = Vec::new();
    for (w, &nm) in nm.iter().enumerate() {
        let [dark, light] = [dark, light].map(|d| Some([d.albedo(nm)?, d.values.as_ref()?[w]]));
        let km = dark.zip(light).and_then(|(dark, light)| KubelkaMunk::from_backings(dark, light, thick));
        let value = km.zip(own.albedo(nm)).map(|(km, card)| km.over(card, own_thick * own_share / share));
        // no number where no layer has such a pair of reflectances
        values.push(value.unwrap_or(f64::NAN));
    }
    Some(values)
}
