//! Tables of instruments and spreadsheets: wavelengths down the first column with a column for each
//! sample, or wavelengths along the header with a row a sample.

use super::fields::{Declared, FieldTable, band};
use super::sample::{MeasuredFile, MeasuredSample, SampleContent, SpectralCell, Written};
use super::words::{self, MeasuredKind};
use crate::material::text_table::{TableBlock, TextLine, TextTable, wavelength_factor};

/// Fewest wavelengths in a header without names.
const FEWEST_BANDS: usize = 3;

/// All samples of a table.
///
/// # Errors
/// No table of spectra is found, or one has a row that does not fit it.
pub fn read(path: String, text: &str) -> Result<MeasuredFile, String> {
    if text.lines().any(|line| line.starts_with("##") && line.contains('=')) && text.contains("##XYDATA") {
        return Err("JCAMP-DX is not read: let the instrument's program write CSV".into());
    }
    let table = TextTable::parse(path, text).map_err(|error| error.to_string())?;
    let mut file = MeasuredFile::default();
    if let Some(header) = header_of_rows(&table) {
        rows_of_samples(&table, header, &mut file);
        return Ok(file);
    }
    let blocks = table.blocks().map_err(|error| error.to_string())?;
    if blocks.is_empty() {
        return Err(no_rows(&table));
    }
    for block in &blocks {
        columns_of_samples(&table, block, &mut file)?;
    }
    Ok(file)
}

/// What is wrong with a table that has no row of numbers.
fn no_rows(table: &TextTable) -> String {
    let mut lines = table.lines.iter().filter(|line| !line.remark);
    match (lines.next(), lines.next()) {
        (None, _) => "it is empty; a table has wavelengths in nm and reflectances".into(),
        (Some(header), None) => {
            let header = header.cells.join(", ");
            format!("0 rows of numbers under {header:?}; a spectrum has at least 2")
        }
        (_, Some(line)) => table.no_number(line, None).to_string(),
    }
}

/// Place of the header of a table with one row a sample: wavelengths or L*, a*, b* are fields.
fn header_of_rows(table: &TextTable) -> Option<usize> {
    let lines = table.lines.iter().enumerate().filter(|(_, line)| !line.remark);
    for (i, line) in lines {
        let numbers = line.cells.iter().filter(|cell| table.number(cell).is_some()).count();
        let fields = FieldTable::new(&line.cells);
        let values: Vec<f64> = line
            .cells
            .iter()
            .filter(|name| band(name).is_some())
            .filter_map(|name| table.number(name))
            .collect();
        let ordered = |is: fn(f64, f64) -> bool| values.windows(2).all(|pair| is(pair[0], pair[1]));
        // numbers alone are wavelengths where all are
        let only_bands = values.len() == numbers
            && values.len() >= FEWEST_BANDS
            && (ordered(|a, b| a < b) || ordered(|a, b| a > b));
        let is_wavelength = |name: &String| wavelength_factor(name).is_some() && band(name).is_none();
        if line.cells.first().is_some_and(is_wavelength) {
            let next = table.lines[i + 1..].iter().find(|next| !next.remark);
            let starts = next.and_then(|next| table.number(&next.cells[0]));
            let rows_begin_with_wavelengths = starts.is_some_and(|value| band(&value.to_string()).is_some());
            return (only_bands && !rows_begin_with_wavelengths).then_some(i);
        }
        let only_colours = fields.is_measured() && !fields.has_spectra() && line.cells.len() >= 3;
        let one_value_a_row = fields.has_spectra() && fields.bands() == 0 && names_a_sample(&line.cells);
        let is_header =
            if numbers == 0 { fields.bands() >= 2 || only_colours || one_value_a_row } else { only_bands };
        if is_header {
            return Some(i);
        }
        if table.number(&line.cells[0]).is_some() && numbers > 1 {
            return None;
        }
    }
    None
}

fn written(line: &TextLine, cell: &str) -> Written {
    Written { text: cell.to_owned(), line: line.line }
}

/// Takes in the rows under a header of wavelengths.
fn rows_of_samples(table: &TextTable, header: usize, into: &mut MeasuredFile) {
    let mut names = table.lines[header].cells.clone();
    if names.iter().all(|name| band(name).is_some()) || names.is_empty() {
        // the cell above the names is left out
        let longer = |line: &&TextLine| !line.remark && line.cells.len() == names.len() + 1;
        if table.lines[header + 1..].iter().find(|line| !line.remark).filter(longer).is_some() {
            names.insert(0, "name".into());
        }
    }
    // a first column without a title, or with the wavelengths' title, names the samples
    let first_is_free = names.first().is_some_and(|name| band(name).is_none());
    if first_is_free && FieldTable::new(&names).names_end() > 0 && !names_a_sample(&names) {
        names[0] = "name".into();
    }
    let fields = FieldTable::new(&names);
    let declared =
        declared(table.lines[..header].iter().flat_map(|line| &line.cells).chain(&table.lines[header].cells));
    for line in table.lines[header + 1..].iter().filter(|line| !line.remark) {
        let mut cells: Vec<Written> = line.cells.iter().map(|cell| written(line, cell)).collect();
        let count = cells.len();
        if count != names.len() {
            cells.truncate(fields.names_end().min(count));
            let text = format!("{count} cells under {} columns", names.len());
            cells.resize(names.len(), Written { text, line: line.line });
        }
        fields.take(&cells, &declared, into);
    }
}

/// Whether fields name samples themselves.
fn names_a_sample(names: &[String]) -> bool {
    let known = ["name", "id", "sample", "patch", "label", "color", "colour"];
    names.iter().any(|name| known.iter().any(|word| name.to_lowercase().contains(word)))
}

/// Columns that hold no reflectance; matched as whole words.
const OTHER_COLUMNS: [&str; 31] = [
    "lab",
    "l",
    "a",
    "b",
    "x",
    "y",
    "z",
    "n",
    "k",
    "kappa",
    "t",
    "abs",
    "absorbance",
    "absorption",
    "od",
    "intensity",
    "counts",
    "dark",
    "reference",
    "sd",
    "std",
    "stdev",
    "error",
    "err",
    "uncertainty",
    "sigma",
    "sem",
    "transmission",
    "density",
    "time",
    "index",
];
/// Words of columns that hold reflectances.
const REFLECTANCES: [&str; 8] =
    ["reflectance", "reflectivity", "reflection", "refl", "albedo", "r", "value", "brf"];

/// What the header of a column says it holds.
#[derive(PartialEq)]
enum ColumnKind {
    Reflectance,
    Transmittance,
    Other,
    Name,
}

impl ColumnKind {
    fn of(name: &str) -> Self {
        let words = words::word_list(name);
        let is = |all: &[&str]| words.iter().any(|word| all.contains(&word.as_str()));
        if name.to_lowercase().contains("transmi") || words == ["t"] {
            Self::Transmittance
        } else if is(&["error", "err", "sd", "std", "stdev", "uncertainty", "sigma", "sem"]) {
            // of whatever stands before it
            Self::Other
        } else if is(&REFLECTANCES) {
            Self::Reflectance
        } else if words.iter().all(|word| OTHER_COLUMNS.contains(&word.as_str())) && !words.is_empty() {
            Self::Other
        } else {
            Self::Name
        }
    }
}

/// Takes in the columns of a block whose first column holds wavelengths.
fn columns_of_samples(table: &TextTable, block: &TableBlock, into: &mut MeasuredFile) -> Result<(), String> {
    let names = &block.names;
    let width = block.rows[0].cells.len();
    let mut place = 0;
    let mut factor = 1.0;
    if !names.is_empty() {
        let Some(found) = names.iter().position(|name| wavelength_factor(name).is_some()) else {
            return Err(format!(
                "{}: column wavelength_nm is missing; found {}",
                table.path,
                names.join(", ")
            ));
        };
        place = found;
        factor = wavelength_factor(&names[found]).unwrap_or(1.0);
    }
    let name = |column: usize| names.get(column).map_or("", String::as_str);
    let mut columns: Vec<usize> = (0..width).filter(|&column| column != place).collect();
    if names.is_empty() {
        columns.retain(|&column| !block.rows.iter().all(|row| row.cells[column].is_empty()));
    } else {
        let kinds: Vec<ColumnKind> = names.iter().map(|name| ColumnKind::of(name)).collect();
        // columns that say so hold the reflectances, else those with a name of their own
        let all = columns.clone();
        for kind in [ColumnKind::Reflectance, ColumnKind::Name, ColumnKind::Transmittance] {
            columns = all
                .iter()
                .copied()
                .filter(|&column| kinds[column] == kind && !name(column).is_empty())
                .collect();
            if !columns.is_empty() {
                break;
            }
        }
        if columns.is_empty() {
            return Err(format!("{}: column reflectance is missing; found {}", table.path, names.join(", ")));
        }
    }
    let above = declared(block.preamble.iter());
    let several = columns.len() > 1;
    for &column in &columns {
        let mut of_column = declared([name(column).to_owned()].iter());
        if name(column).contains('%') || name(column).to_lowercase().contains("percent") {
            of_column.white = Some(100.0);
        }
        let cell = |row: &TextLine| SpectralCell {
            nm: table.number(&row.cells[place]).map(|value| in_nm(value, factor)),
            value: written(row, &row.cells[column]),
        };
        let spectrum: Vec<SpectralCell> = block.rows.iter().map(cell).collect();
        let percent = spectrum.iter().any(|cell| cell.value.text.ends_with('%')).then_some(100.0);
        let title = block.preamble.last().cloned().filter(|title| !title.contains(['=', ':']));
        let sample_name = if several { Some(name(column).to_owned()) } else { title };
        let kind = if ColumnKind::of(name(column)) == ColumnKind::Transmittance {
            MeasuredKind::Transmittance
        } else {
            above.kind
        };
        into.samples.push(MeasuredSample {
            names: sample_name.into_iter().filter(|name| !name.is_empty()).collect(),
            device: Vec::new(),
            condition: of_column.condition.or(above.condition),
            geometry: of_column.geometries.into_iter().chain(above.geometries.clone()).next(),
            kind,
            white: percent.or(of_column.white).or(above.white),
            content: SampleContent::Spectrum(spectrum),
        });
    }
    Ok(())
}

/// A wavelength in nm, without the rounding of its conversion.
fn in_nm(value: f64, factor: f64) -> f64 {
    if factor == 1.0 { value } else { (value * factor * 1e6).round() / 1e6 }
}

/// What lines of text declare.
fn declared<'a>(texts: impl Iterator<Item = &'a String>) -> Declared {
    let mut all = Declared::default();
    for text in texts {
        let lower = text.to_lowercase();
        let about =
            ["reflect", "%r", "r%", "% r", "r [%", "r (%", "r(%", "r[%", "unit", "ordinate", "albedo"];
        if about.iter().any(|word| lower.contains(word)) || lower.trim() == "%" {
            if lower.contains('%') || lower.contains("percent") {
                all.white = Some(100.0);
            } else if lower.contains("factor")
                || lower.contains("share")
                || lower.contains("0-1")
                || lower.contains("0..1")
            {
                all.white = all.white.or(Some(1.0));
            }
        }
        all.condition = all.condition.or(words::conditions(text).first().copied());
        all.geometries.extend(words::geometries(text));
        let measured = lower.contains("mode") || lower.contains("type") || lower.contains("ordinate");
        if measured && let Some(kind) = MeasuredKind::of(text) {
            all.kind = kind;
        }
    }
    all
}
