//! Wave equation and polarisation.

use super::Scheme;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Linear polarisation of a plane wave: s has E along s = ẑ × p̂, p has H along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Polarisation {
    /// E perpendicular to the plane of incidence.
    S,
    /// E in the plane of incidence.
    P,
}

impl Polarisation {
    /// Both polarisations, s first.
    pub const BOTH: [Polarisation; 2] = [Polarisation::S, Polarisation::P];
}

/// Which equation is solved, and for which light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Wave {
    /// The scalar wave equation: like s light, without polarisation.
    #[default]
    Scalar,
    /// Maxwell's equations, E perpendicular to the plane of incidence.
    S,
    /// Maxwell's equations, E in the plane of incidence.
    P,
    /// Maxwell's equations, the mean of s and p efficiencies.
    Unpolarised,
}

impl Wave {
    /// Names in study files, in the order of the variants.
    pub const NAMES: [&'static str; 4] = ["scalar", "s", "p", "unpolarised"];

    /// Polarisations to solve; none for the scalar wave.
    pub fn polarisations(self) -> &'static [Polarisation] {
        match self {
            Wave::Scalar => &[],
            Wave::S => &Polarisation::BOTH[..1],
            Wave::P => &Polarisation::BOTH[1..],
            Wave::Unpolarised => &Polarisation::BOTH,
        }
    }

    /// Whether the wave obeys Maxwell's equations.
    pub fn is_vector(self) -> bool {
        self != Wave::Scalar
    }

    /// The light returned by paper: paper depolarises.
    pub fn returned(self) -> Wave {
        if self.is_vector() { Wave::Unpolarised } else { Wave::Scalar }
    }

    /// The scheme required by the wave: the vector wave has two Gauss planes per cell.
    pub fn scheme(self, scalar: Scheme) -> Scheme {
        if self.is_vector() { Scheme::Quadratic } else { scalar }
    }

    /// Name in study files.
    pub fn name(self) -> &'static str {
        Wave::NAMES[self as usize]
    }

    /// Short description for reports.
    pub fn in_words(self) -> &'static str {
        match self {
            Wave::Scalar => "scalar wave equation",
            Wave::S => "Maxwell's equations, s-polarised light",
            Wave::P => "Maxwell's equations, p-polarised light",
            Wave::Unpolarised => "Maxwell's equations, unpolarised light",
        }
    }
}
