//! Values that can be written in several forms.

mod index;

pub use index::{DilutionWritten, IndexWritten, KramersKronigWritten};
pub(super) use index::{INDEX_KEYS, IndexForms, PigmentIndexForms, index};

use super::limits::{ABOVE_ZERO, ALBEDO, Entries, NOT_NEGATIVE, SHARE, THICKNESS_UM};
use super::measured::{MeasuredCondition, MeasuredUnit, Patch};
use crate::solve::{Registry, SolverChoice};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Grain size.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "a number of nm such as 250, or \"molecular\"")]
pub enum Diameter {
    /// Diameter of the sphere of equal volume, nm.
    Nm(#[schemars(transform = ABOVE_ZERO.mark())] f64),
    /// No size at all.
    Vanishing(Vanishing),
}

/// Grains of vanishing size.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Vanishing {
    /// The limit of vanishing grains: nothing is packed, the pigment is dissolved in the binder.
    Molecular,
}

/// Thickness of a layer.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[schemars(rename = "Thickness")]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "a thickness in µm, { mean = 1.0, std = 0.1 } for an uneven layer, or a list for a composed one"
)]
pub enum ThicknessWritten {
    /// Uniform thickness, µm.
    Even(#[schemars(transform = THICKNESS_UM.mark())] f64),
    /// Variable thickness: every realisation has its own.
    Uneven {
        /// Mean, µm.
        #[schemars(transform = THICKNESS_UM.mark())]
        mean: f64,
        /// Standard deviation, µm; at most a quarter of the mean. Layers beyond three of it are
        /// left out.
        #[schemars(transform = NOT_NEGATIVE.mark())]
        std: f64,
    },
    /// Several thicknesses of a composed layer, µm: one set of solves answers all.
    Several(#[schemars(transform = Entries(THICKNESS_UM))] Vec<f64>),
}

impl ThicknessWritten {
    /// Mean, µm.
    pub fn mean(&self) -> f64 {
        self.all().first().copied().unwrap_or(f64::NAN)
    }

    /// Standard deviation, µm.
    pub fn std(&self) -> f64 {
        if let Self::Uneven { std, .. } = self { *std } else { 0.0 }
    }

    /// All thicknesses, µm.
    pub fn all(&self) -> Vec<f64> {
        match self {
            Self::Even(mean) | Self::Uneven { mean, .. } => vec![*mean],
            Self::Several(all) => all.clone(),
        }
    }
}

/// The paper's albedo.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[schemars(rename = "Albedo")]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "a number, rows [[wavelength in nm, albedo], …] or { csv = \"paper.csv\" }"
)]
pub enum AlbedoWritten {
    /// One albedo for all wavelengths.
    Constant(#[schemars(transform = ALBEDO.mark())] f64),
    /// Rows of wavelength in nm and albedo, with increasing wavelengths, linear in between.
    Rows(#[schemars(length(min = 2))] Vec<[f64; 2]>),
    /// A table in a file.
    Csv {
        /// Table with the columns wavelength_nm and albedo, or a measured spectrum in any format of
        /// `compare.measured`, relative to the study file.
        csv: String,
        /// Sample in a file with several: its name, or its amounts of ink.
        #[serde(skip_serializing_if = "Option::is_none")]
        patch: Option<Patch>,
        /// Value of a perfect white, where the file does not state it.
        #[serde(skip_serializing_if = "Option::is_none")]
        unit: Option<MeasuredUnit>,
        /// The instrument's light, where the sample was measured under several.
        #[serde(skip_serializing_if = "Option::is_none")]
        condition: Option<MeasuredCondition>,
    },
}

/// A share of the area of a print.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[schemars(rename = "Coverage")]
#[serde(untagged, expecting = "a share of the area such as 0.5, or a list of them")]
pub enum CoverageWritten {
    /// One print.
    One(#[schemars(transform = SHARE.mark())] f64),
    /// A ramp of tints.
    Ramp(#[schemars(length(min = 1), transform = Entries(SHARE))] Vec<f64>),
}

impl CoverageWritten {
    /// One share for each tint.
    pub fn all(&self) -> Vec<f64> {
        match self {
            Self::One(share) => vec![*share],
            Self::Ramp(shares) => shares.clone(),
        }
    }
}

/// A paper's brightener.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[schemars(rename = "Fluorescence")]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "{ excitation = [[nm, share], …], emission = [[nm, quanta], …], yield = 0.5 }, { donaldson_csv = \"table.csv\" } \
                 or { m1_csv = \"m1.csv\", m2_csv = \"m2.csv\" }"
)]
pub enum FluorescenceWritten {
    /// One brightener. It takes its share of the light before the paper's albedo acts on the rest.
    Bands {
        /// Rows of wavelength in nm and share of the quanta that the brightener absorbs, 0 to 1.
        #[schemars(length(min = 2))]
        excitation: Vec<[f64; 2]>,
        /// Rows of wavelength in nm and quanta emitted per nm, in any unit.
        #[schemars(length(min = 2))]
        emission: Vec<[f64; 2]>,
        /// Quanta emitted per quantum absorbed, 0 to 1.
        #[serde(rename = "yield")]
        #[schemars(transform = SHARE.mark())]
        quantum_yield: f64,
    },
    /// A bispectral measurement of the paper behind its surface.
    Donaldson {
        /// Table whose first column holds the wavelengths emitted, nm, and whose header names those
        /// of the light, nm, in equal steps; entries are radiance factors. Those that are not of
        /// longer wavelength than their light are reflected light, and left to the albedo.
        donaldson_csv: String,
    },
    /// The bare paper measured with and without ultraviolet light, at 45:0 or as the files state;
    /// the albedo follows from the second.
    Pair {
        /// Factor under D50 with ultraviolet light (M1), in any format of `compare.measured`.
        m1_csv: String,
        /// Factor without ultraviolet light (M2).
        m2_csv: String,
        /// Sample in files with several.
        #[serde(skip_serializing_if = "Option::is_none")]
        patch: Option<Patch>,
        /// Value of a perfect white, where the files do not state it.
        #[serde(skip_serializing_if = "Option::is_none")]
        unit: Option<MeasuredUnit>,
    },
}

/// One length for both directions, or one for each.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "a number or two numbers [x, y]")]
pub enum Pair {
    /// One length along x and y, µm.
    Both(#[schemars(transform = ABOVE_ZERO.mark())] f64),
    /// Lengths along x and y, µm.
    Each([f64; 2]),
}

impl Pair {
    /// Lengths along x and y, µm.
    pub fn xy(self) -> [f64; 2] {
        match self {
            Self::Both(length) => [length; 2],
            Self::Each(lengths) => lengths,
        }
    }
}

/// Every strategy as a name, or as a table with its settings.
pub(super) fn strategies(generator: &mut SchemaGenerator) -> Schema {
    let named = |name: &str, description: &str| json_schema!({ "description": description, "type": "string", "const": name });
    let registry = Registry::default();
    let names = registry.entries().iter().map(|e| named(&e.name, &e.description));
    let mut forms: Vec<Value> = names.map(Value::from).collect();
    forms.push(generator.subschema_for::<SolverChoice>().into());
    json_schema!({ "anyOf": forms })
}
