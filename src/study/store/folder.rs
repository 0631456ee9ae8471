//! The folder that a run writes to.
//!
//! ```text
//! inkwave.json                                marks the folder as ours
//! records/1.sqlite …                          solves, packings, grids (one file per worker)
//! results.json          numbers, provenance   report.html            the page
//! picture.png  spectra.csv  bdf.csv           PARTIAL                present while unfinished
//! ```

use super::database::{Database, RECORDS};
use super::marker::{Holds, MARKER, Marker, PARTIAL, partial};
use super::safely;
use super::slot::{Presence, Slot};
use std::io;
use std::path::{Path, PathBuf};

/// Result files of a study, a fit and a design, which are removed when new work begins: those of
/// another input must not pass for the new one's.
pub const RESULTS: [&str; 21] = [
    "results.json",
    "fit.json",
    "pigment.csv",
    "pigment-other.csv",
    "design.json",
    "report.html",
    "picture.png",
    "picture-with-axes.png",
    "spectra.csv",
    "bdf.csv",
    "kubelka-munk.csv",
    "measured.csv",
    "medium.csv",
    "instruments.csv",
    "absorbed.csv",
    "left-out.csv",
    "densities.csv",
    "numbers.csv",
    "prints.csv",
    "print-spectra.csv",
    "datapackage.json",
];
/// Subfolders that are written to.
const PARTS: [&str; 4] = [RECORDS, "variants", "inputs", "runs"];

/// Why a folder cannot hold the results.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// Files cannot be created or written.
    #[error("cannot write results to {}: {source}", path.display())]
    NotWritable {
        /// The folder or file.
        path: PathBuf,
        /// The system's error message.
        source: io::Error,
    },
    /// The folder holds files but no marker of this program.
    #[error("{} holds other files ({found}), but no results of inkwave", path.display())]
    Foreign {
        /// The folder.
        path: PathBuf,
        /// Name of one of the files.
        found: String,
    },
    /// The folder holds something else written by this program.
    #[error("{} holds {found} of inkwave, not {wanted}", path.display())]
    Other {
        /// The folder.
        path: PathBuf,
        /// What the folder holds.
        found: Holds,
        /// What was to be written.
        wanted: Holds,
    },
    /// Part of the folder is a link to another place.
    #[error("{} is a link, and results are not written through links", path.display())]
    Link {
        /// The link.
        path: PathBuf,
    },
    /// The layout is of another version.
    #[error("{} holds results of {found}, which this version neither reads nor continues", path.display())]
    Older {
        /// The folder.
        path: PathBuf,
        /// The program that wrote the results.
        found: String,
    },
}

impl FolderError {
    /// A failure to write to a path.
    pub fn at(path: &Path) -> impl Fn(io::Error) -> Self + Copy + '_ {
        move |source| Self::NotWritable { path: path.to_owned(), source }
    }

    /// Suggests a remedy.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::NotWritable { .. } => "choose a writable folder, on a disk with free space: --output DIR",
            Self::Foreign { .. } => {
                "choose a new folder, an empty one or that of an earlier run: --output DIR"
            }
            Self::Other { .. } => "choose another folder: --output DIR",
            Self::Link { .. } => "replace it by what it points to, or choose another folder: --output DIR",
            Self::Older { .. } => {
                "choose a new folder (--output DIR) to compute everything again, or use the version that wrote it"
            }
        }
    }
}

/// A folder known to be writable and to hold only results.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Folders that did not exist before.
    made: Vec<PathBuf>,
    /// Whether the marker existed before.
    marked: bool,
    /// The command that resumes interrupted work.
    go_on: Option<String>,
    presence: Presence,
}

impl OutputFolder {
    /// Creates the folder if necessary and marks it.
    ///
    /// # Errors
    /// The folder cannot be created or written, or holds files of something else.
    pub fn open(path: &Path, holds: Holds) -> Result<Self, FolderError> {
        let marked = refuse_foreign(path, holds)?;
        let missing = |p: &&Path| !p.as_os_str().is_empty() && !p.exists();
        let made = path.ancestors().take_while(missing).map(Path::to_owned).collect();
        let not_writable = FolderError::at(path);
        refuse_links(path)?;
        let presence = Presence::enter(path).map_err(not_writable)?;
        let folder = Self { path: path.to_owned(), made, marked, go_on: None, presence };
        tempfile::tempfile_in(path).map_err(not_writable).inspect_err(|_| folder.discard_when_empty())?;
        if !marked {
            let marker =
                serde_json::to_vec_pretty(&Marker::new(holds)).map_err(|e| not_writable(e.into()))?;
            folder.write(MARKER, &marker)?;
        }
        // Temporary files of killed processes go unless others are working here.
        if !Slot::any_is_held(&path.join(RECORDS)) {
            safely::remove_leftovers(path);
        }
        Ok(folder)
    }

    /// Sets the command that resumes the work; it is written to the folder until the work is
    /// finished.
    pub fn going_on_with(self, command: String) -> Self {
        Self { go_on: Some(command), ..self }
    }

    /// A folder of results inside this one, such as that of a variant.
    pub fn inside(&self, name: &str) -> Result<Self, FolderError> {
        let path = self.path.join(name);
        std::fs::create_dir_all(&path).map_err(FolderError::at(&path))?;
        let presence = Presence::default();
        Ok(Self { path, made: Vec::new(), marked: true, go_on: self.go_on.clone(), presence })
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Marks the folder as partial and removes earlier results; called before the first new solve.
    pub fn begin(&self) -> Result<(), FolderError> {
        self.mark_partial()?;
        RESULTS.iter().try_for_each(|name| self.remove(name))
    }

    /// Marks the folder as partial before any work on `input`, a hash of all that the `results`
    /// (names of files) depend on. Results of another input are removed: if the work is stopped,
    /// none of them passes for the new one's.
    ///
    /// # Errors
    /// A file cannot be written or removed.
    pub fn begin_input(&self, input: &str, results: &[&str]) -> Result<(), FolderError> {
        self.mark_partial()?;
        let Some(marker) = Marker::read(&self.path).filter(|marker| marker.input.as_deref() != Some(input))
        else {
            return Ok(());
        };
        results.iter().try_for_each(|name| self.remove(name))?;
        let marker = Marker { input: Some(input.to_owned()), ..marker };
        let bytes = serde_json::to_vec_pretty(&marker).map_err(|e| FolderError::at(&self.path)(e.into()))?;
        self.write(MARKER, &bytes)
    }

    /// Marks the folder as partial and keeps its files.
    pub fn mark_partial(&self) -> Result<(), FolderError> {
        self.write(PARTIAL, partial(self.go_on.as_deref()).as_bytes())
    }

    /// Writes a file atomically.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), FolderError> {
        let path = self.path.join(name);
        safely::write(&path, bytes).map_err(FolderError::at(&path))
    }

    /// Removes a file if it exists.
    pub fn remove(&self, name: &str) -> Result<(), FolderError> {
        let path = self.path.join(name);
        safely::remove(&path).map_err(FolderError::at(&path))
    }

    /// Removes files whose names satisfy `ours`: leftovers of earlier work of another extent.
    ///
    /// # Errors
    /// The folder cannot be read, or a file cannot be removed.
    pub fn remove_files(&self, ours: fn(&str) -> bool) -> Result<(), FolderError> {
        let entries = std::fs::read_dir(&self.path).map_err(FolderError::at(&self.path))?;
        let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
        names.filter(|name| ours(name)).try_for_each(|name| self.remove(&name))
    }

    /// Removes the mark of partial results.
    pub fn complete(&self) -> Result<(), FolderError> {
        self.remove(PARTIAL)
    }

    /// After a failure, removes the empty folders that this run created, unless another process is
    /// working in them.
    pub fn discard_when_empty(&self) {
        let has_records = || Database::open(&self.path).is_ok_and(|database| !database.is_empty());
        if self.marked || !self.presence.is_alone() || has_records() {
            return;
        }
        // Removing a folder fails if it is not empty, as it should; errors are ignored.
        let _ = std::fs::remove_dir_all(self.path.join(RECORDS));
        let _ = self.complete();
        let _ = self.remove(MARKER);
        self.made.iter().for_each(|folder| _ = std::fs::remove_dir(folder));
    }
}

/// Refuses links: a folder received from elsewhere must not redirect writes to other places.
fn refuse_links(path: &Path) -> Result<(), FolderError> {
    let found = PARTS.iter().find_map(|part| link_in(&path.join(part)));
    found.map_or(Ok(()), |path| Err(FolderError::Link { path }))
}

/// The first link among a path and, if it is a folder, everything in it.
fn link_in(path: &Path) -> Option<PathBuf> {
    let kind = path.symlink_metadata().ok()?.file_type();
    if kind.is_symlink() {
        return Some(path.to_owned());
    }
    if !kind.is_dir() {
        return None;
    }
    std::fs::read_dir(path).ok()?.flatten().find_map(|entry| link_in(&entry.path()))
}

/// True if the folder is marked as ours; false if it is new or empty.
fn refuse_foreign(path: &Path, wanted: Holds) -> Result<bool, FolderError> {
    if let Some(marker) = Marker::read(path) {
        let found = marker.inkwave_folder;
        let path = path.to_owned();
        return match marker.is_readable() {
            false => Err(FolderError::Older { path, found: marker.program }),
            true if found == wanted => Ok(true),
            true => Err(FolderError::Other { path, found, wanted }),
        };
    }
    let Ok(entries) = std::fs::read_dir(path) else { return Ok(false) };
    let names: Vec<_> = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    match names.into_iter().find(|name| !name.starts_with('.')) {
        // Another process may have marked the folder in the meantime: then its files are ours.
        Some(_) if Marker::read(path).is_some() => refuse_foreign(path, wanted),
        Some(found) => Err(FolderError::Foreign { path: path.to_owned(), found }),
        None => Ok(false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_run_leaves_nothing_behind() {
        let root = tempfile::tempdir().unwrap();
        let folder = OutputFolder::open(&root.path().join("out/yellow"), Holds::Study).unwrap();
        folder.discard_when_empty();
        assert_eq!(std::fs::read_dir(root.path()).unwrap().count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn a_failed_run_leaves_the_folder_to_another_that_is_at_work_in_it() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("out/yellow");
        let one = OutputFolder::open(&path, Holds::Study).unwrap();
        let two = OutputFolder::open(&path, Holds::Study).unwrap();
        one.discard_when_empty();
        assert!(Marker::read(&path).is_some(), "the second still works here");
        two.write("results.json", b"{}").unwrap();
        drop((one, two));
        assert!(path.join("results.json").exists());
    }

    /// *Planted*: links are sought in some of the parts, or in their first level alone.
    #[cfg(unix)]
    #[test]
    fn nothing_is_written_through_links() {
        for link in ["variants/100", "runs", "runs/0a1b", "runs/0a1b/records", "runs/0a1b/records/1.sqlite"] {
            let root = tempfile::tempdir().unwrap();
            let path = root.path().join("out");
            drop(OutputFolder::open(&path, Holds::Design).unwrap());
            let place = path.join(link);
            std::fs::create_dir_all(place.parent().unwrap()).unwrap();
            std::os::unix::fs::symlink(root.path(), &place).unwrap();
            match OutputFolder::open(&path, Holds::Design) {
                Err(FolderError::Link { path }) => assert_eq!(path, place),
                other => panic!("{link}: {other:?}"),
            }
        }
    }

    /// *Planted*: results of another input stay, or those of the same one go.
    #[test]
    fn results_of_another_input_go_before_its_work_begins() {
        let root = tempfile::tempdir().unwrap();
        let open = || OutputFolder::open(&root.path().join("out"), Holds::Design).unwrap();
        let folder = open();
        let there = |name: &str| folder.path().join(name).exists();
        for (input, kept) in [("a", false), ("a", true), ("b", false), ("b", true), ("a", false)] {
            folder.begin_input(input, &["design.json"]).unwrap();
            assert_eq!((there("design.json"), there(PARTIAL)), (kept, true), "{input}");
            folder.write("design.json", b"{}").unwrap();
            folder.write("other.txt", b"").unwrap();
            folder.complete().unwrap();
        }
        assert!(there("other.txt"), "only results are removed");
        assert_eq!(open().path(), folder.path(), "the marker is still one");
    }

    #[test]
    fn finished_records_stay_and_results_of_earlier_runs_and_leftovers_go() {
        let root = tempfile::tempdir().unwrap();
        let folder = OutputFolder::open(&root.path().join("yellow"), Holds::Study).unwrap();
        Database::open(folder.path()).unwrap().put("point", "a", vec![1]).unwrap();
        let results = ["report.html", "fit.json", "pigment.csv", "design.json"];
        for name in results.into_iter().chain([".inkwave-x.partial", ".inkwave-y.partial"]) {
            std::fs::write(folder.path().join(name), "old").unwrap();
        }
        let left =
            std::fs::File::options().append(true).open(folder.path().join(".inkwave-x.partial")).unwrap();
        left.set_modified(std::time::SystemTime::now() - std::time::Duration::from_secs(90)).unwrap();
        let folder = OutputFolder::open(folder.path(), Holds::Study).unwrap();
        folder.begin().unwrap();
        folder.discard_when_empty();
        let there = |name: &str| folder.path().join(name).exists();
        assert!(results.iter().all(|name| !there(name)) && !there(".inkwave-x.partial"));
        assert!(there(".inkwave-y.partial"), "another process may be writing it");
        assert!(there("records/1.sqlite") && there(PARTIAL));
    }

    #[test]
    fn folders_of_other_people_other_kinds_and_other_versions_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let make = |name: &str, file: &str, text: &str| {
            let path = root.path().join(name);
            std::fs::create_dir_all(path.join(file).parent().unwrap()).unwrap();
            std::fs::write(path.join(file), text).unwrap();
            path
        };
        let open = |path: &Path| OutputFolder::open(path, Holds::Study).map(drop).unwrap_err();
        for (name, file) in [("thesis", "thesis.tex"), ("maps", "points/a.json"), ("other", "inkwave.json")] {
            assert!(matches!(open(&make(name, file, "{}")), FolderError::Foreign { .. }), "{name}");
        }
        let later = r#"{"inkwave_folder": "study", "layout": 3, "program": "inkwave 9.0"}"#;
        assert!(matches!(open(&make("later", "inkwave.json", later)), FolderError::Older { .. }));
        let comparison = OutputFolder::open(&root.path().join("comparison"), Holds::Comparison).unwrap();
        assert!(matches!(open(comparison.path()), FolderError::Other { .. }));
        let below_a_file = open(&root.path().join("thesis/thesis.tex/out"));
        assert!(matches!(below_a_file, FolderError::NotWritable { .. }));
    }
}
