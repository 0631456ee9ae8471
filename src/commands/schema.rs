//! `inkwave schema`: the language of the input files, for editors and for people.

use super::say::say;
use clap::Args;
use inkwave::schema::Document;
use miette::{IntoDiagnostic, Result};

/// Print the JSON Schema of an input file, from which editors complete and underline, or a file with every key.
#[derive(Args)]
pub struct SchemaArgs {
    /// Kind of file: a study for `run` and `pack`, or what `sweep`, `compare` and `solve` read
    #[arg(value_enum, default_value_t = Document::Study)]
    kind: Document,
    /// Print a commented file with every key, its meaning, range and default instead
    #[arg(long)]
    annotated: bool,
}

/// Runs the command.
pub fn run(args: &SchemaArgs) -> Result<()> {
    if args.annotated {
        return say(args.kind.every_key().trim_end());
    }
    say(serde_json::to_string_pretty(&args.kind.schema()).into_diagnostic()?)
}
