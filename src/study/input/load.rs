//! Reads a study file and checks it.

use super::check::{check, check_packing};
use super::fault::{Fault, StudyError, SyntaxFault};
use super::file::StudyFile;
use super::read::{read, without_control_characters};
use super::study::Study;
use super::tree::{Node, parse_json, parse_toml};
use crate::numerics::files;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Reads and checks the study file at `path`. CSV files are relative to its folder.
///
/// # Errors
/// The file cannot be read, is not TOML, has unknown or missing keys, or values that are not
/// allowed.
pub fn load(path: &Path) -> Result<Study, StudyError> {
    load_with(path, check)
}

/// Like [`load`], with all layers as plates of a library: solved between half-spaces of one index,
/// `stack.composed.joint_index`, or that of the first binder.
///
/// # Errors
/// As for [`load`], and what a composed stack cannot hold.
pub fn load_plates(path: &Path) -> Result<Study, StudyError> {
    load_with(path, |file, folder, name| {
        let mut plates = file.clone();
        plates.make_plates(file.title.as_deref().unwrap_or(name));
        check(&plates, folder, name)
    })
}

/// Like [`load`], for packings only: what only the wave needs is optional.
///
/// # Errors
/// As for [`load`], without errors in optical keys.
pub fn load_packing(path: &Path) -> Result<Study, StudyError> {
    load_with(path, check_packing)
}

type Check = fn(&StudyFile, &Path, &str) -> Result<Study, Vec<Fault>>;

fn load_with(path: &Path, check: Check) -> Result<Study, StudyError> {
    let (text, file) = read_study(path)?;
    let checked = check(&file, path.parent().unwrap_or(Path::new("")), &stem(path));
    checked.map_err(|faults| StudyError::Values { path: path.to_owned(), text, faults })
}

/// Reads a study file without checking it; returns its text and its content.
///
/// # Errors
/// As of [`read_file`].
pub fn read_study(path: &Path) -> Result<(String, StudyFile), StudyError> {
    read_file(path)
}

/// Reads the tables of a study, as they stand in another file.
///
/// # Errors
/// All unknown keys, and the first value that is missing or of the wrong type, each with its path.
pub fn read_table(table: toml::Table) -> Result<StudyFile, Vec<Fault>> {
    read(table.into())
}

/// Name of a file without its extension: the default title.
pub fn stem(path: &Path) -> String {
    without_control_characters(&path.file_stem().unwrap_or_default().to_string_lossy())
}

/// Reads a TOML file; returns its text and its content.
///
/// # Errors
/// The file cannot be read, is not TOML, has unknown or missing keys, or values of the wrong type.
pub fn read_file<T: DeserializeOwned>(path: &Path) -> Result<(String, T), StudyError> {
    read_parsed(path, |text| parse_toml(text).map(Node::from))
}

/// Reads a file of TOML, or of JSON if its name ends so.
///
/// # Errors
/// As of [`read_file`].
pub fn read_toml_or_json<T: DeserializeOwned>(path: &Path) -> Result<T, StudyError> {
    let is_json = path.extension().is_some_and(|ending| ending == "json");
    if is_json { read_parsed(path, parse_json) } else { read_file(path) }.map(|(_, value)| value)
}

fn read_parsed<T: DeserializeOwned>(
    path: &Path,
    parse: impl FnOnce(&str) -> Result<Node, SyntaxFault>,
) -> Result<(String, T), StudyError> {
    let text = files::read_text(path, files::STUDY)
        .map_err(|source| StudyError::Unreadable { path: path.to_owned(), source })?;
    match read(parse(&text).map_err(|fault| fault.in_file(path, &text))?) {
        Ok(value) => Ok((text, value)),
        Err(faults) => Err(StudyError::Values { path: path.to_owned(), text, faults }),
    }
}
