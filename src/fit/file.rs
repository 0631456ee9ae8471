//! The file of a fit as written.
//!
//! ```toml
//! base = "ink.toml"                # size, shape, thickness, binder; or a table [base]
//! [[measured]]
//! file = "white.csv"               # CSV, CxF3 or CGATS.17
//! backing = 0.85                   # albedo of the card, or [[nm, albedo], …], or { csv = "…" }
//! geometry = "d:8"
//! [[measured]]
//! file = "black.csv"
//! backing = 0.04
//! geometry = "d:8"
//! [fit]
//! pigment = "yellow"
//! noise = 0.003
//! ```

use crate::input::base::Base;
use crate::input::forms::AlbedoWritten;
use crate::input::limits;
use crate::input::measured::{MeasuredCondition, MeasuredUnit, Patch};
use crate::numerics::allowed::Allowed;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole file of a fit.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FitFile {
    /// Heading of the page; the file's name when left out.
    pub title: Option<String>,
    /// The study of the drawdowns: all but the pigment's index is known.
    pub base: Base,
    /// The spectra measured.
    #[serde(default)]
    pub measured: Vec<MeasuredTable>,
    /// What is fitted, and how.
    #[serde(default)]
    pub fit: FitTable,
    /// Layers of the same pigment to be predicted from the fit.
    #[serde(default)]
    pub predict: Vec<MeasuredTable>,
}

/// `[[measured]]` and `[[predict]]`: a layer on a backing, and its spectrum.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredTable {
    /// The spectrum, relative to this file, in any format of a study's `compare.measured`; optional
    /// under `[[predict]]`.
    pub file: Option<String>,
    /// Sample in a file with several: its name or number, or its amounts of ink such as
    /// `[0, 0, 100, 0]`.
    pub patch: Option<Patch>,
    /// What a perfect white has in the file: 1 (`factor`) or 100 (`percent`); by default what the
    /// file declares.
    pub unit: Option<MeasuredUnit>,
    /// The instrument's light, where the sample was measured under several.
    pub condition: Option<MeasuredCondition>,
    /// Albedo of the backing: a number, a list `[[400, 0.82], [700, 0.91]]`, or `{ csv = "…" }`, a
    /// table or a measured spectrum of the card.
    pub backing: Option<AlbedoWritten>,
    /// Share of the pigment in the layer's volume; that of the base when left out.
    #[schemars(example = 0.3)]
    pub volume_fraction: Option<f64>,
    /// Mean thickness of the layer, µm; that of the base when left out.
    #[schemars(example = 1.0)]
    pub thickness_um: Option<f64>,
    /// How the spectrum is measured (default: what the file declares, else `45:0`).
    pub geometry: Option<FitGeometry>,
}

/// Geometry of a measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
pub enum FitGeometry {
    /// Lit at 45°, seen along the normal.
    #[default]
    #[serde(rename = "45:0")]
    LitAt45,
    /// Diffuse light, seen at 8°, specular light included.
    #[serde(rename = "d:8")]
    Sphere,
    /// A uniform sky, seen along the normal, mirrored light included.
    #[serde(rename = "natural")]
    UniformSky,
}

/// What the index is expected to be like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PriorName {
    /// κ smooth, and n its Kramers–Kronig transform with a constant and one pole in the UV.
    #[default]
    KramersKronig,
    /// n and κ smooth, each for itself.
    Smooth,
}

/// What is fitted besides the index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AlsoFitted {
    /// A common factor on the thicknesses of all layers.
    Thickness,
}

/// n known from elsewhere, such as by immersion.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KnownN {
    /// Vacuum wavelength, nm; it may lie outside the spectra.
    #[schemars(transform = limits::ANCHOR_NM.mark(), example = 589)]
    pub n_nm: f64,
    /// n there.
    #[schemars(transform = limits::INDEX.mark(), example = 1.65)]
    pub n: f64,
    /// Its standard error (default: 0.01).
    #[serde(default = "usual_error")]
    #[schemars(transform = KNOWN_ERROR.mark())]
    pub n_error: f64,
}

/// Standard error of a known n: what makes the least squares singular is refused.
pub const KNOWN_ERROR: Allowed = Allowed::between(1e-4, 1.0, "");

fn usual_error() -> f64 {
    0.01
}

/// `[fit]`: what is fitted, and how.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FitTable {
    /// Name of the pigment whose index is unknown; may be left out where there is only one.
    pub pigment: Option<String>,
    /// What the index is expected to be like.
    pub prior: PriorName,
    /// Standard deviation of every measured reflectance factor.
    pub noise: f64,
    /// What else is unknown.
    pub also: Vec<AlsoFitted>,
    /// n known from elsewhere at one wavelength, for the prior of Kramers and Kronig: opaque coats
    /// leave n open without it.
    pub known_n: Option<KnownN>,
    /// Range of n searched; the result says where fitted values go beyond it.
    pub n: [f64; 2],
    /// Range of κ searched; the result says where fitted values go beyond it.
    pub kappa: [f64; 2],
}

impl Default for FitTable {
    fn default() -> Self {
        let prior = PriorName::default();
        Self {
            pigment: None,
            prior,
            noise: 0.003,
            also: Vec::new(),
            known_n: None,
            n: [1.3, 2.0],
            kappa: [0.0, 0.6],
        }
    }
}
