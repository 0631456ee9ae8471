//! The paper under the layer: its albedo, and what lies between it and the layer.

use super::error::PaperError;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// What is between the layer and the paper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Coupling {
    /// A thin gap of vacuum, wide enough to be incoherent (P1).
    #[default]
    Gap,
    /// The paper's scatterers sit in a medium of this index that touches the layer.
    OpticalContact {
        /// Real index of the paper's medium, at least 1.
        index: f64,
    },
}

impl Coupling {
    /// Index of the exit half-space required in the solves.
    pub fn index_out(self) -> f64 {
        match self {
            Self::Gap => 1.0,
            Self::OpticalContact { index } => index,
        }
    }
}

/// Albedo ρ of the paper, 0–1: the same at every wavelength, or (wavelength_nm, ρ) rows, linear in
/// between.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Albedo {
    /// The same at all wavelengths, 0 to 1.
    Constant(f64),
    /// Rows of wavelength in nm and albedo, linear between.
    Spectral(Vec<[f64; 2]>),
}

impl Albedo {
    /// The albedo ρ(λ) at a wavelength in nm.
    ///
    /// # Errors
    /// Values outside 0–1, tables that do not increase, wavelengths outside the table.
    pub fn at(&self, wavelength_nm: f64) -> Result<f64, PaperError> {
        let value = match self {
            Self::Constant(value) => *value,
            Self::Spectral(rows) => interpolate(rows, wavelength_nm)?,
        };
        if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(PaperError::Albedo { value }) }
    }
}

fn interpolate(rows: &[[f64; 2]], nm: f64) -> Result<f64, PaperError> {
    let unordered = rows.windows(2).find(|w| w[1][0].partial_cmp(&w[0][0]) != Some(Ordering::Greater));
    if rows.len() < 2 || unordered.is_some() {
        return Err(PaperError::AlbedoTable { value: unordered.map_or(nm, |w| w[1][0]) });
    }
    let (lo, hi) = (rows[0][0], rows[rows.len() - 1][0]);
    if !(lo..=hi).contains(&nm) {
        return Err(PaperError::AlbedoRange { value: nm, lo, hi });
    }
    let after = rows.partition_point(|r| r[0] < nm).clamp(1, rows.len() - 1);
    let ([x0, y0], [x1, y1]) = (rows[after - 1], rows[after]);
    Ok(y0 + (nm - x0) / (x1 - x0) * (y1 - y0))
}

/// The paper under the layer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Substrate {
    /// Share of the light that the paper returns.
    pub albedo: Albedo,
    /// What is between ink and paper.
    #[serde(default)]
    pub coupling: Coupling,
}
