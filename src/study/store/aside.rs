//! Quarantines damaged record files and salvages their intact records.

use super::rows::Rows;
use super::safely;
use super::seal::Sealed;
use super::slot::Slot;
use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};

/// Extension of record files.
pub(super) const ROWS: &str = "sqlite";
/// Extension of damaged files whose records are being salvaged.
pub(super) const DAMAGED: &str = "damaged";
/// Suffix of SQLite's write-ahead log beside a file.
const LOG: &str = "-wal";

/// Renames damaged files that no other process holds and closes those in `open`; returns the new
/// names and what is wrong.
pub(super) fn put_aside(
    folder: &Path,
    own_number: u32,
    open: &mut Vec<Rows>,
) -> io::Result<Vec<(PathBuf, String)>> {
    let mut reasons = Vec::new();
    for path in files_of(folder, ROWS)? {
        let Some(number) = path.file_stem().and_then(|stem| stem.to_str()?.parse().ok()) else { continue };
        if number != own_number && Slot::is_held(folder, number) {
            continue;
        }
        let trouble = Rows::read(&path).map_or_else(|error| Some(error.to_string()), |rows| rows.trouble());
        let Some(reason) = trouble else { continue };
        open.retain(|rows| rows.path != path);
        let aside = path.with_extension(DAMAGED);
        std::fs::rename(&path, &aside)?;
        let log = with_suffix(&path, LOG);
        if log.exists() {
            std::fs::rename(log, with_suffix(&aside, LOG))?;
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
    let mut keep = |record: Sealed| {
        let is_new = record.check().is_ok() && saved.insert((record.kind.clone(), record.key.clone()));
        if is_new { into.put(&record) } else { Ok(()) }
    };
    // What cannot be read is damage that is already known.
    let mut save = |newest_first| from.scan(newest_first, &mut keep).unwrap_or(Ok(()));
    into.at_once(|| save(false).and_then(|()| save(true)))?;
    Ok(saved.len())
}

/// Files with this extension, ordered by number.
pub(super) fn files_of(folder: &Path, extension: &str) -> io::Result<Vec<PathBuf>> {
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?;
    paths.retain(|path| path.extension().is_some_and(|e| e == extension));
    paths.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
    Ok(paths)
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Removes a file, if it exists, and what SQLite keeps beside it.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    ["", LOG, "-shm"].into_iter().try_for_each(|suffix| safely::remove(&with_suffix(path, suffix)))
}
