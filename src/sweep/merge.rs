//! Joins the stores of several shards into one folder.

use super::folder;
use super::folder::{FAILURES, OpenError};
use super::load::Sweep;
use crate::store::folder::{FolderError, GRIDS, OutputFolder, PACKINGS, POINTS};
use crate::store::record::PointRecord;
use std::io;
use std::path::{Path, PathBuf};

/// Why shards cannot be joined.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    #[error(transparent)]
    Open(#[from] OpenError),
    #[error(transparent)]
    Folder(#[from] FolderError),
    #[error("{} is of another sweep than {}", other.display(), first.display())]
    OtherSweep { first: PathBuf, other: PathBuf },
    #[error("{} differs from the record of the same inputs in another shard", path.display())]
    Contradiction { path: PathBuf },
    #[error("cannot read or copy {}: {source}", path.display())]
    Copy { path: PathBuf, source: io::Error },
}

/// Copies the records of all shards into `folder`; gives the sweep that they belong to.
///
/// # Errors
/// Shards of different sweeps, records of the same key that differ, or files that cannot be read or written.
pub fn merge(shards: &[PathBuf], folder: &OutputFolder) -> Result<Sweep, MergeError> {
    let first = shards.first().map_or(Path::new(""), PathBuf::as_path);
    let sweep = folder::read(first)?;
    for shard in &shards[1..] {
        let other = folder::read(shard)?;
        let texts = |s: &Sweep| s.variants.iter().map(|v| v.text.clone()).collect::<Vec<_>>();
        if other.outline != sweep.outline || texts(&other) != texts(&sweep) || other.inputs != sweep.inputs {
            return Err(MergeError::OtherSweep { first: first.to_owned(), other: shard.clone() });
        }
    }
    folder.begin()?;
    folder::write(&sweep, folder)?;
    for store in [POINTS, PACKINGS, GRIDS, FAILURES] {
        folder.inside(store)?;
        for shard in shards {
            copy_store(&shard.join(store), store, folder)?;
        }
    }
    drop_settled_failures(folder)?;
    Ok(sweep)
}

fn copy_store(from: &Path, store: &str, folder: &OutputFolder) -> Result<(), MergeError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        |source| MergeError::Copy { path, source }
    };
    for name in names(from).map_err(failed(from))? {
        let source = from.join(&name);
        let bytes = std::fs::read(&source).map_err(failed(&source))?;
        let there = std::fs::read(folder.path().join(store).join(&name)).ok();
        match there {
            Some(there) if store != POINTS || same_point(&there, &bytes) => {}
            Some(_) => return Err(MergeError::Contradiction { path: source }),
            None => folder.write(&format!("{store}/{name}"), &bytes)?,
        }
    }
    Ok(())
}

/// Names of the records in a store; none where there is no store.
fn names(folder: &Path) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    match std::fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        entries => {
            for entry in entries? {
                names.push(entry?.file_name().to_string_lossy().into_owned());
            }
        }
    }
    names.retain(|name| name.ends_with(".json") && !name.starts_with('.'));
    names.sort_unstable();
    Ok(names)
}

/// Equal in every number but the seconds that the solve took.
fn same_point(one: &[u8], other: &[u8]) -> bool {
    let read = |bytes| {
        let mut record: PointRecord = serde_json::from_slice(bytes).ok()?;
        record.account.seconds = 0.0;
        Some(record)
    };
    read(one) == read(other)
}

/// A solve that succeeded in one shard is no failure of another.
fn drop_settled_failures(folder: &OutputFolder) -> Result<(), MergeError> {
    let failures = folder.path().join(FAILURES);
    let names = names(&failures).map_err(|source| MergeError::Copy { path: failures, source })?;
    let mut settled = names.iter().filter(|name| folder.path().join(POINTS).join(name).exists());
    settled.try_for_each(|name| folder.remove(&format!("{FAILURES}/{name}")).map_err(MergeError::from))
}
