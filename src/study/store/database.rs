//! The store of a folder: sealed records, in one SQLite file per writing process.
//!
//! Every process reads all files and writes only its own. Processes therefore never wait for each
//! other, and a damaged file is never written to again: its intact records are copied, the rest
//! counts as absent.

use super::aside::{DAMAGED, ROWS, files_of, put_aside, remove, take_over};
use super::queue::{Queue, QueueError};
use super::rows::Rows;
use super::seal::{Damage, Sealed};
use super::slot::Slot;
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Subfolder that holds the records.
pub const RECORDS: &str = "records";

/// All records of a folder.
#[derive(Debug, Default)]
pub struct Database {
    /// `None` if in memory.
    folder: Option<PathBuf>,
    files: Mutex<Files>,
    /// By record or file.
    damages: Mutex<BTreeMap<String, Damage>>,
}

#[derive(Debug, Default)]
struct Files {
    /// The file of this process, created with its first record.
    own: Option<Own>,
    others: Vec<Rows>,
}

#[derive(Debug)]
struct Own {
    rows: Rows,
    slot: Option<Slot>,
}

/// Whether two contents of a kind agree.
pub type Agreement<'a> = dyn Fn(&str, &[u8], &[u8]) -> bool + 'a;

/// Why a copy ended early.
enum Interruption {
    /// The target file cannot be written.
    Unwritable(rusqlite::Error),
    Contradiction(Box<[Sealed; 2]>),
}

impl From<rusqlite::Error> for Interruption {
    fn from(error: rusqlite::Error) -> Self {
        Self::Unwritable(error)
    }
}

impl Files {
    fn all(&self) -> impl Iterator<Item = &Rows> {
        self.own.iter().map(|own| &own.rows).chain(&self.others)
    }
}

impl Database {
    /// Opens the records in [`RECORDS`] below `folder`; there may be none yet.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn open(folder: &Path) -> io::Result<Self> {
        let database = Self { folder: Some(folder.join(RECORDS)), ..Self::default() };
        database.refresh()?;
        Ok(database)
    }

    /// Opens a store in memory.
    ///
    /// # Errors
    /// SQLite cannot be started.
    pub fn in_memory() -> io::Result<Self> {
        let own = Own { rows: Rows::in_memory().map_err(io::Error::other)?, slot: None };
        Ok(Self { files: Mutex::new(Files { own: Some(own), others: Vec::new() }), ..Self::default() })
    }

    /// Opens files that other processes have created since.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn refresh(&self) -> io::Result<()> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let mut files = lock(&self.files);
        for path in files_of(folder, ROWS)? {
            if files.all().any(|rows| rows.path == path) {
                continue;
            }
            match Rows::read(&path) {
                // another process is creating it: it is read the next time
                Ok(rows) if !rows.is_begun() && is_held(folder, &path) => (),
                Ok(rows) => files.others.push(rows),
                Err(error) => self.note_file(&path, error),
            }
        }
        Ok(())
    }

    /// The intact record with this key; damaged ones are noted and count as absent.
    pub fn get(&self, kind: &str, key: &str) -> Option<Vec<u8>> {
        let mut fault = None;
        for rows in lock(&self.files).all() {
            match rows.get(kind, key) {
                Ok(None) => {}
                Ok(Some(sealed)) => match sealed.check() {
                    Ok(()) => return Some(sealed.content),
                    Err(found) => fault = Some(found),
                },
                Err(error) => self.note_file(&rows.path, error),
            }
        }
        if let Some(fault) = fault {
            self.note(Damage::Record { kind: kind.to_owned(), key: key.to_owned(), fault });
        }
        None
    }

    /// The seal that is stored with a record, which is not read: it tells records of different
    /// content apart, not damaged ones from intact ones.
    pub fn seal(&self, kind: &str, key: &str) -> Option<Vec<u8>> {
        lock(&self.files).all().find_map(|rows| rows.seal(kind, key).ok().flatten())
    }

    /// Stores a record permanently.
    ///
    /// # Errors
    /// The record cannot be written.
    pub fn put(&self, kind: &str, key: &str, content: Vec<u8>) -> io::Result<()> {
        let mut files = lock(&self.files);
        let rows = &self.own(&mut files)?.rows;
        rows.put(&Sealed::new(kind, key, content)).map_err(|error| failed(&rows.path, &error))
    }

    /// Deletes a record from all files, or all records of a kind.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn remove(&self, kind: &str, key: Option<&str>) -> io::Result<()> {
        let files = lock(&self.files);
        files.all().try_for_each(|rows| rows.remove(kind, key).map_err(|error| failed(&rows.path, &error)))
    }

    /// Copies the intact records of `kinds` (of all kinds if empty) that this store lacks, in one
    /// transaction; damaged ones are noted in the source store. Stops at a record that contradicts
    /// the one stored here, according to `same`, and returns both.
    ///
    /// # Errors
    /// This store cannot be written.
    pub fn adopt(&self, from: &Self, kinds: &[&str], same: &Agreement) -> io::Result<Option<[Sealed; 2]>> {
        let mut files = lock(&self.files);
        let into = &self.own(&mut files)?.rows;
        let is_chosen = |row: &Sealed| kinds.is_empty() || kinds.contains(&row.kind.as_str());
        let mut adopt = |row: Sealed| if is_chosen(&row) { from.hand_over(row, into, same) } else { Ok(()) };
        let mut adopt_all = |rows: &Rows| {
            let unreadable = |error| Ok(from.note_file(&rows.path, error));
            rows.scan(false, &mut adopt).unwrap_or_else(unreadable)
        };
        let others = lock(&from.files);
        match into.at_once(|| others.all().try_for_each(&mut adopt_all)) {
            Ok(()) => Ok(None),
            Err(Interruption::Contradiction(both)) => Ok(Some(*both)),
            Err(Interruption::Unwritable(error)) => Err(failed(&into.path, &error)),
        }
    }

    /// Copies an intact record into a file that lacks it; a damaged one is noted.
    fn hand_over(&self, row: Sealed, into: &Rows, same: &Agreement) -> Result<(), Interruption> {
        if let Err(fault) = row.check() {
            return Ok(self.note(Damage::Record { kind: row.kind, key: row.key, fault }));
        }
        match into.get(&row.kind, &row.key)? {
            None => Ok(into.put(&row)?),
            Some(here) if same(&row.kind, &here.content, &row.content) => Ok(()),
            Some(here) => Err(Interruption::Contradiction(Box::new([here, row]))),
        }
    }

    /// Sorted keys of all records of a kind, damaged ones included.
    pub fn keys(&self, kind: &str) -> BTreeSet<String> {
        let mut keys = BTreeSet::new();
        for rows in lock(&self.files).all() {
            match rows.keys(kind) {
                Ok(keys_there) => keys.extend(keys_there),
                Err(error) => self.note_file(&rows.path, error),
            }
        }
        keys
    }

    /// True if there are no records.
    pub fn is_empty(&self) -> bool {
        lock(&self.files).all().all(|rows| rows.is_empty())
    }

    /// Joins the work called `name` in this folder, or starts it.
    ///
    /// # Errors
    /// Other work is in progress there, or the folder cannot be written.
    pub fn queue(&self, name: &str) -> Result<Queue, QueueError> {
        let mut files = lock(&self.files);
        match (&self.folder, &self.own(&mut files)?.slot) {
            (Some(folder), Some(slot)) => Queue::join(folder, slot, name),
            _ => Err(QueueError::Place(io::Error::other("the store is in memory"))),
        }
    }

    /// Notes damage; it replaces an earlier note on the same record or file.
    pub(super) fn note(&self, damage: Damage) {
        lock(&self.damages).insert(damage.subject(), damage);
    }

    /// All damage found so far.
    pub fn damages(&self) -> Vec<Damage> {
        lock(&self.damages).values().cloned().collect()
    }

    fn note_file(&self, path: &Path, reason: impl ToString) {
        self.note(Damage::File { path: path.to_owned(), reason: reason.to_string() });
    }

    /// This process's file, created when first needed.
    fn own<'a>(&self, files: &'a mut Files) -> io::Result<&'a Own> {
        let own = files.own.take().map_or_else(|| self.begin(files), Ok)?;
        Ok(files.own.insert(own))
    }

    /// Reserves a slot and quarantines damaged files before anything is written.
    fn begin(&self, files: &mut Files) -> io::Result<Own> {
        let folder = self.folder.as_deref().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        let slot = Slot::first_free(folder)?;
        let path = folder.join(format!("{}.{ROWS}", slot.number));
        let reasons = put_aside(folder, slot.number, &mut files.others)?;
        files.others.retain(|rows| rows.path != path);
        let rows = Rows::create(&path).map_err(|error| failed(&path, &error))?;
        for damaged in files_of(folder, DAMAGED)? {
            let saved = take_over(&damaged, &rows).map_err(|error| failed(&path, &error))?;
            let known = reasons.iter().find(|(name, _)| *name == damaged);
            let reason = known.map_or("left behind damaged", |(_, reason)| reason.as_str());
            let reason = format!("{reason}; {saved} intact records were saved");
            self.note_file(&damaged.with_extension(ROWS), reason);
            remove(&damaged)?;
        }
        Ok(Own { rows, slot: Some(slot) })
    }
}

/// Whether a process holds the slot of a record file.
fn is_held(folder: &Path, path: &Path) -> bool {
    let number = path.file_stem().and_then(|stem| stem.to_str()?.parse().ok());
    number.is_some_and(|number| Slot::is_held(folder, number))
}

fn failed(path: &Path, error: &rusqlite::Error) -> io::Error {
    io::Error::other(format!("{}: {error}", path.display()))
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
#[path = "database_tests.rs"]
mod tests;
