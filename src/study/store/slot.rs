//! Processes in a folder: numbered slots for those that work there, and the presence of all.
//!
//! A process holds the lock on the file of its slot. The system releases the lock however the
//! process ends, so the slot and the tasks of a killed worker are free at once. The file names its
//! holder, so that a later process in the same slot is not mistaken for an earlier one.
//!
//! Each process also holds a shared lock on the folder itself, so that a failing process knows
//! whether others rely on it.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// More processes than this in one folder are a mistake.
const MOST: u32 = 10_000;
/// Maximum length of a process number and a time, bytes.
const LONGEST_HOLDER: u64 = 64;

/// A slot, held for the lifetime of the value.
#[derive(Debug)]
pub struct Slot {
    /// Number of the slot, from 1.
    pub(super) number: u32,
    /// Unique name of the holding process.
    pub(super) holder: String,
    _lock: File,
}

impl Slot {
    /// Takes the lowest free slot of `folder`.
    ///
    /// # Errors
    /// The lock file cannot be created.
    pub fn first_free(folder: &Path) -> io::Result<Self> {
        let mut free = (1..=MOST).filter_map(|number| Self::take(folder, number).transpose());
        let too_many = || format!("{MOST} processes are already working in {}", folder.display());
        free.next().unwrap_or_else(|| Err(io::Error::other(too_many())))
    }

    /// Takes the slot `number`; `None` if another process holds it.
    ///
    /// # Errors
    /// The lock file cannot be created.
    pub fn take(folder: &Path, number: u32) -> io::Result<Option<Self>> {
        let Some(mut lock) = locked(&lock_file(folder, number), true)? else { return Ok(None) };
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        // the process number and the time, because process numbers are reused
        let holder = format!("{} {}", std::process::id(), since.as_nanos());
        lock.set_len(0)?;
        lock.write_all(holder.as_bytes())?;
        Ok(Some(Self { number, holder, _lock: lock }))
    }

    /// Whether a process holds the slot `number`.
    pub fn is_held(folder: &Path, number: u32) -> bool {
        matches!(locked(&lock_file(folder, number), false), Ok(None))
    }

    /// Whether a process holds any slot of `folder`.
    pub fn any_is_held(folder: &Path) -> bool {
        let Ok(entries) = std::fs::read_dir(folder) else { return false };
        let mut numbers = entries.flatten().filter_map(|entry| {
            let path = entry.path();
            let lock = path.extension().is_some_and(|e| e == "lock");
            path.file_stem().filter(|_| lock)?.to_str()?.parse().ok()
        });
        numbers.any(|number| Self::is_held(folder, number))
    }

    /// Whether `holder`, and not a later process, holds the slot `number`.
    pub fn is_held_by(folder: &Path, number: u32, holder: &str) -> bool {
        let told = std::fs::read_to_string(lock_file(folder, number));
        told.is_ok_and(|told| told == holder) && Self::is_held(folder, number)
    }
}

/// The file, locked; `None` if another process holds the lock.
fn locked(path: &Path, make: bool) -> io::Result<Option<File>> {
    refuse_what_is_no_lock(path)?;
    let file = OpenOptions::new().create(make).append(true).open(path)?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Ok(None),
        // Some network file systems have no locks; a folder there must not be shared.
        Err(TryLockError::Error(error)) if error.kind() != io::ErrorKind::Unsupported => Err(error),
        _ => Ok(Some(file)),
    }
}

/// Refuses links and files that are not lock files of ours: a lock file is overwritten when its
/// slot is taken.
fn refuse_what_is_no_lock(path: &Path) -> io::Result<()> {
    let Ok(metadata) = std::fs::symlink_metadata(path) else { return Ok(()) };
    let ours = |text: String| text.chars().all(|c| c.is_ascii_digit() || " \0".contains(c));
    if metadata.is_file() && metadata.len() <= LONGEST_HOLDER && std::fs::read_to_string(path).is_ok_and(ours)
    {
        return Ok(());
    }
    let reason = "is not a lock file of inkwave, and is not overwritten: remove it if it is not needed";
    Err(io::Error::other(format!("{} {reason}", path.display())))
}

fn lock_file(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("{number}.lock"))
}

/// Presence of this process in a folder, for the lifetime of the value; `None` on systems that
/// cannot lock folders.
#[derive(Debug, Default)]
pub struct Presence(Option<File>);

impl Presence {
    /// Creates the folder if necessary and enters it.
    ///
    /// # Errors
    /// The folder cannot be created.
    pub fn enter(path: &Path) -> io::Result<Self> {
        loop {
            std::fs::create_dir_all(path)?;
            let Some(folder) = File::open(path).ok().filter(|folder| folder.lock_shared().is_ok()) else {
                return Ok(Self(None));
            };
            // Another process may have removed the folder before it was locked.
            if is_at(&folder, path) {
                return Ok(Self(Some(folder)));
            }
        }
    }

    /// Whether no other process is present; if so, none can enter during the lifetime of the value.
    pub fn is_alone(&self) -> bool {
        self.0.as_ref().is_some_and(|folder| folder.try_lock().is_ok())
    }
}

/// Whether the open folder is still the one at `path`.
#[cfg(unix)]
fn is_at(folder: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |metadata: io::Result<std::fs::Metadata>| metadata.ok().map(|m| (m.dev(), m.ino()));
    identity(folder.metadata()) == identity(std::fs::metadata(path))
}

#[cfg(not(unix))]
fn is_at(_folder: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_held_by_one_and_free_again() {
        let folder = tempfile::tempdir().unwrap();
        let one = Slot::first_free(folder.path()).unwrap();
        let two = Slot::first_free(folder.path()).unwrap();
        assert_eq!((one.number, two.number), (1, 2));
        assert!(Slot::is_held(folder.path(), 1) && !Slot::is_held(folder.path(), 3));
        let holder = one.holder.clone();
        assert!(Slot::is_held_by(folder.path(), 1, &holder) && !Slot::is_held_by(folder.path(), 2, &holder));
        drop(one);
        assert!(!Slot::is_held(folder.path(), 1));
        let later = Slot::first_free(folder.path()).unwrap();
        assert!(later.number == 1 && !Slot::is_held_by(folder.path(), 1, &holder));
    }

    #[cfg(unix)]
    #[test]
    fn what_a_link_in_a_lock_s_place_points_to_stays() {
        let folder = tempfile::tempdir().unwrap();
        let thesis = folder.path().join("thesis.tex");
        std::fs::write(&thesis, "words").unwrap();
        std::os::unix::fs::symlink(&thesis, folder.path().join("1.lock")).unwrap();
        std::fs::hard_link(&thesis, folder.path().join("2.lock")).unwrap();
        for number in [1, 2] {
            let refused = Slot::take(folder.path(), number).unwrap_err().to_string();
            assert!(refused.contains("is not a lock file of inkwave"), "{refused}");
        }
        assert_eq!(std::fs::read_to_string(thesis).unwrap(), "words");
    }
}
