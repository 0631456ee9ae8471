//! Reading of user files: only regular files of a bounded size, so that devices, pipes and mistyped
//! paths cannot block the program. With the feature `serde`, also reading of choices tagged by
//! `kind` that a file may give by name alone.

#[cfg(feature = "serde")]
mod tagged;

#[cfg(feature = "schema")]
pub use tagged::also_by_name;
#[cfg(feature = "serde")]
pub use tagged::{name_or_table, no_keys, ratio};

use std::fmt::Display;
use std::fs::File;
use std::io::{self, Error, ErrorKind, Read};
use std::path::Path;

/// Largest study, sweep or comparison, bytes: a list of 10 000 numbers takes a tenth of it, and
/// parsers need seconds for more.
pub const STUDY: u64 = 1 << 20;
/// Largest record of optical constants in YAML, bytes.
pub const RECORD: u64 = 8 << 20;
/// Largest table of indices or albedos, bytes.
pub const TABLE: u64 = 64 << 20;
/// Largest case, bytes: some hundred bytes for each of a million spheres; also largest voxel image.
pub const CASE: u64 = 256 << 20;

/// A file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {reason}")]
pub struct FileError {
    /// The file, with line and column where they are known.
    place: String,
    /// What is wrong there.
    reason: String,
}

impl FileError {
    /// What is wrong in a file, at a line or in a column of it.
    pub fn new(place: impl Display, reason: impl Display) -> Self {
        Self { place: named(&place.to_string()), reason: reason.to_string() }
    }
}

/// A path in a message, also one that is blank.
pub fn named(path: &str) -> String {
    if path.trim().is_empty() { format!("{path:?}, a blank file name") } else { path.to_owned() }
}

/// The text of a regular file of at most `most` bytes, without a byte order mark.
///
/// # Errors
/// The file cannot be opened or read, is not a regular file, is larger, or is not UTF-8.
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    let mut text = String::from_utf8(read_bytes(path, most)?)
        .map_err(|_| Error::new(ErrorKind::InvalidData, "it is not text in UTF-8"))?;
    if text.starts_with('\u{feff}') {
        text.remove(0);
    }
    Ok(text)
}

/// The bytes of a regular file of at most `most` bytes. For errors see [`read_text`].
pub fn read_bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    // Checked before opening: opening a pipe would wait for a writer.
    if !std::fs::metadata(path)?.is_file() {
        let what = "it is not a regular file but a folder, a pipe or a device";
        return Err(Error::new(ErrorKind::InvalidInput, what));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let what = format!("it is larger than the limit of {} MB", most >> 20);
        return Err(Error::new(ErrorKind::FileTooLarge, what));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_of_bounded_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(read_text(&path, 5).unwrap(), "12345");
        std::fs::write(&path, "\u{feff}{}").unwrap();
        assert_eq!(read_text(&path, 5).unwrap(), "{}");
        std::fs::write(&path, "12345").unwrap();
        assert!(read_text(&path, 4).unwrap_err().to_string().contains("larger"));
        assert!(FileError::new("", "not there").to_string().starts_with("\"\", a blank file name: not"));
        assert!(read_text(folder.path(), 4).unwrap_err().to_string().contains("regular"));
        std::fs::write(&path, [0xff, 0xfe]).unwrap();
        assert!(read_text(&path, 5).unwrap_err().to_string().contains("UTF-8"));
        #[cfg(unix)]
        assert!(read_text(Path::new("/dev/zero"), 5).unwrap_err().to_string().contains("regular"));
    }
}
