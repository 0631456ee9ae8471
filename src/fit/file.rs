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
use std::collections::BTreeMap;

/// A whole file of a fit.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FitFile {
    /// Heading of the page; the file's name when left out.
    pub title: Option<String>,
    /// The study of the drawdowns, a file or a table `[base]`: all but the fitted pigment's index
    /// is known, which may be left out.
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
    /// Shares of the base's pigments in the layer's volume by their names, such as a tint's
    /// `{ red = 0.02, white = 0.15 }`; 0 where one is not there, and those of the base for pigments
    /// that are not named.
    pub volume_fractions: Option<BTreeMap<String, f64>>,
    /// Parts by weight of the base's pigments by their names, and of the `binder` when dry, such as
    /// `{ red = 3, white = 30, binder = 40 }`; `fit.densities_g_per_cm3` makes volumes of them.
    /// Pigments that are not named are not there.
    pub weights: Option<BTreeMap<String, f64>>,
    /// Mean thickness of the layer, µm; that of the base when left out.
    #[schemars(example = 1.0)]
    pub thickness_um: Option<f64>,
    /// Whether the layer is so thick that its card does not matter: thickness and backing are left
    /// out. The base needs `[layer.composed]`.
    #[serde(default)]
    pub opaque: bool,
    /// How the spectrum is measured (default: what the file declares, else `45:0`).
    pub geometry: Option<FitGeometry>,
    /// The sample's own face, where it is not the smooth one of the base.
    pub face: Option<FaceTable>,
    /// Weighted numbers that an instrument gave of the sample, such as its densities: beside a
    /// spectrum, or in the place of one where other samples have theirs.
    #[serde(default)]
    pub number: Vec<MeasuredNumberTable>,
}

/// `[[measured.number]]`: a `[[number]]` of the base as it was measured.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredNumberTable {
    /// Its name in the base.
    pub name: String,
    /// Its value, in its own unit.
    #[schemars(example = 1.32)]
    pub value: f64,
    /// Standard error of the value.
    #[schemars(transform = NUMBER_ERROR.mark(), example = 0.01)]
    pub error: f64,
}

/// Standard error of a measured number.
pub const NUMBER_ERROR: Allowed = Allowed::between(1e-6, 1e3, "");

impl MeasuredTable {
    /// Whether it has shares of several pigments.
    pub fn has_own_shares(&self) -> bool {
        self.volume_fractions.is_some() || self.weights.is_some()
    }
}

/// `face`: what the face of a sample does that a smooth one does not: `{ light = 0.012 }`, or
/// `{ k1 = 0.03, k2 = 0.6 }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FaceTable {
    /// Light that a matt or dusty face scatters into the instrument, added to the reflectance
    /// factor; 0.01 to 0.02 are usual.
    #[schemars(range(min = 0.0, max = 0.2))]
    pub light: Option<f64>,
    /// Saunderson's share of light that the face sends back from outside. It is in the reading
    /// where specular light is included.
    #[schemars(range(min = 0.0, max = 0.2))]
    pub k1: Option<f64>,
    /// Saunderson's share of diffuse light that the face sends back from inside; with `k1` it takes
    /// the place of the smooth face of the binder's index.
    #[schemars(range(min = 0.0, max = 0.95))]
    pub k2: Option<f64>,
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
    /// Diffuse light, seen at 8°, specular light excluded.
    #[serde(rename = "d:8 excluded")]
    SphereExcluded,
    /// A uniform sky, seen along the normal, mirrored light included.
    #[serde(rename = "natural")]
    UniformSky,
    /// All light that passes the free layer, without card, of light along the normal.
    #[serde(rename = "transmittance")]
    Transmitted,
}

impl FitGeometry {
    /// Its key in files.
    pub fn key(self) -> &'static str {
        match self {
            Self::LitAt45 => "45:0",
            Self::Sphere => "d:8",
            Self::SphereExcluded => "d:8 excluded",
            Self::UniformSky => "natural",
            Self::Transmitted => "transmittance",
        }
    }

    /// Whether what the layer's face mirrors is in the reading.
    pub fn includes_mirrored(self) -> bool {
        matches!(self, Self::Sphere | Self::UniformSky)
    }
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
    /// Light that the faces of all samples add to their reflectance factors, as `face.light` does:
    /// matt and dusty ones.
    FaceLight,
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
    /// Name of the pigment whose index is unknown; may be left out where there is only one. In a
    /// stack it may stand after the name of its layer: `"top.blue"`.
    pub pigment: Option<String>,
    /// What the index is expected to be like.
    pub prior: PriorName,
    /// Standard deviation of every measured reflectance factor.
    #[schemars(range(min = 1e-5, max = 0.1))]
    pub noise: f64,
    /// What else is unknown.
    pub also: Vec<AlsoFitted>,
    /// n known from elsewhere at one wavelength, for the prior of Kramers and Kronig: opaque coats
    /// leave n open without it.
    pub known_n: Option<KnownN>,
    /// Densities of the pigments by their names, and of the dry `binder`, for `weights`.
    pub densities_g_per_cm3: BTreeMap<String, f64>,
    /// Range of n searched, from and to; the result says where fitted values go beyond it.
    #[schemars(inner(range(min = 1.0, max = 4.0)))]
    pub n: [f64; 2],
    /// Range of κ searched, from and to; the result says where fitted values go beyond it.
    #[schemars(inner(range(min = 0.0, max = 4.0)))]
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
            densities_g_per_cm3: BTreeMap::new(),
            n: [1.3, 2.0],
            kappa: [0.0, 0.6],
        }
    }
}
