//! The folder a run writes to.
//!
//! ```text
//! points/<hash>.json    one finished solve each        packings/<hash>.json   one packing each
//!                                                      grids/<hash>.json      grids and their errors
//! results.json          numbers and provenance         report.html            the page to show
//! picture.png  spectra.csv  bdf.csv                    PARTIAL                there while not all is finished
//! ```

use super::safely;
use std::io;
use std::path::{Path, PathBuf};

/// Marks a folder whose study is not finished.
pub const PARTIAL: &str = "PARTIAL";
/// Files that tell of a study and must not outlive it.
pub const RESULTS: [&str; 6] =
    ["results.json", "report.html", "picture.png", "picture-with-axes.png", "spectra.csv", "bdf.csv"];
/// Finished solves.
pub const POINTS: &str = "points";
/// Packings made.
pub const PACKINGS: &str = "packings";
/// Grids chosen, with their error estimates.
pub const GRIDS: &str = "grids";

/// Why a folder cannot take results.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    #[error("cannot write results to {}: {source}", path.display())]
    NotWritable { path: PathBuf, source: io::Error },
    #[error("{} holds other files ({found}), but no results of inkwave", path.display())]
    Foreign { path: PathBuf, found: String },
}

impl FolderError {
    /// What to try.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::NotWritable { .. } => {
                "give a folder that you may write to, on a disk with room: --output DIR"
            }
            Self::Foreign { .. } => "give a new folder, an empty one or one of an earlier run: --output DIR",
        }
    }
}

/// A folder proven to be writable and to hold nothing but results.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    made: Vec<PathBuf>,
}

impl OutputFolder {
    /// Makes the folder where needed.
    ///
    /// # Errors
    /// It cannot be made or written to, or holds files of something else.
    pub fn open(path: &Path) -> Result<Self, FolderError> {
        refuse_foreign(path)?;
        let missing = |p: &&Path| !p.as_os_str().is_empty() && !p.exists();
        let made = path.ancestors().take_while(missing).map(Path::to_owned).collect();
        let not_writable = |source| FolderError::NotWritable { path: path.to_owned(), source };
        std::fs::create_dir_all(path).map_err(not_writable)?;
        let folder = Self { path: path.to_owned(), made };
        tempfile::tempfile_in(path).map_err(not_writable).inspect_err(|_| folder.discard_when_empty())?;
        Ok(folder)
    }

    /// A folder of results inside this one, such as that of a variant.
    pub fn inside(&self, name: &str) -> Result<Self, FolderError> {
        let path = self.path.join(name);
        match std::fs::create_dir_all(&path) {
            Ok(()) => Ok(Self { path, made: Vec::new() }),
            Err(source) => Err(FolderError::NotWritable { path, source }),
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Marks the folder partial and takes the results of earlier runs away, before the first new solve.
    pub fn begin(&self) -> Result<(), FolderError> {
        let text = "This study is not finished. Run it again to continue where it stopped.\n";
        self.write(PARTIAL, text.as_bytes())?;
        RESULTS.iter().try_for_each(|name| self.remove(name))
    }

    /// Writes one file whole or not at all.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), FolderError> {
        let path = self.path.join(name);
        safely::write(&path, bytes).map_err(|source| FolderError::NotWritable { path, source })
    }

    /// Removes a file of an earlier study, if it is there.
    pub fn remove(&self, name: &str) -> Result<(), FolderError> {
        let path = self.path.join(name);
        match std::fs::remove_file(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => {
                Err(FolderError::NotWritable { path, source })
            }
            _ => Ok(()),
        }
    }

    /// Takes the partial mark away.
    pub fn complete(&self) -> Result<(), FolderError> {
        self.remove(PARTIAL)
    }

    /// After a failure: leaves no empty folders behind that this run made.
    pub fn discard_when_empty(&self) {
        let empty =
            |name: &str| std::fs::read_dir(self.path.join(name)).is_ok_and(|mut d| d.next().is_none());
        if self.made.is_empty() || !empty(POINTS) && self.path.join(POINTS).exists() {
            return;
        }
        // Removal of a folder fails when it is not empty, which is what is wanted.
        let _ = self.complete();
        for name in [POINTS, PACKINGS, GRIDS] {
            let _ = std::fs::remove_dir(self.path.join(name));
        }
        for folder in &self.made {
            let _ = std::fs::remove_dir(folder);
        }
    }
}

fn refuse_foreign(path: &Path) -> Result<(), FolderError> {
    let Ok(entries) = std::fs::read_dir(path) else { return Ok(()) };
    let names: Vec<String> =
        entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    let ours = names.iter().any(|name| name == POINTS || name == PARTIAL);
    match names.iter().find(|name| !name.starts_with('.')) {
        Some(found) if !ours => Err(FolderError::Foreign { path: path.to_owned(), found: found.clone() }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_run_leaves_nothing_behind() {
        let root = tempfile::tempdir().unwrap();
        let folder = OutputFolder::open(&root.path().join("out/yellow")).unwrap();
        std::fs::create_dir(folder.path().join(POINTS)).unwrap();
        folder.discard_when_empty();
        assert_eq!(std::fs::read_dir(root.path()).unwrap().count(), 0);
    }

    #[test]
    fn finished_points_stay() {
        let root = tempfile::tempdir().unwrap();
        let folder = OutputFolder::open(&root.path().join("yellow")).unwrap();
        std::fs::create_dir(folder.path().join(POINTS)).unwrap();
        std::fs::write(folder.path().join("points/a.json"), "{}").unwrap();
        std::fs::write(folder.path().join("report.html"), "old").unwrap();
        folder.begin().unwrap();
        folder.discard_when_empty();
        assert!(!folder.path().join("report.html").exists());
        assert!(folder.path().join("points/a.json").exists() && folder.path().join(PARTIAL).exists());
    }

    #[test]
    fn other_peoples_folders_and_files_are_refused() {
        let root = tempfile::tempdir().unwrap();
        std::fs::write(root.path().join("thesis.tex"), "").unwrap();
        let foreign = OutputFolder::open(root.path());
        assert!(matches!(foreign, Err(FolderError::Foreign { .. })));
        let below_a_file = OutputFolder::open(&root.path().join("thesis.tex/out"));
        assert!(matches!(below_a_file, Err(FolderError::NotWritable { .. })));
    }
}
