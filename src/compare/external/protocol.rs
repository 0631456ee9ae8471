//! What inkwave asks a program, and what it may answer: one JSON text each.

use crate::input::case_inputs::CaseInputs;
use crate::wave::Wave;
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The equation that a program solves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ValueEnum)]
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

/// The question, on the program's standard input.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ProgramRequest {
    /// A word for this case, which the answer may repeat.
    pub case: String,
    /// The case, with the keys of a case file of `inkwave solve`: µm, degrees, time factor e^(−iωt).
    #[schemars(with = "CaseInputs")]
    pub inputs: Value,
    /// The wave to solve.
    pub wave: WaveKind,
    /// The value of the program's own knob for accuracy; null where it has none.
    pub knob: Option<f64>,
    /// Wall time after which the program is killed, s.
    pub time_limit_s: f64,
    /// Memory beyond which the program is killed, GB.
    pub memory_gb: f64,
}

/// The answer, on the program's standard output: all orders that propagate, or a refusal.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Answer {
    /// Amplitudes of the orders, for an incident wave of amplitude 1 at x = y = 0 of the face that
    /// it enters by.
    #[serde(default)]
    pub orders: Option<Vec<AnsweredOrder>>,
    /// Why the program does not solve this case.
    #[serde(default)]
    pub refusal: Option<String>,
    /// The question's word for its case: an answer to another case is not taken.
    #[serde(default)]
    pub case: Option<String>,
    /// What the program itself measured of its solve, without its start, s.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub seconds: Option<f64>,
}

/// One order on one side.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
pub struct AnsweredOrder {
    /// Order along x, counted from the specular direction: kx = qx + 2πm/Lx.
    pub m: i32,
    /// Order along y.
    #[serde(default)]
    pub n: i32,
    /// Where it leaves the layer.
    pub side: AnsweredSide,
    /// Complex amplitude at x = y = 0 of the face by which it leaves.
    pub amplitude: AnsweredAmplitude,
}

/// The amplitude of an order: [re, im] of the scalar wave, of the vector wave one for each pair of
/// polarisations.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "[re, im], or by incident, then by outgoing polarisation")]
pub enum AnsweredAmplitude {
    /// Of the scalar wave.
    Scalar([f64; 2]),
    /// Of the vector wave.
    Vector {
        /// For incident s light.
        s: OutgoingAmplitudes,
        /// For incident p light.
        p: OutgoingAmplitudes,
    },
}

/// Amplitudes [re, im] of both outgoing polarisations.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
pub struct OutgoingAmplitudes {
    /// E perpendicular to the plane of the order's direction and the normal, along ẑ × k∥.
    pub s: [f64; 2],
    /// E in that plane; H is along ẑ × k∥.
    pub p: [f64; 2],
}

/// Where an order leaves the layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AnsweredSide {
    /// On the side that the light comes from.
    Reflected,
    /// On the other side.
    Transmitted,
}
