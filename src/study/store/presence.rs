//! Who is at work in a folder. Every process shares a lock of the folder itself, so that whoever fails knows whether anybody
//! else relies on it; the system takes the locks of killed processes back.

use std::fs::File;
use std::io;
use std::path::Path;

/// A process in a folder, as long as the value lives; nothing is known where the system does not lock folders.
#[derive(Debug, Default)]
pub struct Presence(Option<File>);

impl Presence {
    /// Makes the folder where it is not there, and enters.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn enter(path: &Path) -> io::Result<Self> {
        loop {
            std::fs::create_dir_all(path)?;
            let Some(folder) = File::open(path).ok().filter(|folder| folder.lock_shared().is_ok()) else {
                return Ok(Self(None));
            };
            // Another process may have failed and removed the folder before the lock was there.
            if is_at(&folder, path) {
                return Ok(Self(Some(folder)));
            }
        }
    }

    /// Whether no other process is here; if so, none enters as long as the value lives.
    pub fn is_alone(&self) -> bool {
        self.0.as_ref().is_some_and(|folder| folder.try_lock().is_ok())
    }
}

/// Whether the open folder is the one at `path`.
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
