//! `inkwave schema`: the language of the input files, for editors and for people.

use super::say::say;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use inkwave::schema::Document;
use miette::{IntoDiagnostic, Result};

/// Print the JSON Schema of an input file, from which editors complete and underline, or a file with every key.
#[derive(Args)]
pub struct SchemaArgs {
    /// Kind of file: a study for `run` and `pack`, or what `sweep`, `compare` and `solve` read
    #[arg(default_value = "study", value_parser = kinds())]
    kind: Document,
    /// A commented file with every key, its meaning, range and default, instead of the schema
    #[arg(long)]
    annotated: bool,
}

fn kinds() -> impl TypedValueParser<Value = Document> {
    PossibleValuesParser::new(Document::ALL.map(Document::name))
        .map(|name| Document::ALL.into_iter().find(|kind| kind.name() == name).unwrap_or(Document::Study))
}

/// Runs the command.
pub fn run(args: &SchemaArgs) -> Result<()> {
    if args.annotated {
        return say(args.kind.every_key().trim_end());
    }
    say(serde_json::to_string_pretty(&args.kind.schema()).into_diagnostic()?)
}
