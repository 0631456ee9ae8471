//! Values that may be written in more than one form.

use crate::solve::SolverChoice;
use serde::de::{self, MapAccess, SeqAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;

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
    /// Record of refractiveindex.info (YAML), relative to the study file.
    pub yaml: Option<String>,
}

/// Grain size as written: a diameter in nm, or `"molecular"` for the limit of vanishing grains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Diameter {
    /// A size in nm.
    Nm(f64),
    /// No grains: the mixture on the scale of molecules.
    Molecular,
}

impl<'de> Deserialize<'de> for Diameter {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct DiameterVisitor;
        impl Visitor<'_> for DiameterVisitor {
            type Value = Diameter;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number of nm such as 250, or \"molecular\"")
            }
            fn visit_f64<E: de::Error>(self, v: f64) -> Result<Diameter, E> {
                Ok(Diameter::Nm(v))
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<Diameter, E> {
                self.visit_f64(v as f64)
            }
            fn visit_str<E: de::Error>(self, name: &str) -> Result<Diameter, E> {
                match name {
                    "molecular" => Ok(Diameter::Molecular),
                    _ => Err(de::Error::invalid_value(de::Unexpected::Str(name), &self)),
                }
            }
        }
        deserializer.deserialize_any(DiameterVisitor)
    }
}

/// A layer's thickness as written: a number of µm, or `{ mean = …, std = … }` of an uneven layer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ThicknessWritten {
    /// Mean, µm.
    pub mean: f64,
    /// Standard deviation, µm.
    pub std: f64,
}

impl From<f64> for ThicknessWritten {
    fn from(mean: f64) -> Self {
        Self { mean, std: 0.0 }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ThicknessTable {
    mean: f64,
    std: f64,
}

impl<'de> Deserialize<'de> for ThicknessWritten {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ThicknessVisitor;
        impl<'de> Visitor<'de> for ThicknessVisitor {
            type Value = ThicknessWritten;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a thickness in µm, or { mean = 1.0, std = 0.1 } for an uneven layer")
            }
            fn visit_f64<E: de::Error>(self, v: f64) -> Result<ThicknessWritten, E> {
                Ok(v.into())
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<ThicknessWritten, E> {
                self.visit_f64(v as f64)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ThicknessWritten, A::Error> {
                let ThicknessTable { mean, std } =
                    ThicknessTable::deserialize(MapAccessDeserializer::new(map))?;
                Ok(ThicknessWritten { mean, std })
            }
        }
        deserializer.deserialize_any(ThicknessVisitor)
    }
}

/// The paper's albedo as written: a number, rows of (wavelength in nm, albedo), or the path of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum AlbedoWritten {
    /// The same at all wavelengths.
    Constant(f64),
    /// Rows of wavelength in nm and albedo.
    Rows(Vec<[f64; 2]>),
    /// Relative to the study file.
    Csv {
        /// File with the columns wavelength_nm and albedo.
        csv: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CsvTable {
    csv: String,
}

impl<'de> Deserialize<'de> for AlbedoWritten {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AlbedoVisitor;
        impl<'de> Visitor<'de> for AlbedoVisitor {
            type Value = AlbedoWritten;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number, rows [[wavelength in nm, albedo], …] or { csv = \"paper.csv\" }")
            }
            fn visit_f64<E: de::Error>(self, v: f64) -> Result<AlbedoWritten, E> {
                Ok(AlbedoWritten::Constant(v))
            }
            fn visit_i64<E: de::Error>(self, v: i64) -> Result<AlbedoWritten, E> {
                self.visit_f64(v as f64)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<AlbedoWritten, A::Error> {
                let mut rows = Vec::new();
                while let Some(row) = seq.next_element()? {
                    rows.push(row);
                }
                Ok(AlbedoWritten::Rows(rows))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<AlbedoWritten, A::Error> {
                let CsvTable { csv } = CsvTable::deserialize(MapAccessDeserializer::new(map))?;
                Ok(AlbedoWritten::Csv { csv })
            }
        }
        deserializer.deserialize_any(AlbedoVisitor)
    }
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
    #[serde(alias = "kappa")]
    k: Option<f64>,
    built_in: Option<String>,
    csv: Option<String>,
    yaml: Option<String>,
}

/// The keys of [`IndexTable`].
const INDEX_KEYS: &[&str] = &["n", "k", "kappa", "built_in", "csv", "yaml"];

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
                let IndexTable { n, k, built_in, csv, yaml } = table;
                Ok(IndexWritten { n, k, built_in, csv, yaml })
            }
        }
        deserializer.deserialize_struct("index", INDEX_KEYS, IndexVisitor)
    }
}

/// A strategy by name, or as a table with its settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Strategy(pub SolverChoice);

impl<'de> Deserialize<'de> for Strategy {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct StrategyVisitor;
        impl<'de> Visitor<'de> for StrategyVisitor {
            type Value = Strategy;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the name of a strategy, or a table such as { krylov = { restart = 60 } }")
            }
            fn visit_str<E: de::Error>(self, name: &str) -> Result<Strategy, E> {
                let unknown = |_| de::Error::unknown_variant(name, SolverChoice::NAMES);
                SolverChoice::named(name).map(Strategy).map_err(unknown)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Strategy, A::Error> {
                SolverChoice::deserialize(MapAccessDeserializer::new(map)).map(Strategy)
            }
        }
        deserializer.deserialize_any(StrategyVisitor)
    }
}
