//! Pages of variants that need not be made again: what a page and its numbers were made from, its
//! outcome, and the files that belong to it.

use super::outcome::Outcome;
use crate::report::publish::PublishResult;
use crate::run::Stores;
use crate::store::folder::{FolderError, OutputFolder};
use crate::store::identity::build;
use crate::store::safely::is_temporary;
use crate::store::{Key, Record, Store};
use crate::work::rounds::stored_seals;
use crate::work::variant::Variant;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::time::UNIX_EPOCH;

/// Hexadecimal digits of a file's checksum: 128 bits of BLAKE3.
const DIGITS: usize = 32;

/// The published results of a variant.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct KeptPage {
    /// Content hash of what they were made from.
    made_from: Key,
    /// Numbers for tables and conclusions of the sweep.
    outcome: Outcome,
    /// Contributions of the realisations to each weighted number, and to the difference to a
    /// target, which published numbers do not hold.
    of_numbers: Vec<Vec<(usize, f64)>>,
    of_target: Vec<(usize, f64)>,
    /// Checksum of every file of the variant's folder.
    files: BTreeMap<String, String>,
}

impl Record for KeptPage {
    const KIND: &'static str = "page";
}

/// The pages of a sweep that are kept, in its store.
pub(super) struct KeptPages<'a> {
    stores: &'a Stores,
    pages: Store<KeptPage>,
}

impl<'a> KeptPages<'a> {
    pub fn new(stores: &'a Stores) -> Self {
        Self { stores, pages: stores.of() }
    }

    /// The outcome of a variant whose page was made from what is stored now, by this program, and
    /// whose files are as they were written; `nothing` is its outcome without results.
    pub fn unchanged(&self, variant: &Variant, folder: &OutputFolder, nothing: &Outcome) -> Option<Outcome> {
        self.evaluated_with(variant, nothing, &checksums(folder).ok()?)
    }

    /// The outcome of a variant between others, which has no page.
    pub fn evaluated(&self, variant: &Variant, nothing: &Outcome) -> Option<Outcome> {
        self.evaluated_with(variant, nothing, &BTreeMap::new())
    }

    fn evaluated_with(
        &self,
        variant: &Variant,
        nothing: &Outcome,
        present: &BTreeMap<String, String>,
    ) -> Option<Outcome> {
        let KeptPage { made_from, mut outcome, of_numbers, of_target, files } =
            self.pages.get(key(variant).as_str())?;
        if made_from != self.made_from(variant) || files != *present {
            return None;
        }
        outcome.numbers.iter_mut().zip(of_numbers).for_each(|(note, by)| note.deviations = by);
        outcome.target.iter_mut().for_each(|target| target.deviations.clone_from(&of_target));
        // what the sweep's file calls the variant
        let Outcome { name, labels, aim, .. } = nothing.clone();
        Some(Outcome { name, labels, aim, ..outcome })
    }

    /// Keeps the outcome of a finished variant that is solved as a whole.
    ///
    /// # Errors
    /// Its files cannot be read, or the record cannot be written.
    pub fn keep(&self, variant: &Variant, folder: &OutputFolder, outcome: &Outcome) -> PublishResult {
        if !outcome.is_complete() || variant.study.composed().is_some() {
            return Ok(());
        }
        self.put(variant, outcome, checksums(folder)?)
    }

    /// Keeps the outcome of a variant between others, if it is solved as a whole.
    ///
    /// # Errors
    /// The record cannot be written.
    pub fn keep_evaluated(&self, variant: &Variant, outcome: &Outcome) -> PublishResult {
        if variant.study.composed().is_some() {
            return Ok(());
        }
        self.put(variant, outcome, BTreeMap::new())
    }

    fn put(&self, variant: &Variant, outcome: &Outcome, files: BTreeMap<String, String>) -> PublishResult {
        let page = KeptPage {
            made_from: self.made_from(variant),
            outcome: outcome.clone(),
            of_numbers: outcome.numbers.iter().map(|note| note.deviations.clone()).collect(),
            of_target: outcome.target.iter().flat_map(|target| target.deviations.clone()).collect(),
            files,
        };
        Ok(self.pages.put(key(variant).as_str(), &page)?)
    }

    /// Content hash of the program, of everything that the study holds, and of what is stored for
    /// it.
    fn made_from(&self, variant: &Variant) -> Key {
        let study = format!("{:?}", variant.study);
        Key::of("page", &(program(), study, stored_seals(&variant.study, self.stores)))
    }
}

/// The record of a variant's latest page.
fn key(variant: &Variant) -> Key {
    Key::of("variant", &variant.name)
}

/// The build, and size and time of its file: builds of changed sources have the same name.
fn program() -> (&'static str, Option<(u64, u128)>) {
    let file = std::env::current_exe().and_then(std::fs::metadata).ok();
    let written = file.and_then(|file| {
        let since = file.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        Some((file.len(), since.as_nanos()))
    });
    (build(), written)
}

/// The checksum of every file in a folder, by name, but for those that come and go.
fn checksums(folder: &OutputFolder) -> Result<BTreeMap<String, String>, FolderError> {
    let failed = FolderError::at(folder.path());
    let mut all = BTreeMap::new();
    for entry in std::fs::read_dir(folder.path()).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        // another process may be writing this page: temporary files, and those of the page before
        if is_temporary(&entry.path()) || entry.path().is_dir() {
            continue;
        }
        let bytes = match std::fs::read(entry.path()) {
            Err(gone) if gone.kind() == ErrorKind::NotFound => continue,
            read => read.map_err(failed)?,
        };
        let mut checksum = blake3::hash(&bytes).to_hex().to_string();
        checksum.truncate(DIGITS);
        all.insert(entry.file_name().to_string_lossy().into_owned(), checksum);
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::marker::Holds;

    /// Of a page that another process writes, the finished files count. *Planted*: temporary files,
    /// which vanish while they are read.
    #[test]
    fn files_that_are_being_written_have_no_checksum() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = OutputFolder::open(scratch.path(), Holds::Study).unwrap();
        let before = checksums(&folder).unwrap();
        std::fs::write(scratch.path().join(".inkwave-0.partial"), "half").unwrap();
        assert_eq!(checksums(&folder).unwrap(), before);
        std::fs::write(scratch.path().join("results.json"), "{}").unwrap();
        assert_eq!(checksums(&folder).unwrap().len(), before.len() + 1);
    }

    /// A file that vanishes between the listing and the reading; a link without a target is one.
    /// *Planted*: every file that is listed must be there.
    #[cfg(unix)]
    #[test]
    fn files_that_vanish_have_no_checksum() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = OutputFolder::open(scratch.path(), Holds::Study).unwrap();
        let before = checksums(&folder).unwrap();
        std::os::unix::fs::symlink("nowhere", scratch.path().join("results.json")).unwrap();
        assert_eq!(checksums(&folder).unwrap(), before);
    }
}
