//! The page's tables: packings, and what those of uncertainty and provenance need.

use crate::evaluate::manifest::{Manifest, SpectrumRow};
use crate::evaluate::seen::Seen;
use crate::ink::Method;
use crate::input::study::{Study, WantedResolution};
use crate::numerics::vector::norm;
use crate::store::packing_record::{PackingRecord, ShareRecord};
use crate::wave::Resolution;
use minijinja::{Value, context};

/// What the table of uncertainties holds beside the manifest.
pub(crate) fn certainty(manifest: &Manifest<&Study>, seen: &Seen) -> Value {
    let colour = manifest.colours.first().and_then(|note| note.lab_standard_error);
    context! {
        averaged => seen.realisations.len(),
        no_ink => seen.ink.as_ref().err().map(ToString::to_string),
        colour_error => colour.map(norm),
        largest_error => largest_error(&manifest.spectra),
    }
}

fn largest_error(rows: &[SpectrumRow]) -> Option<f64> {
    let errors = rows.iter().flat_map(|row| [row.reflectance, row.transmittance]);
    errors.filter_map(|estimate| estimate.standard_error).reduce(f64::max)
}

pub(crate) fn packings(study: &Study, manifest: &Manifest<&Study>) -> Vec<Value> {
    let rows = manifest.packings.iter().flat_map(|packing| {
        let pigments = study.pigments.iter().zip(&packing.shares);
        pigments.map(|(pigment, share)| packing_row(packing, &pigment.name, share))
    });
    rows.collect()
}

/// A pigment's volume fractions, requested and reached, in one packing.
fn packing_row(packing: &PackingRecord, pigment: &str, share: &ShareRecord) -> Value {
    context! {
        realisation => packing.realisation + 1,
        pigment => pigment.to_owned(),
        grains => share.grains,
        asked => format!("{:.2}", 100.0 * share.requested_fraction),
        reached => format!("{:.2}", 100.0 * share.achieved_fraction),
        sizes => share.sizes.map_or_else(|| "–".to_owned(), |sizes| sizes.in_words()),
        method => method(packing),
    }
}

/// How the grains were packed, with the number of steps.
fn method(packing: &PackingRecord) -> String {
    let (words, steps) = (packing.method.in_words(), packing.steps);
    match packing.method {
        Method::SequentialAddition => format!("{words}, {steps} attempts"),
        Method::Relaxation => format!("{words}, {steps} steps"),
        Method::Given | Method::Voxels => words.to_owned(),
    }
}

/// What the table of provenance holds beside the manifest.
pub(crate) fn provenance(study: &Study, manifest: &Manifest<&Study>) -> Value {
    let grid = match study.resolution {
        WantedResolution::Accuracy { amplitude, .. } => {
            format!("chosen for amplitude errors of {amplitude:.0e}")
        }
        WantedResolution::Grid { .. } => "as asked".to_owned(),
    };
    let words =
        |r: Resolution| format!("{} × {} points, {} cells ({} planes)", r.nx, r.ny, r.cells, r.planes());
    let longest = manifest.resolution_longest.map(|r| format!("; {} for the longest waves", words(r)));
    context! {
        wave => study.wave.in_words(),
        grid => format!("{}, {grid}{}", words(manifest.resolution), longest.unwrap_or_default()),
        solver => study.solver.build().name(),
        mixed => (manifest.builds.len() > 1).then_some("different builds: "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::estimate::Estimate;

    #[test]
    fn the_largest_error_is_that_of_any_row() {
        let of = |standard_error| Estimate { value: 0.5, standard_error };
        let row = |r, t| SpectrumRow {
            wavelength_nm: 550.0,
            polar_deg: 0.0,
            reflectance: of(r),
            specular_reflectance: of(None),
            transmittance: of(t),
            specular_transmittance: of(None),
            absorptance: of(None),
            natural_light: None,
            lit_at_45: None,
            deviations: Vec::new(),
        };
        let rows = [row(Some(0.01), None), row(Some(0.04), Some(0.02))];
        assert_eq!(largest_error(&rows), Some(0.04));
    }
}
