//! Tables of numbers as instruments, spreadsheets and websites write them: any usual separator,
//! decimal points or commas, with or without a header, remarks, lines of text before the numbers,
//! and several tables one after another.

mod encoding;
mod separator;
mod wavelength_column;

pub use encoding::{read_text, with_line_feeds};
pub use separator::{Separator, number};
pub use wavelength_column::{numbered_wavelength_factor, wavelength_factor};

use crate::numerics::files::FileError;
use separator::guessed;
use std::path::Path;

/// Most cells in a line: a spectrum from 200 to 2500 nm in steps of 0.2 nm has 11 500.
const MOST_COLUMNS: usize = 16_384;
/// Most cells in a file: some hundred megabytes in memory.
const MOST_CELLS: usize = 4_000_000;

/// A line of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct TextLine {
    /// Its number, from 1.
    pub line: usize,
    /// Its cells, without blanks around them.
    pub cells: Vec<String>,
    /// Whether it is a remark, which begins with `#`.
    pub remark: bool,
}

/// The lines of a file that are not empty.
#[derive(Clone, Debug, PartialEq)]
pub struct TextTable {
    /// Path of the file, for messages.
    pub path: String,
    /// What separates its cells.
    pub separator: Separator,
    /// Its lines; empty ones, and lines of separators only, are left out.
    pub lines: Vec<TextLine>,
}

/// Rows of numbers under one header.
#[derive(Clone, Debug, PartialEq)]
pub struct TableBlock {
    /// Lines of text and remarks between the block before and this one's header.
    pub preamble: Vec<String>,
    /// The header as written; empty if the block has none.
    pub names: Vec<String>,
    /// Rows with equally many cells. The first is a number; of several pairs of a wavelength and
    /// its value the first may be at its end, and is empty then.
    pub rows: Vec<TextLine>,
}

impl TextTable {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, is no text, or has more cells than a table of spectra.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path.display().to_string(), &read_text(path)?)
    }

    /// Splits a text into cells. A first line `sep=;` states the separator.
    ///
    /// # Errors
    /// Too many cells.
    pub fn parse(path: String, text: &str) -> Result<Self, FileError> {
        let stated = text.lines().next().and_then(|first| first.trim().strip_prefix("sep="));
        let stated = stated.and_then(|rest| rest.chars().next());
        let separator = stated.map_or_else(|| guessed(text), Separator::Character);
        let mut table = Self { path, separator, lines: Vec::new() };
        let indent = table.indent(text);
        let mut count = 0;
        for (i, written) in text.lines().enumerate().skip(usize::from(stated.is_some())) {
            let (line, trimmed) = (i + 1, written.trim());
            let remark = trimmed.starts_with('#');
            let content = trimmed.trim_start_matches('#');
            let width = match separator {
                Separator::Character(character) => content.matches(character).count() + 1,
                Separator::Blanks => content.split_whitespace().take(MOST_COLUMNS + 1).count(),
            };
            count += width;
            if width > MOST_COLUMNS || count > MOST_CELLS {
                let reason = format!(
                    "more than {MOST_COLUMNS} cells in a line, or {MOST_CELLS} in all: no table of spectra"
                );
                return Err(FileError::new(format_args!("{}, line {line}", table.path), reason));
            }
            let mut cells = table.cells(content);
            if indent.is_some() && !remark && table.number(&cells[0]).is_some() {
                // of pairs of columns the first is at its end
                let free = leading_tabs(written).saturating_sub(indent.unwrap_or(0));
                cells.splice(0..0, vec![String::new(); free.min(MOST_COLUMNS)]);
            }
            if cells.iter().any(|cell| !cell.is_empty()) {
                table.lines.push(TextLine { line, cells, remark });
            }
        }
        Ok(table)
    }

    /// Tabs before every row of a table that tabs separate; `None` for others.
    fn indent(&self, text: &str) -> Option<usize> {
        let begins = |line: &&str| {
            let first = line.trim().split('\t').next().unwrap_or_default();
            self.number(first).is_some()
        };
        let is_tab = self.separator == Separator::Character('\t');
        is_tab.then(|| text.lines().filter(begins).map(leading_tabs).min().unwrap_or(0))
    }

    /// Cells of a line; between quotes separators do not count.
    fn cells(&self, line: &str) -> Vec<String> {
        let delimiter = match self.separator {
            Separator::Character(character) => u8::try_from(character).ok(),
            Separator::Blanks => Some(b' '),
        };
        if let (true, Some(delimiter)) = (line.contains('"'), delimiter) {
            let mut reader = csv::ReaderBuilder::new();
            let reader = reader.has_headers(false).delimiter(delimiter).trim(csv::Trim::All);
            if let Some(Ok(record)) = reader.from_reader(line.as_bytes()).records().next() {
                return record.iter().map(str::to_owned).collect();
            }
        }
        self.separator.cells(line).into_iter().map(str::to_owned).collect()
    }

    /// The number in a cell.
    pub fn number(&self, cell: &str) -> Option<f64> {
        self.separator.number(cell)
    }

    /// The blocks of rows that begin with a number, each under the line above it if that is a
    /// header: text with as many cells. A remark directly above a block without a header is one.
    ///
    /// # Errors
    /// A row whose number of cells is not that of its header, or that does not begin with a number
    /// between others that do.
    pub fn blocks(&self) -> Result<Vec<TableBlock>, FileError> {
        let mut blocks: Vec<TableBlock> = Vec::new();
        let mut texts: Vec<&TextLine> = Vec::new();
        let mut open = false;
        for line in &self.lines {
            if line.remark {
                texts.push(line);
                continue;
            }
            let others = line.cells.iter().skip(1).filter(|cell| self.number(cell).is_some()).count();
            let of_pairs =
                open && blocks.last().is_some_and(|block| self.is_of_later_pair(line, &block.names));
            let starts = of_pairs || self.number(&line.cells[0]).is_some();
            if open && (starts || others > 0) {
                let names = blocks.last().map(|block| block.names.clone()).unwrap_or_default();
                let width = blocks.last().map_or(0, |block| block.rows[0].cells.len());
                let row = self.fitted(line, width, &names)?;
                if !starts {
                    return Err(self.no_number(line, names.first()));
                }
                if let Some(block) = blocks.last_mut() {
                    block.rows.push(row);
                }
            } else if starts && line.cells.len() > 1 {
                let names = self.header(&mut texts, line)?;
                let width = if names.is_empty() { line.cells.len() } else { names.len() };
                let rows = vec![self.fitted(line, width, &names)?];
                let preamble = texts.drain(..).map(|text| text.cells.join(" ")).collect();
                blocks.push(TableBlock { preamble, names, rows });
                open = true;
            } else {
                let above = texts.last().filter(|text| !text.remark && text.cells.len() == line.cells.len());
                if let Some(header) =
                    above.filter(|text| others > 0 && wavelength_factor(&text.cells[0]).is_some())
                {
                    return Err(self.no_number(line, header.cells.first()));
                }
                texts.push(line);
                open = false;
            }
        }
        Ok(blocks)
    }

    /// Whether the first pair of columns, a wavelength and its value, is at its end in a row, and a
    /// later one goes on.
    fn is_of_later_pair(&self, line: &TextLine, names: &[String]) -> bool {
        let mut pairs = names.iter().zip(&line.cells).skip(1);
        let goes_on = |(name, cell): (&String, &String)| {
            numbered_wavelength_factor(name).is_some() && self.number(cell).is_some()
        };
        line.cells[0].is_empty() && pairs.any(goes_on)
    }

    /// The row with exactly this number of cells; empty ones at its end may be too many or, where
    /// there are several columns of wavelengths, missing.
    fn fitted(&self, line: &TextLine, width: usize, names: &[String]) -> Result<TextLine, FileError> {
        let mut row = line.clone();
        let wavelengths = names.iter().filter(|name| numbered_wavelength_factor(name).is_some()).count();
        if wavelengths > 1 && row.cells.len() < width {
            row.cells.resize(width, String::new());
        }
        while row.cells.len() > width && row.cells.last().is_some_and(String::is_empty) {
            row.cells.pop();
        }
        if row.cells.len() == width {
            return Ok(row);
        }
        let mut reason = format!("{} cells under {width} columns", row.cells.len());
        if self.separator == Separator::Character(',') && row.cells.len() > width {
            reason += "; numbers with a decimal comma need a semicolon between columns";
            if !names.is_empty() {
                reason += &format!(" ({})", names.join(";").to_lowercase());
            }
        }
        Err(FileError::new(format_args!("{}, line {}", self.path, line.line), reason))
    }

    /// The header of a block that begins with this row, taken out of the lines above it.
    fn header(&self, texts: &mut Vec<&TextLine>, row: &TextLine) -> Result<Vec<String>, FileError> {
        let Some(&last) = texts.last() else { return Ok(Vec::new()) };
        let mut names = last.cells.clone();
        while names.len() > row.cells.len() && names.last().is_some_and(String::is_empty) {
            names.pop();
        }
        // numbers name samples only beside a column of wavelengths
        let is_header = names.len() > 1
            && !names[0].is_empty()
            && (names.iter().all(|name| self.number(name).is_none())
                || wavelength_factor(&names[0]).is_some());
        let remark_of_other_width = last.remark && names.len() != row.cells.len();
        if !is_header || remark_of_other_width {
            return Ok(Vec::new());
        }
        texts.pop();
        Ok(names)
    }

    /// A cell that should hold a number.
    pub fn no_number(&self, line: &TextLine, column: Option<&String>) -> FileError {
        let place = format!("{}, line {}", self.path, line.line);
        let place = column.map_or(place.clone(), |name| format!("{place}, column {name}"));
        let cell = &line.cells[0];
        match cell.is_empty() {
            true => FileError::new(place, "an empty cell; enter a number, or remove the line"),
            false => FileError::new(place, format_args!("found {cell:?} where a number is needed")),
        }
    }
}

/// Tabs that a line begins with.
fn leading_tabs(line: &str) -> usize {
    line.chars()
        .take_while(|character| character.is_whitespace())
        .filter(|character| *character == '\t')
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(text: &str) -> Vec<TableBlock> {
        TextTable::parse("a.csv".into(), text).unwrap().blocks().unwrap()
    }

    fn numbers(text: &str) -> Vec<Vec<f64>> {
        let table = TextTable::parse("a.csv".into(), text).unwrap();
        let block = table.blocks().unwrap().remove(0);
        let of = |row: &TextLine| {
            let written = row.cells.iter().filter(|cell| !cell.is_empty());
            written.map(|cell| table.number(cell).unwrap()).collect()
        };
        block.rows.iter().map(of).collect()
    }

    #[test]
    fn the_same_table_however_it_is_written() {
        let rows = vec![vec![400.0, 0.25], vec![500.0, 12.5]];
        for text in [
            "nm,r\n400,0.25\n500,12.5\n",
            "400,0.25\n500,12.5\n",
            "sep=;\nnm;r\n400;0,25\n500;12,5\n",
            "sep=,\r\nnm,r\r\n400,0.25\r\n500,12.5\r\n",
            "nm;r\n400;0,25\n500;12,5\n",
            "nm\tr\n400\t0,25\n500\t12.5\n",
            "nm   r\n400   0.25\n500   12.5\n",
            "# a remark\nnm, r\n400, 0.25\n# another\n\n500, 12.5\n;;\n",
            "Instrument: X 1, serial 12\nDate,2020\n\"nm\",\"r, of white\"\n400,0.25\n500,12.5\n",
            "nm,r,,\n400,0.25,,\n500,12.5,,\n",
            "nm,r\n400,0.25\n500,12.5%\n",
        ] {
            assert_eq!(numbers(text), rows, "{text}");
        }
    }

    #[test]
    fn pairs_of_columns_may_be_of_different_lengths() {
        let head = "nm\ta\tnm.1\tb\n400\t0.1\t410\t0.2\n500\t0.3\t510\t0.4\n";
        let of = |text: &str| -> Vec<Vec<String>> {
            blocks(text).remove(0).rows.into_iter().map(|row| row.cells).collect()
        };
        let first = ["600", "0.5", "", ""];
        let second = ["", "", "610", "0.6"];
        for end in ["600\t0.5\n", "600\t0.5\t\t\n", "600\t0.5\t\t\t\n"] {
            assert_eq!(of(&format!("{head}{end}"))[2], first, "{end:?}");
        }
        assert_eq!(of(&format!("{head}\t\t610\t0.6\n"))[2], second);
        let commas = head.replace('\t', ",");
        assert_eq!(of(&format!("{commas}600,0.5\n"))[2], first);
        assert_eq!(of(&format!("{commas},,610,0.6\n"))[2], second);
        // a table that is indented as a whole
        assert_eq!(of("nm\ta\n\t400\t0.1\n\t500\t0.2\n")[1], ["500", "0.2"]);
        // one column of wavelengths: a cell is missing
        let table = TextTable::parse("a.csv".into(), "nm\ta\tb\n400\t0.1\t0.2\n500\t0.3\n").unwrap();
        assert!(table.blocks().unwrap_err().to_string().contains("line 3: 2 cells under 3 columns"));
    }

    #[test]
    fn tables_one_after_another_keep_their_headers() {
        let two = blocks("wl,n\n0.4,1.5\n0.5,1.4\n\nwl,k\n0.4,0.1\n0.5,0.2\n");
        assert_eq!(two.len(), 2);
        assert_eq!((two[0].names[1].as_str(), two[1].names[1].as_str(), two[1].rows.len()), ("n", "k", 2));
        let titled = blocks("first\nnm,r\n400,1\n500,1\nsecond\nnm,r\n400,2\n500,2\n");
        assert_eq!(
            (titled[1].preamble.as_slice(), titled[1].rows.len()),
            (["second".to_owned()].as_slice(), 2)
        );
        assert_eq!(blocks("# nm r\n400 1\n500 2\n")[0].names, ["nm", "r"]);
        assert!(blocks("name,a\n").is_empty());
    }

    #[test]
    fn a_row_that_does_not_fit_is_named_by_its_line() {
        let error =
            |text: &str| TextTable::parse("a.csv".into(), text).unwrap().blocks().unwrap_err().to_string();
        let comma = error("nm,r\n400,0,25\n500,0,5\n");
        assert!(comma.contains("line 2: 3 cells under 2 columns; numbers with a decimal comma"), "{comma}");
        assert!(error("nm,r\n4l0,1\n410,2\n").contains("line 2, column nm: found \"4l0\""));
        assert!(error("nm,r\n400,1\n4l0,2\n420,3\n").contains("line 3, column nm: found \"4l0\""));
        let wide = format!("nm{}\n", ",1".repeat(1_000_000));
        let wide = TextTable::parse("a.csv".into(), &wide).unwrap_err().to_string();
        assert!(wide.contains("line 1: more than 16384 cells"), "{wide}");
    }
}
