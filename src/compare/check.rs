//! Conformity of a program: a film, a grating and a sphere whose answers are known, and the usual
//! slips by name.

mod case_slips;
mod cases;
mod slips;

use super::error::CompareError;
use super::external::ExternalTable;
use super::external::judge::{ExpectedOrder, ReadAnswer};
use super::external::protocol::WaveKind;
use super::row::Row;
use crate::solve::Watch;
use case_slips::CASE_SLIPS;
pub use cases::{KNOWN, KnownCase};
use slips::{OrderSlip, SLIPS, changed};
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
pub fn check(
    program: &ExternalTable,
    folder: &Path,
    watch: &mut dyn Watch,
) -> Result<Conformity, CompareError> {
    let described = program.described(folder, watch)?.unwrap_or_default();
    let knob = program.knob.first().copied();
    let (mut cases, mut answered) = (Vec::new(), Vec::new());
    for wave in [WaveKind::Scalar, WaveKind::Vector] {
        for known in KNOWN.map(|name| KnownCase::new(name, wave)) {
            let name = format!("{}, {}", known.name, wave.name());
            if let Some(reason) = described.refusal(&known.case()?, wave) {
                cases.push((name, Err(reason)));
                continue;
            }
            let mut row = Row::new(None, &program.name, None);
            let question = (known.inputs.clone(), wave, knob);
            match program.asked(question, folder, &mut row, watch)? {
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

fn verdict(
    answered: &[Answered],
    failed: bool,
    watch: &mut dyn Watch,
) -> Result<ConformityVerdict, CompareError> {
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
fn explains_case(
    change: fn(&mut serde_json::Value),
    answered: &[Answered],
    watch: &mut dyn Watch,
) -> Result<bool, CompareError> {
    for Answered { known, answer, .. } in answered {
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
    let mut found = Vec::new();
    for (k, first) in SLIPS.iter().enumerate() {
        for second in SLIPS[k + 1..].iter().filter(|second| explains(&[first, second])) {
            let joint = |a: &str, b: &str| format!("{a}, and {b}");
            found.push([joint(first.name, second.name), joint(first.remedy, second.remedy)]);
        }
    }
    found
}
