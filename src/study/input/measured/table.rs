//! Tables of instruments and spreadsheets: wavelengths down the first column with a column for each
//! sample, or wavelengths along the header with a row a sample.

use super::columns;
use super::fields::{FieldTable, band};
use super::quantity::{declared, declared_quantity};
use super::sample::{MeasuredFile, Written};
use crate::material::text_table::{TextLine, TextTable, wavelength_factor};

/// Fewest wavelengths in a header without names.
const FEWEST_BANDS: usize = 3;

/// All samples of a table.
///
/// # Errors
/// No table of spectra is found, or one has a row that does not fit it.
pub fn read(path: String, text: &str) -> Result<MeasuredFile, String> {
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
        columns::samples(&table, block, &mut file)?;
    }
    Ok(file)
}

/// Why a text in JCAMP-DX is not read, if it is one: its values may be packed, scaled and of any
/// quantity.
pub fn jcamp_refusal(text: &str) -> Option<String> {
    let mut states = String::new();
    let mut is_jcamp = false;
    for line in text.lines().filter_map(|line| line.trim_start().strip_prefix("##")) {
        let Some((label, value)) = line.split_once('=') else { continue };
        let label: String = label.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_uppercase();
        is_jcamp |= ["JCAMPDX", "JCAMPCS", "XYDATA", "XYPOINTS", "PEAKTABLE", "XUNITS", "YUNITS"]
            .contains(&label.as_str());
        if label == "YUNITS" && states.is_empty() {
            states = format!(" (its YUNITS are {})", value.trim());
        }
    }
    is_jcamp.then(|| {
        format!(
            "JCAMP-DX is not read{states}: let the instrument's program write reflectance as CSV, wavelengths in nm \
             (wavelength_nm,reflectance)"
        )
    })
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
    let mut declared =
        declared(table.lines[..header].iter().flat_map(|line| &line.cells).chain(&table.lines[header].cells));
    let above = table.lines[..header].iter().map(|line| line.cells.join(" "));
    declared.kind = above.rev().find_map(|line| declared_quantity(&line)).unwrap_or(declared.kind);
    for line in table.lines[header + 1..].iter().filter(|line| !line.remark) {
        let mut cells: Vec<Written> = line.cells.iter().map(|cell| Written::of(line, cell)).collect();
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
