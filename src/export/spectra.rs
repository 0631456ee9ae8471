//! The spectra of the print with Lab for colour programs.
//!
//! CGATS.17 text: spectra in percent with Lab, one row per geometry, in the columns that ArgyllCMS
//! reads.
//!
//! CxF3 (ISO 17972), as colour instruments' programs exchange them. The format has no element for
//! uncertainties: they are tags of each object. `Creator`, `Description` and the tags state that
//! the data are simulated.

use super::print::{Print, PrintSpectrum};
use crate::draw::cell::plain;
use crate::evaluate::summary::program;
use minijinja::value::Serde;
use minijinja::{Environment, Value, context};
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
        let light = print.viewing.illuminant();
        let degree = print.viewing.observer().replace("2015_", "2015, ");
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
    if let Some(light) = &print.exciting {
        own("EXCITING_LIGHT", &format!("{light}, ultraviolet included: none of M0 to M3"));
    }
    own("SPECTRAL_NORM", "100.000000");
    own("MEAS_TYPE", "REFLECTIVE");
    let first = print.wavelengths_nm.first();
    let last = print.wavelengths_nm.last();
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

/// Decimals of reflectance factors: far below any standard error.
const DECIMALS: usize = 7;
/// Illuminants of studies that the format has a name for.
const ILLUMINANTS: [&str; 11] = ["A", "D50", "D65", "E", "F2", "F3", "F7", "F9", "F10", "F11", "F12"];

/// The complete file.
///
/// # Errors
/// The template does not fit the data, which is a bug.
pub fn cxf(print: &Print) -> Result<String, minijinja::Error> {
    let start = print.wavelengths_nm.first().copied().unwrap_or(0);
    let data = context! {
        program => program(),
        created => &print.created,
        title => plain(&print.title),
        study_hash => &print.study_hash,
        conditions => print.viewing.name(),
        origin => print.spectra_from(),
        lab_note => print.lab_note(),
        exciting => &print.exciting,
        start,
        increment => print.wavelengths_nm.get(1).map_or(10, |second| second - start),
        light => print.viewing.illuminant().to_owned(),
        observer => print.viewing.observer().to_owned(),
        illuminants => Serde(ILLUMINANTS),
        spectra => print.spectra.iter().map(spectrum).collect::<Vec<_>>(),
    };
    let mut templates = Environment::new();
    templates.add_template("cxf.xml", include_str!("cxf.xml"))?;
    templates.get_template("cxf.xml")?.render(data)
}

/// Values, errors and colour of a spectrum, with the white that Lab refers to.
fn spectrum(spectrum: &PrintSpectrum) -> Value {
    let errors = spectrum.values.iter().map(|e| e.standard_error.map(|s| format!("{s:.DECIMALS$}")));
    let errors: Option<Vec<String>> = errors.collect();
    let five = |all: [f64; 3]| Serde(all.map(|x| format!("{x:.5}")));
    context! {
        id => spectrum.geometry.id(),
        name => spectrum.geometry.name(),
        values => spectrum.values.iter().map(|e| format!("{:.DECIMALS$}", e.value)).collect::<Vec<_>>(),
        errors => errors.map_or_else(|| "unknown".to_owned(), |e| e.join(" ")),
        lab => spectrum.colour.map(|colour| five(colour.lab)),
        lab_errors => spectrum.colour.and_then(|colour| colour.lab_standard_error()).map(five),
        white => spectrum.colour.map(|colour| five(colour.white_xyz)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::viewing::{Summation, Viewing};
    use crate::export::print::InstrumentGeometry;
    use crate::numerics::estimate::Estimate;

    #[test]
    fn the_step_of_the_wavelengths_and_standard_errors_are_the_prints() {
        let of = |value, error| Estimate { value, standard_error: Some(error) };
        let spectrum = PrintSpectrum {
            geometry: InstrumentGeometry::LitAt45,
            values: vec![of(0.5, 0.02), of(0.25, 0.005)],
            lab_covariance: None,
            colour: None,
            page_lab: None,
        };
        let print = Print {
            title: "Made up".to_owned(),
            study_hash: "0".to_owned(),
            created: "2000-01-01T00:00:00Z".to_owned(),
            viewing: Viewing::new("D50", "2", Summation::Plain).unwrap(),
            exciting: None,
            interpolated: false,
            wavelengths_nm: vec![400, 410],
            spectra: vec![spectrum],
        };
        let file = cxf(&print).unwrap();
        assert!(file.contains("<cc:WavelengthRange StartWL=\"400\" Increment=\"10\"/>"), "{file}");
        assert!(file.contains("Name=\"StandardErrors\" Value=\"0.0200000 0.0050000\""), "{file}");
        // *Planted*: the condition of other papers on one that daylight excites
        assert!(file.contains("M0_Incandescent") && !file.contains("ExcitingLight"), "{file}");
        let brightened = Print { exciting: Some("D65".to_owned()), ..print };
        let file = cxf(&brightened).unwrap();
        assert!(
            !file.contains("M0_Incandescent") && file.contains("Name=\"ExcitingLight\" Value=\"D65"),
            "{file}"
        );
        assert!(cgats(&brightened, Dialect::Standard).contains("EXCITING_LIGHT \"D65"));
    }
}
