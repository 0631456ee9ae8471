//! Errors of numerical tables.

use std::path::PathBuf;
use thiserror::Error;

/// A table that cannot be used.
#[derive(Debug, Error)]
pub enum ColumnsError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is not a table.
    #[error("{}: {source}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// The reader's error.
        source: csv::Error,
    },
    /// The file has no header line.
    #[error("{}: it is empty; the first line names the columns", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Two columns have the same name.
    #[error("{}: column {column} occurs twice; keep one of them", path.display())]
    Twice {
        /// The file.
        path: PathBuf,
        /// Name of the columns.
        column: String,
    },
    /// A line whose number of cells differs from that of the header.
    #[error(
        "{}, line {line}: {found} cells under {} columns{}", path.display(), names.len(),
        semicolons(names, *comma)
    )]
    Ragged {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: u64,
        /// Number of cells in the line.
        found: usize,
        /// Column names in the header.
        names: Vec<String>,
        /// Whether commas separate the columns, so that decimal commas may be the cause.
        comma: bool,
    },
    /// A cell that is not a number.
    #[error("{}, line {line}, column {column}: found {found:?} where a number is needed", path.display())]
    NoNumber {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// Content of the cell.
        found: String,
    },
    /// A required cell is empty.
    #[error("{}, line {line}, column {column}: an empty cell; enter a number, or remove the line", path.display())]
    EmptyCell {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: u64,
        /// Name of the column.
        column: String,
    },
    /// Wavelengths that are probably in µm.
    #[error(
        "{}, column {column}: the largest wavelength is {largest}: these look like µm; the column must be in nm: \
         multiply it by 1000", path.display()
    )]
    Micrometres {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        column: String,
        /// The largest wavelength.
        largest: f64,
    },
}

/// Remedy where decimal commas may be the cause.
fn semicolons(names: &[String], comma: bool) -> String {
    if !comma {
        return String::new();
    }
    format!("; numbers with a decimal comma need a semicolon between columns ({})", names.join(";"))
}
