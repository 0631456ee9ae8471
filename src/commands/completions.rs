//! `inkwave completions SHELL` and `inkwave man FOLDER`: generated from the definitions behind
//! `--help`.

use super::say::say;
use clap::{Args, Command};
use clap_complete::Shell;
use miette::{IntoDiagnostic, WrapErr};
use std::path::PathBuf;

/// Print the completion script for a shell
///
/// For example: inkwave completions bash > ~/.local/share/bash-completion/completions/inkwave
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// Shell to complete for
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Write the man pages, one per command, to a folder
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Output folder (created if missing)
    pub folder: PathBuf,
}

/// Prints the completions.
pub fn completions(args: &CompletionsArgs, mut command: Command) -> miette::Result<()> {
    let name = command.get_name().to_owned();
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, name, &mut text);
    say(String::from_utf8_lossy(&text).trim_end())
}

/// Writes the pages.
pub fn man(args: &ManArgs, command: Command) -> miette::Result<()> {
    let cannot = || format!("cannot write to {}", args.folder.display());
    std::fs::create_dir_all(&args.folder).into_diagnostic().wrap_err_with(cannot)?;
    clap_mangen::generate_to(command, &args.folder).into_diagnostic().wrap_err_with(cannot)?;
    say!("man pages: {}", args.folder.display())
}
