//! `[[number]]`: a weighted mean of a spectrum, and what is made of it.

use crate::appearance::weighted::{NumberTransform, weight_names};
use crate::input::limits;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

/// `[[number]]`: a weighted mean of a spectrum over its wavelengths, or what is made of one, such
/// as a solar reflectance, an optical density, a whiteness, a haze or a sun protection factor; with
/// an error bar like a colour's.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NumberTable {
    /// Its name in results, tables and conclusions.
    #[schemars(example = &"solar reflectance")]
    pub name: String,
    /// Weights against wavelength: the name of a table of this program, an illuminant and an
    /// observer such as `"D65/10"` (their Y, or X, Y, Z where the transform takes these), or
    /// `{ csv = "weights.csv" }` with the columns wavelength_nm and weight.
    pub weights: WeightsWritten,
    /// First wavelength that counts, nm (default: the table's first): a part of the weights, such
    /// as the near infrared from 700 nm.
    #[schemars(transform = limits::WAVELENGTH_NM.mark(), example = 700)]
    pub from_nm: Option<f64>,
    /// Last wavelength that counts, nm (default: the table's last).
    #[schemars(transform = limits::WAVELENGTH_NM.mark(), example = 2500)]
    pub to_nm: Option<f64>,
    /// The spectrum that is weighted.
    pub of: SeenLight,
    /// A second spectrum with the same weights, by whose mean that of `of` is divided: a haze is
    /// the scattered over all transmitted light.
    #[schemars(example = &"transmittance")]
    pub over: Option<SeenLight>,
    /// What is made of the mean.
    #[serde(default)]
    pub transform: NumberTransform,
}

/// Weights of a number.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[schemars(rename = "NumberWeights")]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "a name such as \"solar_g173\" or \"D65/10\", or { csv = \"weights.csv\" }"
)]
pub enum WeightsWritten {
    /// A table of this program, or an illuminant and an observer.
    Named(#[schemars(schema_with = "offered")] String),
    /// A table in a file.
    Csv {
        /// Table with the columns wavelength_nm and weight, relative to the study file.
        csv: String,
        /// Its column (default: `weight`, or the only one beside the wavelengths).
        #[serde(skip_serializing_if = "Option::is_none")]
        column: Option<String>,
    },
}

/// Schema of a name: editors offer the tables, and other names are illuminants with observers.
fn offered(_: &mut SchemaGenerator) -> Schema {
    let names = [weight_names(), vec!["D65/2", "D65/10", "C/2", "A/2"]].concat();
    json_schema!({ "type": "string", "anyOf": [{ "enum": names }, {}] })
}

/// A spectrum that a number weights; light comes along the normal where it is not said otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SeenLight {
    /// On the paper: all reflected light, the mirrored included.
    Albedo,
    /// On the paper: under a uniform sky, seen along the normal, with or without the mirrored sky
    /// as `output.mirrored_sky` says.
    NaturalLight,
    /// On the paper: lit at 45°, seen along the normal.
    #[serde(rename = "lit_at_45")]
    LitAt45,
    /// The layer alone: R.
    Reflectance,
    /// The layer alone: T.
    Transmittance,
    /// The layer alone: A.
    Absorptance,
    /// The layer alone: what goes straight on, |⟨t⟩|².
    CoherentTransmittance,
    /// The layer alone: T without what goes straight on.
    ScatteredTransmittance,
}

impl SeenLight {
    /// Whether it is of the layer on its paper.
    pub fn on_paper(self) -> bool {
        matches!(self, Self::Albedo | Self::NaturalLight | Self::LitAt45)
    }

    /// Whether it takes the coherent transmittance, which uneven layers do not have.
    pub fn is_coherent(self) -> bool {
        matches!(self, Self::CoherentTransmittance | Self::ScatteredTransmittance)
    }

    /// Its key in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::NaturalLight => "natural_light",
            Self::LitAt45 => "lit_at_45",
            Self::Reflectance => "reflectance",
            Self::Transmittance => "transmittance",
            Self::Absorptance => "absorptance",
            Self::CoherentTransmittance => "coherent_transmittance",
            Self::ScatteredTransmittance => "scattered_transmittance",
        }
    }
}
