//! The kinds of input files and their schemas.

use super::tidy::{tidy, without_null};
use crate::compare::experiment::ComparisonFile;
use crate::compare::external::Protocol;
use crate::design::file::DesignFile;
use crate::fit::file::FitFile;
use crate::input::case_inputs::CaseInputs;
use crate::input::file::StudyFile;
use crate::sweep::file::SweepFile;
use clap::ValueEnum;
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, json_schema};
use serde_json::Value;

/// A kind of input file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Document {
    /// One ink: for `run`, `pack`, `sweep` (as its base) and `compare`.
    Study,
    /// Many variants of a study, for `sweep`.
    Sweep,
    /// Strategies side by side, for `compare`.
    Compare,
    /// Measured drawdowns, for `fit`.
    Fit,
    /// A wanted colour, for `design`.
    Design,
    /// One explicit geometry, for `solve` and `compare`.
    Case,
    /// What programs of comparisons are asked, and may answer.
    External,
}

impl Document {
    /// A commented file of this kind with every key, its meaning, range and default.
    pub fn every_key(self) -> &'static str {
        match self {
            Document::Study => include_str!("../../examples/every-key.toml"),
            Document::Sweep => include_str!("../../examples/every-key-sweep.toml"),
            Document::Compare => include_str!("../../examples/every-key-compare.toml"),
            Document::Fit => include_str!("../../examples/fit/every-key.toml"),
            Document::Design => include_str!("../../examples/design/every-key.toml"),
            Document::Case => include_str!("../../examples/every-key-case.toml"),
            Document::External => include_str!("../../schema/external.md"),
        }
    }

    /// Its JSON Schema (draft 7, which most editors know).
    pub fn schema(self) -> Value {
        match self {
            Document::Study => toml_schema::<StudyFile>("Study of inkwave"),
            Document::Sweep => toml_schema::<SweepFile>("Sweep of inkwave"),
            Document::Compare => toml_schema::<ComparisonFile>("Comparison of inkwave"),
            Document::Fit => toml_schema::<FitFile>("Fit of inkwave"),
            Document::Design => toml_schema::<DesignFile>("Design of inkwave"),
            Document::Case => case_schema(),
            Document::External => {
                root::<Protocol>("Question and answer of programs in comparisons of inkwave").into()
            }
        }
    }
}

fn root<T: JsonSchema>(title: &str) -> Schema {
    let mut schema = SchemaSettings::draft07().into_generator().into_root_schema_for::<T>();
    schema.insert("title".into(), title.into());
    tidy(&mut schema);
    schema
}

/// TOML has no null.
fn toml_schema<T: JsonSchema>(title: &str) -> Value {
    let mut schema = root::<T>(title);
    without_null(&mut schema);
    schema.into()
}

/// The inputs themselves, or an object that holds them as `inputs`, as reference cases do.
fn case_schema() -> Value {
    let mut inputs = root::<CaseInputs>("Case of inkwave");
    let mut take = |key: &str| inputs.remove(key).unwrap_or_default();
    let [schema, title, mut definitions] = ["$schema", "title", "definitions"].map(&mut take);
    definitions["Case"] = inputs.into();
    let inputs = json_schema!({ "$ref": "#/definitions/Case" });
    json_schema!({
        "$schema": schema,
        "title": title,
        "anyOf": [
            { "type": "object", "properties": { "inputs": inputs }, "required": ["inputs"] },
            inputs,
        ],
        "definitions": definitions,
    })
    .into()
}
