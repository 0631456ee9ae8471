//! Tracks the processes in a folder. Each holds a shared lock on the folder itself, so that a
//! failing process knows whether others rely on it; the system releases the locks of killed
//! processes.

use std::fs::File;
use std::io;
use std::path::Path;

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
