//! Measured spectra and colours: CGATS.17 and its relatives, CxF3, and tables of instruments and
//! spreadsheets. The format follows from the structure of a file, what the values are from what the
//! file declares; what it leaves open is asked for.

mod cgats;
mod choose;
mod columns;
mod cxf;
mod factors;
mod fields;
mod quantity;
mod sample;
mod table;
mod words;

pub use words::{MeasuredGeometry, MeasuredKind};

use crate::appearance::colour::Colour;
use crate::appearance::tristimulus::Colorimeter;
use crate::appearance::tristimulus::TABLE_RANGE_NM;
use crate::appearance::viewing::ColourError;
use crate::appearance::viewing::Viewing;
use crate::material::text_table::{read_text, with_line_feeds};
use sample::{MeasuredFile, MeasuredSample, SampleContent, Written};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// Colours of one sample that differ by less are one colour, written as L*, a*, b* and as X, Y, Z
/// of white tables that differ in their last digits.
const COORDINATE_ROUNDING: f64 = 0.1;

/// Value of a perfect white in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MeasuredUnit {
    /// White is 1.
    Factor,
    /// White is 100.
    Percent,
}

/// Light of the instrument by ISO 13655.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
pub enum MeasuredCondition {
    /// An incandescent lamp, near illuminant A.
    M0,
    /// Daylight D50, ultraviolet included.
    M1,
    /// Without ultraviolet.
    M2,
    /// Polarised, which leaves out mirror reflection.
    M3,
}

impl MeasuredCondition {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::M0, Self::M1, Self::M2, Self::M3];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::M0 => "M0",
            Self::M1 => "M1",
            Self::M2 => "M2",
            Self::M3 => "M3",
        }
    }
}

/// A sample in a file with several.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "the name or number of a sample, or its amounts of ink such as [0, 0, 100, 0]")]
pub enum Patch {
    /// Its name, number or place on the chart as the file has it.
    Name(String),
    /// A number that is its name.
    Number(u32),
    /// Its amounts of ink in the file's order, percent: C, M, Y, K; or other device values.
    Inks(Vec<f64>),
}

impl fmt::Display for Patch {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Name(name) => f.write_str(name),
            Self::Number(number) => write!(f, "{number}"),
            Self::Inks(inks) => write!(f, "{inks:?}"),
        }
    }
}

/// What is requested of a file of measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredRequest {
    /// The sample; without it the only one, or the first.
    pub patch: Option<Patch>,
    /// Whether a file with several samples is refused if none is named.
    pub one_must_be_named: bool,
    /// The unit, where the file does not declare it.
    pub unit: Option<MeasuredUnit>,
    /// The instrument's light, where a sample is measured under several.
    pub condition: Option<MeasuredCondition>,
    /// What is read: reflectance, or transmittance.
    pub kind: MeasuredKind,
    /// Allowed geometries; empty where any will do. Files that state none are taken.
    pub geometries: Vec<MeasuredGeometry>,
    /// Range of wavelengths that is used, nm: outside it faults do not matter.
    pub used_nm: [f64; 2],
    /// Requested conditions of a colour without a spectrum.
    pub viewing: Viewing,
}

impl Default for MeasuredRequest {
    fn default() -> Self {
        Self {
            patch: None,
            one_must_be_named: false,
            unit: None,
            condition: None,
            kind: MeasuredKind::Reflectance,
            geometries: vec![MeasuredGeometry::LitAt45],
            used_nm: TABLE_RANGE_NM,
            viewing: Viewing::default(),
        }
    }
}

/// What a file holds of the sample that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum MeasuredContent {
    /// A spectrum.
    Spectrum(MeasuredSpectrum),
    /// A colour, where the sample has no spectrum.
    Colour(MeasuredColour),
}

/// A sample of a file, and what its reader should know.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredReading {
    /// The sample.
    pub measured: MeasuredContent,
    /// Its geometry, if the file states it.
    pub geometry: Option<MeasuredGeometry>,
    /// The instrument's light by ISO 13655, if the file states it.
    pub condition: Option<MeasuredCondition>,
    /// What was taken where the file leaves something open.
    pub remarks: Vec<String>,
}

/// Reflectance factors (white diffuser: 1) against wavelength, nm, increasing.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MeasuredSpectrum {
    /// Name of the file, and of the sample if it has several.
    pub source: String,
    /// (wavelength in nm, reflectance factor) rows.
    pub rows: Vec<[f64; 2]>,
    /// Number of samples in the file.
    #[serde(default)]
    pub patches: usize,
}

/// L*, a*, b* of a sample, with the illuminant and the observer stated in its file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredColour {
    /// L*, a*, b*.
    pub lab: [f64; 3],
    /// The conditions, or why they are not known.
    pub viewing: Result<Viewing, String>,
}

impl MeasuredReading {
    /// Reads a sample of a file.
    ///
    /// # Errors
    /// The file cannot be read or has no such sample; what is meant, its unit or its conditions are
    /// left open; it is no reflectance, or of a geometry that is not asked for; or a value that is
    /// used is not sound. The message names keys of `[compare]`.
    pub fn new(path: &Path, request: &MeasuredRequest) -> Result<Self, String> {
        let text = read_text(path).map_err(|error| error.to_string())?;
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Self::parse(&text, &name, request).map_err(|reason| format!("{}: {reason}", path.display()))
    }

    /// Reads a sample from the text of a file of this name; for errors see [`Self::new`].
    ///
    /// # Errors
    /// See [`Self::new`].
    pub fn parse(text: &str, name: &str, request: &MeasuredRequest) -> Result<Self, String> {
        let text = with_line_feeds(text.trim_start_matches('\u{feff}'));
        let (file, what) = samples(&text, name)?;
        if file.samples.is_empty() {
            return Err(format!("it is {what} without spectra, L*, a*, b* or X, Y, Z of samples"));
        }
        let chosen = choose::choose(&file, request)?;
        let mut remarks: Vec<String> =
            file.remarks.iter().map(|remark| format!("{name}: {remark}")).collect();
        let sample_name = chosen.sample.name();
        let source = match (chosen.samples, sample_name) {
            (1, _) => name.to_owned(),
            (count, "") => format!("{name}: unnamed, sample {} of {count}", chosen.place),
            (count, _) => format!("{name}: {sample_name:?}, sample {} of {count}", chosen.place),
        };
        if chosen.samples > 1 && request.patch.is_none() {
            remarks.push(format!("using {source}; compare.patch = \"…\" selects another by name"));
        }
        let measured = match &chosen.sample.content {
            SampleContent::Spectrum(cells) => {
                let white = factors::white(&file, chosen.sample, request)?;
                remarks.extend(white.remark.map(|remark| format!("{source}: {remark}")));
                let called = if chosen.samples > 1 { format!("{sample_name:?}, ") } else { String::new() };
                if chosen.samples > 1 {
                    factors::all_possible(&file, white.value, request)?;
                }
                let rows = factors::rows(cells, white.value, request.used_nm);
                let rows = rows.map_err(|reason| format!("{called}{reason}"))?;
                MeasuredContent::Spectrum(MeasuredSpectrum { source, rows, patches: chosen.samples })
            }
            SampleContent::Lab(..) | SampleContent::Xyz(..) => {
                MeasuredContent::Colour(colour(&file, &chosen, request)?)
            }
        };
        let MeasuredSample { geometry, condition, .. } = chosen.sample;
        Ok(Self { measured, geometry: geometry.clone(), condition: *condition, remarks })
    }
}

/// The samples of a text, whose format follows from its structure, and the format in words.
fn samples(text: &str, name: &str) -> Result<(MeasuredFile, &'static str), String> {
    if text.trim_start().starts_with('<') {
        return Ok((cxf::read(text)?, "a CxF file"));
    }
    if let Some(reason) = table::jcamp_refusal(text) {
        return Err(reason);
    }
    if cgats::is_cgats(text) {
        return Ok((cgats::read(text)?, "a CGATS file"));
    }
    let begins = text.split_whitespace().next().unwrap_or_default();
    if ["CGATS", "CTI", "SPECT", "IT8", "ISO28178", "LGOROWLENGTH"]
        .iter()
        .any(|word| begins.starts_with(word))
    {
        return Err("no BEGIN_DATA_FORMAT".into());
    }
    table::read(name.to_owned(), text).map(|file| (file, "a table"))
}

/// The colour of a sample under the requested conditions, or under those that it has.
fn colour(
    file: &MeasuredFile,
    chosen: &choose::Chosen,
    request: &MeasuredRequest,
) -> Result<MeasuredColour, String> {
    let requested = &request.viewing;
    let mut all = Vec::new();
    let mut none = "no colour".to_owned();
    for sample in std::iter::once(chosen.sample).chain(chosen.colours.iter().copied()) {
        all.extend(match &sample.content {
            SampleContent::Spectrum(_) => None,
            SampleContent::Lab(cells, stated) => {
                let lab = coordinates(cells, ["L*", "a*", "b*"])?;
                Some(MeasuredColour { lab, viewing: stated.viewing(requested.summation) })
            }
            SampleContent::Xyz(cells, stated) => {
                let xyz = coordinates(cells, ["X", "Y", "Z"])?;
                let white = factors::white_y(file, request.unit)?;
                match stated.viewing(requested.summation) {
                    Ok(viewing) => {
                        Some(MeasuredColour { lab: lab_of(xyz, white, &viewing)?, viewing: Ok(viewing) })
                    }
                    Err(reason) => {
                        none = format!("X, Y, Z have no L*, a*, b*: {reason}");
                        None
                    }
                }
            }
        });
    }
    let is_requested = |colour: &&MeasuredColour| colour.viewing.as_ref() == Ok(requested);
    let first = all.iter().find(is_requested).or(all.first()).ok_or(none)?;
    let differs = |other: &MeasuredColour| {
        other.viewing == first.viewing
            && other.lab.iter().zip(first.lab).any(|(a, b)| (a - b).abs() > COORDINATE_ROUNDING)
    };
    if all.iter().any(differs) {
        let name = chosen.sample.name();
        return Err(format!(
            "several colours of {name:?} that differ: keep one of them, or give them different names"
        ));
    }
    Ok(first.clone())
}

/// The numbers of three cells, whose coordinates have these names.
fn coordinates(cells: &[Written; 3], names: [&str; 3]) -> Result<[f64; 3], String> {
    let mut values = [0.0; 3];
    for (i, name) in names.into_iter().enumerate() {
        let cell = &cells[i];
        values[i] = cell.value().filter(|value| value.is_finite()).ok_or_else(|| {
            format!("line {}, {name}: found {:?} where a number is needed", cell.line, cell.text.trim())
        })?;
    }
    Ok(values)
}

/// L*, a*, b* of X, Y, Z whose perfect white has the luminance `white`.
fn lab_of(xyz: [f64; 3], white: f64, viewing: &Viewing) -> Result<[f64; 3], String> {
    let table: Vec<f64> = (380..=780).step_by(5).map(f64::from).collect();
    let colorimeter = Colorimeter::under(&table, viewing).map_err(|error| error.to_string())?;
    Ok(colorimeter.colour_of(xyz.map(|value| 100.0 / white * value)).lab)
}

impl MeasuredSpectrum {
    /// First and last wavelength, nm.
    pub fn range_nm(&self) -> [f64; 2] {
        [self.rows[0][0], self.rows[self.rows.len() - 1][0]]
    }

    /// The value at a wavelength, linear between rows; `None` outside their range.
    pub fn at(&self, nm: f64) -> Option<f64> {
        let [lo, hi] = self.range_nm();
        if !(lo..=hi).contains(&nm) {
            return None;
        }
        let after = self.rows.partition_point(|row| row[0] < nm).clamp(1, self.rows.len() - 1);
        let [x0, y0] = self.rows[after - 1];
        let [x1, y1] = self.rows[after];
        Some(y0 + (nm - x0) / (x1 - x0) * (y1 - y0))
    }

    /// The spectrum with its end values wherever a range of wavelengths, nm, goes on beyond it, in
    /// steps of 5 nm (ASTM E308-18, 7.3.2.2).
    #[must_use]
    pub fn extended(&self, range_nm: [f64; 2]) -> Self {
        const STEP_NM: f64 = 5.0;
        let [[first, start], [last, end]] = [self.rows[0], self.rows[self.rows.len() - 1]];
        let steps = |missing_nm: f64| (missing_nm.max(0.0) / STEP_NM).ceil() as usize;
        let before = (1..=steps(first - range_nm[0])).rev();
        let before = before.map(|k| [first - STEP_NM * k as f64, start]);
        let after = (1..=steps(range_nm[1] - last)).map(|k| [last + STEP_NM * k as f64, end]);
        let rows = before.chain(self.rows.iter().copied()).chain(after).collect();
        Self { rows, ..self.clone() }
    }

    /// The colour, summed over the spectrum's own rows within a range of wavelengths, nm. At an end
    /// of the range without a row the value is interpolated. The steps of a study are no measure of
    /// how fine a spectrum was measured: a steep edge between them would be lost.
    ///
    /// # Errors
    /// The rows within the range carry no colour.
    pub fn colour(&self, viewing: &Viewing, range_nm: [f64; 2]) -> Result<Colour, ColourError> {
        let [first, last] = self.range_nm();
        let from = range_nm[0].max(first).max(TABLE_RANGE_NM[0]);
        let to = range_nm[1].min(last).min(TABLE_RANGE_NM[1]);
        let mut rows: Vec<[f64; 2]> =
            self.rows.iter().copied().filter(|[nm, _]| (from..=to).contains(nm)).collect();
        if rows.first().is_none_or(|[nm, _]| *nm > from) {
            rows.splice(0..0, self.at(from).map(|value| [from, value]));
        }
        if rows.last().is_none_or(|[nm, _]| *nm < to) {
            rows.extend(self.at(to).map(|value| [to, value]));
        }
        let nm: Vec<f64> = rows.iter().map(|row| row[0]).collect();
        let values: Vec<f64> = rows.iter().map(|row| row[1]).collect();
        Colorimeter::under(&nm, viewing)?.colour(&values)
    }
}

#[cfg(test)]
#[path = "measured_tests.rs"]
mod tests;
