//! CGATS.17 text: spectra in percent with Lab, one row per geometry, in the columns that ArgyllCMS
//! reads.

use super::print::Print;
use crate::evaluate::summary::program;
use std::fmt::Write;

/// Dialect of the file, named in its first line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// `CGATS.17`, the standard's own.
    Standard,
    /// `SPECT`: read by the tools of ArgyllCMS as measured spectra without device values.
    Argyll,
}

/// The complete file.
pub fn cgats(print: &Print, dialect: Dialect) -> String {
    let mut out = match dialect {
        Dialect::Standard => "CGATS.17\n\n",
        Dialect::Argyll => "SPECT\n\n",
    }
    .to_owned();
    header(&mut out, print, dialect);
    fields(&mut out, print);
    let _ = writeln!(out, "\nNUMBER_OF_SETS {}\nBEGIN_DATA", print.spectra.len());
    for (i, spectrum) in print.spectra.iter().enumerate() {
        let lab = spectrum.colour.filter(|_| has_lab(print)).map(|colour| colour.lab);
        let numbers = lab.into_iter().flatten().chain(spectrum.values.iter().map(|e| 100.0 * e.value));
        let row: Vec<String> = numbers.map(|x| format!("{x:.6}")).collect();
        let _ = writeln!(out, "{} \"{}\" {}", i + 1, spectrum.geometry.name(), row.join(" "));
    }
    out + "END_DATA\n"
}

fn header(out: &mut String, print: &Print, dialect: Dialect) {
    let title = print.title.replace('"', "'").replace(['\n', '\r'], " ");
    let _ = writeln!(out, "ORIGINATOR \"{} (simulated)\"", program());
    let _ = writeln!(out, "DESCRIPTOR \"Simulated, not measured: {}\"", title);
    let _ = writeln!(out, "CREATED \"{}\"", print.created);
    if dialect == Dialect::Standard {
        // the standard's own words; Argyll takes each keyword once
        let (light, degree) =
            (print.viewing.illuminant(), print.viewing.observer().replace("2015_", "2015, "));
        let _ = writeln!(out, "WEIGHTING_FUNCTION \"ILLUMINANT, {light}\"");
        let _ = writeln!(out, "WEIGHTING_FUNCTION \"OBSERVER, {degree} degree\"");
    }
    let mut own = |keyword: &str, value: &str| {
        let _ = writeln!(out, "KEYWORD \"{keyword}\"\n{keyword} \"{value}\"");
    };
    own("STUDY_HASH", &print.study_hash);
    own("MEASUREMENT_GEOMETRY", "45:0 and uniform sky:0, simulated");
    own("LAB_CONDITIONS", &print.viewing.name().replace('°', " degree"));
    own("SPECTRA_NOTE", print.spectra_from());
    let no_lab = "none: the wavelengths do not suffice for a colour";
    own("LAB_NOTE", &if has_lab(print) { print.lab_note() } else { no_lab.to_owned() });
    if dialect == Dialect::Argyll {
        own("SPECTRAL_NORM", "100.000000");
        own("MEAS_TYPE", "REFLECTIVE");
    }
    let (first, last) = (print.wavelengths_nm.first(), print.wavelengths_nm.last());
    own("SPECTRAL_BANDS", &print.wavelengths_nm.len().to_string());
    own("SPECTRAL_START_NM", &format!("{:.6}", f64::from(first.copied().unwrap_or(0))));
    own("SPECTRAL_END_NM", &format!("{:.6}", f64::from(last.copied().unwrap_or(0))));
}

/// Whether every spectrum has a colour; otherwise there are no Lab columns.
fn has_lab(print: &Print) -> bool {
    print.spectra.iter().all(|spectrum| spectrum.colour.is_some())
}

fn fields(out: &mut String, print: &Print) {
    let bands: Vec<String> = print.wavelengths_nm.iter().map(|nm| format!("SPEC_{nm:03}")).collect();
    let (count, lab) = if has_lab(print) { (5, "LAB_L LAB_A LAB_B ") } else { (2, "") };
    let _ = writeln!(out, "\nNUMBER_OF_FIELDS {}", count + bands.len());
    let _ = writeln!(out, "BEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME {lab}{}", bands.join(" "));
    let _ = writeln!(out, "END_DATA_FORMAT");
}
