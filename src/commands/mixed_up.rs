//! Recognises files meant for another command.

use inkwave::input::fault::StudyError;
use inkwave::input::tree::parse_toml;
use miette::{Report, miette};

/// Error for a study given to `inkwave sweep`, or a sweep given to `inkwave run`, by the tables that
/// only one of them has; `None` if that is not what is wrong.
pub(super) fn not_for(error: &StudyError, wanted: &str) -> Option<Report> {
    let StudyError::Values { path, text, .. } = error else { return None };
    let table = parse_toml(text).ok()?;
    let has = |keys: [&str; 2]| keys.iter().any(|key| table.contains_key(*key));
    let (found, command) = match (has(["layer", "pigment"]), has(["base", "axis"])) {
        (true, false) if wanted == "sweep" => ("study", "run"),
        (false, true) if wanted == "study" => ("sweep", "sweep"),
        _ => return None,
    };
    let path = path.display();
    let help = format!("run it with `inkwave {command} {path}`");
    Some(miette!(help = help, "{path} is a {found}, and this command reads a {wanted}"))
}
