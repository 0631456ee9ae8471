//! Programs of any language as rows of a comparison: what a file says of them, and their runs.

mod process;
pub mod protocol;

use super::error::CompareError;
use super::row::{Row, Varied};
use crate::solve::Watch;
use crate::wave::FarField;
use process::{Limits, ProgramRun};
use protocol::{ProgramRequest, judge};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// A program of another project, asked for the orders of each case by a JSON text on its standard
/// input.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExternalTable {
    /// Name of its rows.
    #[schemars(length(min = 1), example = &"treams")]
    pub name: String,
    /// The program and its arguments, started in the folder of this file.
    #[schemars(length(min = 1), example = ["python3", "treams_adapter.py"])]
    pub command: Vec<String>,
    /// Values of its own knob for accuracy, one row each; none when left out.
    #[serde(default)]
    pub knob: Vec<f64>,
    /// Wall time after which it is killed, s.
    #[serde(default = "minute")]
    pub time_limit_s: f64,
    /// Memory of all its processes beyond which it is killed, GB.
    #[serde(default = "gigabytes")]
    pub memory_gb: f64,
}

fn minute() -> f64 {
    60.0
}

fn gigabytes() -> f64 {
    4.0
}

/// A case as it is put to programs.
pub(super) struct CaseAsked<'a> {
    pub varied: Option<Varied>,
    /// The keys of a case file, or why the case has none.
    pub inputs: &'a Result<Value, String>,
    pub truth: &'a FarField,
    /// Where commands are started.
    pub folder: &'a Path,
}

impl ExternalTable {
    /// Values of the knob; one run without where there are none.
    pub(super) fn knobs(&self) -> Vec<Option<f64>> {
        if self.knob.is_empty() { vec![None] } else { self.knob.iter().copied().map(Some).collect() }
    }

    /// Refuses what cannot be run; `taken` are the names of other rows.
    ///
    /// # Errors
    /// The field, what was found and what is allowed.
    pub(super) fn check(&self, taken: &[String]) -> Result<(), CompareError> {
        let limits = [("time_limit_s", self.time_limit_s), ("memory_gb", self.memory_gb)];
        let wrong = limits.into_iter().find(|(_, limit)| !(limit.is_finite() && *limit > 0.0));
        let knob = self.knob.iter().find(|knob| !knob.is_finite());
        let (key, found, allowed) = if self.name.trim().is_empty() || taken.contains(&self.name) {
            ("name", format!("{:?}", self.name), "a name that no strategy and no other program has")
        } else if self.command.first().is_none_or(|program| program.is_empty()) {
            ("command", "empty".into(), "a program and its arguments")
        } else if let Some((key, limit)) = wrong {
            (key, limit.to_string(), "a finite number above 0")
        } else if let Some(knob) = knob {
            ("knob", knob.to_string(), "finite numbers")
        } else {
            return Ok(());
        };
        let (field, allowed) = (format!("external.{key}"), allowed.to_string());
        Err(CompareError::Field { field, found, allowed, remedy: "correct the [[external]] table" })
    }

    /// One row: the program's orders judged, or the reason why there are none.
    ///
    /// # Errors
    /// The user stopped it.
    pub(super) fn row(
        &self,
        question: &CaseAsked,
        knob: Option<f64>,
        watch: &mut dyn Watch,
    ) -> Result<Row, CompareError> {
        let mut row = Row { knob, ..Row::new(question.varied, &self.name, None) };
        let inputs = match question.inputs {
            Ok(inputs) => inputs.clone(),
            Err(reason) => return Ok(Row { result: Err(reason.clone()), ..row }),
        };
        let Self { time_limit_s, memory_gb, .. } = *self;
        let request = ProgramRequest { inputs, wave: "scalar".into(), knob, time_limit_s, memory_gb };
        let limits = Limits { seconds: time_limit_s, bytes: 1e9 * memory_gb };
        let mut command = Command::new(&self.command[0]);
        command.args(&self.command[1..]).current_dir(question.folder);
        let run = match ProgramRun::of(command, request.to_string().into_bytes(), limits, watch)? {
            Ok(run) => run,
            Err(reason) => {
                let reason = format!("{} cannot be started: {reason}", self.command[0]);
                return Ok(Row { result: Err(reason), ..row });
            }
        };
        row.seconds = Some(run.seconds);
        row.processor_seconds = run.processor_seconds;
        row.bytes = run.peak_bytes as usize;
        row.result = run.outcome().and_then(|output| judge(output, question.truth));
        Ok(row)
    }
}
