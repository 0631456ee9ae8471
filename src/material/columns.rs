//! Tables of numbers as people save them: commas, semicolons or tabs, decimal points or decimal commas.
//!
//! A spreadsheet in much of the world writes `;` between columns and `,` in numbers. Which one a file uses is read off
//! its header line; a file that mixes them is refused with an explanation, never guessed at.

use crate::numerics::files;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A table that cannot be used.
#[derive(Debug, Error)]
pub enum ColumnsError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The file is no table.
    #[error("{}: {source}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What the reader found.
        source: csv::Error,
    },
    /// The file has no header line.
    #[error("{}: it is empty; the first line names the columns", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Two columns have the same name.
    #[error("{}: column {column} is there twice; keep one of them", path.display())]
    Twice {
        /// The file.
        path: PathBuf,
        /// Name of the columns.
        column: String,
    },
    /// A line has another number of cells than the header.
    #[error(
        "{}, line {line}: {found} cells under {expected} columns{}", path.display(),
        if *comma { "; numbers with a decimal comma need a semicolon between columns (wavelength_nm;kappa)" } else { "" }
    )]
    Ragged {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: u64,
        /// Its cells.
        found: usize,
        /// Columns of the header.
        expected: usize,
        /// Commas separate the columns, so that decimal commas may be the cause.
        comma: bool,
    },
    /// A cell is no number.
    #[error("{}, line {line}, column {column}: found {found:?} where a number is needed", path.display())]
    NoNumber {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// What the cell holds.
        found: String,
    },
}

/// Columns by name, and rows of numbers; an empty cell is `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// Names in lower case, as the header has them.
    pub names: Vec<String>,
    /// One list a line.
    pub rows: Vec<Vec<Option<f64>>>,
}

impl Columns {
    /// Reads a file; lines that start with `#` are comments.
    ///
    /// # Errors
    /// The file cannot be read, has no header, or a line that does not fit it.
    pub fn read(path: &Path) -> Result<Self, ColumnsError> {
        let unreadable = |source| ColumnsError::Unreadable { path: path.into(), source };
        let bytes = files::read_bytes(path, files::TABLE).map_err(unreadable)?;
        if bytes.contains(&0) {
            let what = "it is no plain text (UTF-16, or a spreadsheet's own format): save it as CSV in UTF-8";
            return Err(unreadable(io::Error::new(io::ErrorKind::InvalidData, what)));
        }
        Self::parse(path, &String::from_utf8_lossy(&bytes))
    }

    fn parse(path: &Path, text: &str) -> Result<Self, ColumnsError> {
        let text = text.trim_start_matches('\u{feff}');
        let header = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'));
        let header = header.ok_or_else(|| ColumnsError::Empty { path: path.into() })?;
        let separator = [b';', b'\t'].into_iter().find(|&c| header.contains(char::from(c))).unwrap_or(b',');
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(separator)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.as_bytes());
        let broken = |error: csv::Error| ColumnsError::Broken { path: path.into(), source: error };
        let names: Vec<String> = reader.headers().map_err(broken)?.iter().map(str::to_lowercase).collect();
        let earlier = |i: usize| !names[i].is_empty() && names[..i].contains(&names[i]);
        if let Some(i) = (0..names.len()).find(|&i| earlier(i)) {
            return Err(ColumnsError::Twice { path: path.into(), column: names[i].clone() });
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(broken)?;
            // Spreadsheets end with lines of nothing but separators.
            if record.iter().any(|cell| !cell.is_empty()) {
                rows.push(row(path, &names, separator, &record)?);
            }
        }
        Ok(Self { names, rows })
    }

    /// Place of the first of these names that the table has.
    pub fn find(&self, names: &[&str]) -> Option<usize> {
        self.names.iter().position(|name| names.contains(&name.as_str()))
    }
}

fn row(
    path: &Path,
    names: &[String],
    separator: u8,
    record: &csv::StringRecord,
) -> Result<Vec<Option<f64>>, ColumnsError> {
    let (path, line) = (path.to_owned(), record.position().map_or(0, csv::Position::line));
    let (found, expected) = (record.len(), names.len());
    if found != expected {
        return Err(ColumnsError::Ragged {
            path,
            line,
            found,
            expected,
            comma: separator == b',' && found > expected,
        });
    }
    let mut numbers = Vec::with_capacity(expected);
    for (cell, column) in record.iter().zip(names) {
        // a decimal comma, where commas do not separate columns
        let text = if separator == b',' { cell.to_owned() } else { cell.replace(',', ".") };
        let number = (!text.is_empty()).then(|| text.parse()).transpose();
        let no_number = |_| {
            let (path, column, found) = (path.clone(), column.clone(), cell.to_owned());
            ColumnsError::NoNumber { path, line, column, found }
        };
        numbers.push(number.map_err(no_number)?);
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Columns, ColumnsError> {
        Columns::parse(Path::new("ink.csv"), text)
    }

    #[test]
    fn a_spreadsheets_table_reads_like_any_other() {
        let plain = parse("# mine\nwavelength_nm,kappa,n\n400,0.125,\n500,0.25,1.5\n").unwrap();
        let excel = parse("\u{feff}Wavelength_nm;kappa;n\r\n400;0,125;\r\n500;0,25;1,5\r\n").unwrap();
        let tabs = parse("wavelength_nm\tkappa\tn\n400\t0.125\t\n500\t0,25\t1,5\n").unwrap();
        assert_eq!(
            plain.rows,
            vec![vec![Some(400.0), Some(0.125), None], vec![Some(500.0), Some(0.25), Some(1.5)]]
        );
        assert_eq!((&excel, &tabs), (&plain, &plain));
        assert_eq!(plain.find(&["k", "kappa"]), Some(1));
    }

    #[test]
    fn decimal_commas_between_commas_are_explained() {
        let message = parse("wavelength_nm,kappa\n400,0,125\n").unwrap_err().to_string();
        assert!(
            message.contains("line 2: 3 cells under 2 columns; numbers with a decimal comma"),
            "{message}"
        );
        let message = parse("wavelength_nm;kappa\n400;much\n").unwrap_err().to_string();
        assert!(message.contains("column kappa: found \"much\""), "{message}");
        assert!(parse("# nothing\n").is_err());
        let message = parse("wavelength_nm,n,n\n400,1.4,1.5\n").unwrap_err().to_string();
        assert!(message.contains("column n is there twice"), "{message}");
    }
}
