//! What a fit finds: the index at each wavelength, and the light that faces add.

use serde::Serialize;

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
    /// Whether n or κ lies outside the range that was searched (`fit.n`, `fit.kappa`).
    pub outside_search: bool,
}

/// Light that faces add to the reflectance factors of all samples.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FaceLight {
    /// Its size.
    pub value: f64,
    /// Its standard error; none where the data contradict the study.
    pub standard_error: Option<f64>,
}
