//! What an instrument would report of the print: its spectra every 10 nm, and the Lab that these have under the study's light.

use super::error::ExportError;
use crate::appearance::colour::{Colorimeter, Colour};
use crate::evaluate::ink_maker::{InkMaker, Swatch};
use crate::evaluate::manifest::{Manifest, SpectrumRow};
use crate::evaluate::seen::see;
use crate::evaluate::summary::{program, summarise};
use crate::export::print::{Geometry, Print, PrintSpectrum, resample, uniform_grid};
use crate::export::stored::Stored;
use crate::input::study::Study;
use crate::input::variation::LightRule;
use crate::numerics::estimate::Estimate;

/// A spectrum with the covariance of its Lab.
struct Known {
    geometry: Geometry,
    values: Vec<Estimate>,
    lab_covariance: Option<[[f64; 3]; 3]>,
}

/// The spectra with their colours. Fitted spectra are taken where the file has its wavelengths, as the program's colours take
/// them; listed ones are interpolated. Lab is summed from what is written, so that whoever sums it again finds it.
pub(super) fn print(stored: &Stored, format: &'static str, created: &str) -> Result<Print, ExportError> {
    let study = &stored.study;
    let grid = uniform_grid(&study.wavelengths_nm);
    if grid.len() < 2 || study.wavelengths_nm.len() < 2 {
        return Err(ExportError::TooFewWavelengths { format });
    }
    let wavelengths_nm: Vec<f64> = grid.iter().map(|&nm| f64::from(nm)).collect();
    let known = if matches!(study.variation.light, LightRule::Shifted { .. }) {
        let on_grid = Study { wavelengths_nm: wavelengths_nm.clone(), ..study.clone() };
        let seen = see(&on_grid, &stored.collected)?;
        known(&summarise(&on_grid, &stored.collected, &seen))
    } else {
        let mut known = known(&summarise(study, &stored.collected, &stored.seen));
        known.iter_mut().for_each(|k| k.values = resample(&study.wavelengths_nm, &k.values, &grid));
        known
    };
    let meter = Colorimeter::under(&wavelengths_nm, &study.judgement.viewing);
    let spectrum = |Known { geometry, values, lab_covariance }: Known| {
        let reflectance: Vec<f64> = values.iter().map(|e| e.value).collect();
        let colour = meter.as_ref().ok().and_then(|meter| meter.colour(&reflectance).ok());
        PrintSpectrum { geometry, values, colour: colour.map(|c| Colour { lab_covariance, ..c }) }
    };
    Ok(Print {
        title: study.title.clone(),
        study_hash: study.key().to_string(),
        program: program(),
        created: created.to_owned(),
        viewing: study.judgement.viewing.clone(),
        spectra: known.into_iter().map(spectrum).collect(),
        wavelengths_nm: grid,
    })
}

/// Both spectra of the print.
fn known(manifest: &Manifest<&Study>) -> Vec<Known> {
    let (lit, sky) = (Geometry::LitAt45, Geometry::NaturalLight);
    let both = [
        known_at(manifest, lit, |row| row.lit_at_45, |maker| &maker.print),
        known_at(manifest, sky, |row| row.natural_light, |maker| &maker.natural_light),
    ];
    both.into_iter().flatten().collect()
}

/// The spectrum at one geometry; `None` where it is not known at every wavelength.
fn known_at(
    manifest: &Manifest<&Study>,
    geometry: Geometry,
    of: fn(&SpectrumRow) -> Option<Estimate>,
    swatch: fn(&InkMaker) -> &Swatch,
) -> Option<Known> {
    // the ink on its paper stands beside the layer at the normal alone
    let normal = manifest.spectra.iter().filter(|row| row.polar_deg == 0.0);
    let values = normal.map(of).collect::<Option<Vec<Estimate>>>()?;
    let lab_covariance = manifest.ink_maker.as_ref().and_then(|maker| swatch(maker).colour.lab_covariance);
    Some(Known { geometry, values, lab_covariance })
}
