//! A refractive index in any of its forms.

use crate::input::limits::{ABSORPTION, ANCHOR_NM, CONCENTRATION, DENSITY, INDEX, N_ERROR, PATH_MM};
use crate::material::named::{MATERIALS, NamedMaterial};
use crate::material::synthetic::Synthetic;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

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
/// at both ends or bands that they cut) is guessed, and its error enters every error bar.
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
pub(in crate::input) enum IndexForms {
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
pub(in crate::input) enum PigmentIndexForms {
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
pub(in crate::input) const INDEX_KEYS: &[&str] = &[
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
pub(in crate::input) fn index<'de, D: Deserializer<'de>>(deserializer: D) -> Result<IndexWritten, D::Error> {
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
