//! From a path to a checked study.

use super::check::{check, check_packing};
use super::fault::{Fault, StudyError};
use super::file::StudyFile;
use super::study::Study;
use std::path::Path;

/// Reads and checks the study file at `path`. CSV files are looked for beside it.
///
/// # Errors
/// The file cannot be read, is no TOML, has unknown or missing keys, or has values that are not allowed.
pub fn load(path: &Path) -> Result<Study, StudyError> {
    load_with(path, check)
}

/// As [`load`], for the packings alone: what only the wave needs may be left out.
///
/// # Errors
/// As [`load`], without the faults of optical keys.
pub fn load_packing(path: &Path) -> Result<Study, StudyError> {
    load_with(path, check_packing)
}

type Check = fn(&StudyFile, &Path, &str) -> Result<Study, Vec<Fault>>;

fn load_with(path: &Path, check: Check) -> Result<Study, StudyError> {
    let unreadable = |source| StudyError::Unreadable { path: path.to_owned(), source };
    let text = std::fs::read_to_string(path).map_err(unreadable)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = path.file_stem().map_or_else(|| "study".into(), |stem| stem.to_string_lossy());
    let file: StudyFile = toml::from_str(&text).map_err(|error| syntax(path, &text, &error))?;
    let values = |faults| StudyError::Values { path: path.to_owned(), text: text.clone(), faults };
    check(&file, folder, &name).map_err(values)
}

pub(crate) fn syntax(path: &Path, text: &str, error: &toml::de::Error) -> StudyError {
    let message = error.message().trim().to_owned();
    let remedy = remedy(&message);
    StudyError::Syntax { path: path.to_owned(), text: text.to_owned(), span: error.span(), message, remedy }
}

/// What to try, from the wording of serde's messages.
pub(crate) fn remedy(message: &str) -> String {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    if message.starts_with("unknown") && !quoted.is_empty() {
        let (found, known) = (quoted[0], &quoted[1..]);
        let likeness = |name: &&&str| (1000.0 * strsim::jaro_winkler(found, name)) as u32;
        let nearest = known.iter().max_by_key(likeness).filter(|name| likeness(name) > 800);
        let meant = nearest.map_or_else(String::new, |name| format!("did you mean {name}? "));
        return format!("{meant}remove {found} or write one of: {}", known.join(", "));
    }
    if let ("missing field", Some(key)) = (message.get(..13).unwrap_or(""), quoted.first()) {
        return format!("add {key} to this table; examples/yellow.toml shows a whole study");
    }
    if message.starts_with("invalid") {
        return "write the value in the form that was expected; examples/yellow.toml shows a whole study"
            .into();
    }
    "correct the TOML here; https://toml.io shows its syntax".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_pen_gets_the_likely_key() {
        let told = remedy("unknown field `perod_um`, expected one of `period_um`, `thickness_um`");
        assert_eq!(told, "did you mean period_um? remove perod_um or write one of: period_um, thickness_um");
    }
}
