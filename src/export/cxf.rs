//! CxF3 (ISO 17972): the spectra of the print with Lab, as colour instruments' programs exchange
//! them.
//!
//! The format has no element for uncertainties: they are tags of each object. `Creator`,
//! `Description` and the tags state that the data are simulated.

use super::print::{Print, PrintSpectrum};
use crate::evaluate::summary::program;
use crate::report::cell::plain;
use minijinja::value::Serde;
use minijinja::{Environment, Value, context};

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
            interpolated: false,
            wavelengths_nm: vec![400, 410],
            spectra: vec![spectrum],
        };
        let file = cxf(&print).unwrap();
        assert!(file.contains("<cc:WavelengthRange StartWL=\"400\" Increment=\"10\"/>"), "{file}");
        assert!(file.contains("Name=\"StandardErrors\" Value=\"0.0200000 0.0050000\""), "{file}");
    }
}
