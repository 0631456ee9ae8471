//! Kubelka–Munk coefficients of an ensemble without its faces, with errors, at the wavelengths at
//! which its light is diffuse, as they assume.

use super::super::ink::{InkError, InkOnPaper};
use super::super::on_paper::LayerOnPaper;
use super::super::uncertainty::{Shift, Uncertainty};
use crate::appearance::kubelka_munk::{DiffuseFaces, KubelkaMunk};
use crate::appearance::paper::Coupling;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use serde::Serialize;

/// Largest unscattered share of the transmittance at the normal of diffuse light: below it, S of
/// photons scattered isotropically between plane faces varies with thickness by [`MODEL`], 3 %, at
/// most; above it, it soon varies more.
const STRAIGHT_ON: f64 = 0.01;
/// Relative standard error of K and S due to the assumption of perfectly diffuse light, estimated
/// from these photons (tests of [`crate::appearance::kubelka_munk`]).
const MODEL: f64 = 0.03;

/// Kubelka–Munk coefficients at one wavelength.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct KubelkaMunkRow {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// K, 1/µm.
    pub absorption_per_um: Estimate,
    /// S, 1/µm.
    pub scattering_per_um: Estimate,
}

/// Coefficients, and the reason if there are none.
type RowsOrReason = Result<(Vec<KubelkaMunkRow>, Option<String>), InkError>;

/// K and S at the wavelengths at which they are determined; otherwise the reason.
pub(super) fn kubelka_munk(ink: &InkOnPaper, uncertainty: &Uncertainty, study: &Study) -> RowsOrReason {
    if let Coupling::OpticalContact { .. } = study.paper.coupling {
        let reason = "K and S are defined for a layer between two equal half-spaces, but this one is in contact with its paper";
        return Ok((Vec::new(), Some(reason.to_owned())));
    }
    if !study.stack.is_empty() {
        let reason = "K and S are those of one layer, and this is a stack of several";
        return Ok((Vec::new(), Some(reason.to_owned())));
    }
    if study.packing.relief.is_some() {
        let reason = "K and S require Saunderson's correction for the faces, which is known for plane faces only, and this \
                      layer has a relief";
        return Ok((Vec::new(), Some(reason.to_owned())));
    }
    of_plane_layer(ink, uncertainty, study.layer.thickness_um)
}

/// Coefficients of a layer with plane faces between equal half-spaces.
fn of_plane_layer(ink: &InkOnPaper, uncertainty: &Uncertainty, thickness_um: f64) -> RowsOrReason {
    let straight = straight_on(ink)?;
    let faces = &ink.faces();
    let part = |get| Coefficient { thickness_um, faces, get }.estimates(ink, uncertainty);
    let k = part(|km| km.absorption_per_um);
    let s = part(|km| km.scattering_per_um);
    let mut rows = Vec::new();
    for (i, &wavelength_nm) in ink.wavelengths_nm().iter().enumerate() {
        let absorption_per_um = k[i];
        let scattering_per_um = s[i];
        if straight[i] <= STRAIGHT_ON && is_known(&k[i]) && is_known(&s[i]) {
            rows.push(KubelkaMunkRow { wavelength_nm, absorption_per_um, scattering_per_um });
        }
    }
    let reason = rows.is_empty().then(|| in_words(&straight));
    Ok((rows, reason))
}

/// If hardly any light is transmitted, T is zero within its error: K and S are undetermined.
fn is_known(e: &Estimate) -> bool {
    e.value.is_finite() && e.standard_error.is_none_or(f64::is_finite)
}

/// Unscattered share of T at the normal, plus its standard error, at every wavelength.
fn straight_on(ink: &InkOnPaper) -> Result<Vec<f64>, InkError> {
    let normal = ink.at(0.0)?;
    let shares = ink.spectrum(|layer| layer.straight_on(&normal)).estimates();
    Ok(shares.into_iter().map(|e| e.value + e.standard_error.unwrap_or(0.0)).collect())
}

/// Why there are no K and S if this much light is unscattered.
fn in_words(straight: &[f64]) -> String {
    let least = straight.iter().copied().filter(|share| share.is_finite()).fold(f64::INFINITY, f64::min);
    if least <= STRAIGHT_ON || !least.is_finite() {
        let reason = "too little light is transmitted, or no layer with plane faces has these R and T in diffuse light";
        return format!("No K and S: {reason}");
    }
    format!(
        "No K and S: at every wavelength at least {:.0} % of the light transmitted at normal incidence is unscattered, standard \
         error included (limit {:.0} %); the layer is too thin or scatters too little for Kubelka–Munk theory, or more \
         realisations are needed",
        100.0 * least,
        100.0 * STRAIGHT_ON
    )
}

/// K and S from R, T and the thickness.
type TwoFluxFormula = fn(f64, f64, f64) -> Option<KubelkaMunk>;

/// K or S of a layer of known thickness.
struct Coefficient<'a> {
    thickness_um: f64,
    /// The faces at every wavelength.
    faces: &'a [DiffuseFaces],
    get: fn(KubelkaMunk) -> f64,
}

impl Coefficient<'_> {
    /// Estimates at every wavelength, with all errors.
    fn estimates(&self, ink: &InkOnPaper, uncertainty: &Uncertainty) -> Vec<Estimate> {
        self.computed(ink, uncertainty).into_iter().map(with_model).collect()
    }

    /// Estimates with the errors of the calculation only, as if the assumptions of Kubelka and Munk
    /// were exact.
    fn computed(&self, ink: &InkOnPaper, uncertainty: &Uncertainty) -> Vec<Estimate> {
        let estimates = ink.spectrum(|layer| self.continued(layer, [0.0; 2])).estimates().into_iter();
        let mut all = Vec::new();
        for (i, (continued, layer)) in estimates.zip(ink.layers()).enumerate() {
            // errors of tables of indices
            let inputs = ink.input_error(i, |layer| self.continued(layer, [0.0; 2]));
            let moved = |by: Shift| self.continued(layer, by) - continued.value;
            let of_unknown_signs = |shift| of_unknown_signs(moved, shift);
            let errors = uncertainty.widen_by(continued, ink.wavelength_nm(layer), inputs, of_unknown_signs);
            // NaN if R̄ and T̄ do not determine it
            let value = self.of(layer, [0.0; 2], KubelkaMunk::from_layer);
            all.push(Estimate { value, ..errors });
        }
        all
    }

    /// The analytic continuation of the coefficient, shifted by errors of R and T: K itself stops
    /// at 0, where its spread would vanish.
    fn continued(&self, layer: &LayerOnPaper, by: Shift) -> f64 {
        self.of(layer, by, KubelkaMunk::continued)
    }

    /// The coefficient by a formula for R and T of the layer without its faces, from R̄ and T̄ of
    /// the whole (the diffuse fluxes exchanged with the paper), shifted by errors; NaN if these do
    /// not determine it.
    fn of(&self, layer: &LayerOnPaper, [r, t]: Shift, formula: TwoFluxFormula) -> f64 {
        let r = layer.mean_reflectance_exit() + r;
        let t = layer.mean_transmittance() + t;
        let bare = self.faces[layer.node].taken_off(r, t);
        bare.and_then(|[r, t]| formula(r, t, self.thickness_um)).map_or(f64::NAN, self.get)
    }
}

/// Adds the error of the model.
fn with_model(Estimate { value, standard_error }: Estimate) -> Estimate {
    Estimate { value, standard_error: standard_error.map(|e| e.hypot(MODEL * value)) }
}

/// The larger change by errors of R and T whose signs are unknown: opposite signs are worse for S,
/// as without absorption, equal signs for K.
fn of_unknown_signs(moved: impl Fn(Shift) -> f64, [r, t]: Shift) -> f64 {
    worse(moved([r, t]), moved([r, -t]))
}

/// The larger of two errors, or NaN.
fn worse(alike: f64, opposite: f64) -> f64 {
    if alike.is_nan() || alike.abs() > opposite.abs() { alike } else { opposite }
}

#[cfg(test)]
#[path = "coefficients_tests.rs"]
mod tests;
