//! Contents of the report page of a study: its tables of packings, what those of uncertainty and
//! provenance need, and what its list of limits depends on beside the manifest.

mod figures;

use super::numbers;
use super::scalar_error;
use crate::draw::DrawResult;
use crate::draw::page::{hex, png_data};
use crate::evaluate::manifest::{Manifest, SpectrumRow};
use crate::evaluate::seen::Seen;
use crate::evaluate::summary::aimed_at;
use crate::ink::{Method, PigmentGrains, SizeDistribution};
use crate::input::study::{Study, WantedResolution};
use crate::input::variation::LightRule;
use crate::numerics::estimate::Estimate;
use crate::numerics::vector::norm;
use crate::store::packing_record::{PackingRecord, ShareRecord};
use crate::wave::Resolution;
pub(super) use figures::shown_nm;
use minijinja::value::Serde;
use minijinja::{Value, context};

/// What the page of a run shows; `picture` is the labelled picture as PNG.
///
/// # Errors
/// A figure cannot be drawn.
pub fn sheet(manifest: &Manifest<&Study>, seen: &Seen, picture: Option<&[u8]>) -> DrawResult<Value> {
    let figures = [figures::figures(manifest, seen)?, figures::of_ink_makers(manifest)?].concat();
    let shown = context! {
        picture => picture.map(png_data),
        swatch => manifest.colours.first().map(|note| hex(note.colour.srgb8)),
        figures => Serde(figures),
        shapes => Serde(shapes(manifest.study)),
        packed => packings(manifest),
        weighted => Serde(numbers::lines(&manifest.numbers)),
    };
    let certainty = certainty(manifest, seen);
    let limits = limits(manifest);
    let provenance = provenance(manifest);
    Ok(context!(..shown, ..certainty, ..limits, ..provenance, ..Value::from(Serde(manifest))))
}

/// Shape and size of the grains of every packed pigment.
pub(super) fn shapes(study: &Study) -> Vec<[String; 2]> {
    let grains = study.pigments.iter().map(|pigment| &pigment.grains);
    grains.map(|grains| [grains.shape.name().to_owned(), size(grains)]).collect()
}

/// The grains' size: one diameter, or the largest.
fn size(grains: &PigmentGrains) -> String {
    match grains.size {
        SizeDistribution::Constant { value_nm, .. } => format!("{value_nm} nm"),
        _ => format!("up to {:.0} nm", grains.size.largest_nm()),
    }
}

/// The first colour in one line.
pub(super) fn colour_in_words(manifest: &Manifest<&Study>) -> Option<String> {
    let first = manifest.colours.first()?;
    let [l, a, b] = [0, 1, 2].map(|i| {
        let standard_error = first.lab_standard_error.map(|errors| errors[i]);
        Estimate { value: first.colour.lab[i], standard_error }.in_words(2)
    });
    let chroma = first.chroma.in_words(2);
    let conditions = &first.conditions;
    Some(format!("L* {l}, a* {a}, b* {b}, C* {chroma} under {conditions}"))
}

pub(crate) fn limits(manifest: &Manifest<&Study>) -> Value {
    context! {
        viewing => manifest.study.judgement.viewing.name(),
        scalar_error => scalar_error::line(manifest.study),
        lacking => manifest.tried_packings.missing_in_words(),
        synthetic => manifest.study.pigments.iter().any(|p| p.material.source.contains("synthetic")),
        too_few => few_wavelengths(manifest),
        widest => missed_target(manifest),
        inputs => manifest.study.inputs_with_errors(),
        undetermined => Serde(manifest.study.undetermined_inputs()),
    }
}

/// Wavelengths that a colour needs.
const ENOUGH_WAVELENGTHS: usize = 8;

/// The number of wavelengths of a colour that has too few: those solved over all realisations where
/// each has its own.
fn few_wavelengths(manifest: &Manifest<&Study>) -> Option<usize> {
    let solved = match manifest.study.variation.light {
        LightRule::Shifted { strata, .. } => strata * manifest.realisations.finished,
        LightRule::Listed => manifest
            .study
            .wavelengths_nm
            .iter()
            .filter(|nm| manifest.spectra.iter().any(|row| row.wavelength_nm == **nm))
            .count(),
    };
    (solved < ENOUGH_WAVELENGTHS && manifest.study.angles.strata > 0).then_some(solved)
}

/// The widest interval where it is beyond `run.target_delta_e`.
pub(super) fn missed_target(manifest: &Manifest<&Study>) -> Option<f64> {
    let target = manifest.study.target_delta_e?;
    let bars = aimed_at(manifest.study, manifest).filter_map(|note| note.delta_e_2000_95);
    bars.reduce(f64::max).filter(|&bar| bar > target)
}

/// What the table of uncertainties holds beside the manifest.
pub(crate) fn certainty(manifest: &Manifest<&Study>, seen: &Seen) -> Value {
    let colour = manifest.colours.first().and_then(|note| note.lab_standard_error);
    context! {
        averaged => seen.realisations.len(),
        cells => seen.cells.len(),
        no_ink => seen.ink.as_ref().err().map(ToString::to_string),
        colour_error => colour.map(norm),
        inputs => manifest.study.inputs_with_errors(),
        largest_error => largest_error(&manifest.spectra),
    }
}

fn largest_error(rows: &[SpectrumRow]) -> Option<f64> {
    let errors = rows.iter().flat_map(|row| [row.reflectance, row.transmittance]);
    errors.filter_map(|estimate| estimate.standard_error).reduce(f64::max)
}

pub(crate) fn packings(manifest: &Manifest<&Study>) -> Vec<Value> {
    let rows = manifest.packings.iter().flat_map(|packing| {
        let pigments = manifest.study.pigments.iter().zip(&packing.shares);
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
    let words = packing.method.in_words();
    let steps = packing.steps;
    match packing.method {
        Method::SequentialAddition => format!("{words}, {steps} attempts"),
        Method::Relaxation => format!("{words}, {steps} steps"),
        Method::Given | Method::Voxels => words.to_owned(),
    }
}

/// What the table of provenance holds beside the manifest.
pub(crate) fn provenance(manifest: &Manifest<&Study>) -> Value {
    let grid = match manifest.study.resolution {
        WantedResolution::Accuracy { amplitude, .. } => {
            format!("chosen for amplitude errors of {amplitude:.0e}")
        }
        WantedResolution::Grid { .. } => "as asked".to_owned(),
    };
    let words =
        |r: Resolution| format!("{} × {} points, {} cells ({} planes)", r.nx, r.ny, r.cells, r.planes());
    let longest = manifest.resolution_longest.map(|r| format!("; {} for the longest waves", words(r)));
    context! {
        wave => manifest.study.wave.in_words(),
        grid => format!("{}, {grid}{}", words(manifest.resolution), longest.unwrap_or_default()),
        solver => manifest.study.solver.build().name(),
        mixed => (manifest.origin.builds.len() > 1).then_some("different builds: "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::estimate::Estimate;

    #[test]
    fn the_largest_error_is_that_of_any_row() {
        let half = |standard_error| Estimate { value: 0.5, standard_error };
        let row = |r, t| SpectrumRow {
            wavelength_nm: 550.0,
            polar_deg: 0.0,
            reflectance: half(r),
            specular_reflectance: half(None),
            transmittance: half(t),
            specular_transmittance: half(None),
            coherent_transmittance: None,
            absorptance: half(None),
            natural_light: None,
            lit_at_45: None,
            sphere_at_8: None,
            sphere_at_8_excluded: None,
            diffuse_normal: None,
            transmittance_diffuse: None,
            absorptance_behind: None,
            deviations: Vec::new(),
        };
        let rows = [row(Some(0.01), None), row(Some(0.04), Some(0.02))];
        assert_eq!(largest_error(&rows), Some(0.04));
    }
}
