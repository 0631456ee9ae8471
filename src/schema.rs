//! Descriptions of all input files: JSON Schemas, generated from the types that read them, for
//! completion and checks in editors, and a commented file with every key of each.
//! They are adapted to what the reader of the files accepts.

use crate::design::file::DesignFile;
use crate::evaluate::composed::composition::Composition;
use crate::evaluate::composed::library::Library;
use crate::fit::file::FitFile;
use crate::input::case_inputs::CaseInputs;
use crate::input::file::StudyFile;
use crate::report::columns::dictionary;
use crate::sweep::file::SweepFile;
use clap::ValueEnum;
use inkwave_bench::experiment::ComparisonFile;
use inkwave_bench::external::Protocol;
use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
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
    /// A target colour, for `design`.
    Design,
    /// One explicit geometry, for `solve` and `compare`.
    Case,
    /// What programs of comparisons are asked, and may answer.
    External,
    /// What the columns of all tables hold.
    Columns,
    /// Solved layers as plates, as `library` writes them.
    Library,
    /// A stack of a library's plates, for `compose`.
    Composition,
}

impl Document {
    /// A commented file of this kind with every key, its meaning, range and default.
    pub fn every_key(self) -> &'static str {
        match self {
            Document::Study => include_str!("../examples/every-key.toml"),
            Document::Sweep => include_str!("../examples/every-key-sweep.toml"),
            Document::Compare => include_str!("../examples/every-key-compare.toml"),
            Document::Fit => include_str!("../examples/fit/every-key.toml"),
            Document::Design => include_str!("../examples/design/every-key.toml"),
            Document::Case => include_str!("../examples/every-key-case.toml"),
            Document::External => include_str!("../schema/external.md"),
            Document::Columns => include_str!("../docs/columns.md"),
            Document::Library => include_str!("../schema/library.md"),
            Document::Composition => include_str!("../examples/library/every-key.toml"),
        }
    }

    /// Its JSON Schema (draft 7, which most editors know); of columns the list of them.
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
            Document::Columns => dictionary(),
            Document::Library => root::<Library>("Library of plates of inkwave").into(),
            Document::Composition => toml_schema::<Composition>("Composition of inkwave"),
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

/// Removes formats (`double`, `uint64`), which validators do not know, and defaults that cannot be
/// written in a file: null, and whole tables, whose keys have defaults of their own.
fn tidy(schema: &mut Schema) {
    schema.remove("format");
    let table = |value: &Value| value.is_object() && value.get("kind").is_none();
    if schema.get("default").is_some_and(|value| value.is_null() || table(value)) {
        schema.remove("default");
    }
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = for_readers(text);
    }
    transform_subschemas(&mut tidy, schema);
}

/// A doc comment without its links and line breaks.
fn for_readers(text: &str) -> String {
    let plain = text.replace("[`", "`").replace("`]", "`").replace("`crate::", "`").replace("`super::", "`");
    plain.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Removes null from the values allowed.
fn without_null(schema: &mut Schema) {
    if let Some(Value::Array(types)) = schema.get_mut("type") {
        types.retain(|kind| kind != "null");
        let only = types.first().filter(|_| types.len() == 1).cloned();
        only.into_iter().for_each(|only| drop(schema.insert("type".into(), only)));
    }
    if let Some(Value::Array(forms)) = schema.get_mut("anyOf") {
        forms.retain(|form| form["type"] != "null");
        if forms.len() == 1 {
            let forms = schema.remove("anyOf").unwrap_or_default();
            schema.insert("allOf".into(), forms);
        }
    }
    transform_subschemas(&mut without_null, schema);
}
