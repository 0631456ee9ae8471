//! The mark of a folder with unfinished work, and the command that resumes it.

use std::path::Path;

/// File that marks a folder as unfinished.
pub const PARTIAL: &str = "PARTIAL";
/// Precedes the command.
const INDENT: &str = "    ";

/// Text of the mark.
pub(super) fn text(go_on: Option<&str>) -> String {
    let begun =
        "The work here is unfinished, and files may be from an earlier run. The same command resumes it";
    match go_on {
        Some(command) => format!("{begun}:\n\n{INDENT}{command}\n"),
        None => format!("{begun}.\n"),
    }
}

/// The command that resumes the work in a folder, if its mark contains one.
pub fn go_on(folder: &Path) -> Option<String> {
    let text = std::fs::read_to_string(folder.join(PARTIAL)).ok()?;
    text.lines().find_map(|line| line.strip_prefix(INDENT)).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_tells_how_to_go_on() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(go_on(folder.path()), None);
        for command in [None, Some("inkwave run yellow.toml --output 'my ink'")] {
            std::fs::write(folder.path().join(PARTIAL), text(command)).unwrap();
            assert_eq!(go_on(folder.path()).as_deref(), command);
        }
    }
}
