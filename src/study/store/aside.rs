//! Damaged files of records: put aside, and what is sound taken over.

use super::rows::{End, Rows, StoredRow};
use super::seal::Sealed;
use super::slot::Slot;
use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};

/// Files of records.
pub(super) const ROWS: &str = "sqlite";
/// Files that were damaged and are being taken over.
pub(super) const DAMAGED: &str = "damaged";

/// What ends a copy.
pub(super) enum Interruption {
    /// The file that is read.
    There(rusqlite::Error),
    /// The file that is written.
    Here(rusqlite::Error),
    Contradiction(Box<(Sealed, StoredRow)>),
}

impl From<rusqlite::Error> for Interruption {
    fn from(error: rusqlite::Error) -> Self {
        Self::There(error)
    }
}

/// Renames damaged files that no other process holds, closing those in `open`; gives the new names and what is wrong.
pub(super) fn put_aside(
    folder: &Path,
    slot: &Slot,
    open: &mut Vec<Rows>,
) -> io::Result<Vec<(PathBuf, String)>> {
    let mut reasons = Vec::new();
    for path in files_of(folder, ROWS)? {
        let number = path.file_stem().and_then(|stem| stem.to_str()?.parse().ok());
        let Some(number) = number else { continue };
        if number != slot.number() && Slot::is_held(folder, number) {
            continue;
        }
        let trouble = match Rows::read(&path) {
            Ok(rows) => rows.trouble(),
            Err(error) => Some(error.to_string()),
        };
        let Some(reason) = trouble else { continue };
        open.retain(|rows| rows.path() != path);
        let aside = path.with_extension(DAMAGED);
        std::fs::rename(&path, &aside)?;
        let log = log_of(&path);
        if log.exists() {
            std::fs::rename(log, log_of(&aside))?;
        }
        remove(&path)?;
        reasons.push((aside, reason));
    }
    Ok(reasons)
}

/// Copies what is sound, from both ends; gives the number of records saved.
pub(super) fn take_over(damaged: &Path, into: &Rows) -> rusqlite::Result<usize> {
    let Ok(from) = Rows::read(damaged) else { return Ok(0) };
    let mut saved = HashSet::new();
    let mut keep = |row: StoredRow| save(&row, into, &mut saved);
    into.at_once(|| {
        save_from(&from, End::First, &mut keep)?;
        save_from(&from, End::Last, &mut keep)
    })?;
    Ok(saved.len())
}

/// Copies a sound record whose kind and key are not among those `saved` before.
fn save(row: &StoredRow, into: &Rows, saved: &mut HashSet<(String, String)>) -> Result<(), Interruption> {
    if row.sealed.check(&row.kind, &row.key).is_ok() && saved.insert((row.kind.clone(), row.key.clone())) {
        into.put(row).map_err(Interruption::Here)?;
    }
    Ok(())
}

/// Gives the records to `keep`, from one end on as far as they can be read: the damage of this file is known already.
fn save_from(
    damaged: &Rows,
    end: End,
    keep: impl FnMut(StoredRow) -> Result<(), Interruption>,
) -> rusqlite::Result<()> {
    match damaged.scan(end, keep) {
        Err(Interruption::Here(error)) => Err(error),
        _ => Ok(()),
    }
}

/// Files with this extension, in the order of their numbers.
pub(super) fn files_of(folder: &Path, extension: &str) -> io::Result<Vec<PathBuf>> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?;
    let mut paths: Vec<PathBuf> =
        paths.into_iter().filter(|path| path.extension().is_some_and(|e| e == extension)).collect();
    paths.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
    Ok(paths)
}

/// SQLite's log beside a file.
fn log_of(path: &Path) -> PathBuf {
    with_suffix(path, "-wal")
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Removes a file and what SQLite keeps beside it, as far as they are there.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    for path in [path.to_owned(), log_of(path), with_suffix(path, "-shm")] {
        match std::fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    Ok(())
}
