//! The prints in dots of a study as CGATS.17 text: a characterisation set, from which makers of
//! profiles take device values, Lab and spectra.

use super::print::{Bands, resample};
use super::request::ExportResult;
use crate::evaluate::printed::{PrintNote, Prints};
use crate::evaluate::summary::program;
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

/// The file, with a row a print; device values and factors are percentages.
///
/// # Errors
/// Wavelengths that do not hold two multiples of 10 nm.
pub fn cgats(study: &Study, prints: &Prints, created: &str) -> ExportResult<String> {
    let bands = Bands::new(study, "cgats")?;
    let device = Device::of(prints);
    let mut rows = Vec::new();
    for note in &prints.prints {
        let Some(values) = device.values(note) else { continue };
        let spectrum = resample(&study.wavelengths_nm, &note.factors, &bands.wavelengths_nm);
        let lab = note.lab.iter().map(|value| value.value);
        let numbers = values.into_iter().chain(lab).chain(spectrum.iter().map(|e| 100.0 * e.value));
        let numbers: Vec<String> = numbers.map(|x| format!("{x:.6}")).collect();
        let thickness = note.thickness_um.map_or(String::new(), |um| format!(", {um} µm"));
        rows.push(format!("{} \"{}{thickness}\" {}", rows.len() + 1, note.name(), numbers.join(" ")));
    }
    let title = study.title.replace('"', "'").replace(['\n', '\r'], " ");
    let mut out = "CGATS.17\n\n".to_owned();
    let _ = writeln!(out, "ORIGINATOR \"{} (simulated)\"", program());
    let _ = writeln!(out, "DESCRIPTOR \"Simulated, not measured: prints in dots, {title}\"");
    let _ = writeln!(out, "CREATED \"{created}\"");
    let mut own = |keyword: &str, value: &str| {
        let _ = writeln!(out, "KEYWORD \"{keyword}\"\n{keyword} \"{value}\"");
    };
    own("STUDY_HASH", study.key().as_str());
    own("MEASUREMENT_GEOMETRY", &format!("{}, simulated", prints.geometry));
    own("LAB_CONDITIONS", &prints.conditions.replace('°', " degree"));
    own("SPECTRAL_NORM", "100.000000");
    own("MEAS_TYPE", "REFLECTIVE");
    let columns: Vec<String> = device.columns.into_iter().map(|(column, _)| column).collect();
    let spectral: Vec<String> = bands.wavelengths_nm.iter().map(|nm| format!("SPEC_{nm:03}")).collect();
    let _ = writeln!(out, "\nNUMBER_OF_FIELDS {}", 5 + columns.len() + spectral.len());
    let all = format!("{} LAB_L LAB_A LAB_B {}", columns.join(" "), spectral.join(" "));
    let _ = writeln!(out, "BEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME {all}\nEND_DATA_FORMAT");
    let _ = writeln!(out, "\nNUMBER_OF_SETS {}\nBEGIN_DATA\n{}\nEND_DATA", rows.len(), rows.join("\n"));
    Ok(out)
}
