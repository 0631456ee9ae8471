//! Atomic writing of files: readers never see half of one.

use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

/// Prefix of temporary files.
const PREFIX: &str = ".inkwave-";
const SUFFIX: &str = ".partial";

/// Writes `bytes` to a temporary file beside `path`, flushes it to disk and renames it: a crash, a
/// full disk or a second process leaves either the old file or the complete new one.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new().prefix(PREFIX).suffix(SUFFIX).tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_data()?;
    readable_by_others(file.path())?;
    file.persist(path)?;
    Ok(())
}

/// Removes a file if it exists.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    std::fs::remove_file(path).or_else(|e| if e.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(e) })
}

/// A temporary file of this age has no writer any more.
const LEFT_BEHIND: Duration = Duration::from_secs(60);

/// Removes temporary files that a killed process left in `folder` and below. Files younger than a
/// minute are kept: another process may be writing them.
pub fn remove_leftovers(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            remove_leftovers(&path);
        } else if is_temporary(&path) && age(&entry).is_some_and(|age| age > LEFT_BEHIND) {
            // Another process may already have removed the file.
            let _ = std::fs::remove_file(path);
        }
    }
}

fn age(entry: &std::fs::DirEntry) -> Option<Duration> {
    entry.metadata().ok()?.modified().ok()?.elapsed().ok()
}

/// Whether a file is one that is being written, or was left by a process that was killed.
pub fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy());
    name.is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX))
}

/// Temporary files are private to their owner; results get the usual permissions.
#[cfg(unix)]
fn readable_by_others(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable_by_others(_path: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        write(&path, b"old").unwrap();
        write(&path, b"new").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    /// A process that has opened the old file can read all of it: the new file takes its name, not
    /// its content.
    #[test]
    fn a_file_that_is_being_read_stays_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        write(&path, b"old and long").unwrap();
        let reader = std::fs::File::open(&path).unwrap();
        write(&path, b"new").unwrap();
        assert_eq!(io::read_to_string(reader).unwrap(), "old and long");
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
    }

    /// Temporary files have mode 600, and the umask can only take more away.
    #[cfg(unix)]
    #[test]
    fn others_can_read_what_was_written() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        write(&path, b"x").unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o644);
    }

    #[test]
    fn a_missing_folder_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(write(&folder.path().join("no/a.json"), b"x").is_err());
    }
}
