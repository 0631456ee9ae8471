//! What inkwave asks a program, and what it may answer: one JSON text each.

use crate::input::case_inputs::CaseInputs;
use crate::wave::FarField;
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::HashMap;
use std::fmt;

/// The question, on the program's standard input.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ProgramRequest {
    /// The case, with the keys of a case file of `inkwave solve`: µm, degrees, time factor e^(−iωt).
    #[schemars(with = "CaseInputs")]
    pub inputs: Value,
    /// The wave to solve: `scalar`.
    pub wave: String,
    /// The value of the program's own knob for accuracy; null where it has none.
    pub knob: Option<f64>,
    /// Wall time after which the program is killed, s.
    pub time_limit_s: f64,
    /// Memory beyond which the program is killed, GB.
    pub memory_gb: f64,
}

impl fmt::Display for ProgramRequest {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let json = serde_json::to_string(self).map_err(|_| fmt::Error)?;
        f.write_str(&json)
    }
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
    /// Complex amplitude [re, im] at x = y = 0 of the face by which it leaves.
    pub amplitude: [f64; 2],
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

/// Question and answer, for the schema.
#[derive(JsonSchema)]
#[allow(dead_code, reason = "only its schema is used")]
pub struct Protocol {
    request: ProgramRequest,
    answer: Answer,
}

/// Characters of an answer that a reason quotes.
const QUOTED: usize = 60;

/// The largest error of any propagating amplitude in a program's output, or why there is none.
///
/// # Errors
/// No JSON, a refusal, orders that are missing, twice there or not finite.
pub fn judge(output: &[u8], truth: &FarField) -> Result<f64, String> {
    let answer: Answer = serde_json::from_slice(output).map_err(|error| unreadable(output, &error))?;
    if let Some(reason) = answer.refusal {
        return Err(format!("refused: {}", quoted(&reason)));
    }
    let mut amplitudes = HashMap::new();
    for order in answer.orders.ok_or("the answer has neither `orders` nor `refusal`")? {
        let AnsweredOrder { m, n, side, amplitude: [re, im] } = order;
        if !(re.is_finite() && im.is_finite()) {
            return Err(format!("the amplitude of order ({m}, {n}) is not finite"));
        }
        if amplitudes.insert((m, n, side), Complex64::new(re, im)).is_some() {
            return Err(format!("order ({m}, {n}) is answered twice on one side"));
        }
    }
    let mut error = 0.0;
    for o in &truth.orders {
        let sides = [
            (AnsweredSide::Reflected, o.reflected_propagates, o.reflected),
            (AnsweredSide::Transmitted, o.transmitted_propagates, o.transmitted),
        ];
        for (side, _, amplitude) in sides.into_iter().filter(|(_, propagates, _)| *propagates) {
            let found = amplitudes.get(&(o.m, o.n, side)).ok_or_else(|| missing(o.m, o.n, side))?;
            error = f64::max(error, (found - amplitude).norm());
        }
    }
    if error < f64::INFINITY { Ok(error) } else { Err("an amplitude is beyond all bounds".into()) }
}

fn missing(m: i32, n: i32, side: AnsweredSide) -> String {
    let side = if side == AnsweredSide::Reflected { "reflected" } else { "transmitted" };
    format!("the {side} order ({m}, {n}) propagates and is not answered")
}

fn unreadable(output: &[u8], error: &serde_json::Error) -> String {
    if output.is_empty() {
        return "the program answered nothing".into();
    }
    format!("the answer is not as `inkwave schema external` says: {error} in {:?}", words(output))
}

/// The beginning of some output, without what a terminal would act upon.
pub(super) fn words(output: &[u8]) -> String {
    quoted(&String::from_utf8_lossy(&output[..output.len().min(4 * QUOTED)]))
}

fn quoted(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(QUOTED).collect()
}
