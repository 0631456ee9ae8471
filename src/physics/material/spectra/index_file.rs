//! Tables of indices as CSV: the program's own, those of spreadsheets and of refractiveindex.info.

use super::table::check_index;
use super::{Dilution, RowError, Sample, Spectrum, SpectrumError, Table, the_other};
use crate::material::columns::{line_of, micrometres};
use crate::material::dispersion::{DataSource, Dispersion};
use crate::material::usable::{FileRow, Unusable, Usable, usable};
use crate::numerics::files::{self, FileError};
use csv::StringRecord;
use std::path::Path;

/// Shortest wavelength in µm of which all others may be longer; larger numbers are probably nm.
const MOST_UM: f64 = 100.0;
/// Negative absorbance down to this is the drift of an instrument's zero.
const ZERO_DRIFT: f64 = 0.005;
/// Beginnings of remarks by which a file says that a quantity is not determined.
const UNDETERMINED: [&str; 4] =
    ["n is not determined", "kappa is not determined", "k is not determined", "κ is not determined"];

/// What a column holds.
#[derive(Clone, Copy, PartialEq)]
enum IndexColumn {
    /// Vacuum wavelength in nm, or in µm.
    Wavelength {
        in_um: bool,
    },
    N,
    Kappa,
    /// Decadic absorbance of a dilution.
    Absorbance,
    NError,
    KappaError,
    Correlation,
}

impl IndexColumn {
    /// By the name of a column.
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "wavelength_nm" | "wavelength (nm)" | "wavelength, nm" | "nm" => {
                Self::Wavelength { in_um: false }
            }
            "wl" | "wavelength_um" | "wavelength (µm)" | "wavelength, µm" | "wavelength (μm)"
            | "wavelength, μm" | "wavelength (um)" | "wavelength, um" => Self::Wavelength { in_um: true },
            "n" => Self::N,
            "kappa" | "k" | "κ" => Self::Kappa,
            "absorbance" => Self::Absorbance,
            "n_error" => Self::NError,
            "kappa_error" | "k_error" => Self::KappaError,
            "correlation" => Self::Correlation,
            _ => return None,
        })
    }
}

/// Lines below one header.
struct Block {
    /// Names in lower case.
    names: Vec<String>,
    quantities: Vec<Option<IndexColumn>>,
    /// Line numbers, from 1, and cells.
    lines: Vec<(u64, Vec<String>)>,
}

/// Numbers of one line; what the file does not give is `None`.
#[derive(Clone, Copy, Default)]
struct Numbers {
    wavelength: Option<f64>,
    n: Option<f64>,
    kappa: Option<f64>,
    absorbance: Option<f64>,
    error: RowError,
}

/// Reads a table; `n` is given beside one that has no real part.
pub(super) fn read(path: &Path, n: Option<f64>) -> Result<Spectrum, SpectrumError> {
    read_any(path, n, None)
}

/// Reads the absorbance of a dilution.
pub(super) fn read_absorbance(path: &Path, n: f64, dilution: &Dilution) -> Result<Spectrum, SpectrumError> {
    read_any(path, Some(n), Some(dilution))
}

fn read_any(path: &Path, n: Option<f64>, dilution: Option<&Dilution>) -> Result<Spectrum, SpectrumError> {
    let bytes = files::read_bytes(path, files::TABLE);
    let bytes = bytes.map_err(|error| FileError::new(path.display(), error))?;
    if bytes.contains(&0) {
        let what = "it is not plain text (UTF-16, or a spreadsheet's own format): save it as CSV in UTF-8";
        return Err(FileError::new(path.display(), what).into());
    }
    let text = String::from_utf8_lossy(&bytes);
    let text = text.trim_start_matches('\u{feff}');
    let name = path.display().to_string();
    let expected = "expected a header line wavelength_nm,kappa or wavelength_nm,kappa,n (k is accepted for kappa), or the blocks \
                    wl,n and wl,k of refractiveindex.info in µm";
    let (blocks, decimal_comma) =
        blocks(text).map_err(|reason| FileError::new(&name, format_args!("{reason}; {expected}")))?;
    let has = |block: &Block, quantity| block.quantities.contains(&Some(quantity));
    let with_absorbance = blocks.iter().any(|block| has(block, IndexColumn::Absorbance));
    absorbance_fits(with_absorbance, dilution.is_some()).map_err(|reason| FileError::new(&name, reason))?;
    let with_n = blocks.iter().find(|block| has(block, IndexColumn::N));
    let attenuation = if with_absorbance { IndexColumn::Absorbance } else { IndexColumn::Kappa };
    let with_kappa = blocks.iter().find(|block| has(block, attenuation));
    let of_site = blocks.iter().all(|block| has(block, IndexColumn::Wavelength { in_um: true }));
    let Some(only) = with_kappa.filter(|_| blocks.len() == 1) else {
        if with_kappa.is_none() && !(of_site && with_n.is_some()) {
            return Err(FileError::new(&name, format_args!("column \"kappa\" is missing; {expected}")).into());
        }
        let mut record =
            Dispersion { name: name.clone(), n: None, kappa: None, unusable: Vec::new(), joined: Vec::new() };
        for (block, quantity, place) in
            [(with_n, IndexColumn::N, &mut record.n), (with_kappa, IndexColumn::Kappa, &mut record.kappa)]
        {
            let Some(block) = block else { continue };
            let (rows, gaps) = column(block, quantity, &name, decimal_comma)?;
            *place = Some(DataSource::Table(rows));
            record.unusable.extend(gaps);
        }
        return Ok(Spectrum::Recorded(match the_other(path, record.n.is_some(), n)? {
            Some(n) => record.with_n(n),
            None => record,
        }));
    };
    if only.lines.len() < 2 {
        return Err(SpectrumError::TooFewRows { name, rows: only.lines.len() });
    }
    let beside = the_other(path, with_n.is_some(), n)?;
    let undetermined = remarks(text);
    let table = table(only, (beside, dilution), &name, decimal_comma)?;
    Ok(Spectrum::Tabulated(Table { name, undetermined, ..table }))
}

/// Absorbance says what κ is with the dilution alone, and the dilution nothing of κ.
fn absorbance_fits(in_file: bool, with_dilution: bool) -> Result<(), &'static str> {
    match (in_file, with_dilution) {
        (true, false) => {
            Err("a column absorbance, from which κ follows with path, concentration and density alone: give \
             dilution = { path_mm = 10, concentration_g_per_l = 0.02, density_g_per_cm3 = 1.5 } beside the file")
        }
        (false, true) => {
            Err("no column absorbance, although a dilution is given beside the file; a table of κ needs none")
        }
        _ => Ok(()),
    }
}

/// Remarks that say that a quantity is not determined.
fn remarks(text: &str) -> Vec<String> {
    let remarks = text.lines().filter_map(|line| Some(line.trim_start().strip_prefix('#')?.trim()));
    let said = remarks.filter(|remark| UNDETERMINED.iter().any(|start| remark.starts_with(start)));
    said.map(str::to_owned).collect()
}

/// The blocks of a file, and whether its numbers may have decimal commas. Remarks start with `#`; a
/// first line `sep=;` names the separator, as some spreadsheets write it.
fn blocks(text: &str) -> Result<(Vec<Block>, bool), String> {
    let mut lines =
        text.lines().filter(|line| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
    let first = lines.next().ok_or("it is empty; the first line names the columns")?;
    let told = first.trim().trim_matches('"').strip_prefix("sep=").map(str::trim_end);
    let header = if told.is_some() { lines.next().unwrap_or("") } else { first };
    let separator = match told.map(str::as_bytes) {
        Some([own]) => *own,
        _ => [b';', b'\t'].into_iter().find(|&c| header.contains(char::from(c))).unwrap_or(b','),
    };
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(separator)
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let mut all: Vec<Block> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| error.to_string())?;
        let first = record.get(0).unwrap_or("").to_lowercase();
        let told = first.starts_with("sep=") && all.is_empty();
        if told || first.starts_with('#') || record.iter().all(str::is_empty) {
            continue;
        }
        let is_header = matches!(IndexColumn::named(&first), Some(IndexColumn::Wavelength { .. }));
        match all.last_mut().filter(|_| !is_header) {
            Some(block) => {
                block.lines.push((line_of(text, &record), record.iter().map(str::to_owned).collect()));
            }
            None => all.push(header_of(&record)?),
        }
    }
    Ok((all, separator != b','))
}

/// A block without lines.
fn header_of(record: &StringRecord) -> Result<Block, String> {
    let names: Vec<String> = record.iter().map(str::to_lowercase).collect();
    let mut quantities: Vec<Option<IndexColumn>> = Vec::new();
    for name in &names {
        // spreadsheets append empty columns
        let quantity = if name.is_empty() { None } else { IndexColumn::named(name) };
        if quantity.is_none() && !name.is_empty() {
            return Err(format!("column {name:?} is not known"));
        }
        if let Some(before) = quantity.and_then(|own| quantities.iter().position(|&q| q == Some(own))) {
            let other = &names[before];
            return Err(if other == name {
                format!("column {name} occurs twice; keep one of them")
            } else {
                format!("columns {other} and {name} mean the same; keep one")
            });
        }
        quantities.push(quantity);
    }
    if !quantities.iter().any(|q| matches!(q, Some(IndexColumn::Wavelength { .. }))) {
        return Err("column \"wavelength_nm\" is missing".to_owned());
    }
    Ok(Block { names, quantities, lines: Vec::new() })
}

impl Block {
    /// The numbers of a line, or what is wrong with them.
    fn numbers(
        &self,
        (line, cells): &(u64, Vec<String>),
        decimal_comma: bool,
    ) -> (Numbers, Result<(), String>) {
        let (mut numbers, mut fault) = (Numbers::default(), Ok(()));
        let (found, wanted) = (cells.len(), self.names.len());
        if found != wanted {
            let mut reason = format!("line {line}: {found} cells under {wanted} columns");
            if !decimal_comma && found > wanted {
                reason += "; numbers with a decimal comma need a semicolon between columns (";
                reason += &(self.names.join(";") + ")");
            }
            fault = Err(reason);
        }
        for ((cell, quantity), name) in cells.iter().zip(&self.quantities).zip(&self.names) {
            let Some(quantity) = quantity else { continue };
            let text = if decimal_comma { cell.replace(',', ".") } else { cell.clone() };
            let Ok(number) = text.parse::<f64>() else {
                let reason = if cell.is_empty() {
                    format!("line {line}, column {name}: an empty cell; enter a number, or remove the line")
                } else {
                    format!("line {line}, column {name}: found {cell:?} where a number is needed")
                };
                fault = fault.and(Err(reason));
                continue;
            };
            match quantity {
                IndexColumn::Wavelength { in_um } => {
                    let nm = if *in_um { (1e9 * number).round() / 1e6 } else { number };
                    numbers.wavelength = Some(nm).filter(|nm| nm.is_finite() && *nm > 0.0);
                    if numbers.wavelength.is_none() {
                        let allowed = "a wavelength is a number greater than 0";
                        fault =
                            fault.and(Err(format!("line {line}, column {name}: found {cell:?}; {allowed}")));
                    }
                }
                IndexColumn::N => numbers.n = Some(number),
                IndexColumn::Kappa => numbers.kappa = Some(number),
                IndexColumn::Absorbance => numbers.absorbance = Some(number),
                IndexColumn::NError => numbers.error.n = number,
                IndexColumn::KappaError => numbers.error.kappa = number,
                IndexColumn::Correlation => numbers.error.correlation = number,
            }
        }
        (numbers, fault)
    }

    /// Refuses a column of wavelengths in another unit than its name says.
    fn check_unit(&self, all: &[Numbers]) -> Result<(), String> {
        let in_um = self.quantities.contains(&Some(IndexColumn::Wavelength { in_um: true }));
        let known = || all.iter().filter_map(|numbers| numbers.wavelength);
        if in_um {
            let least = known().fold(f64::INFINITY, f64::min);
            let wrong = least.is_finite() && least > 1e3 * MOST_UM;
            return if wrong {
                Err(format!(
                    "the smallest wavelength is {}: these look like nm; the column must be in µm",
                    1e-3 * least
                ))
            } else {
                Ok(())
            };
        }
        match micrometres(known()) {
            Some(largest) => Err(format!(
                "the largest wavelength is {largest}: these look like µm; the column must be in nm: multiply it by 1000"
            )),
            None => Ok(()),
        }
    }

    /// The numbers of every line.
    fn all(&self, decimal_comma: bool) -> Result<(Vec<Numbers>, Vec<Result<(), String>>), String> {
        let (numbers, faults): (Vec<Numbers>, Vec<_>) =
            self.lines.iter().map(|line| self.numbers(line, decimal_comma)).unzip();
        self.check_unit(&numbers)?;
        Ok((numbers, faults))
    }
}

/// n or κ alone: wavelength in µm and value, and where there is none.
fn column(
    block: &Block,
    quantity: IndexColumn,
    name: &str,
    decimal_comma: bool,
) -> Result<(Vec<[f64; 2]>, Vec<Unusable>), FileError> {
    let (numbers, faults) = block.all(decimal_comma).map_err(|reason| FileError::new(name, reason))?;
    let rows = numbers.iter().zip(faults).map(|(numbers, fault)| {
        let value = if quantity == IndexColumn::N { numbers.n } else { numbers.kappa };
        let nm = numbers.wavelength;
        let values = fault.and(Ok([1e-3 * nm.unwrap_or(0.0), value.unwrap_or(f64::NAN)]));
        FileRow { nm, values }
    });
    let Usable { rows, gaps, first_fault } = usable(rows.collect());
    if rows.is_empty() {
        let reason = first_fault.unwrap_or_else(|| "a header without rows".to_owned());
        return Err(FileError::new(name, reason));
    }
    Ok((rows.into_iter().map(|(_, row)| row).collect(), gaps))
}

/// n and κ in common rows, with their errors; n and a dilution may stand beside the file.
fn table(
    block: &Block,
    (n, dilution): (Option<f64>, Option<&Dilution>),
    name: &str,
    decimal_comma: bool,
) -> Result<Table, FileError> {
    let (numbers, faults) = block.all(decimal_comma).map_err(|reason| FileError::new(name, reason))?;
    let mut rows = Vec::new();
    for (i, (numbers, fault)) in numbers.iter().zip(faults).enumerate() {
        let Numbers { wavelength, error, .. } = *numbers;
        let own_n = numbers.n.or(n).unwrap_or(f64::NAN);
        let diluted = dilution.zip(numbers.absorbance).zip(wavelength);
        let diluted = diluted.map(|((dilution, absorbance), nm)| {
            let drifted = (-ZERO_DRIFT..0.0).contains(&absorbance);
            dilution.kappa(if drifted { 0.0 } else { absorbance }, nm)
        });
        let kappa = diluted.or(numbers.kappa).unwrap_or(f64::NAN);
        let row = format!("row {}", i + 1);
        let values = fault
            .and_then(|()| check_index(&row, own_n, kappa).map_err(|error| error.to_string()))
            .and_then(|()| error.check(&row))
            .map(|()| (Sample { wavelength_nm: wavelength.unwrap_or(0.0), n: own_n, kappa }, error));
        rows.push(FileRow { nm: wavelength, values });
    }
    let Usable { rows, gaps, first_fault } = usable(rows);
    if rows.len() < 2 {
        let reason = first_fault.unwrap_or_else(|| "fewer than 2 different rows".to_owned());
        return Err(FileError::new(name, reason));
    }
    let (samples, mut errors): (Vec<Sample>, Vec<RowError>) = rows.into_iter().map(|(_, row)| row).unzip();
    if errors.iter().all(|error| error.n == 0.0 && error.kappa == 0.0) {
        errors.clear();
    }
    Ok(Table {
        name: name.to_owned(),
        samples,
        unusable: gaps,
        errors,
        undetermined: Vec::new(),
        changes: Vec::new(),
    })
}
