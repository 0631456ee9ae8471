//! Numerical tables as spreadsheets export them: commas, semicolons or tabs, decimal points or
//! decimal commas.
//!
//! In many countries, spreadsheets write `;` between columns and `,` in numbers. The header line
//! determines which convention a file uses; a mixed file is rejected with an explanation.
//!
//! Also ranges of tables, and gaps between their rows too wide to interpolate without a warning.

use crate::numerics::allowed::brief;
use crate::numerics::files::{self, FileError};
use csv::StringRecord;
use std::collections::HashSet;
use std::path::Path;

/// Shortest plausible wavelength in a table of optical constants, nm; smaller numbers are probably
/// µm.
const LEAST_NM: f64 = 10.0;
/// Wider tables are no spectra; instruments write some hundred columns.
const MOST_COLUMNS: usize = 10_000;

/// The largest wavelength, if the wavelengths are too small to be in nm.
pub fn micrometres(wavelengths_nm: impl IntoIterator<Item = f64>) -> Option<f64> {
    let largest = wavelengths_nm.into_iter().reduce(f64::max)?;
    (0.0 < largest && largest < LEAST_NM).then_some(largest)
}

/// What wavelengths from `low` to `high`, read as nm, are in another unit, where they have nothing
/// in common with those that are needed and would have in that unit: what they look like, and how
/// to write them in nm.
pub fn in_other_unit([low, high]: [f64; 2], [from, to]: [f64; 2]) -> Option<String> {
    let meets = |[low, high]: [f64; 2]| low <= to && high >= from;
    let units = [
        ("ångström", [0.1 * low, 0.1 * high], "divide them by 10"),
        ("µm", [1e3 * low, 1e3 * high], "multiply them by 1000"),
        ("wavenumbers in 1/cm", [1e7 / high, 1e7 / low], "write 10000000 divided by each"),
    ];
    let is_none = low > 0.0 && !meets([low, high]);
    let (unit, _, remedy) = units.into_iter().find(|(_, range_nm, _)| is_none && meets(*range_nm))?;
    let [low, high] = [low, high].map(brief);
    Some(format!("wavelengths from {low} to {high} look like {unit}: if so, {remedy}, which gives nm"))
}

/// Columns by name, and rows of numbers; an empty cell is `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Columns {
    /// Path of the file.
    path: String,
    /// Names in lower case, as the header has them.
    pub names: Vec<String>,
    /// One list per line.
    pub rows: Vec<Vec<Option<f64>>>,
    /// Line number of each row, from 1.
    lines: Vec<u64>,
}

impl Columns {
    /// Reads a file; lines that start with `#` are comments.
    ///
    /// # Errors
    /// The file cannot be read, has no header, or a line that does not fit it.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let bytes = files::read_bytes(path, files::TABLE);
        let bytes = bytes.map_err(|error| FileError::new(path.display(), error))?;
        if bytes.contains(&0) {
            let what =
                "it is not plain text (UTF-16, or a spreadsheet's own format): save it as CSV in UTF-8";
            return Err(FileError::new(path.display(), what));
        }
        Self::parse(path.display().to_string(), &String::from_utf8_lossy(&bytes))
    }

    fn parse(path: String, text: &str) -> Result<Self, FileError> {
        let text = text.trim_start_matches('\u{feff}');
        let header = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'));
        let Some(header) = header else {
            return Err(FileError::new(path, "it is empty; the first line names the columns"));
        };
        let separator = [b';', b'\t'].into_iter().find(|&c| header.contains(char::from(c))).unwrap_or(b',');
        let columns = 1 + header.bytes().filter(|&c| c == separator).count();
        if columns > MOST_COLUMNS {
            let what = format!(
                "it has {columns} columns; at most {MOST_COLUMNS} are read: keep those of the spectrum"
            );
            return Err(FileError::new(path, what));
        }
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(separator)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.as_bytes());
        let headers = reader.headers().map_err(|error| FileError::new(&path, error))?;
        let names: Vec<String> = headers.iter().map(str::to_lowercase).collect();
        let mut seen = HashSet::new();
        if let Some(name) = names.iter().find(|name| !name.is_empty() && !seen.insert(*name)) {
            return Err(FileError::new(&path, format!("column {name} occurs twice; keep one of them")));
        }
        let mut table = Self { path, names, rows: Vec::new(), lines: Vec::new() };
        for record in reader.records() {
            let record = record.map_err(|error| FileError::new(&table.path, error))?;
            // Spreadsheets append lines of separators only.
            if record.iter().any(|cell| !cell.is_empty()) {
                let line = line_of(text, &record);
                table.rows.push(table.row(line, separator, &record)?);
                table.lines.push(line);
            }
        }
        Ok(table)
    }

    fn row(&self, line: u64, separator: u8, record: &StringRecord) -> Result<Vec<Option<f64>>, FileError> {
        let (place, found) = (format!("{}, line {line}", self.path), record.len());
        if found != self.names.len() {
            let mut reason = format!("{found} cells under {} columns", self.names.len());
            if separator == b',' && found > self.names.len() {
                reason += "; numbers with a decimal comma need a semicolon between columns (";
                reason += &(self.names.join(";") + ")");
            }
            return Err(FileError::new(place, reason));
        }
        let mut numbers = Vec::with_capacity(found);
        for (cell, column) in record.iter().zip(&self.names) {
            // a decimal comma, where commas do not separate columns
            let text = if separator == b',' { cell.to_owned() } else { cell.replace(',', ".") };
            let reason = format_args!("found {cell:?} where a number is needed");
            let wrong = |_| FileError::new(format_args!("{place}, column {column}"), reason);
            numbers.push((!text.is_empty()).then(|| text.parse().map_err(wrong)).transpose()?);
        }
        Ok(numbers)
    }

    /// Index of the first of these names among the columns.
    pub fn find(&self, names: &[&str]) -> Option<usize> {
        self.names.iter().position(|name| names.contains(&name.as_str()))
    }

    /// A column without empty cells.
    ///
    /// # Errors
    /// An empty cell.
    pub fn numbers(&self, place: usize) -> Result<Vec<f64>, FileError> {
        let empty = |line| {
            let at = format!("{}, line {line}, column {}", self.path, self.names[place]);
            FileError::new(at, "an empty cell; enter a number, or remove the line")
        };
        self.rows.iter().zip(&self.lines).map(|(row, line)| row[place].ok_or_else(|| empty(line))).collect()
    }

    /// A column of wavelengths without empty cells, nm.
    ///
    /// # Errors
    /// An empty cell, or wavelengths that look like µm.
    pub fn wavelengths_nm(&self, place: usize) -> Result<Vec<f64>, FileError> {
        let numbers = self.numbers(place)?;
        let Some(largest) = micrometres(numbers.iter().copied()) else { return Ok(numbers) };
        let reason = format!(
            "the largest wavelength is {largest}: these look like µm; the column must be in nm: multiply it by 1000"
        );
        Err(FileError::new(format_args!("{}, column {}", self.path, self.names[place]), reason))
    }
}

/// Line number of a record, from 1; the reader's position is before the empty lines and comments
/// that it skips.
pub(super) fn line_of(text: &str, record: &StringRecord) -> u64 {
    let Some(place) = record.position() else { return 0 };
    let rest = text.get(place.byte() as usize..).unwrap_or("");
    let skipped = rest.lines().take_while(|line| line.trim().is_empty() || line.starts_with('#'));
    place.line() + skipped.count() as u64
}

/// Spectra usually have rows every 5 to 20 nm; a wider gap than this can hide an absorption band,
/// nm.
const WORTH_TELLING_NM: f64 = 50.0;

/// The widest gap between increasing `rows_nm` within a range of wavelengths, if wide enough to
/// report.
pub fn widest_gap_nm(rows_nm: &[f64], [from, to]: [f64; 2]) -> Option<[f64; 2]> {
    let gaps = rows_nm.windows(2).map(|pair| [pair[0], pair[1]]);
    widest(gaps.filter(|gap| gap[0] < to && gap[1] > from && gap[1] - gap[0] > WORTH_TELLING_NM))
}

/// The widest of some gaps.
pub(in crate::material) fn widest(gaps: impl Iterator<Item = [f64; 2]>) -> Option<[f64; 2]> {
    gaps.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
}

/// The range common to all ranges.
pub(super) fn common(ranges: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    ranges.fold([0.0, f64::INFINITY], |[lo, hi], [a, b]| [f64::max(lo, a), f64::min(hi, b)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Columns, FileError> {
        Columns::parse("ink.csv".into(), text)
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
        assert_eq!((&excel.names, &tabs.names), (&plain.names, &plain.names));
        assert_eq!((&excel.rows, &tabs.rows), (&plain.rows, &plain.rows));
        assert_eq!(plain.find(&["k", "kappa"]), Some(1));
    }

    #[test]
    fn decimal_commas_between_commas_are_explained() {
        let message = parse("wavelength_nm,kappa\n400,0,125\n").unwrap_err().to_string();
        assert!(
            message.contains("line 2: 3 cells under 2 columns; numbers with a decimal comma"),
            "{message}"
        );
        assert!(message.ends_with("(wavelength_nm;kappa)"), "{message}");
        let message = parse("wavelength_nm,reflectance\n400,0,5\n").unwrap_err().to_string();
        assert!(message.ends_with("(wavelength_nm;reflectance)"), "{message}");
        let message = parse("wavelength_nm;kappa\n400;much\n").unwrap_err().to_string();
        assert!(message.contains("column kappa: found \"much\""), "{message}");
        assert!(parse("# nothing\n").is_err());
        let message = parse("wavelength_nm,n,n\n400,1.4,1.5\n").unwrap_err().to_string();
        assert!(message.contains("column n occurs twice"), "{message}");
    }

    #[test]
    fn a_table_of_a_million_columns_is_refused_before_it_is_read() {
        let header = (0..1_000_000).map(|i| format!("c{i}")).collect::<Vec<_>>().join(",");
        let begun = std::time::Instant::now();
        let message = parse(&header).unwrap_err().to_string();
        assert!(message.contains("it has 1000000 columns; at most 10000 are read"), "{message}");
        // compared with each other, the names take minutes
        assert!(begun.elapsed().as_secs() < 5, "{:?}", begun.elapsed());
    }

    #[test]
    fn empty_cells_and_micrometres_are_told_with_their_place() {
        let table = parse("# mine\nwavelength_nm,kappa\n400,0.1\n\n500,\n").unwrap();
        assert_eq!(table.wavelengths_nm(0).unwrap(), [400.0, 500.0]);
        let message = table.numbers(1).unwrap_err().to_string();
        assert!(message.contains("ink.csv, line 5, column kappa: an empty cell"), "{message}");
        let table = parse("wavelength_nm,kappa\n0.4,0.1\n0.7,0.2\n").unwrap();
        let message = table.wavelengths_nm(0).unwrap_err().to_string();
        assert!(message.contains("0.7: these look like µm; the column must be in nm"), "{message}");
    }

    #[test]
    fn the_widest_gap_inside_the_range_counts() {
        let rows = [300.0, 400.0, 450.0, 530.0, 590.0, 900.0];
        assert_eq!(widest_gap_nm(&rows, [400.0, 590.0]), Some([450.0, 530.0]));
        assert_eq!(widest_gap_nm(&rows, [400.0, 450.0]), None);
        assert_eq!(widest_gap_nm(&rows, [500.0, 500.0]), Some([450.0, 530.0]));
        assert_eq!(widest_gap_nm(&rows, [450.0, 450.0]), None, "a wavelength on a row");
        assert_eq!(widest_gap_nm(&[400.0, 700.0], [420.0, 680.0]), Some([400.0, 700.0]));
    }

    /// *Planted*: tables in nm that lie beyond the light taken for ångström.
    #[test]
    fn wavelengths_in_another_unit_are_told() {
        let visible = [400.0, 700.0];
        for (range, words) in [
            ([3000.0, 8000.0], Some("ångström: if so, divide them by 10")),
            ([0.3, 20.0], Some("µm: if so, multiply them by 1000")),
            ([12_500.0, 25_000.0], Some("1/cm: if so, write 10000000 divided by each")),
            ([380.0, 4000.0], None),
            ([750.0, 2500.0], None),
            ([200.0, 390.0], None),
            ([-5.0, 0.0], None),
        ] {
            let said = in_other_unit(range, visible);
            assert_eq!(said.is_some(), words.is_some(), "{range:?}: {said:?}");
            assert!(said.unwrap_or_default().contains(words.unwrap_or_default()), "{range:?}");
        }
    }
}
