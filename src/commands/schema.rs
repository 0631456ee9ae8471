//! `inkwave schema`: JSON Schemas and commented examples of the input files.

use super::say::say;
use clap::Args;
use inkwave::schema::Document;
use miette::{IntoDiagnostic, Result};

/// Print the JSON Schema of an input file, for completion and checks in editors, or a file with
/// every key
#[derive(Args)]
pub struct SchemaArgs {
    /// Kind of input file
    #[arg(value_enum, default_value_t = Document::Study)]
    kind: Document,
    /// Print a commented file with every key, its meaning, range and default instead of the schema
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
