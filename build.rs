//! Tells the program which build it is: name, version and, where git knows it, the commit.

use std::path::Path;
use std::process::Command;

fn main() {
    let [folder, name, version] = ["CARGO_MANIFEST_DIR", "CARGO_PKG_NAME", "CARGO_PKG_VERSION"]
        .map(|key| std::env::var(key).unwrap_or_default());
    for path in ["build.rs", "src", "Cargo.toml"] {
        println!("cargo:rerun-if-changed={path}");
    }
    let commit = commit(Path::new(&folder)).map_or_else(String::new, |commit| format!(" ({commit})"));
    println!("cargo:rustc-env=INKWAVE_BUILD={name} {version}{commit}");
}

/// The commit, with a `+` where the sources have changes of their own; none outside the program's own repository.
fn commit(folder: &Path) -> Option<String> {
    let root = git(&["rev-parse", "--show-toplevel"])?;
    if Path::new(&root).canonicalize().ok()? != folder.canonicalize().ok()? {
        return None;
    }
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo:rerun-if-changed={log}");
    }
    git(&["describe", "--always", "--abbrev=10", "--dirty=+", "--exclude=*"])
}

fn git(arguments: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    let said = String::from_utf8(output.stdout).ok()?;
    Some(said.trim().to_owned()).filter(|said| !said.is_empty())
}
