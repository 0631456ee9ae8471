//! The folder of a sweep.
//!
//! ```text
//! sweep.json                    axes, variants, conclusions
//! inputs/…                      tables read by variants
//! variants/<name>/study.toml    each variant as a study of its own, beside its results
//! records/                      the store shared by all variants
//! inkwave.json                  marks the folder
//! sweep.csv  conclusions.csv  contact-sheet*.png  report.html
//! PARTIAL                       present while unfinished
//! ```

use super::load::{Input, Sweep, Variant};
use super::seal::{SealedOutline, seal};
use super::sound;
use crate::input::fault::StudyError;
use crate::input::load::load;
use crate::run::resolve::Resolved;
use crate::store::Record;
use crate::store::database::Database;
use crate::store::folder::{FolderError, OutputFolder};
use crate::store::marker::{Holds, Marker};
use crate::store::record::FailureRecord;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

/// File with the outline of the sweep.
pub const OUTLINE: &str = "sweep.json";
/// Folder of the variants.
pub const VARIANTS: &str = "variants";

/// Why a folder cannot be read as a sweep.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The folder holds no sweep.
    #[error("{} holds no sweep: {reason}", path.display())]
    NoSweep {
        /// The folder.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// Files differ from those that were written.
    #[error("{} was changed since it was written: {what}", path.display())]
    Changed {
        /// The folder.
        path: PathBuf,
        /// What does not match.
        what: String,
    },
    /// The study of a variant cannot be read.
    #[error(transparent)]
    Variant(#[from] StudyError),
}

/// Writes everything needed to report on the folder without the sweep file.
///
/// # Errors
/// A file cannot be written.
pub fn write(sweep: &Sweep, folder: &OutputFolder) -> Result<(), FolderError> {
    let make = |path: PathBuf| std::fs::create_dir_all(&path).map_err(FolderError::at(&path));
    for Input { path, bytes } in &sweep.inputs {
        make(folder.path().join(path).parent().unwrap_or(Path::new("")).to_owned())?;
        folder.write(path, bytes)?;
    }
    for Variant { name, text, .. } in &sweep.variants {
        make(folder.path().join(VARIANTS).join(name))?;
        folder.write(&format!("{VARIANTS}/{name}/study.toml"), text.as_bytes())?;
    }
    let outline =
        sealed(sweep).map_err(|error| FolderError::at(&folder.path().join(OUTLINE))(error.into()))?;
    folder.write(OUTLINE, &outline)
}

/// Content of `sweep.json`.
fn sealed(sweep: &Sweep) -> serde_json::Result<Vec<u8>> {
    let seal = Some(seal(&sweep.outline, sweep.variants.iter().map(|variant| variant.text.as_str()))?);
    serde_json::to_vec_pretty(&SealedOutline { outline: sweep.outline.clone(), seal })
}

/// Reads the sweep from its folder.
///
/// # Errors
/// The folder holds no sweep, or its files were changed or lost.
pub fn read(path: &Path) -> Result<Sweep, OpenError> {
    let no_sweep = |reason: String| OpenError::NoSweep { path: path.to_owned(), reason };
    let unreadable = |error: &dyn Display| no_sweep(format!("{OUTLINE}: {error}"));
    let text = std::fs::read(path.join(OUTLINE)).map_err(|e| unreadable(&e))?;
    let SealedOutline { outline, seal: found } = serde_json::from_slice(&text).map_err(|e| unreadable(&e))?;
    sound::check(&outline).map_err(|reason| unreadable(&reason))?;
    let changed = |what: &str| OpenError::Changed { path: path.to_owned(), what: what.to_owned() };
    let files = outline.variants.iter().map(|place| path.join(VARIANTS).join(&place.name).join("study.toml"));
    let files: Vec<PathBuf> = files.collect();
    let mut texts = Vec::new();
    for file in &files {
        let text = std::fs::read_to_string(file);
        texts.push(text.map_err(|error| no_sweep(format!("{}: {error}", file.display())))?);
    }
    let found = found.ok_or_else(|| changed("sweep.json has no checksum, like those of older versions"))?;
    if found != seal(&outline, texts.iter().map(String::as_str)).map_err(|e| unreadable(&e))? {
        return Err(changed("the checksum of sweep.json does not match it and the variants' study.toml"));
    }
    let mut variants = Vec::new();
    for ((place, file), text) in outline.variants.iter().zip(&files).zip(texts) {
        variants.push(Variant { name: place.name.clone(), study: load(file)?, text });
    }
    let inputs = inputs(path).map_err(|e| no_sweep(format!("inputs: {e}")))?;
    match inputs.iter().find(|input| !input.is_whole()) {
        Some(input) => Err(changed(&format!("{} is not the table that was read", input.path))),
        None => Ok(Sweep { outline, variants, inputs }),
    }
}

/// Copies the grids of another folder, including those that could not be chosen; returns their
/// number.
///
/// # Errors
/// The other folder holds no sweep, or the records cannot be written.
pub fn take_grids(from: &Path, folder: &OutputFolder) -> io::Result<usize> {
    if Marker::read(from).is_none_or(|marker| marker.inkwave_folder != Holds::Sweep || !marker.is_readable())
    {
        return Err(io::Error::other("no folder of a sweep: write one with --grids-only"));
    }
    let (from, into) = (Database::open(from)?, Database::open(folder.path())?);
    into.adopt(&from, &[Resolved::KIND, FailureRecord::KIND], |_, _, _| true)?;
    Ok(from.keys(Resolved::KIND).len())
}

fn inputs(path: &Path) -> io::Result<Vec<Input>> {
    let mut found = Vec::new();
    let Ok(folders) = std::fs::read_dir(path.join("inputs")) else { return Ok(found) };
    for folder in folders {
        for file in std::fs::read_dir(folder?.path())? {
            let file = file?.path();
            let name = file.strip_prefix(path).unwrap_or(&file).to_string_lossy().into_owned();
            found.push(Input { path: name, bytes: std::fs::read(&file)? });
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}
