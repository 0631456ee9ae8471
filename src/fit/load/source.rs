//! Whether two measured spectra are one.

use std::path::{Path, PathBuf};

/// Largest file that is compared with others byte by byte: spectra are smaller by far.
const LARGEST_COMPARED: u64 = 1 << 22;

/// Where a spectrum comes from.
pub(super) struct MeasuredSource {
    /// The file without links and dots; none where there is no such file.
    path: Option<PathBuf>,
    content: Option<Vec<u8>>,
}

impl MeasuredSource {
    pub(super) fn of(path: &Path) -> Self {
        let content = std::fs::metadata(path).ok().filter(|file| file.len() <= LARGEST_COMPARED);
        Self { path: path.canonicalize().ok(), content: content.and_then(|_| std::fs::read(path).ok()) }
    }

    /// Whether both are one file, or a file and its copy.
    pub(super) fn is(&self, other: &Self) -> bool {
        let one_path = self.path.is_some() && self.path == other.path;
        one_path || (self.content.is_some() && self.content == other.content)
    }
}
