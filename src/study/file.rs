//! The study file as written: TOML with the units in the key names, nothing checked yet.
//!
//! ```toml
//! title = "Yellow ink, 30 %"
//! [layer]
//! period_um = 2.0                      # or [2.0, 1.5]
//! thickness_um = 1.0
//! binder.index = 1.558
//! [[pigment]]
//! name = "yellow"
//! diameter_nm = 250
//! volume_fraction = 0.30
//! index = { built_in = "yellow" }      # or { n = 1.4, k = 0.1 }, { csv = "measured.csv" }
//! [light]
//! from_nm = 400
//! to_nm = 700
//! step_nm = 30
//! ```

use serde::de::{self, MapAccess, SeqAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

/// A whole study file. Tables left out take the defaults documented on their fields.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Shown as the report's heading; the file's name when left out.
    pub title: Option<String>,
    pub layer: LayerTable,
    #[serde(default, rename = "pigment")]
    pub pigments: Vec<PigmentTable>,
    #[serde(default)]
    pub paper: PaperTable,
    pub light: LightTable,
    #[serde(default)]
    pub angles: AnglesTable,
    #[serde(default)]
    pub run: RunTable,
    #[serde(default)]
    pub resolution: ResolutionTable,
    #[serde(default)]
    pub solver: SolverTable,
    #[serde(default)]
    pub output: OutputTable,
}

/// `[layer]`: the periodic cell and what lies above and below it.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LayerTable {
    /// Period in x and y, µm: one number or `[x, y]`.
    pub period_um: Pair,
    pub thickness_um: f64,
    pub binder: BinderTable,
    /// Refractive index of the half-space the light comes from.
    #[serde(default = "vacuum")]
    pub index_above: f64,
    /// Refractive index of the half-space behind the layer: 1 for the thin air gap to the paper.
    #[serde(default = "vacuum")]
    pub index_below: f64,
}

/// `[layer.binder]`
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BinderTable {
    pub index: IndexWritten,
}

/// `[[pigment]]`: one kind of grain.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PigmentTable {
    pub name: String,
    #[serde(default)]
    pub shape: ShapeName,
    /// Diameter of the grain (the median of a distribution), nm.
    pub diameter_nm: f64,
    /// Relative standard deviation of a log-normal size distribution; 0 makes all grains alike.
    #[serde(default)]
    pub diameter_spread: f64,
    /// Share of the layer's volume, 0–1.
    pub volume_fraction: f64,
    pub index: IndexWritten,
}

/// The shapes a study may ask for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeName {
    #[default]
    Sphere,
}

/// A complex refractive index n + iκ as written: a number, or a table with one of three forms.
#[derive(Clone, Debug, Default, Serialize)]
pub struct IndexWritten {
    /// Real part.
    pub n: Option<f64>,
    /// Imaginary part κ ≥ 0 (absorption).
    pub k: Option<f64>,
    /// Name of a built-in synthetic spectrum.
    pub built_in: Option<String>,
    /// CSV file, relative to the study file: wavelength in nm, κ and optionally n.
    pub csv: Option<String>,
}

/// `[paper]`: the Lambertian substrate.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct PaperTable {
    pub albedo: f64,
    pub coupling: CouplingName,
}

impl Default for PaperTable {
    fn default() -> Self {
        Self { albedo: 0.9, coupling: CouplingName::Gap }
    }
}

/// How layer and paper touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CouplingName {
    /// The paper's model (P1 section 5): a thin air gap, light goes back and forth incoherently.
    #[default]
    Gap,
}

/// `[light]`: vacuum wavelengths in nm, as a list or as a range.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LightTable {
    pub wavelengths_nm: Option<Vec<f64>>,
    pub from_nm: Option<f64>,
    pub to_nm: Option<f64>,
    pub step_nm: Option<f64>,
}

/// `[angles]`: polar angles as quadrature nodes (`count`) or as a list.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct AnglesTable {
    /// Number of Gauss nodes over the hemisphere.
    pub count: Option<usize>,
    pub polar_deg: Option<Vec<f64>>,
    /// Azimuth of the plane of incidence, degrees from x.
    #[serde(default)]
    pub azimuth_deg: f64,
}

/// `[run]`
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RunTable {
    /// Number of independent packings to average over.
    pub realisations: usize,
    pub seed: u64,
}

impl Default for RunTable {
    fn default() -> Self {
        Self { realisations: 4, seed: 1 }
    }
}

/// `[resolution]`: a wanted accuracy, or the grid itself.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ResolutionTable {
    /// Largest wanted error of any order's complex amplitude.
    pub accuracy: Option<f64>,
    /// Grid points per µm in x and y.
    pub points_per_um: Option<f64>,
    /// Planes per µm in z.
    pub planes_per_um: Option<f64>,
}

/// `[solver]`
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SolverTable {
    pub method: String,
    /// Relative residual at which a solve counts as converged.
    pub tolerance: f64,
    pub max_steps: usize,
}

impl Default for SolverTable {
    fn default() -> Self {
        Self { method: "krylov".into(), tolerance: 1e-6, max_steps: 2000 }
    }
}

/// `[output]`
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputTable {
    /// Folder for the results, relative to where the program runs; `out/<study name>` when left out.
    pub folder: Option<String>,
    /// Side of the picture's square, pixels.
    pub picture_pixels: usize,
}

impl Default for OutputTable {
    fn default() -> Self {
        Self { folder: None, picture_pixels: 360 }
    }
}

fn vacuum() -> f64 {
    1.0
}

/// One number for both directions, or two.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pair(pub [f64; 2]);

impl<'de> Deserialize<'de> for Pair {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PairVisitor;
        impl<'de> Visitor<'de> for PairVisitor {
            type Value = Pair;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number or two numbers [x, y]")
            }
            fn visit_f64<E: de::Error>(self, v: f64) -> Result<Pair, E> {
                Ok(Pair([v, v]))
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<Pair, E> {
                self.visit_f64(v as f64)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Pair, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = seq.next_element()? {
                    values.push(value);
                }
                let found = values.len();
                values.try_into().map(Pair).map_err(|_| de::Error::invalid_length(found, &self))
            }
        }
        deserializer.deserialize_any(PairVisitor)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct IndexTable {
    n: Option<f64>,
    k: Option<f64>,
    built_in: Option<String>,
    csv: Option<String>,
}

impl<'de> Deserialize<'de> for IndexWritten {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct IndexVisitor;
        impl<'de> Visitor<'de> for IndexVisitor {
            type Value = IndexWritten;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number or a table such as { n = 1.4, k = 0.1 }")
            }
            fn visit_f64<E: de::Error>(self, n: f64) -> Result<IndexWritten, E> {
                Ok(IndexWritten { n: Some(n), ..Default::default() })
            }
            fn visit_i64<E: de::Error>(self, n: i64) -> Result<IndexWritten, E> {
                self.visit_f64(n as f64)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<IndexWritten, A::Error> {
                let table = IndexTable::deserialize(MapAccessDeserializer::new(map))?;
                let IndexTable { n, k, built_in, csv } = table;
                Ok(IndexWritten { n, k, built_in, csv })
            }
        }
        deserializer.deserialize_any(IndexVisitor)
    }
}
