//! Layers predicted from a fitted index, beside what Kubelka and Munk make of the measured spectra.

use super::fitted::{FaceLight, FittedIndex};
use crate::appearance::kubelka_munk::KubelkaMunk;
use crate::appearance::tristimulus::Colorimeter;
use crate::evaluate::gate;
use crate::evaluate::published::Quantity;
use crate::fit::data::{few_cells, jackknife};
use crate::fit::load::{Drawdown, FitTask};
use crate::fit::response::Response;
use crate::numerics::estimate::Estimate;
use serde::Serialize;

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

impl Forecast {
    /// Drawdown number `k` of the predicted ones, from the fitted index and what faces add.
    pub fn new(
        task: &FitTask,
        drawdown: &Drawdown,
        k: usize,
        response: &Response,
        index: &[FittedIndex],
        face_light: Option<FaceLight>,
    ) -> Self {
        let added = face_light.filter(|_| drawdown.is_reflected()).map_or(0.0, |light| light.value);
        let values: Vec<f64> = response.values[k].iter().map(|value| value + added).collect();
        let of_face = face_light.and_then(|light| light.standard_error).unwrap_or_default();
        let errors =
            index.iter().enumerate().map(|(w, row)| forecast_error(response, k, w, row).hypot(of_face));
        let kubelka_munk = kubelka_munk(task, drawdown);
        Self {
            name: drawdown.name.clone(),
            errors: errors.collect(),
            measured: drawdown.values.clone(),
            delta_e_2000: difference(task, drawdown, Some(&values)),
            delta_e_2000_kubelka_munk: difference(task, drawdown, kubelka_munk.as_ref()),
            values,
            kubelka_munk,
        }
    }

    /// Why this prediction cannot be published: its first factor that no layer can have.
    pub fn impossible(&self, wavelengths_nm: &[f64]) -> Option<String> {
        let rows = self.values.iter().zip(&self.errors).zip(wavelengths_nm);
        rows.into_iter().find_map(|((&value, &error), nm)| {
            let number = Estimate { value, standard_error: Some(error) };
            let reason = gate::impossible(Quantity::Factor, number)?;
            Some(format!("no prediction of {}: its reflectance factor at {nm} nm is {reason}", self.name))
        })
    }
}

/// ΔE₀₀ of a predicted spectrum to the measured one, where both have colours.
fn difference(task: &FitTask, drawdown: &Drawdown, predicted: Option<&Vec<f64>>) -> Option<f64> {
    let meter = Colorimeter::new(task.wavelengths_nm()).ok()?;
    let measured = meter.colour(drawdown.values.as_ref()?).ok()?;
    Some(meter.colour(predicted?).ok()?.delta_e_2000(&measured).value)
}

/// Standard error of a predicted value: the few cells, and the index.
fn forecast_error(response: &Response, k: usize, w: usize, row: &FittedIndex) -> f64 {
    let replicates: Vec<f64> = response.replicates[k].iter().map(|cell| cell[w]).collect();
    let ensemble = few_cells(replicates.len()) * jackknife(&replicates, &replicates);
    let along_n = response.slopes[0][k][w];
    let along_kappa = response.slopes[1][k][w];
    let n_error = row.n_error.unwrap_or_default();
    let kappa_error = row.kappa_error.unwrap_or_default();
    let correlation = row.correlation.unwrap_or(0.0);
    let common = 2.0 * along_n * along_kappa * n_error * kappa_error * correlation;
    (ensemble + ((along_n * n_error).powi(2) + (along_kappa * kappa_error).powi(2) + common).max(0.0)).sqrt()
}

/// Kubelka and Munk's prediction: K and S of a layer measured in the same geometry on two backings,
/// in proportion to the share and the thickness. Of a stack there is none: other layers have theirs.
fn kubelka_munk(task: &FitTask, drawdown: &Drawdown) -> Option<Vec<f64>> {
    if drawdown.is_opaque || !drawdown.is_reflected() || !drawdown.study.stack.is_empty() {
        return None;
    }
    // K and S of a mixture are those of its other pigments, too
    let mixture = |d: &Drawdown| -> Vec<f64> {
        let own = d.study.pigments[task.pigment].grains.volume_fraction;
        d.study.pigments.iter().map(|pigment| pigment.grains.volume_fraction / own).collect()
    };
    let is_same_mixture = |d: &Drawdown| {
        let (one, other) = (mixture(d), mixture(drawdown));
        one.len() == other.len() && one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-9)
    };
    let nm = task.wavelengths_nm();
    let middle = nm[nm.len() / 2];
    let alike: Vec<&Drawdown> = task
        .measured
        .iter()
        .filter(|d| d.geometry == drawdown.geometry && !d.is_opaque && is_same_mixture(d))
        .collect();
    let mut pairs = alike.iter().flat_map(|one| alike.iter().map(move |other| [*one, *other]));
    let [dark, light] =
        pairs.find(|[one, other]| other.coat == one.coat && other.albedo(middle) > one.albedo(middle))?;
    let share_of = |d: &Drawdown| d.study.pigments[task.pigment].grains.volume_fraction;
    let share = share_of(dark);
    let own_share = share_of(drawdown);
    let thick = dark.study.layer.thickness_um;
    let own_thick = drawdown.study.layer.thickness_um;
    let mut values = Vec::new();
    for (w, &nm) in nm.iter().enumerate() {
        let on_card = |d: &Drawdown| Some([d.albedo(nm)?, d.values.as_ref()?[w]]);
        let km = on_card(dark)
            .zip(on_card(light))
            .and_then(|(dark, light)| KubelkaMunk::from_backings(dark, light, thick));
        let value =
            km.zip(drawdown.albedo(nm)).map(|(km, card)| km.over(card, own_thick * own_share / share));
        // no number where no layer has such a pair of reflectances
        values.push(value.unwrap_or(f64::NAN));
    }
    Some(values)
}
