//! A weighted number that a study asks for.

use crate::appearance::weighted::{NamedWeights, NumberTransform, WeightTable};
use crate::input::file::SeenLight;
use serde::{Deserialize, Serialize};

/// A weighted number; no solve depends on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WantedNumber {
    /// Its name in results.
    pub name: String,
    /// Its weights, before their range.
    pub weights: WantedWeights,
    /// The wavelengths of the weights that count, nm.
    pub range_nm: [f64; 2],
    /// The spectrum that is weighted.
    pub of: SeenLight,
    /// The spectrum by whose mean it is divided.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over: Option<SeenLight>,
    /// What is made of the mean.
    pub transform: NumberTransform,
}

/// Weights by name, or as a file has them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WantedWeights {
    /// Of this program.
    Named(String),
    /// Of a file.
    Table {
        /// Name of the file.
        source: String,
        /// The weights.
        table: WeightTable,
    },
}

impl WantedWeights {
    /// Where they come from, in words.
    pub fn source(&self) -> &str {
        match self {
            Self::Named(name) => name,
            Self::Table { source, .. } => source,
        }
    }

    /// The tables; `None` if the name is unknown.
    pub fn tables(&self) -> Option<NamedWeights> {
        match self {
            Self::Named(name) => NamedWeights::find(name),
            Self::Table { source, table } => {
                Some(NamedWeights { name: source.clone(), tables: vec![table.clone()], white: None })
            }
        }
    }
}

impl WantedNumber {
    /// The tables within the range; `None` if there is no weight there.
    pub fn tables(&self) -> Option<NamedWeights> {
        let whole = self.weights.tables()?;
        let tables = whole.tables.iter().map(|table| table.within(self.range_nm)).collect::<Option<_>>()?;
        Some(NamedWeights { tables, ..whole })
    }

    /// The spectra that it takes.
    pub fn spectra(&self) -> impl Iterator<Item = SeenLight> {
        std::iter::once(self.of).chain(self.over)
    }

    /// What it is, in words.
    pub fn in_words(&self) -> String {
        let [from, to] = self.range_nm;
        let over = self.over.map_or_else(String::new, |over| format!(" over {}", over.name()));
        format!(
            "{} of {}{over}, weighted with {} from {from} to {to} nm",
            self.transform.name(),
            self.of.name(),
            self.weights.source()
        )
    }
}
