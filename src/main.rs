//! Parse, call the library, tell errors well.

mod commands;

use clap::{Parser, Subcommand};

/// Predicts what a printer-ink or paint layer looks like before it exists.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a study: packings, wave solves, colour, picture and report
    Run(commands::run::RunArgs),
}

fn main() -> miette::Result<()> {
    match Arguments::parse().command {
        Command::Run(args) => commands::run::run(&args),
    }
}
