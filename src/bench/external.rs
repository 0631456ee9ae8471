//! Programs of any language as rows of a comparison: what a file says of them, and their runs.

pub mod judge;
mod process;
pub mod protocol;
mod tree;

use super::error::CompareResult;
use super::row::{Row, Varied};
use crate::input::case::Case;
use crate::input::fault::Faults;
use crate::input::wave_kind::WaveKind;
use crate::solve::Watch;
use judge::{ExpectedOrder, ReadAnswer};
use process::ProgramRun;
use protocol::{ProgramDescription, ProgramRequest};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;
use std::path::{Path, PathBuf, absolute};
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
    #[schemars(length(min = 1), example = ("python3", "treams_adapter.py"))]
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

/// Question, answer and description, for the schema.
#[derive(JsonSchema)]
#[allow(dead_code, reason = "only its schema is used")]
pub struct Protocol {
    request: ProgramRequest,
    answer: protocol::Answer,
    description: ProgramDescription,
}

/// A case as it is put to programs.
pub(super) struct CaseAsked<'a> {
    pub varied: Option<Varied>,
    /// The keys of a case file, or why the case has none.
    pub inputs: &'a Result<Value, String>,
    pub case: &'a Case,
    pub wave: WaveKind,
    pub expected: &'a [ExpectedOrder],
    /// Where commands are started.
    pub folder: &'a Path,
}

/// What one start of a program is to solve.
pub(super) struct ProtocolQuestion {
    /// The keys of a case file.
    pub inputs: Value,
    pub wave: WaveKind,
    pub knob: Option<f64>,
}

impl ExternalTable {
    /// Values of the knob; one run without where there are none.
    pub(super) fn knobs(&self) -> Vec<Option<f64>> {
        if self.knob.is_empty() { vec![None] } else { self.knob.iter().copied().map(Some).collect() }
    }

    /// Reports what cannot be run; `taken` are the names of other rows.
    pub(super) fn check(&self, taken: &[String], faults: &mut Faults) {
        let positive = "a finite number above 0";
        let usable = |limit: f64| limit.is_finite() && limit > 0.0;
        let named = !self.name.trim().is_empty() && !taken.contains(&self.name);
        let started = self.command.first().is_some_and(|program| !program.is_empty());
        let rules = [
            (named, "name", format!("{:?}", self.name), "a name that no strategy and no other program has"),
            (started, "command", "empty".into(), "a program and its arguments"),
            (usable(self.time_limit_s), "time_limit_s", self.time_limit_s.to_string(), positive),
            (usable(self.memory_gb), "memory_gb", self.memory_gb.to_string(), positive),
            (self.knob.iter().all(|k| k.is_finite()), "knob", format!("{:?}", self.knob), "finite numbers"),
        ];
        for (_, key, found, allowed) in rules.into_iter().filter(|rule| !rule.0) {
            faults.add(format!("external.{key}"), found, allowed, "correct the [[external]] table");
        }
    }

    /// What the program says of itself with `--describe`; none where it does not.
    ///
    /// # Errors
    /// The user stopped it.
    pub(super) fn described(
        &self,
        folder: &Path,
        watch: &mut dyn Watch,
    ) -> CompareResult<Option<ProgramDescription>> {
        let run = self.started(folder, &["--describe"], String::new(), watch)?;
        let output = run.ok().and_then(|run| run.outcome().ok().map(<[u8]>::to_vec));
        Ok(output.and_then(|output| ProgramDescription::of(&output)))
    }

    /// One row: the program's orders judged, or the reason why there are none.
    ///
    /// # Errors
    /// The user stopped it.
    pub(super) fn row(
        &self,
        question: &CaseAsked,
        knob: Option<f64>,
        described: Option<&ProgramDescription>,
        watch: &mut dyn Watch,
    ) -> CompareResult<Row> {
        let mut row = Row { knob, ..Row::new(question.varied, &self.name, None) };
        let refusal = described.and_then(|d| d.refusal(question.case, question.wave));
        let inputs = match (question.inputs, refusal) {
            (Ok(inputs), None) => inputs.clone(),
            (Err(reason), _) => return Ok(Row { result: Err(reason.clone()), ..row }),
            (_, Some(reason)) => return Ok(Row { result: Err(reason), ..row }),
        };
        let asked = ProtocolQuestion { inputs, wave: question.wave, knob };
        let answer = self.ask(asked, question.folder, &mut row, watch)?;
        row.own_seconds = answer.as_ref().ok().and_then(|answer| answer.seconds);
        row.result = answer.and_then(|answer| answer.error(question.expected));
        Ok(row)
    }

    /// Asks for the orders of a case; time and memory go into the row.
    ///
    /// # Errors
    /// The user stopped it.
    pub(super) fn ask(
        &self,
        question: ProtocolQuestion,
        folder: &Path,
        row: &mut Row,
        watch: &mut dyn Watch,
    ) -> CompareResult<Result<ReadAnswer, String>> {
        let Self { time_limit_s, memory_gb, .. } = *self;
        let ProtocolQuestion { inputs, wave, knob } = question;
        let case = blake3::hash(inputs.to_string().as_bytes()).to_hex()[..12].to_owned();
        let request = ProgramRequest { case, inputs, wave, knob, time_limit_s, memory_gb };
        let text = serde_json::to_string(&request).unwrap_or_default();
        let run = match self.started(folder, &[], text, watch)? {
            Ok(run) => run,
            Err(reason) => return Ok(Err(format!("{} cannot be started: {reason}", self.command[0]))),
        };
        row.seconds = Some(run.seconds);
        row.processor_seconds = run.processor_seconds;
        row.bytes = run.peak_bytes as usize;
        Ok(run.outcome().and_then(|output| ReadAnswer::of(output, &request.case)))
    }

    /// Starts the program and waits for its end.
    fn started(
        &self,
        folder: &Path,
        more: &[&str],
        input: String,
        watch: &mut dyn Watch,
    ) -> CompareResult<Result<ProgramRun, std::io::Error>> {
        let mut command = Command::new(self.program(folder));
        command.args(&self.command[1..]).args(more);
        if !folder.as_os_str().is_empty() {
            command.current_dir(folder);
        }
        ProgramRun::of(command, input.into_bytes(), self, watch)
    }

    /// The program to start: a path with folders counts from the folder of the file.
    fn program(&self, folder: &Path) -> PathBuf {
        let program = PathBuf::from(&self.command[0]);
        let inside = folder.join(&program);
        if program.components().count() > 1 { absolute(&inside).unwrap_or(inside) } else { program }
    }
}
