//! Values that can be written in several forms.

use super::limits::{
    ABOVE_ZERO, ABSORPTION, ALBEDO, ANCHOR_NM, CONCENTRATION, DENSITY, Entries, INDEX, N_ERROR, NOT_NEGATIVE,
    PATH_MM, SHARE, THICKNESS_UM,
};
use super::measured::{MeasuredCondition, MeasuredUnit, Patch};
use crate::material::named::{MATERIALS, NamedMaterial, Synthetic};
use crate::solve::{Registry, SolverChoice};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;
use std::fmt;

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
        /// Standard deviation, µm; at most a quarter of the mean.
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

/// A complex refractive index n + iκ: a number, or a table in one of several forms. The table alone
/// is derived, fields are read by `index`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndexWritten {
    /// Real part.
    pub n: Option<f64>,
    /// Imaginary part κ ≥ 0 (absorption).
    pub k: Option<f64>,
    /// Name of a built-in synthetic spectrum.
    pub built_in: Option<String>,
    /// Name of a material that comes with the program.
    pub material: Option<String>,
    /// CSV file, relative to the study file: wavelength in nm, κ and optionally n.
    pub csv: Option<String>,
    /// Record of refractiveindex.info (YAML), relative to the study file.
    pub yaml: Option<String>,
    /// What n follows from, beside a file of κ alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kramers_kronig: Option<KramersKronigWritten>,
    /// The dilution whose absorbance a file holds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dilution: Option<DilutionWritten>,
    /// Both rays of a listed crystal instead of their mean; of pigments only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub birefringent: Option<bool>,
    /// Index of the ordinary ray, of pigments only.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "ray")]
    pub ordinary: Option<Box<IndexWritten>>,
    /// Index of the extraordinary ray.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "ray")]
    pub extraordinary: Option<Box<IndexWritten>>,
}

/// Reads the index of one ray in any of its forms.
fn ray<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Box<IndexWritten>>, D::Error> {
    Ok(Some(Box::new(index(deserializer)?)))
}

/// n by the relation of Kramers and Kronig from the κ of the file: what is known of n, either at
/// one wavelength or far to the red. Absorption beyond the file (one pole in the ultraviolet, tails
/// at both ends) is guessed, and its error enters every error bar.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "KramersKronig")]
#[serde(deny_unknown_fields)]
pub struct KramersKronigWritten {
    /// Wavelength of the known n, nm; it may lie outside the file.
    #[schemars(transform = ANCHOR_NM.mark())]
    pub n_nm: Option<f64>,
    /// n at that wavelength.
    #[schemars(transform = INDEX.mark())]
    pub n: Option<f64>,
    /// Instead of both: n far to the red of all absorption in the ultraviolet, without the bands of
    /// the file.
    #[schemars(transform = INDEX.mark())]
    pub n_infinity: Option<f64>,
    /// Standard error of the known n (default: 0).
    #[schemars(transform = N_ERROR.mark())]
    pub n_error: Option<f64>,
}

/// The dilution whose absorbance (decadic, of a cuvette against one with the liquid alone) the file
/// holds: molecules, or grains far smaller than the wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Dilution")]
#[serde(deny_unknown_fields)]
pub struct DilutionWritten {
    /// Path of the light, mm.
    #[schemars(transform = PATH_MM.mark())]
    pub path_mm: f64,
    /// Mass of the pigment in a litre of the dilution, g.
    #[schemars(transform = CONCENTRATION.mark())]
    pub concentration_g_per_l: f64,
    /// Density of the pigment, g/cm³.
    #[schemars(transform = DENSITY.mark())]
    pub density_g_per_cm3: f64,
}

/// Schema of [`IndexWritten`], whose keys are read one by one so that each error can be named.
#[derive(JsonSchema)]
#[schemars(rename = "Index", untagged, deny_unknown_fields)]
#[allow(dead_code, reason = "the schema alone")]
pub(super) enum IndexForms {
    /// A transparent medium: its real index.
    Real(#[schemars(transform = INDEX.mark())] f64),
    /// One index for all wavelengths: n + iκ.
    Constant {
        /// Real part.
        #[schemars(transform = INDEX.mark())]
        n: f64,
        /// Imaginary part κ ≥ 0, which absorbs (default: 0).
        #[schemars(transform = ABSORPTION.mark())]
        k: Option<f64>,
    },
    BuiltIn {
        /// A built-in synthetic pigment.
        #[schemars(schema_with = "built_in_names")]
        built_in: String,
    },
    Material {
        /// A measured material that comes with the program; `inkwave materials` lists them.
        #[schemars(schema_with = "material_names")]
        material: String,
    },
    Csv {
        /// Table with the columns wavelength_nm, kappa and optionally n, relative to the study
        /// file; without n in the file, give it beside. Also the CSV files of refractiveindex.info
        /// (blocks wl,n and wl,k, wavelengths in µm). The columns n_error, kappa_error (standard
        /// errors, in the units of n and kappa) and correlation (of both, -1 to 1), which a fit
        /// writes, enter every error bar, as errors common to all wavelengths. A remark "# n is
        /// not determined: …" is repeated where the table is used.
        csv: String,
        /// Real part at all wavelengths, if the file contains only κ.
        #[schemars(transform = INDEX.mark())]
        n: Option<f64>,
        /// Instead of it: n by the relation of Kramers and Kronig.
        kramers_kronig: Option<KramersKronigWritten>,
        /// The dilution, if the file has a column absorbance in place of kappa.
        dilution: Option<DilutionWritten>,
    },
    Yaml {
        /// Record of refractiveindex.info, relative to the study file; without n in the file, give
        /// it beside.
        yaml: String,
        /// Real part at all wavelengths, if the file contains only k.
        #[schemars(transform = INDEX.mark())]
        n: Option<f64>,
        /// Instead of it: n by the relation of Kramers and Kronig.
        kramers_kronig: Option<KramersKronigWritten>,
    },
}

/// Schema of the index of a pigment: one for all directions of the field, or both of a crystal.
#[derive(JsonSchema)]
#[schemars(rename = "PigmentIndex", untagged, deny_unknown_fields)]
#[allow(dead_code, reason = "the schema alone")]
pub(super) enum PigmentIndexForms {
    /// One index.
    One(IndexForms),
    /// A listed uniaxial crystal, such as "TiO2 rutile", with both of its rays.
    Listed {
        /// Its name.
        #[schemars(schema_with = "material_names")]
        material: String,
        /// Whether both rays count, with Maxwell's equations, or their mean (default: false).
        birefringent: bool,
    },
    /// A uniaxial crystal, with Maxwell's equations: ε_o across its optic axis, ε_e along it.
    Rays {
        /// Index of the ordinary ray.
        ordinary: IndexForms,
        /// Index of the extraordinary ray.
        extraordinary: IndexForms,
    },
}

fn built_in_names(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": Synthetic::ALL.map(Synthetic::name) })
}

fn material_names(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": MATERIALS.iter().flat_map(NamedMaterial::names).collect::<Vec<_>>() })
}

/// The keys of [`IndexWritten`].
pub(super) const INDEX_KEYS: &[&str] = &[
    "n",
    "k",
    "built_in",
    "material",
    "csv",
    "yaml",
    "kramers_kronig",
    "dilution",
    "birefringent",
    "ordinary",
    "extraordinary",
];

/// Reads an index in any of its forms.
pub(super) fn index<'de, D: Deserializer<'de>>(deserializer: D) -> Result<IndexWritten, D::Error> {
    deserializer.deserialize_struct("index", INDEX_KEYS, IndexVisitor)
}

struct IndexVisitor;

impl<'de> Visitor<'de> for IndexVisitor {
    type Value = IndexWritten;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number or a table such as { n = 1.4, k = 0.1 }")
    }

    fn visit_f64<E: Error>(self, n: f64) -> Result<IndexWritten, E> {
        Ok(IndexWritten { n: Some(n), ..Default::default() })
    }

    fn visit_i64<E: Error>(self, n: i64) -> Result<IndexWritten, E> {
        self.visit_f64(n as f64)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<IndexWritten, A::Error> {
        IndexWritten::deserialize(MapAccessDeserializer::new(map))
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
