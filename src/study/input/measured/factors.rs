//! From the values of a file to reflectance factors: the unit, which files often leave open, and
//! checked rows.

use super::sample::{MeasuredFile, MeasuredSample, SampleContent, SpectralCell};
use super::{MeasuredRequest, MeasuredUnit};
use crate::material::columns::micrometres;

/// Larger values are percentages; values between 1 and this are ambiguous, so that the unit is
/// required.
pub const LARGEST_FACTOR: f64 = 3.0;
/// Largest value of any sample, white at 1: beyond it the file as a whole is misread, or is no
/// reflectance.
const LARGEST_OF_ALL: f64 = 4.0;
/// Noise of an instrument at black; smaller values are not reflectance factors.
pub const LEAST_FACTOR: f64 = -0.1;

/// Value of a perfect white, and a remark where the file does not declare it.
pub struct White {
    /// The value.
    pub value: f64,
    /// What was taken, and why.
    pub remark: Option<String>,
}

/// Decides on the unit: by the key, by what the file declares, or by the values of all samples of
/// the file at the wavelengths that are used; never by one sample.
///
/// # Errors
/// The values may be either percentages or factors.
pub fn white(
    file: &MeasuredFile,
    sample: &MeasuredSample,
    request: &MeasuredRequest,
) -> Result<White, String> {
    let asked = request.unit.map(|unit| if unit == MeasuredUnit::Percent { 100.0 } else { 1.0 });
    match (asked, sample.white) {
        (Some(value), Some(declared)) if declared != value => {
            let remark = format!(
                "the file declares {declared} for a perfect white; compare.unit is believed, which says {value}"
            );
            return Ok(White { value, remark: Some(remark) });
        }
        (Some(value), _) => return Ok(White { value, remark: None }),
        (None, Some(value)) => return Ok(White { value, remark: too_dark(file, value, request) }),
        (None, None) => {}
    }
    let largest = largest_of(file, None, request);
    let key = "compare.unit = \"percent\" or \"factor\"";
    if largest > LARGEST_FACTOR {
        let remark = format!(
            "no unit is stated; taken as percent, as the file has values up to {largest}; {key} says it"
        );
        return Ok(White { value: 100.0, remark: Some(remark) });
    }
    if largest > 1.0 {
        return Err(format!(
            "no unit is stated, and the largest value is {largest} in the whole file: dark prints in percent, or factors above a \
             perfect white; say which by {key}"
        ));
    }
    let remark = format!(
        "no unit is stated; taken as factors of a perfect white, as the file's largest value is {largest}; {key} says it"
    );
    Ok(White { value: 1.0, remark: Some(remark) })
}

/// The largest value of the spectra of reflectance that declare this white, at the wavelengths that
/// are used, or else at all.
fn largest_of(file: &MeasuredFile, white: Option<f64>, request: &MeasuredRequest) -> f64 {
    let alike = |other: &&MeasuredSample| other.white == white && other.kind == request.kind;
    let all: Vec<&SpectralCell> = file.samples.iter().filter(alike).flat_map(spectral_cells).collect();
    let used = largest_value(all.iter().copied().filter(|cell| is_used(cell, request)));
    used.or_else(|| largest_value(all.iter().copied())).unwrap_or(0.0)
}

/// A remark on a file that declares percentages and has values of factors alone.
fn too_dark(file: &MeasuredFile, white: f64, request: &MeasuredRequest) -> Option<String> {
    let largest = largest_of(file, Some(white), request);
    (white > LARGEST_FACTOR && largest > 0.0 && largest <= 1.0).then(|| {
        format!(
            "the file declares {white} for a perfect white, and its largest value is {largest}: a black, or factors under a wrong \
             declaration, which compare.unit = \"factor\" corrects"
        )
    })
}

/// Judges all samples of a file: one that no surface can have shows that the file is misread.
///
/// # Errors
/// A sample has a value far above a perfect white at a wavelength that is used. `white` is that of
/// samples that declare none.
pub fn all_possible(file: &MeasuredFile, white: f64, request: &MeasuredRequest) -> Result<(), String> {
    for sample in file.samples.iter().filter(|sample| sample.kind == request.kind) {
        // compare.unit may correct what the samples declare
        let white = sample.white.unwrap_or(white).max(white);
        let cells = spectral_cells(sample).filter(|cell| is_used(cell, request));
        let mut values = cells.filter_map(|cell| Some((cell, cell.value.value()?)));
        if let Some((cell, value)) = values.find(|(_, value)| value / white > LARGEST_OF_ALL) {
            let nm = cell.nm.unwrap_or_default();
            return Err(format!(
                "line {}: {value} at {nm} nm is not a reflectance factor; a perfect white is {white}: the file is misread or \
                 holds another quantity; if its commas are decimal, write points, quotes around numbers, or semicolons \
                 between cells (a first line sep=; says so)",
                cell.value.line
            ));
        }
    }
    Ok(())
}

/// The cells of a sample's spectrum, if it has one.
fn spectral_cells(sample: &MeasuredSample) -> impl Iterator<Item = &SpectralCell> {
    let cells: &[SpectralCell] = match &sample.content {
        SampleContent::Spectrum(cells) => cells,
        SampleContent::Lab(..) | SampleContent::Xyz(..) => &[],
    };
    cells.iter()
}

/// Whether a wavelength is within the range that is used.
fn is_used(cell: &SpectralCell, request: &MeasuredRequest) -> bool {
    let [from, to] = request.used_nm;
    cell.nm.is_some_and(|nm| (from..=to).contains(&nm))
}

/// Luminance Y of a perfect white in a file of X, Y, Z: 100 by the formats, unless the key says 1.
///
/// # Errors
/// No sample of the file is lighter than a hundredth of that white.
pub fn white_y(file: &MeasuredFile, unit: Option<MeasuredUnit>) -> Result<f64, String> {
    match unit {
        Some(MeasuredUnit::Percent) => return Ok(100.0),
        Some(MeasuredUnit::Factor) => return Ok(1.0),
        None => {}
    }
    let luminance = |sample: &MeasuredSample| match &sample.content {
        SampleContent::Xyz(cells, _) => cells[1].value().filter(|y| y.is_finite()),
        SampleContent::Spectrum(_) | SampleContent::Lab(..) => None,
    };
    match file.samples.iter().filter_map(luminance).reduce(f64::max) {
        Some(largest) if largest <= 1.0 => Err(format!(
            "the largest Y of the file is {largest}: black, or shares of a white of 1; say which by compare.unit = \"percent\" \
             or \"factor\""
        )),
        _ => Ok(100.0),
    }
}

/// The largest finite value of some cells.
fn largest_value<'a>(cells: impl Iterator<Item = &'a SpectralCell>) -> Option<f64> {
    cells.filter_map(|cell| cell.value.value()).filter(|value| value.is_finite()).reduce(f64::max)
}

/// The rows of a spectrum, rising in wavelength, white at 1. Rows outside `used_nm` that are no
/// reflectance factors are left out; those within, and the next on either side, must be sound.
///
/// # Errors
/// A wavelength or a value that is used is not sound.
pub fn rows(cells: &[SpectralCell], white: f64, used_nm: [f64; 2]) -> Result<Vec<[f64; 2]>, String> {
    if cells.len() < 2 {
        return Err(format!("{} rows; a spectrum has at least 2", cells.len()));
    }
    let mut sorted: Vec<(f64, &SpectralCell)> = Vec::with_capacity(cells.len());
    for cell in cells {
        let nm = cell.nm.filter(|nm| nm.is_finite()).ok_or_else(|| {
            format!(
                "line {}: a value without its wavelength (in CxF: StartWL of the spectrum, and Increment of the \
                 WavelengthRange of its ColorSpecification)",
                cell.value.line
            )
        })?;
        sorted.push((nm, cell));
    }
    if let Some(largest) = micrometres(sorted.iter().map(|(nm, _)| *nm)) {
        return Err(format!(
            "the largest wavelength is {largest}: these look like µm; write them in nm, times 1000"
        ));
    }
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    // what lies between the rows next to the range decides on values inside it
    let first = sorted.iter().rposition(|(nm, _)| *nm <= used_nm[0]).unwrap_or(0);
    let last = sorted.iter().position(|(nm, _)| *nm >= used_nm[1]).unwrap_or(sorted.len() - 1);
    // rows of one wavelength are used together
    let (from, to) = (sorted[first].0, sorted[last].0);
    let first = sorted.iter().position(|(nm, _)| *nm == from).unwrap_or(first);
    let last = sorted.iter().rposition(|(nm, _)| *nm == to).unwrap_or(last);
    let is_used = |i: usize| (first..=last).contains(&i) || last < first;
    let mut rows: Vec<[f64; 2]> = Vec::with_capacity(sorted.len());
    for (i, (nm, cell)) in sorted.iter().enumerate() {
        let value = match sound(*nm, cell, white) {
            Ok(value) => value,
            Err(reason) if is_used(i) => return Err(reason),
            Err(_) => continue,
        };
        match rows.last() {
            Some(&[before, known]) if before == *nm => {
                if known != value && is_used(i) {
                    let line = cell.value.line;
                    return Err(format!(
                        "line {line}: two values at {nm} nm, {} and {}",
                        known * white,
                        value * white
                    ));
                }
            }
            _ => rows.push([*nm, value]),
        }
    }
    if rows.len() < 2 {
        return Err(format!("{} rows; a spectrum has at least 2", rows.len()));
    }
    Ok(rows)
}

/// The value of a cell as a reflectance factor.
fn sound(nm: f64, cell: &SpectralCell, white: f64) -> Result<f64, String> {
    let text = cell.value.text.trim();
    let line = cell.value.line;
    if text.is_empty() {
        return Err(format!("line {line}, {nm} nm: an empty cell; enter a number, or remove the row"));
    }
    let Some(value) = cell.value.value() else {
        return Err(format!("line {line}, {nm} nm: found {text:?} where a number is needed"));
    };
    if !value.is_finite() {
        return Err(format!("line {line}: {text} at {nm} nm is not a number"));
    }
    let factor = value / white;
    if !(LEAST_FACTOR..=LARGEST_FACTOR).contains(&factor) {
        return Err(format!(
            "line {line}: {value} at {nm} nm is not a reflectance factor; a perfect white is 1, or 100 in percent (taken as {white})"
        ));
    }
    Ok(factor)
}
