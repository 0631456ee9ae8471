//! `layer.microstructure`: grains in given places.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Grains in given places instead of packed ones, from a simulation or a microscope. The cut is
/// continued periodically as it is; z runs from the lit face to the paper.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MicrostructureTable {
    /// One file or several, relative to the study file; every cut (a CSV file, a frame of a dump)
    /// is a realisation. CSV with x_um, y_um, z_um and radius_um or diameter_um (or _nm),
    /// optionally pigment and grain; a LAMMPS dump; extended XYZ.
    #[schemars(example = &"positions.csv")]
    pub spheres: PositionFiles,
    /// Unit of the lengths in a dump or an XYZ file.
    #[schemars(example = LengthUnit::Um)]
    pub unit: Option<LengthUnit>,
    /// What the column of sizes in a dump or an XYZ file holds, whatever its name.
    #[schemars(example = SizeColumn::Radius)]
    pub size: Option<SizeColumn>,
}

impl MicrostructureTable {
    /// As the schema shows it.
    pub(super) fn example() -> Self {
        Self { spheres: PositionFiles::One("positions.csv".into()), unit: None, size: None }
    }
}

/// One file or several.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "a file name or a list of file names")]
pub enum PositionFiles {
    /// One file.
    One(String),
    /// Several files.
    Several(Vec<String>),
}

impl PositionFiles {
    /// All of them.
    pub fn all(&self) -> &[String] {
        match self {
            PositionFiles::One(file) => std::slice::from_ref(file),
            PositionFiles::Several(files) => files,
        }
    }
}

/// Unit of the lengths in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LengthUnit {
    /// Micrometres.
    Um,
    /// Nanometres.
    Nm,
}

impl LengthUnit {
    /// The unit in µm.
    pub fn um(self) -> f64 {
        match self {
            LengthUnit::Um => 1.0,
            LengthUnit::Nm => 1e-3,
        }
    }
}

/// Meaning of a column of sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SizeColumn {
    /// Radii.
    Radius,
    /// Diameters.
    Diameter,
}
