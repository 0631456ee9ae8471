//! Which wave equation is solved, where polarisation is not chosen: by a single solve, by a
//! comparison, by a program beside it.

use crate::wave::Wave;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The equation that a program solves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WaveKind {
    /// The scalar wave equation.
    #[default]
    Scalar,
    /// Maxwell's equations, for s and p light.
    Vector,
}

impl WaveKind {
    /// The equation, for light of both polarisations where it has any.
    pub fn wave(self) -> Wave {
        if self == Self::Vector { Wave::Unpolarised } else { Wave::Scalar }
    }

    /// Its name in files and answers.
    pub fn name(self) -> &'static str {
        if self == Self::Vector { "vector" } else { "scalar" }
    }
}
