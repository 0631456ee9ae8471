//! The prints in dots of a study as CGATS.17 text: characterisation sets, from which makers of
//! profiles take device values, XYZ and Lab of D50 and 2°, and spectra.

use super::print::{Bands, resample};
use super::request::{ExportError, ExportResult};
use crate::appearance::tristimulus::Colorimeter;
use crate::appearance::viewing::{Summation, Viewing};
use crate::evaluate::printed::{PrintNote, Prints};
use crate::evaluate::summary::program;
use crate::input::measured::MeasuredCondition;
use crate::input::study::Study;
use std::fmt::Write;

/// Process inks, in the order of their columns.
const PROCESS: [(&str, &str); 4] =
    [("cyan", "CMYK_C"), ("magenta", "CMYK_M"), ("yellow", "CMYK_Y"), ("black", "CMYK_K")];

/// Columns of device values, and of which ink each is; `None` for a process ink that is not
/// printed.
struct Device {
    columns: Vec<(String, Option<usize>)>,
    /// Whether prints name their inks; else they have one coverage.
    named: bool,
}

impl Device {
    /// CMYK where all inks are process inks by name, else columns `nCLR_k` (ISO 12642-2).
    fn of(prints: &Prints) -> Self {
        let names: Vec<String> =
            prints.prints.iter().map(|note| &note.print.inks).fold(Vec::new(), |names, inks| {
                match names.is_empty() {
                    true => inks.iter().map(|ink| ink.name.to_lowercase()).collect(),
                    false => names,
                }
            });
        let place = |process: &str| names.iter().position(|name| name == process);
        let is_process = !names.is_empty() && names.iter().all(|n| PROCESS.iter().any(|(p, _)| p == n));
        let columns = if is_process {
            PROCESS.iter().map(|(name, column)| ((*column).to_owned(), place(name))).collect()
        } else {
            let count = names.len().max(1);
            (0..count).map(|k| (format!("{count}CLR_{}", k + 1), Some(k))).collect()
        };
        Self { columns, named: !names.is_empty() }
    }

    /// Device values of a print, percent. The solid of this study's layer alone has no place among
    /// named inks.
    fn values(&self, note: &PrintNote) -> Option<Vec<f64>> {
        let is_bare = note.print.nominal == 0.0;
        if self.named && note.print.inks.is_empty() && !is_bare {
            return None;
        }
        let of = |ink: usize| match note.print.inks.get(ink) {
            Some(ink) => ink.coverage,
            None => note.print.nominal,
        };
        Some(self.columns.iter().map(|(_, ink)| 100.0 * ink.map_or(0.0, of)).collect())
    }
}

/// A characterisation set.
pub struct PrintSet {
    /// Its file's name.
    pub name: String,
    /// Which prints they are.
    pub about: String,
    /// The file.
    pub text: String,
}

/// The sets of a study: one for each condition and thickness of its prints, since readers take
/// every row of a file for a print of its own and know no two colours of the same device values.
///
/// # Errors
/// Wavelengths that do not hold two multiples of 10 nm, or carry no colour.
pub fn sets(study: &Study, prints: &Prints, created: &str) -> ExportResult<Vec<PrintSet>> {
    let mut kinds: Vec<(Option<MeasuredCondition>, Option<f64>)> = Vec::new();
    for note in &prints.prints {
        let kind = (note.print.condition, note.thickness_um);
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    let thicknesses = kinds.iter().filter(|(condition, _)| *condition == kinds[0].0).count();
    let mut sets = Vec::new();
    for (condition, thickness_um) in kinds {
        let notes: Vec<&PrintNote> = prints
            .prints
            .iter()
            .filter(|note| (note.print.condition, note.thickness_um) == (condition, thickness_um))
            .collect();
        let mut parts: Vec<String> =
            condition.iter().map(|condition| condition.name().to_lowercase()).collect();
        parts.extend(thickness_um.filter(|_| thicknesses > 1).map(|um| format!("{um}um")));
        let name: String = parts.iter().map(|part| format!("-{part}")).collect();
        let words = if parts.is_empty() { String::new() } else { format!(" ({})", parts.join(", ")) };
        sets.push(PrintSet {
            name: format!("prints{name}.cgats"),
            about: format!("prints{words} with XYZ, Lab and spectra, CGATS.17"),
            text: cgats(study, prints, &notes, created)?,
        });
    }
    Ok(sets)
}

/// Text between quotes of a file that is ASCII alone.
fn plain(text: &str) -> String {
    let ascii = |c: char| match c {
        '"' => "'".to_owned(),
        'µ' | 'μ' => "u".to_owned(),
        '°' => " degree".to_owned(),
        c if c.is_ascii() && !c.is_ascii_control() => c.to_string(),
        c if c.is_whitespace() => " ".to_owned(),
        _ => "?".to_owned(),
    };
    text.chars().map(ascii).collect()
}

/// A file with a row a print, the bare paper once; device values and factors are percentages, Y of
/// a perfect white is 100.
fn cgats(study: &Study, prints: &Prints, notes: &[&PrintNote], created: &str) -> ExportResult<String> {
    let bands = Bands::new(study, "cgats")?;
    let nm: Vec<f64> = bands.wavelengths_nm.iter().map(|&nm| f64::from(nm)).collect();
    // the space in which profiles connect, whatever the study's own light
    let daylight = Viewing::new("D50", "2", Summation::Plain).map_err(refused)?;
    let meter = Colorimeter::under(&nm, &daylight).map_err(refused)?;
    let device = Device::of(prints);
    let mut rows = Vec::new();
    let mut printed: Vec<Vec<f64>> = Vec::new();
    for note in notes {
        let Some(values) = device.values(note).filter(|values| !printed.contains(values)) else { continue };
        printed.push(values.clone());
        let spectrum = resample(&study.wavelengths_nm, &note.factors, &bands.wavelengths_nm);
        let factors: Vec<f64> = spectrum.iter().map(|factor| factor.value).collect();
        let colour = meter.colour(&factors).map_err(refused)?;
        let seen = colour.xyz.into_iter().chain(colour.lab);
        let numbers = values.into_iter().chain(seen).chain(factors.iter().map(|factor| 100.0 * factor));
        let numbers: Vec<String> = numbers.map(|x| format!("{x:.6}")).collect();
        let name = plain(&note.name());
        rows.push(format!("{} \"{name}\" {}", rows.len() + 1, numbers.join(" ")));
    }
    let thickness = notes.iter().find_map(|note| note.thickness_um);
    let thickness = thickness.map_or(String::new(), |um| format!(", layer of {um} um"));
    let title = plain(&study.title);
    let mut out = "CGATS.17\n\n".to_owned();
    let _ = writeln!(out, "ORIGINATOR \"{} (simulated)\"", program());
    let _ = writeln!(out, "DESCRIPTOR \"Simulated, not measured: prints, {title}{thickness}\"");
    let _ = writeln!(out, "CREATED \"{created}\"");
    for weighting in ["ILLUMINANT, D50", "OBSERVER, 2 degree"] {
        let _ = writeln!(out, "WEIGHTING_FUNCTION \"{weighting}\"");
    }
    if let Some(condition) = notes.iter().find_map(|note| note.print.condition) {
        let _ = writeln!(out, "MEASUREMENT_SOURCE \"MeasurementCondition={}\"", condition.name());
    }
    let mut own = |keyword: &str, value: &str| {
        let _ = writeln!(out, "KEYWORD \"{keyword}\"\n{keyword} \"{value}\"");
    };
    own("STUDY_HASH", study.key().as_str());
    own("MEASUREMENT_GEOMETRY", &format!("{}, simulated", prints.geometry));
    own("LAB_CONDITIONS", &plain(&daylight.name()));
    own("SPECTRAL_BANDS", &nm.len().to_string());
    own("SPECTRAL_START_NM", &format!("{:.6}", nm[0]));
    own("SPECTRAL_END_NM", &format!("{:.6}", nm[nm.len() - 1]));
    own("SPECTRAL_NORM", "100.000000");
    own("MEAS_TYPE", "REFLECTIVE");
    let columns: Vec<String> = device.columns.into_iter().map(|(column, _)| column).collect();
    let spectral: Vec<String> = bands.wavelengths_nm.iter().map(|nm| format!("SPECTRAL_NM{nm:03}")).collect();
    let _ = writeln!(out, "\nNUMBER_OF_FIELDS {}", 8 + columns.len() + spectral.len());
    let all = format!("{} XYZ_X XYZ_Y XYZ_Z LAB_L LAB_A LAB_B {}", columns.join(" "), spectral.join(" "));
    let _ = writeln!(out, "BEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME {all}\nEND_DATA_FORMAT");
    let _ = writeln!(out, "\nNUMBER_OF_SETS {}\nBEGIN_DATA\n{}\nEND_DATA", rows.len(), rows.join("\n"));
    Ok(out)
}

/// Wavelengths that carry no colour.
fn refused(error: impl std::fmt::Display) -> ExportError {
    ExportError::Refused(format!("cgats of prints: {error}"))
}
