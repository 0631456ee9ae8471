//! What an instrument would report of the print: its spectra every 10 nm, and the Lab that these have under the study's light.

use crate::appearance::colour::{Colorimeter, Colour};
use crate::evaluate::ink_maker::{InkMaker, Swatch};
use crate::evaluate::manifest::{Manifest, SpectrumRow};
use crate::evaluate::seen::see;
use crate::evaluate::summary::{program, summarise};
use crate::export::error::ExportError;
use crate::export::print::{InstrumentGeometry, Print, PrintSpectrum, resample, uniform_grid};
use crate::export::stored::Stored;
use crate::input::study::Study;
use crate::input::variation::LightRule;
use crate::numerics::estimate::Estimate;

/// A spectrum with the covariance of its Lab.
struct KnownSpectrum {
    geometry: InstrumentGeometry,
    values: Vec<Estimate>,
    lab_covariance: Option<[[f64; 3]; 3]>,
    page_lab: Option<[f64; 3]>,
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
    let own = summarise(study, &stored.collected, &stored.seen);
    let fitted = matches!(study.variation.light, LightRule::Shifted { .. });
    let mut known = if fitted {
        let on_grid = Study { wavelengths_nm: wavelengths_nm.clone(), ..study.clone() };
        let seen = see(&on_grid, &stored.collected)?;
        known(&summarise(&on_grid, &stored.collected, &seen))
    } else {
        let mut known = known(&own);
        known.iter_mut().for_each(|k| k.values = resample(&study.wavelengths_nm, &k.values, &grid));
        known
    };
    known.iter_mut().for_each(|k| k.page_lab = page_lab(&own, k.geometry));
    if let ([], Some(reason)) = (known.as_slice(), own.withheld.first()) {
        return Err(ExportError::NoInk { format, reason: reason.in_words() });
    }
    let meter = Colorimeter::under(&wavelengths_nm, &study.judgement.viewing);
    // what the page withholds no file gives
    let meter = meter.ok().filter(|_| own.ink_maker.is_some());
    Ok(Print {
        title: study.title.clone(),
        study_hash: study.key().to_string(),
        program: program(),
        created: created.to_owned(),
        viewing: study.judgement.viewing.clone(),
        spectra: known.into_iter().map(|known| with_colour(known, meter.as_ref())).collect(),
        interpolated: !fitted,
        wavelengths_nm: grid,
    })
}

/// The colour is that of the values themselves.
fn with_colour(known: KnownSpectrum, meter: Option<&Colorimeter>) -> PrintSpectrum {
    let KnownSpectrum { geometry, values, lab_covariance, page_lab } = known;
    let reflectance: Vec<f64> = values.iter().map(|e| e.value).collect();
    let colour = meter.and_then(|meter| meter.colour(&reflectance).ok());
    let colour = colour.map(|c| Colour { lab_covariance, ..c });
    PrintSpectrum { geometry, values, colour, page_lab }
}

/// Lab of the study's page under the study's light.
fn page_lab(manifest: &Manifest<&Study>, geometry: InstrumentGeometry) -> Option<[f64; 3]> {
    let maker = manifest.ink_maker.as_ref()?;
    let swatch = match geometry {
        InstrumentGeometry::LitAt45 => &maker.print,
        InstrumentGeometry::NaturalLight => &maker.natural_light,
    };
    Some(swatch.colour.lab)
}

/// Both spectra of the print.
fn known(manifest: &Manifest<&Study>) -> Vec<KnownSpectrum> {
    let (lit, sky) = (InstrumentGeometry::LitAt45, InstrumentGeometry::NaturalLight);
    let both = [
        known_at(manifest, lit, |row| row.lit_at_45, |maker| &maker.print),
        known_at(manifest, sky, |row| row.natural_light, |maker| &maker.natural_light),
    ];
    both.into_iter().flatten().collect()
}

/// The spectrum at one geometry; `None` where it is not known at every wavelength.
fn known_at(
    manifest: &Manifest<&Study>,
    geometry: InstrumentGeometry,
    of: fn(&SpectrumRow) -> Option<Estimate>,
    swatch: fn(&InkMaker) -> &Swatch,
) -> Option<KnownSpectrum> {
    // the ink on its paper stands beside the layer at the normal alone
    let normal = manifest.spectra.iter().filter(|row| row.polar_deg == 0.0);
    let values = normal.map(of).collect::<Option<Vec<Estimate>>>()?;
    let lab_covariance = manifest.ink_maker.as_ref().and_then(|maker| swatch(maker).colour.lab_covariance);
    Some(KnownSpectrum { geometry, values, lab_covariance, page_lab: None })
}
