//! Conformity of a program: a film, a grating and a sphere whose answers are known, and common
//! mistakes by name.
//!
//! The cases are small, without symmetry, and lit from directions of the reciprocal lattice, so
//! that programs with periodic boundaries solve them as well.

mod slips;

use super::error::CompareResult;
use super::external::judge::{ExpectedOrder, ReadAnswer, expected};
use super::external::{ExternalTable, ProtocolQuestion};
use super::row::Row;
use crate::input::case::Case;
use crate::input::wave_kind::WaveKind;
use crate::run::memory;
use crate::solve::accuracy::{Task, suited_scheme};
use crate::solve::{Coverages, Gmres, Goal, Watch};
use crate::wave::{Mean, Precision};
use serde_json::{Value, json};
use slips::{CASE_SLIPS, OrderSlip, SLIPS, SlipLight, changed};
use std::f64::consts::TAU;
use std::path::Path;

/// Largest amplitude error of a program that conforms: coarse enough for any method's first grid,
/// fine enough to tell all slips apart.
pub const TOLERANCE: f64 = 0.03;

/// What the check of a program found.
#[derive(Clone, Debug)]
pub struct Conformity {
    /// One line for each case: its name, and the error or why there is none.
    pub cases: Vec<(String, Result<f64, String>)>,
    /// What the answers mean together.
    pub verdict: ConformityVerdict,
}

/// What the answers of a program mean together.
#[derive(Clone, Debug, PartialEq)]
pub enum ConformityVerdict {
    /// Every case that it does not refuse agrees.
    Conforms,
    /// Slips, each of which explains all answers, with what to do about them.
    Slips(Vec<[String; 2]>),
    /// Some answers are wrong, and no known slip explains them.
    Unknown,
    /// No case was answered.
    Silent,
}

/// A case with its answer.
struct Answered {
    known: KnownCase,
    expected: Vec<ExpectedOrder>,
    answer: ReadAnswer,
}

/// Asks a program for the known cases of both waves and judges its answers.
///
/// # Errors
/// The user stopped it.
pub fn check(program: &ExternalTable, folder: &Path, watch: &mut dyn Watch) -> CompareResult<Conformity> {
    let described = program.described(folder, watch)?.unwrap_or_default();
    let knob = program.knob.first().copied();
    let mut cases = Vec::new();
    let mut answered = Vec::new();
    for wave in [WaveKind::Scalar, WaveKind::Vector] {
        for known in KNOWN.map(|name| KnownCase::new(name, wave)) {
            let name = format!("{}, {}", known.name, wave.name());
            if let Some(reason) = described.refusal(&known.case()?, wave) {
                cases.push((name, Err(reason)));
                continue;
            }
            let mut row = Row::new(None, &program.name, None);
            let question = ProtocolQuestion { inputs: known.inputs.clone(), wave, knob };
            match program.ask(question, folder, &mut row, watch)? {
                Err(reason) => cases.push((name, Err(reason))),
                Ok(answer) => {
                    let expected = known.orders(watch)?;
                    cases.push((name, answer.error(&expected)));
                    answered.push(Answered { known, expected, answer });
                }
            }
        }
    }
    let verdict = verdict(&answered, failed(&cases), watch)?;
    Ok(Conformity { cases, verdict })
}

/// Whether a case failed otherwise than by a refusal.
fn failed(cases: &[(String, Result<f64, String>)]) -> bool {
    let refused = |reason: &String| reason.starts_with("refused") || reason.starts_with("not asked");
    cases.iter().any(|(_, result)| result.as_ref().is_err_and(|reason| !refused(reason)))
}

fn verdict(answered: &[Answered], failed: bool, watch: &mut dyn Watch) -> CompareResult<ConformityVerdict> {
    if answered.is_empty() {
        return Ok(if failed { ConformityVerdict::Unknown } else { ConformityVerdict::Silent });
    }
    let within = |orders: &dyn Fn(&Answered) -> Vec<ExpectedOrder>| {
        answered.iter().all(|a| a.answer.error(&orders(a)).is_ok_and(|error| error <= TOLERANCE))
    };
    if within(&|a| a.expected.clone()) {
        return Ok(if failed { ConformityVerdict::Unknown } else { ConformityVerdict::Conforms });
    }
    let explains = |slips: &[&OrderSlip]| within(&|a| changed(&a.expected, slips, &a.known.light()));
    let single = SLIPS.iter().filter(|slip| explains(&[slip]));
    let mut found: Vec<[String; 2]> = single.map(|slip| [slip.name.into(), slip.remedy.into()]).collect();
    for slip in &CASE_SLIPS {
        if found.is_empty() && explains_case(slip.act, answered, watch)? {
            found.push([slip.name.into(), slip.remedy.into()]);
        }
    }
    if found.is_empty() {
        found = pairs(explains);
    }
    Ok(if found.is_empty() { ConformityVerdict::Unknown } else { ConformityVerdict::Slips(found) })
}

/// Whether the answers are right for cases that were changed before they were solved.
fn explains_case(change: fn(&mut Value), all: &[Answered], watch: &mut dyn Watch) -> CompareResult<bool> {
    for Answered { known, answer, .. } in all {
        let mut other = known.clone();
        change(&mut other.inputs);
        if !answer.error(&other.orders(watch)?).is_ok_and(|error| error <= TOLERANCE) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Pairs of slips that explain the answers together.
fn pairs(explains: impl Fn(&[&OrderSlip]) -> bool) -> Vec<[String; 2]> {
    let mut explaining = Vec::new();
    for (k, first) in SLIPS.iter().enumerate() {
        for second in SLIPS[k + 1..].iter().filter(|second| explains(&[first, second])) {
            let joint = |a: &str, b: &str| format!("{a}, and {b}");
            explaining.push([joint(first.name, second.name), joint(first.remedy, second.remedy)]);
        }
    }
    explaining
}

/// Names of the cases.
pub const KNOWN: [&str; 3] = ["film", "grating", "sphere"];

/// Amplitude error of inkwave's own solution, far below [`TOLERANCE`].
const ACCURACY: f64 = 1e-3;

/// A case with a known answer.
#[derive(Clone, Debug)]
pub struct KnownCase {
    /// Its name.
    pub name: &'static str,
    /// The equation.
    pub wave: WaveKind,
    /// The keys of a case file.
    pub inputs: Value,
}

impl KnownCase {
    /// One of [`KNOWN`], for a wave.
    pub fn new(name: &'static str, wave: WaveKind) -> KnownCase {
        let inputs = match name {
            "film" => film(),
            "grating" => grating(),
            _ => sphere(),
        };
        KnownCase { name, wave, inputs }
    }

    /// The case, checked.
    ///
    /// # Errors
    /// None for the cases as they are.
    pub fn case(&self) -> CompareResult<Case> {
        Ok(Case::parse(&self.inputs.to_string(), false)?)
    }

    /// All orders that propagate, as inkwave solves them.
    ///
    /// # Errors
    /// The user stopped it.
    pub fn orders(&self, watch: &mut dyn Watch) -> CompareResult<Vec<ExpectedOrder>> {
        let case = self.case()?;
        let wave = self.wave.wave();
        let task = Task {
            coverages: &Coverages::new(wave, &case.scene, Precision::of(Precision::error_for(ACCURACY))),
            media: &case.media,
            incidence: &case.incidence,
            mean: Mean { depends_on_z: true, absorbing: true },
            scheme: wave.scheme(suited_scheme(ACCURACY)),
            solver: &Gmres::default(),
            goal: Goal { tolerance: ACCURACY / 50.0, ..Goal::default() },
            memory: memory::usable(),
        };
        Ok(expected(&task.solve_to_accuracy(ACCURACY, watch)?.far_fields))
    }

    /// What slips depend on; the half-spaces of the known cases are real.
    fn light(&self) -> SlipLight {
        let number = |key: &str| self.inputs[key].as_f64().unwrap_or_default();
        let k0 = TAU / number("wavelength");
        let (sin, cos) = number("sigma_deg").to_radians().sin_cos();
        let (y, x) = number("phi_deg").to_radians().sin_cos();
        let lateral = [sin * x, sin * y];
        let step = [0, 1].map(|axis| {
            let period_um = self.inputs["L"][axis].as_f64().unwrap_or(1.0);
            TAU / period_um / k0
        });
        SlipLight { kappa: cos, height: k0 * number("H"), exit: number("n_out"), lateral, step }
    }
}

/// Two films, the first absorbing, on glass; kx is one step of a lattice of 1 µm.
fn film() -> Value {
    json!({
        "wavelength": 0.5, "sigma_deg": 30.0, "phi_deg": 0.0, "L": [1.0, 1.0], "H": 0.35, "n_in": 1.0, "n_out": 1.5,
        "layers_from_z0": [{ "thickness": 0.2, "eta": [1.8, 0.1] }, { "thickness": 0.15, "eta": [1.4, 0.0] }],
    })
}

/// Two different bars under a film; kx is one step of the lattice.
fn grating() -> Value {
    let bars = json!([
        { "x0": 0.1, "x1": 0.35, "eta": [1.9, 0.0] },
        { "x0": 0.5, "x1": 0.65, "eta": [1.6, 0.2] },
    ]);
    json!({
        "wavelength": 0.54, "sigma_deg": 0.6_f64.asin().to_degrees(), "phi_deg": 0.0, "L": [0.9, 0.9], "H": 0.4,
        "n_in": 1.0, "n_out": 1.5,
        "sublayers_from_z0": [
            { "thickness": 0.1, "eta_background": [1.5, 0.0], "bars": [] },
            { "thickness": 0.3, "eta_background": [1.3, 0.0], "bars": bars },
        ],
    })
}

/// One absorbing sphere off the centre of a rectangular cell; ky is one step of the lattice.
fn sphere() -> Value {
    json!({
        "wavelength": 0.5, "sigma_deg": 0.625_f64.asin().to_degrees(), "phi_deg": 90.0, "L": [0.6, 0.8], "H": 0.45,
        "n_in": 1.0, "n_out": 1.33, "eta_binder": [1.5, 0.0],
        "spheres": [{ "center": [0.2, 0.5, 0.22], "radius": 0.15, "eta": [1.9, 0.1] }],
    })
}
