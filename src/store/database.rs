//! The packed store of a folder: sealed records in one SQLite file for each process that writes.
//!
//! Everybody reads all files and writes its own. So processes never wait for one another, and a file that was damaged
//! is never written to again: what is sound in it is taken over, what is lost counts as absent.

use super::damage::Damage;
use super::queue::{Queue, QueueError, Task};
use super::rows::{End, Row, Rows};
use super::seal::Sealed;
use super::slot::Slot;
use std::collections::{BTreeSet, HashSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Where a folder keeps its records.
pub const RECORDS: &str = "records";
/// Files of records.
const ROWS: &str = "sqlite";
/// Files that were damaged and are being taken over.
const DAMAGED: &str = "damaged";

/// All records of a folder.
#[derive(Debug)]
pub struct Database {
    /// `None` in memory.
    folder: Option<PathBuf>,
    files: Mutex<Files>,
    damages: Mutex<Damages>,
}

#[derive(Debug, Default)]
struct Files {
    /// This process's own file, from the first record on.
    own: Option<Own>,
    others: Vec<Rows>,
}

#[derive(Debug)]
struct Own {
    rows: Rows,
    slot: Option<Slot>,
}

#[derive(Debug, Default)]
struct Damages {
    found: Vec<Damage>,
    known: HashSet<String>,
}

/// What ends a copy.
enum Interruption {
    /// The file that is read.
    There(rusqlite::Error),
    /// The file that is written.
    Here(rusqlite::Error),
    Contradiction(Box<(Sealed, Row)>),
}

impl From<rusqlite::Error> for Interruption {
    fn from(error: rusqlite::Error) -> Self {
        Self::There(error)
    }
}

impl Files {
    fn all(&self) -> impl Iterator<Item = &Rows> {
        self.own.iter().map(|own| &own.rows).chain(&self.others)
    }
}

impl Database {
    /// The records below `folder` (in its [`RECORDS`]), of which there may be none yet.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn open(folder: &Path) -> io::Result<Self> {
        let database =
            Self { folder: Some(folder.join(RECORDS)), files: Mutex::default(), damages: Mutex::default() };
        database.refresh()?;
        Ok(database)
    }

    /// A store that lives as long as the value.
    ///
    /// # Errors
    /// SQLite cannot be started.
    pub fn in_memory() -> io::Result<Self> {
        let own = Own { rows: Rows::in_memory().map_err(io::Error::other)?, slot: None };
        let files = Mutex::new(Files { own: Some(own), others: Vec::new() });
        Ok(Self { folder: None, files, damages: Mutex::default() })
    }

    /// Looks for files that other processes have begun since.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn refresh(&self) -> io::Result<()> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let mut files = lock(&self.files);
        for path in files_of(folder, ROWS)? {
            if files.all().any(|rows| rows.path() == path) {
                continue;
            }
            match Rows::read(&path) {
                Ok(rows) => files.others.push(rows),
                Err(error) => self.note_file(&path, &error.to_string(), None),
            }
        }
        Ok(())
    }

    /// The sound record of this name; a damaged one is noted and counts as absent.
    pub fn get(&self, kind: &str, key: &str) -> Option<Vec<u8>> {
        let files = lock(&self.files);
        let mut fault = None;
        for rows in files.all() {
            match rows.get(kind, key) {
                Ok(None) => {}
                Ok(Some(sealed)) => match sealed.check(kind, key) {
                    Ok(()) => return Some(sealed.content),
                    Err(found) => fault = Some(found),
                },
                Err(error) => self.note_file(rows.path(), &error.to_string(), None),
            }
        }
        if let Some(fault) = fault {
            self.note(Damage::Record { kind: kind.to_owned(), key: key.to_owned(), fault });
        }
        None
    }

    /// Keeps a record for good.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn put(&self, kind: &str, key: &str, content: Vec<u8>) -> io::Result<()> {
        let row = Row { kind: kind.to_owned(), key: key.to_owned(), sealed: Sealed::new(kind, key, content) };
        self.writing(|rows| rows.put(&row))
    }

    /// Forgets a record, in all files.
    ///
    /// # Errors
    /// They cannot be written to.
    pub fn remove(&self, kind: &str, key: &str) -> io::Result<()> {
        let files = lock(&self.files);
        files.all().try_for_each(|rows| rows.remove(kind, key).map_err(|error| failed(rows.path(), &error)))
    }

    /// Forgets all records of a kind, in all files.
    ///
    /// # Errors
    /// They cannot be written to.
    pub fn remove_all(&self, kind: &str) -> io::Result<()> {
        let files = lock(&self.files);
        files.all().try_for_each(|rows| rows.remove_all(kind).map_err(|error| failed(rows.path(), &error)))
    }

    /// Copies the sound records of these kinds (or of all, where none is named) that this store has not, all or none;
    /// damaged ones are noted in the other store.
    /// Stops at a record that contradicts the one that is here, by `same` of their kind and contents, and gives both.
    ///
    /// # Errors
    /// They cannot be written here.
    pub fn adopt(
        &self,
        from: &Self,
        kinds: &[&str],
        same: impl Fn(&str, &[u8], &[u8]) -> bool,
    ) -> io::Result<Option<(Sealed, Row)>> {
        let mut files = lock(&self.files);
        let into = &self.own(&mut files)?.rows;
        let mut adopt = |row: Row| -> Result<(), Interruption> {
            if !kinds.is_empty() && !kinds.contains(&row.kind.as_str()) {
                return Ok(());
            }
            if let Err(fault) = row.sealed.check(&row.kind, &row.key) {
                return Ok(from.note(Damage::Record { kind: row.kind, key: row.key, fault }));
            }
            match into.get(&row.kind, &row.key).map_err(Interruption::Here)? {
                None => into.put(&row).map_err(Interruption::Here),
                Some(here) if same(&row.kind, &here.content, &row.sealed.content) => Ok(()),
                Some(here) => Err(Interruption::Contradiction(Box::new((here, row)))),
            }
        };
        let others = lock(&from.files);
        let all = into.at_once(|| {
            for rows in others.all() {
                match rows.scan(End::First, &mut adopt) {
                    Err(Interruption::There(error)) => from.note_file(rows.path(), &error.to_string(), None),
                    end => end?,
                }
            }
            Ok(())
        });
        match all {
            Ok(()) => Ok(None),
            Err(Interruption::Contradiction(both)) => Ok(Some(*both)),
            Err(Interruption::Here(error) | Interruption::There(error)) => Err(failed(into.path(), &error)),
        }
    }

    /// Names of all records of a kind, sound or not, in order.
    pub fn keys(&self, kind: &str) -> BTreeSet<String> {
        let files = lock(&self.files);
        let mut keys = BTreeSet::new();
        for rows in files.all() {
            match rows.keys(kind) {
                Ok(found) => keys.extend(found),
                Err(error) => self.note_file(rows.path(), &error.to_string(), None),
            }
        }
        keys
    }

    /// True when there is no record at all.
    pub fn is_empty(&self) -> bool {
        lock(&self.files).all().all(|rows| rows.is_empty())
    }

    /// Gets ready to write: takes a place in the folder and takes over what is sound in damaged files.
    ///
    /// # Errors
    /// The folder cannot be written to.
    pub fn prepare(&self) -> io::Result<()> {
        self.own(&mut lock(&self.files)).map(drop)
    }

    /// Joins the work called `name` in this folder, or begins it.
    ///
    /// # Errors
    /// Others work on something else there, or the folder cannot be written to.
    pub fn queue(&self, name: &str, tasks: &[Task]) -> Result<Queue, QueueError> {
        let mut files = lock(&self.files);
        match (&self.folder, &self.own(&mut files)?.slot) {
            (Some(folder), Some(slot)) => Queue::join(folder, slot, name, tasks),
            _ => Err(QueueError::Place(io::Error::other("the store is in memory"))),
        }
    }

    /// Notes damage once; what was saved of a file takes the place of what was said of it before.
    pub(super) fn note(&self, damage: Damage) {
        let mut damages = lock(&self.damages);
        if let Damage::File { path, saved: Some(_), .. } = &damage {
            damages.found.retain(|known| known.file() != Some(path));
        } else if !damages.known.insert(damage.subject()) {
            return;
        }
        damages.found.push(damage);
    }

    /// All damage met so far.
    pub fn damages(&self) -> Vec<Damage> {
        lock(&self.damages).found.clone()
    }

    fn note_file(&self, path: &Path, reason: &str, saved: Option<usize>) {
        self.note(Damage::File { path: path.to_owned(), reason: reason.to_owned(), saved });
    }

    fn writing<T>(&self, write: impl FnOnce(&Rows) -> rusqlite::Result<T>) -> io::Result<T> {
        let mut files = lock(&self.files);
        let own = self.own(&mut files)?;
        write(&own.rows).map_err(|error| failed(own.rows.path(), &error))
    }

    /// The own file, made when it is first needed.
    fn own<'a>(&self, files: &'a mut Files) -> io::Result<&'a Own> {
        if files.own.is_none() {
            let begun = self.begin(files)?;
            files.own = Some(begun);
        }
        files.own.as_ref().ok_or_else(|| io::Error::other("no file for records"))
    }

    /// Takes a place and puts aside what is damaged before anything is written.
    fn begin(&self, files: &mut Files) -> io::Result<Own> {
        let folder = self.folder.as_deref().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        let slot = Slot::first_free(folder)?;
        let path = folder.join(format!("{}.{ROWS}", slot.number()));
        let reasons = self.put_aside(folder, &slot, files)?;
        files.others.retain(|rows| rows.path() != path);
        let rows = Rows::create(&path).map_err(|error| failed(&path, &error))?;
        for damaged in files_of(folder, DAMAGED)? {
            let saved = take_over(&damaged, &rows).map_err(|error| failed(&path, &error))?;
            let known = reasons.iter().find(|(name, _)| *name == damaged);
            let reason = known.map_or("left behind damaged", |(_, reason)| reason.as_str());
            self.note_file(&damaged.with_extension(ROWS), reason, Some(saved));
            remove(&damaged)?;
        }
        Ok(Own { rows, slot: Some(slot) })
    }

    /// Renames damaged files that no other process holds; gives the new names and what is wrong.
    fn put_aside(&self, folder: &Path, slot: &Slot, files: &mut Files) -> io::Result<Vec<(PathBuf, String)>> {
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
            files.others.retain(|rows| rows.path() != path);
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
}

/// Copies what is sound, from both ends; gives the number of records saved.
fn take_over(damaged: &Path, into: &Rows) -> rusqlite::Result<usize> {
    let Ok(from) = Rows::read(damaged) else { return Ok(0) };
    let mut saved = HashSet::new();
    let mut keep = |row: Row| -> Result<(), Interruption> {
        if row.sealed.check(&row.kind, &row.key).is_ok() && saved.insert((row.kind.clone(), row.key.clone()))
        {
            into.put(&row).map_err(Interruption::Here)?;
        }
        Ok(())
    };
    into.at_once(|| {
        for end in [End::First, End::Last] {
            // The damage of the file read is known already.
            if let Err(Interruption::Here(error)) = from.scan(end, &mut keep) {
                return Err(error);
            }
        }
        Ok(())
    })?;
    Ok(saved.len())
}

/// Files with this extension, in the order of their numbers.
fn files_of(folder: &Path, extension: &str) -> io::Result<Vec<PathBuf>> {
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
fn remove(path: &Path) -> io::Result<()> {
    for path in [path.to_owned(), log_of(path), with_suffix(path, "-shm")] {
        match std::fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    Ok(())
}

fn failed(path: &Path, error: &rusqlite::Error) -> io::Error {
    io::Error::other(format!("{}: {error}", path.display()))
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::damage::Fault;

    fn open(folder: &tempfile::TempDir) -> Database {
        Database::open(folder.path()).unwrap()
    }

    /// Changes a row of a worker's file behind the store's back.
    fn tamper(folder: &tempfile::TempDir, sql: &str) {
        let path = folder.path().join("records/1.sqlite");
        rusqlite::Connection::open(path).unwrap().execute_batch(sql).unwrap();
    }

    fn two_records(folder: &tempfile::TempDir) {
        let store = open(folder);
        store.put("point", "a", vec![1; 5000]).unwrap();
        store.put("point", "b", vec![2]).unwrap();
    }

    #[test]
    fn workers_write_their_own_files_and_read_all() {
        let folder = tempfile::tempdir().unwrap();
        let (one, two) = (open(&folder), open(&folder));
        one.put("point", "a", vec![1]).unwrap();
        two.put("point", "b", vec![2]).unwrap();
        assert_eq!(one.get("point", "b"), None);
        one.refresh().unwrap();
        two.refresh().unwrap();
        assert_eq!((one.get("point", "b"), two.get("point", "a")), (Some(vec![2]), Some(vec![1])));
        assert!(folder.path().join("records/2.sqlite").exists() && one.keys("point").len() == 2);
    }

    #[test]
    fn damage_counts_as_absence_is_told_once_and_heals() {
        let swap =
            "update records set content = (select content from records as o where o.key != records.key)";
        for (sql, fault) in [
            ("update records set content = x'03' where key = 'a'", Fault::Seal),
            ("update records set method = 0 where key = 'a'", Fault::Seal),
            ("update records set program = 'other' where key = 'a'", Fault::Seal),
            (swap, Fault::Seal),
        ] {
            let folder = tempfile::tempdir().unwrap();
            two_records(&folder);
            tamper(&folder, sql);
            let store = open(&folder);
            assert_eq!((store.get("point", "a"), store.get("point", "a")), (None, None));
            let expected = Damage::Record { kind: "point".into(), key: "a".into(), fault };
            assert_eq!(store.damages(), [expected], "{sql}");
            store.put("point", "a", vec![9]).unwrap();
            assert_eq!(open(&folder).get("point", "a"), Some(vec![9]));
            assert_eq!(open(&folder).damages(), []);
        }
    }

    #[test]
    fn a_damaged_file_is_put_aside_and_what_is_sound_is_saved() {
        let folder = tempfile::tempdir().unwrap();
        two_records(&folder);
        let path = folder.path().join("records/1.sqlite");
        let whole = std::fs::read(&path).unwrap();
        for place in (16..100).step_by(3).chain((100..whole.len()).step_by(499)) {
            let mut damaged = whole.clone();
            damaged[place] ^= 0x55;
            std::fs::write(&path, damaged).unwrap();
            let store = open(&folder);
            store.prepare().unwrap();
            for (key, content) in [("a", vec![1; 5000]), ("b", vec![2])] {
                assert!(store.get("point", key).is_none_or(|found| found == content), "byte {place}");
                store.put("point", key, content).unwrap();
            }
            drop(store);
            let healed = open(&folder);
            healed.prepare().unwrap();
            assert!(healed.get("point", "a").is_some() && healed.damages().is_empty(), "byte {place}");
        }
        for length in [0, 1, 100, whole.len() / 2] {
            std::fs::write(&path, &whole[..length]).unwrap();
            let store = open(&folder);
            store.prepare().unwrap();
            assert!(
                store.get("point", "a").is_none() && (length < 2 || !store.damages().is_empty()),
                "{length}"
            );
        }
    }

    #[test]
    fn a_copy_takes_what_is_sound_and_stops_at_contradictions() {
        let [one, two, into] = [(); 3].map(|()| tempfile::tempdir().unwrap());
        two_records(&one);
        two_records(&two);
        tamper(&one, "update records set content = x'03' where key = 'a'");
        let merged = open(&into);
        let equal = |_: &str, a: &[u8], b: &[u8]| a == b;
        for shard in [&one, &two] {
            let from = open(shard);
            assert_eq!(merged.adopt(&from, &[], equal).unwrap(), None);
            assert_eq!(from.damages().len(), usize::from(std::ptr::eq(shard, &one)));
        }
        assert_eq!(merged.get("point", "a"), Some(vec![1; 5000]));
        let other = tempfile::tempdir().unwrap();
        open(&other).put("point", "c", vec![4]).unwrap();
        open(&other).put("point", "b", vec![3]).unwrap();
        let (here, there) = merged.adopt(&open(&other), &["point"], equal).unwrap().unwrap();
        assert_eq!((here.content, there.key.as_str()), (vec![2], "b"));
        assert_eq!(merged.get("point", "c"), None, "all or nothing");
    }
}
