//! Quarantines damaged record files and salvages their intact records.

use super::rows::{End, Rows, StoredRow};
use super::seal::Sealed;
use super::slot::Slot;
use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};

/// Extension of record files.
pub(super) const ROWS: &str = "sqlite";
/// Extension of damaged files whose records are being salvaged.
pub(super) const DAMAGED: &str = "damaged";

/// Why a copy ended early.
pub(super) enum Interruption {
    /// The source file cannot be read.
    There(rusqlite::Error),
    /// The target file cannot be written.
    Here(rusqlite::Error),
    Contradiction(Box<(Sealed, StoredRow)>),
}

impl From<rusqlite::Error> for Interruption {
    fn from(error: rusqlite::Error) -> Self {
        Self::There(error)
    }
}

/// Renames damaged files that no other process holds and closes those in `open`; returns the new
/// names and what is wrong.
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

/// Copies the intact records, reading from both ends; returns their number.
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

/// Copies an intact record unless its kind and key are among those already `saved`.
fn save(row: &StoredRow, into: &Rows, saved: &mut HashSet<(String, String)>) -> Result<(), Interruption> {
    if row.sealed.check(&row.kind, &row.key).is_ok() && saved.insert((row.kind.clone(), row.key.clone())) {
        into.put(row).map_err(Interruption::Here)?;
    }
    Ok(())
}

/// Passes the records to `keep`, starting at one end, as far as they can be read. Errors are
/// ignored because the damage of this file is already known.
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

/// Files with this extension, ordered by number.
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

/// SQLite's write-ahead log beside a file.
fn log_of(path: &Path) -> PathBuf {
    with_suffix(path, "-wal")
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Removes a file, if it exists, and what SQLite keeps beside it.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    for path in [path.to_owned(), log_of(path), with_suffix(path, "-shm")] {
        match std::fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    Ok(())
}
