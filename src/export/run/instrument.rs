//! What an instrument would report of the print: its spectra every 10 nm, and the Lab that these
//! have under the study's light.

use crate::evaluate::manifest::Manifest;
use crate::evaluate::seen::see;
use crate::evaluate::summary::summarise;
use crate::export::error::ExportError;
use crate::export::print::{InstrumentGeometry, Print, PrintSpectrum, bands, resample};
use crate::export::stored::Stored;
use crate::input::study::Study;
use crate::input::variation::LightRule;

/// The spectra with their colours. Fitted spectra are evaluated at the wavelengths of the file,
/// listed ones are interpolated. Lab is computed from the exported values, so that other programs
/// find the same.
pub(super) fn print(stored: &Stored, format: &'static str, created: &str) -> Result<Print, ExportError> {
    let study = &stored.study;
    let (grid, meter) = bands(study, format)?;
    let own = summarise(study, &stored.collected, &stored.seen);
    let fitted = matches!(study.variation.light, LightRule::Shifted { .. });
    let spectra = if fitted {
        let wavelengths_nm = grid.iter().map(|&nm| f64::from(nm)).collect();
        let on_grid = Study { wavelengths_nm, ..study.clone() };
        let seen = see(&on_grid, &stored.collected)?;
        known(&summarise(&on_grid, &stored.collected, &seen), &own)
    } else {
        let mut known = known(&own, &own);
        known.iter_mut().for_each(|k| k.values = resample(&study.wavelengths_nm, &k.values, &grid));
        known
    };
    if let ([], Some(reason)) = (spectra.as_slice(), own.withheld.first()) {
        return Err(ExportError::no_ink(format, &reason.in_words()));
    }
    // a number that the page withholds is in no file
    Ok(Print::new(study, created, (grid, meter.filter(|_| own.ink_maker.is_some())), (!fitted, spectra)))
}

/// Both spectra of the print, those that are known at every wavelength; Lab of the page is that of
/// `own`.
fn known(manifest: &Manifest<&Study>, own: &Manifest<&Study>) -> Vec<PrintSpectrum> {
    let mut all = Vec::new();
    for geometry in InstrumentGeometry::ALL {
        // the ink on its paper is evaluated at normal incidence only
        let normal = manifest.spectra.iter().filter(|row| row.polar_deg == 0.0);
        let values = normal.map(|row| geometry.of(row.lit_at_45, row.natural_light)).collect();
        let colour = |manifest: &Manifest<&Study>| {
            let maker = manifest.ink_maker.as_ref()?;
            Some(geometry.of(&maker.print, &maker.natural_light).colour)
        };
        if let Some(values) = values {
            let lab_covariance = colour(manifest).and_then(|colour| colour.lab_covariance);
            let page_lab = colour(own).map(|colour| colour.lab);
            all.push(PrintSpectrum { geometry, values, lab_covariance, colour: None, page_lab });
        }
    }
    all
}
