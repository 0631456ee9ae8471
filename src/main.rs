//! The program: parses the command line, calls the library and prints errors.

#![forbid(unsafe_code)]

mod commands;

use clap::{CommandFactory, Parser, Subcommand};
use std::sync::LazyLock;

/// What identifies the program that made a result: version, commit and method.
static VERSION: LazyLock<String> = LazyLock::new(|| {
    let build = env!("INKWAVE_BUILD").trim_start_matches("inkwave ");
    format!("{build}, method {}", inkwave::store::identity::METHOD_VERSION)
});

/// Predict what a printer-ink or paint layer looks like before it exists
#[derive(Parser)]
#[command(version, long_version = VERSION.as_str(), about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a study: packings, wave solves, colour, picture and report
    Run(commands::run::RunArgs),
    Pack(commands::pack::PackArgs),
    Sweep(commands::sweep::SweepArgs),
    Merge(commands::merge::MergeArgs),
    Report(commands::merge::ReportArgs),
    Solve(commands::solve::SolveArgs),
    Fit(commands::inverse::FitArgs),
    Design(commands::inverse::DesignArgs),
    Compare(commands::compare::CompareArgs),
    Export(commands::export::ExportArgs),
    Library(commands::library::LibraryArgs),
    Compose(commands::library::ComposeArgs),
    Materials(commands::reference::MaterialsArgs),
    Schema(commands::reference::SchemaArgs),
    Completions(commands::reference::CompletionsArgs),
    Man(commands::reference::ManArgs),
}

fn main() -> miette::Result<()> {
    inkwave::store::set_build(env!("INKWAVE_BUILD"));
    let command = Cli::parse().command;
    if !matches!(command, Command::Completions(_) | Command::Man(_) | Command::Schema(_)) {
        commands::work::start_threads()?;
    }
    match command {
        Command::Run(args) => commands::run::run(&args),
        Command::Pack(args) => commands::pack::run(&args),
        Command::Compare(args) => commands::compare::run(&args),
        Command::Completions(args) => commands::reference::completions(&args, Cli::command()),
        Command::Man(args) => commands::reference::man(&args, Cli::command()),
        Command::Materials(args) => commands::reference::materials(&args),
        Command::Schema(args) => commands::reference::schema(&args),
        Command::Fit(args) => commands::inverse::fit(&args),
        Command::Design(args) => commands::inverse::design(&args),
        Command::Export(args) => commands::export::run(&args),
        Command::Library(args) => commands::library::library(&args),
        Command::Compose(args) => commands::library::compose(&args),
        Command::Sweep(args) => commands::sweep::run(&args),
        Command::Merge(args) => commands::merge::run(&args),
        Command::Report(args) => commands::merge::report(&args),
        Command::Solve(args) => commands::solve::run(args),
    }
}
