//! Tables with wavelengths down a column, and a column for each sample behind it.

use super::quantity::{declared, declared_quantity, other_quantity};
use super::sample::{MeasuredFile, MeasuredSample, SampleContent, SpectralCell, Written};
use super::words::{self, MeasuredKind};
use crate::material::text_table::{Separator, TableBlock, TextLine, TextTable, numbered_wavelength_factor};

/// Wavelengths, nm, that no reflectance in percent reaches.
const WAVELENGTHS_NM: std::ops::RangeInclusive<f64> = 200.0..=2600.0;
/// Fewest rows that show whether a column holds wavelengths.
const FEWEST_ROWS: usize = 2;

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

/// Whether the name of a column says in full that reflectances stand below it.
fn names_reflectance(name: &str) -> bool {
    let words = words::word_list(name);
    words.iter().any(|word| ["reflectance", "reflectivity", "refl", "albedo", "brf"].contains(&word.as_str()))
}

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
        if is(&["error", "err", "sd", "std", "stdev", "uncertainty", "sigma", "sem"]) {
            // of whatever stands before it
            Self::Other
        } else if let Some(quantity) = other_quantity(name) {
            if quantity == MeasuredKind::Transmittance { Self::Transmittance } else { Self::Other }
        } else if is(&REFLECTANCES) {
            Self::Reflectance
        } else if words.iter().all(|word| OTHER_COLUMNS.contains(&word.as_str())) && !words.is_empty() {
            Self::Other
        } else {
            Self::Name
        }
    }
}

/// A column of wavelengths.
#[derive(Clone, Copy)]
struct WavelengthColumn {
    place: usize,
    /// From its unit to nm.
    factor: f64,
}

impl WavelengthColumn {
    /// The column at a place, if its name says so.
    fn of(place: usize, name: &str) -> Option<Self> {
        Some(Self { place, factor: numbered_wavelength_factor(name)? })
    }

    /// The wavelength of a row, nm.
    fn nm(self, table: &TextTable, row: &TextLine) -> Option<f64> {
        table.number(&row.cells[self.place]).map(|value| in_nm(value, self.factor))
    }
}

/// The columns of wavelengths of a block, by its header, or else the first column.
fn wavelength_columns(table: &TextTable, block: &TableBlock) -> Result<Vec<WavelengthColumn>, String> {
    if block.names.is_empty() {
        return Ok(vec![WavelengthColumn { place: 0, factor: 1.0 }]);
    }
    let named = block.names.iter().enumerate();
    let found: Vec<WavelengthColumn> =
        named.filter_map(|(place, name)| WavelengthColumn::of(place, name)).collect();
    if found.is_empty() {
        let names = block.names.join(", ");
        return Err(format!("{}: column wavelength_nm is missing; found {names}", table.path));
    }
    Ok(found)
}

/// The columns that hold what is measured: those that say so, else those with a name of their own.
fn value_columns(
    table: &TextTable,
    block: &TableBlock,
    wavelengths: &[WavelengthColumn],
) -> Result<Vec<usize>, String> {
    let names = &block.names;
    let width = block.rows[0].cells.len();
    let is_wavelength = |column: &usize| wavelengths.iter().any(|known| known.place == *column);
    let others: Vec<usize> = (0..width).filter(|column| !is_wavelength(column)).collect();
    if names.is_empty() {
        let holds = |column: &usize| !block.rows.iter().all(|row| row.cells[*column].is_empty());
        return Ok(others.into_iter().filter(holds).collect());
    }
    let kinds: Vec<ColumnKind> = names.iter().map(|name| ColumnKind::of(name)).collect();
    for kind in [ColumnKind::Reflectance, ColumnKind::Name, ColumnKind::Transmittance] {
        let is_kind = |column: &usize| kinds[*column] == kind && !names[*column].is_empty();
        let columns: Vec<usize> = others.iter().copied().filter(is_kind).collect();
        if !columns.is_empty() {
            return Ok(columns);
        }
    }
    let quantities = others.iter().filter_map(|&i| Some((&names[i], other_quantity(&names[i])?)));
    let quantities: Vec<String> =
        quantities.map(|(name, kind)| format!("; {name:?} is {}, not reflectance", kind.name())).collect();
    Err(format!(
        "{}: column reflectance is missing; found {}{}",
        table.path,
        names.join(", "),
        quantities.concat()
    ))
}

/// The wavelengths of a column of values: those of the column before it.
fn wavelengths_of(
    column: usize,
    table: &TextTable,
    block: &TableBlock,
    wavelengths: &[WavelengthColumn],
) -> Result<WavelengthColumn, String> {
    if let [one] = wavelengths {
        return Ok(*one);
    }
    let name = block.names.get(column).map_or("", String::as_str);
    let remedy = "put each column of wavelengths before its values, or leave one pair of columns in the file";
    let before = wavelengths.iter().rposition(|known| known.place < column);
    let Some(before) = before else {
        return Err(format!(
            "{}: several columns of wavelengths, and none before {name:?}: {remedy}",
            table.path
        ));
    };
    let own = wavelengths[before];
    let neighbour =
        before.checked_sub(1).map(|i| wavelengths[i]).filter(|other| other.place + 1 == own.place);
    if let Some(other) = neighbour
        && let Some(row) = block.rows.iter().find(|row| own.nm(table, row) != other.nm(table, row))
    {
        return Err(format!(
            "{}, line {}: two columns of wavelengths before {name:?} that differ, {} and {}: {remedy}",
            table.path, row.line, row.cells[other.place], row.cells[own.place]
        ));
    }
    Ok(own)
}

/// Whether commas may stand within numbers as well as between cells: no number has a point, and
/// some cell stands under no name.
fn decimal_commas(table: &TextTable, block: &TableBlock) -> Option<String> {
    if table.separator != Separator::Character(',') {
        return None;
    }
    let cells = || block.rows.iter().flat_map(|row| row.cells.iter());
    let has_point = |cell: &String| cell.contains(['.', ',']);
    let width = block.rows[0].cells.len();
    let is_free = |column: &usize| match block.names.get(*column) {
        Some(name) => name.is_empty() && block.rows.iter().any(|row| !row.cells[*column].is_empty()),
        None => width > 2,
    };
    let last = &block.rows[block.rows.len() - 1];
    ((1..width).any(|column| is_free(&column)) && !cells().any(has_point)).then(|| {
        format!(
            "{}, line {}: in {:?} commas separate cells, or are decimal commas as well, and no number has a point: write \
             points, or quotes around numbers, or semicolons between cells (a first line sep=; says so), or name every \
             column",
            table.path,
            last.line,
            last.cells.join(",")
        )
    })
}

/// The first and the last value of a column that can only hold wavelengths.
fn like_wavelengths(table: &TextTable, block: &TableBlock, column: usize) -> Option<[f64; 2]> {
    let numbers: Vec<f64> = block.rows.iter().filter_map(|row| table.number(&row.cells[column])).collect();
    let all = numbers.len() >= FEWEST_ROWS && numbers.iter().all(|value| WAVELENGTHS_NM.contains(value));
    let falls = numbers.windows(2).all(|pair| pair[0] > pair[1]);
    let rises = numbers.windows(2).all(|pair| pair[0] < pair[1]);
    (all && (rises || falls)).then(|| [numbers[0], numbers[numbers.len() - 1]])
}

/// Takes in the columns of a block.
///
/// # Errors
/// No column holds wavelengths or reflectances, or which is which is left open.
pub fn samples(table: &TextTable, block: &TableBlock, into: &mut MeasuredFile) -> Result<(), String> {
    let wavelengths = wavelength_columns(table, block)?;
    let columns = value_columns(table, block, &wavelengths)?;
    if let Some(reason) = decimal_commas(table, block) {
        return Err(reason);
    }
    let name = |column: usize| block.names.get(column).map_or("", String::as_str);
    let above = declared(block.preamble.iter());
    let quantity_above = block.preamble.iter().rev().find_map(|line| Some((line, declared_quantity(line)?)));
    for &column in &columns {
        if let Some([first, last]) = like_wavelengths(table, block, column) {
            return Err(format!(
                "{}: column {} {:?} holds {first} to {last}, which look like wavelengths: name it wavelength_nm, and the \
                 values behind it are taken at them, or remove it",
                table.path,
                column + 1,
                name(column)
            ));
        }
        let own = wavelengths_of(column, table, block, &wavelengths)?;
        let mut of_column = declared([name(column).to_owned()].iter());
        if name(column).contains('%') || name(column).to_lowercase().contains("percent") {
            of_column.white = Some(100.0);
        }
        let cell = |row: &TextLine| SpectralCell {
            nm: own.nm(table, row),
            value: Written::of(row, &row.cells[column]),
        };
        // pairs of columns may be of different lengths
        let is_beyond = |row: &&TextLine| row.cells[own.place].is_empty() && row.cells[column].is_empty();
        let spectrum: Vec<SpectralCell> = block.rows.iter().filter(|row| !is_beyond(row)).map(cell).collect();
        let percent = spectrum.iter().any(|cell| cell.value.text.ends_with('%')).then_some(100.0);
        let title = block.preamble.last().cloned().filter(|title| !title.contains(['=', ':']));
        let sample_name = if columns.len() > 1 { Some(name(column).to_owned()) } else { title };
        let is_transmitted = ColumnKind::of(name(column)) == ColumnKind::Transmittance;
        // a title such as `Density` may name the sample of a column that says what it holds
        let is_of_column = |line: &str| line.contains([':', '=']) || !names_reflectance(name(column));
        let told = quantity_above.filter(|(line, _)| is_of_column(line));
        let kind_above = told.map_or(above.kind, |(_, kind)| kind);
        into.samples.push(MeasuredSample {
            names: sample_name.into_iter().filter(|name| !name.is_empty()).collect(),
            device: Vec::new(),
            condition: of_column.condition.or(above.condition),
            geometry: of_column.geometries.into_iter().chain(above.geometries.clone()).next(),
            kind: if is_transmitted { MeasuredKind::Transmittance } else { kind_above },
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
