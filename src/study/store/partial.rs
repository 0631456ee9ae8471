//! The mark of a folder whose work is not finished, with the command that goes on.

use std::path::Path;

/// Marks a folder whose study is not finished.
pub const PARTIAL: &str = "PARTIAL";
/// Stands before the command.
const INDENT: &str = "    ";

/// What the mark says.
pub(super) fn text(go_on: Option<&str>) -> String {
    let begun = "The work here is not finished, and files may be of an earlier run. The same command goes on";
    match go_on {
        Some(command) => format!("{begun}:\n\n{INDENT}{command}\n"),
        None => format!("{begun}.\n"),
    }
}

/// The command that goes on with a folder, if its mark has it.
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
