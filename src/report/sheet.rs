//! Contents of the report page of a study beside the manifest: figures, tables of packings, what
//! those of uncertainty and provenance need, and what its list of limits depends on. Every section
//! is there where its part of the manifest is.

mod figures;
mod layers;
mod slabs;
mod words;

use super::numbers;
use super::scalar_error;
use crate::draw::DrawResult;
use crate::draw::page::{hex, png_data};
use crate::evaluate::evaluated::Evaluated;
use crate::evaluate::ink_maker::{InkMaker, Swatch};
use crate::evaluate::manifest::{
    ColourNote, EnsembleNotes, MOST_LISTED, Manifest, SpectrumRow, WholeResults,
};
use crate::evaluate::seen::Seen;
use crate::evaluate::summary::aimed_at;
use crate::ink::{Method, PigmentGrains, SizeDistribution};
use crate::input::study::{Study, WantedResolution};
use crate::input::variation::LightRule;
use crate::numerics::estimate::Estimate;
use crate::numerics::vector::norm;
use crate::store::packing_record::{PackingRecord, ShareRecord};
use crate::wave::Resolution;
use minijinja::value::Serde;
use minijinja::{Value, context};

/// What the page of a study shows beside its numbers.
pub(super) struct ShownFiles<'a> {
    /// The first picture with its axes, as PNG.
    pub picture: Option<&'a [u8]>,
    /// Thickness of its layer in µm, where the study has layers of several thicknesses.
    pub pictured_um: Option<f64>,
    /// Names of the tables.
    pub tables: Vec<&'static str>,
}

/// Number of plots of spectra with which the page of a layer that is solved as a whole begins.
const SPECTRA: usize = 2;

/// What the page of a study shows.
///
/// # Errors
/// A figure cannot be drawn.
pub(super) fn sheet(evaluated: &Evaluated, files: &ShownFiles) -> DrawResult<Value> {
    let manifest = &evaluated.manifest;
    let study = manifest.study;
    let whole = manifest.whole();
    let mut figures = Vec::new();
    let mut parts = Vec::new();
    if let Some((whole, seen)) = whole.zip(evaluated.seen()) {
        figures.extend(figures::figures(manifest, whole.rows, seen)?);
        parts.push(averages(&whole, seen));
        let ensemble = whole.ensemble;
        parts.push(context!(packed => packings(study, ensemble), grid => grid(study, ensemble)));
        if let Some(maker) = &manifest.ink_maker {
            figures.extend(figures::of_ink_makers(maker, &whole)?);
            parts.push(context!(patches => Serde(patches(maker))));
        }
    }
    if let Some(composed) = manifest.composed() {
        figures.extend(slabs::figures(manifest, &composed)?);
        parts.push(slabs::page(manifest, &composed));
    }
    // of a layer that is solved as a whole: behind what is seen, and what it does without paper
    let place = if whole.is_none() { figures.len() } else { SPECTRA.min(figures.len()) };
    figures.splice(place..place, layers::figures(manifest)?);
    let conditions = whole.map_or(&[][..], |whole| whole.colours);
    let shown = context! {
        picture => files.picture.map(png_data),
        pictured_um => files.pictured_um,
        tables => Serde(&files.tables),
        thicknesses_um => manifest.thicknesses_um(),
        layers => layers::in_words(manifest),
        pictured => files.pictured_um.map(|um| layers::called(manifest, um)),
        called => manifest.thicknesses_um().iter().map(|um| layers::called(manifest, *um)).collect::<Vec<_>>(),
        parts => Serde(layers::parts(manifest)),
        conditions => Serde(conditions),
        failed => Serde(failed(manifest)),
        swatch => conditions.first().map(|note| hex(note.colour.srgb8)),
        figures => Serde(figures),
        shapes => Serde(shapes(study)),
        weighted => Serde(numbers::lines(&manifest.numbers)),
    };
    parts.extend([shown, limits(manifest, whole.as_ref()), provenance(manifest)]);
    let data = parts.into_iter().fold(Value::from(Serde(manifest)), |all, part| context!(..part, ..all));
    Ok(data)
}

/// Names and colours of the patches of a layer that is solved as a whole.
fn patches(maker: &InkMaker) -> [(&'static str, String); 3] {
    let InkMaker { over_black, over_white, print, .. } = maker;
    let patch = |name, swatch: &Swatch| (name, swatch.hex.clone());
    [patch("over black", over_black), patch("over white", over_white), patch("on its paper", print)]
}

/// Place and reason of every solve without a result.
fn failed(manifest: &Manifest) -> Vec<(String, String)> {
    let listed = manifest.failures.iter().take(MOST_LISTED);
    listed.map(|note| (note.place(), note.reason().to_owned())).collect()
}

/// Shape and size of the grains of every packed pigment.
fn shapes(study: &Study) -> Vec<[String; 2]> {
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

/// The main results in a line each: the first colour of a layer that is solved as a whole, or those
/// of every thickness of a composed one.
pub(super) fn main_results(manifest: &Manifest) -> Vec<String> {
    if let Some(composed) = manifest.composed() {
        return slabs::lines(manifest, &composed);
    }
    let first = manifest.whole().and_then(|whole| whole.colours.first());
    first.map(colour_in_words).into_iter().collect()
}

fn colour_in_words(note: &ColourNote) -> String {
    let [l, a, b] = [0, 1, 2].map(|i| {
        let standard_error = note.lab_standard_error.map(|errors| errors[i]);
        Estimate { value: note.colour.lab[i], standard_error }.in_words(2)
    });
    let chroma = note.chroma.in_words(2);
    let conditions = &note.conditions;
    format!("L* {l}, a* {a}, b* {b}, C* {chroma} under {conditions}")
}

fn limits(manifest: &Manifest, whole: Option<&WholeResults>) -> Value {
    context! {
        viewing => manifest.study.judgement.viewing.name(),
        scalar_error => scalar_error::line(manifest.study),
        surface => manifest.scalar_surface.map(|surface| surface.in_words()),
        lacking => manifest.missing_packings(),
        synthetic => manifest.study.pigments.iter().any(|p| p.material.source.contains("synthetic")),
        too_few => whole.and_then(|whole| few_wavelengths(manifest.study, whole)),
        widest => missed_target(manifest).map(|(bar, _)| bar),
        inputs => manifest.study.inputs_with_errors(),
        undetermined => Serde(manifest.study.undetermined_inputs()),
    }
}

/// Wavelengths that a colour needs.
const ENOUGH_WAVELENGTHS: usize = 8;

/// The number of wavelengths of a colour that has too few: those solved over all realisations where
/// each has its own.
fn few_wavelengths(study: &Study, whole: &WholeResults) -> Option<usize> {
    let solved = match study.variation.light {
        LightRule::Shifted { strata, .. } => strata * whole.ensemble.realisations.finished,
        LightRule::Listed => {
            let is_solved = |nm: &&f64| whole.rows.iter().any(|row| row.wavelength_nm == **nm);
            study.wavelengths_nm.iter().filter(is_solved).count()
        }
    };
    (solved < ENOUGH_WAVELENGTHS && study.angles.strata > 0).then_some(solved)
}

/// The widest interval where it is beyond `run.target_delta_e`, and what would make it narrower.
pub(super) fn missed_target(manifest: &Manifest) -> Option<(f64, &'static str)> {
    let target = manifest.study.target_delta_e?;
    let bars = aimed_at(manifest.study, manifest).filter_map(|note| Some((note.delta_e_2000_95?, note)));
    let (bar, note) = bars.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(bar, _)| *bar > target)?;
    Some((bar, note.budget.remedy_but_packings().unwrap_or("more packings: run.realisations")))
}

/// What the table of uncertainties holds beside the manifest.
fn averages(whole: &WholeResults, seen: &Seen) -> Value {
    let colour = whole.colours.first().and_then(|note| note.lab_standard_error);
    context! {
        averaged => seen.realisations.len(),
        cells => seen.cells.len(),
        no_ink => seen.ink.as_ref().err().map(ToString::to_string),
        colour_error => colour.map(norm),
        largest_error => largest_error(whole.rows),
    }
}

fn largest_error(rows: &[SpectrumRow]) -> Option<f64> {
    let errors = rows.iter().flat_map(|row| [row.reflectance, row.transmittance]);
    errors.filter_map(|estimate| estimate.standard_error).reduce(f64::max)
}

fn packings(study: &Study, ensemble: &EnsembleNotes) -> Vec<Value> {
    let rows = ensemble.packings.iter().take(MOST_LISTED).flat_map(|packing| {
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
    let words = packing.method.in_words();
    let steps = packing.steps;
    match packing.method {
        Method::SequentialAddition => format!("{words}, {steps} attempts"),
        Method::Relaxation => format!("{words}, {steps} steps"),
        Method::Given | Method::Voxels => words.to_owned(),
    }
}

/// The grids in words.
fn grid(study: &Study, ensemble: &EnsembleNotes) -> String {
    let chosen = match study.resolution {
        WantedResolution::Accuracy { amplitude, .. } => {
            format!("chosen for amplitude errors of {amplitude:.0e}")
        }
        WantedResolution::Grid { .. } => "as asked".to_owned(),
    };
    let words =
        |r: Resolution| format!("{} × {} points, {} cells ({} planes)", r.nx, r.ny, r.cells, r.planes());
    let longest = ensemble.resolution_longest.map(|r| format!("; {} for the longest waves", words(r)));
    format!("{}, {chosen}{}", words(ensemble.resolution), longest.unwrap_or_default())
}

/// What the table of provenance holds beside the manifest.
fn provenance(manifest: &Manifest) -> Value {
    context! {
        wave => manifest.study.wave.in_words(),
        solver => manifest.study.solver.build().name(),
        mixed => (manifest.origin.builds.len() > 1).then_some("different builds: "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::manifest::SpectrumReplicates;
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
            replicates: SpectrumReplicates::default(),
        };
        let rows = [row(Some(0.01), None), row(Some(0.04), Some(0.02))];
        assert_eq!(largest_error(&rows), Some(0.04));
    }
}
