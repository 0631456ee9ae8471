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
//!
//! An outline is validated wherever its file comes from: names must stay inside the folder;
//! variants, axes and labels must exist. The checksum of `sweep.json` and the variants' studies
//! detects accidental changes, this check deliberate ones.

use super::claims::Claim;
use super::expand::is_folder_name;
use super::file::MeasuredQuantity;
use super::load::{Input, Outline, Sweep};
use crate::input::fault::StudyError;
use crate::input::load::load;
use crate::run::resolve::Resolved;
use crate::store::Record;
use crate::store::database::Database;
use crate::store::folder::{FolderError, OutputFolder};
use crate::store::marker::{Holds, Marker};
use crate::store::record::FailureRecord;
use crate::work::variant::Variant;
use serde::{Deserialize, Serialize};
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
    #[error("{0}")]
    NoSweep(String),
    /// Files differ from those that were written.
    #[error("{0}")]
    Changed(String),
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
    for (Variant { name, .. }, text) in sweep.variants.iter().zip(&sweep.texts) {
        make(folder.path().join(VARIANTS).join(name))?;
        folder.write(&format!("{VARIANTS}/{name}/study.toml"), text.as_bytes())?;
    }
    let outline =
        sealed(sweep).map_err(|error| FolderError::at(&folder.path().join(OUTLINE))(error.into()))?;
    folder.write(OUTLINE, &outline)
}

/// Content of `sweep.json`.
fn sealed(sweep: &Sweep) -> serde_json::Result<Vec<u8>> {
    let seal = Some(seal(&sweep.outline, sweep.texts.iter().map(String::as_str))?);
    serde_json::to_vec_pretty(&SealedOutline { outline: sweep.outline.clone(), seal })
}

/// Reads the sweep from its folder.
///
/// # Errors
/// The folder holds no sweep, or its files were changed or lost.
pub fn read(path: &Path) -> Result<Sweep, OpenError> {
    let no_sweep = |why: String| OpenError::NoSweep(format!("{} holds no sweep: {why}", path.display()));
    let unreadable = |error: &dyn Display| no_sweep(format!("{OUTLINE}: {error}"));
    let text = std::fs::read(path.join(OUTLINE)).map_err(|e| unreadable(&e))?;
    let SealedOutline { outline, seal: stated_seal } =
        serde_json::from_slice(&text).map_err(|e| unreadable(&e))?;
    check(&outline).map_err(|reason| unreadable(&reason))?;
    let since = format!("{} was changed since it was written", path.display());
    let changed = |what: &str| OpenError::Changed(format!("{since}: {what}"));
    let files = outline.variants.iter().map(|place| path.join(VARIANTS).join(&place.name).join("study.toml"));
    let files: Vec<PathBuf> = files.collect();
    let mut texts = Vec::new();
    for file in &files {
        let text = std::fs::read_to_string(file);
        texts.push(text.map_err(|error| no_sweep(format!("{}: {error}", file.display())))?);
    }
    let stated_seal =
        stated_seal.ok_or_else(|| changed("sweep.json has no checksum, like those of older versions"))?;
    if stated_seal != seal(&outline, texts.iter().map(String::as_str)).map_err(|e| unreadable(&e))? {
        return Err(changed("the checksum of sweep.json does not match it and the variants' study.toml"));
    }
    let mut variants = Vec::new();
    for (place, file) in outline.variants.iter().zip(&files) {
        variants.push(Variant { name: place.name.clone(), study: load(file)? });
    }
    let inputs = inputs(path).map_err(|e| no_sweep(format!("inputs: {e}")))?;
    match inputs.iter().find(|input| !input.is_whole()) {
        Some(input) => Err(changed(&format!("{} is not the table that was read", input.path))),
        None => Ok(Sweep { outline, variants, texts, inputs }),
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
    into.adopt(&from, &[Resolved::KIND, FailureRecord::KIND], &|_, _, _| true)?;
    Ok(from.keys(Resolved::KIND).len())
}

fn inputs(path: &Path) -> io::Result<Vec<Input>> {
    let mut inputs = Vec::new();
    let Ok(folders) = std::fs::read_dir(path.join("inputs")) else { return Ok(inputs) };
    for folder in folders {
        for file in std::fs::read_dir(folder?.path())? {
            let file = file?.path();
            let name = file.strip_prefix(path).unwrap_or(&file).to_string_lossy().into_owned();
            inputs.push(Input { path: name, bytes: std::fs::read(&file)? });
        }
    }
    inputs.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(inputs)
}

/// Content of `sweep.json`.
#[derive(Debug, Serialize, Deserialize)]
pub struct SealedOutline {
    /// Everything about the sweep except its studies.
    #[serde(flatten)]
    pub outline: Outline,
    /// Checksum of the outline and all studies; `None` in files of older versions.
    pub seal: Option<String>,
}

/// The first 128 bits of BLAKE3 over the outline and the studies as written, in hexadecimal.
///
/// # Errors
/// The outline cannot be written as JSON.
pub fn seal<'a>(outline: &Outline, studies: impl Iterator<Item = &'a str>) -> serde_json::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"inkwave sweep/").update(&serde_json::to_vec(outline)?);
    for text in studies {
        // including its length, so that text moved between files is noticed
        hasher.update(format!("/{}/", text.len()).as_bytes()).update(text.as_bytes());
    }
    Ok(hasher.finalize().to_hex()[..32].to_owned())
}

/// Checks an outline before any of its names is used as a path and any of its numbers as an index.
///
/// # Errors
/// A message with the field, what was found and what is allowed.
pub fn check(outline: &Outline) -> Result<(), String> {
    let count = outline.variants.len();
    for (i, variant) in outline.variants.iter().enumerate() {
        let name = &variant.name;
        let place = &variant.place;
        if !is_folder_name(name) || outline.variants[..i].iter().any(|other| other.name == *name) {
            let allowed = "names that differ, of folders under variants, of letters, digits and . _ + -";
            return Err(format!("variants[{i}].name: found {name:?}; allowed: {allowed}"));
        }
        let labels = place.iter().zip(&outline.axes);
        if place.len() != outline.axes.len() || !labels.into_iter().all(|(&k, axis)| k < axis.labels.len()) {
            return Err(format!("variants[{i}].place: found {place:?}; allowed: a label of every axis"));
        }
    }
    if outline.reference >= count {
        let found = outline.reference;
        return Err(format!("reference: found {found}; allowed: whole numbers below {count}"));
    }
    match outline.claims.iter().position(|claim| !names_variants(claim, count)) {
        Some(i) => {
            Err(format!("claims[{i}]: found other variants; allowed: those of the sweep, of delta_e two"))
        }
        None => Ok(()),
    }
}

/// Whether a conclusion's variants exist, in the number that its quantity compares.
fn names_variants(claim: &Claim, count: usize) -> bool {
    let compared = (claim.plus.len(), claim.minus.len());
    let fits =
        if claim.table.quantity == MeasuredQuantity::DeltaE { compared == (1, 1) } else { compared.0 > 0 };
    fits && claim.variants().all(|variant| variant < count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::definition::file::SheetTable;
    use crate::sweep::definition::load::{AxisOutline, Place};

    fn outline() -> Outline {
        let place = |name: &str, k: usize| Place { name: name.into(), place: vec![k] };
        Outline {
            title: "Tiny".into(),
            axes: vec![AxisOutline {
                name: "size".into(),
                labels: vec!["100".into(), "200".into()],
                unit: String::new(),
            }],
            sheet: SheetTable::default(),
            reference: 0,
            reference_asked: false,
            claims: Vec::new(),
            variants: vec![place("100", 0), place("200", 1)],
        }
    }

    #[test]
    fn names_stay_inside_the_folder() {
        assert_eq!(check(&outline()), Ok(()));
        for name in ["..", ".", "", "../../x", "/absolute/x", "a/b", "a\\b", "C:x", "a\0b"] {
            let mut altered = outline();
            altered.variants[1].name = name.into();
            let told = check(&altered).unwrap_err();
            assert!(told.starts_with("variants[1].name: found"), "{name:?}: {told}");
        }
        let mut twice = outline();
        twice.variants[1].name = "100".into();
        assert!(check(&twice).unwrap_err().contains("names that differ"));
    }

    #[test]
    fn numbers_are_those_of_something() {
        let mut altered = outline();
        altered.reference = 9;
        assert!(check(&altered).unwrap_err().starts_with("reference: found 9"));
        let mut altered = outline();
        altered.variants[0].place = vec![6];
        assert!(check(&altered).unwrap_err().starts_with("variants[0].place: found [6]"));
        let mut altered = outline();
        altered.variants[0].place = vec![0, 1];
        assert!(check(&altered).unwrap_err().starts_with("variants[0].place: found [0, 1]"));
    }
}
