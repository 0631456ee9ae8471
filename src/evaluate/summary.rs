//! The numbers of a run, ready for `results.json`, the tables and the page.

use super::manifest::{Certainty, ColourNote, Count, FailureNote, Manifest, SpectrumRow, Status};
use super::seen::{LayerSeen, NoInk, Seen};
use super::uncertainty;
use super::uncertainty::Uncertainty;
use crate::appearance::angles::PolarAngle;
use crate::appearance::bdf::Lobe;
use crate::appearance::colour::Colour;
use crate::appearance::ink_on_paper::{InkError, InkOnPaper};
use crate::appearance::paper::LayerOnPaper;
use crate::input::study::Study;
use crate::run::runner::Collected;
use crate::store::identity::METHOD_VERSION;
use crate::store::record::PointRecord;

/// Illumination of print measurement, seen along the normal (ISO 13655: 45°:0°).
const PRINT_LIGHT_DEG: f64 = 45.0;
/// Name of that geometry.
pub const LIT_AT_45: &str = "45°:0°";
/// Name of a uniform sky, seen along the normal.
pub const NATURAL_LIGHT: &str = "natural light";

/// The program and its version.
pub fn program() -> String {
    format!("{} {}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"))
}

/// All numbers of a run.
pub fn summarise<'a>(study: &'a Study, collected: &Collected, seen: &Seen) -> Manifest<&'a Study> {
    let records = || collected.realisations.iter().flat_map(|r| r.points.iter().flatten());
    let (asked, finished) = (study.solves(), collected.finished());
    let uncertainty = Uncertainty { grid: collected.resolved.grid_error, certain: study.pigments.is_empty() };
    let (colours, no_colour) = match colours(study, seen, &uncertainty) {
        Ok(colours) => (colours, None),
        Err(reason) => (Vec::new(), Some(reason)),
    };
    Manifest {
        status: if finished == asked { Status::Complete } else { Status::Partial },
        title: study.title.clone(),
        study_hash: study.key().to_string(),
        program: program(),
        builds: records().map(|record| record.build.clone()).collect(),
        method_version: METHOD_VERSION,
        seed: study.packing.seed,
        realisations: Count { asked: study.realisations, finished: collected.complete().count() },
        solves: Count { asked, finished },
        failures: failures(study, collected),
        resolution: collected.resolved.resolution,
        certainty: certainty(collected, records().collect(), angle_error(seen)),
        packings: collected.realisations.iter().map(|r| r.packing.clone()).collect(),
        colours,
        no_colour,
        spectra: spectra(study, seen, &uncertainty),
        solve_seconds: records().map(|record| record.account.seconds).sum(),
        study,
    }
}

fn failures(study: &Study, collected: &Collected) -> Vec<FailureNote> {
    let note = |failure: &crate::run::runner::Failure| FailureNote {
        realisation: failure.point.realisation,
        wavelength_nm: study.wavelengths_nm[failure.point.wavelength],
        polar_deg: failure.point.incidence.polar_deg,
        reason: failure.reason.clone(),
    };
    collected.failures().map(note).collect()
}

fn angle_error(seen: &Seen) -> Option<f64> {
    seen.ink.as_ref().ok()?.angle_errors().into_iter().reduce(f64::max)
}

fn certainty(
    collected: &Collected,
    records: Vec<&PointRecord>,
    angle_error_estimate: Option<f64>,
) -> Certainty {
    let largest = |f: &dyn Fn(&PointRecord) -> f64| records.iter().map(|r| f(r)).fold(0.0, f64::max);
    let steps: usize = records.iter().map(|r| r.account.steps).sum();
    Certainty {
        amplitude_error_estimate: collected.resolved.error_estimate,
        reflectance_grid_error: collected.resolved.grid_error.reflectance,
        transmittance_grid_error: collected.resolved.grid_error.transmittance,
        angle_error_estimate,
        largest_energy_error: largest(&|r| r.energy_error().abs()),
        largest_residual: largest(&|r| r.account.residual),
        mean_steps: steps as f64 / records.len().max(1) as f64,
        operator_applications: records.iter().map(|r| r.account.operator_applications).sum(),
    }
}

/// Directions of the two standard conditions.
struct Conditions {
    normal: PolarAngle,
    print_light: Option<PolarAngle>,
}

impl Conditions {
    fn new(ink: &InkOnPaper) -> Result<Self, InkError> {
        let rule = ink.rule();
        Ok(Self { normal: rule.at(0.0)?, print_light: rule.at(PRINT_LIGHT_DEG).ok() })
    }

    fn natural_light<'a>(&'a self, study: &'a Study) -> impl Fn(&LayerOnPaper) -> f64 + 'a {
        |layer| layer.natural_light(&self.normal, study.output.mirrored_sky)
    }

    fn lit_at_45(&self) -> Option<impl Fn(&LayerOnPaper) -> f64 + '_> {
        let light = self.print_light.as_ref()?;
        Some(|layer: &LayerOnPaper| uncertainty::lit(layer, light, &self.normal))
    }
}

/// Colours under both conditions, or why there are none.
fn colours(study: &Study, seen: &Seen, uncertainty: &Uncertainty) -> Result<Vec<ColourNote>, String> {
    let ink = seen.ink.as_ref().map_err(NoInk::to_string)?;
    let of = || -> Result<Vec<ColourNote>, InkError> {
        let conditions = Conditions::new(ink)?;
        let Conditions { normal, print_light } = &conditions;
        let sky = |layer: &LayerOnPaper| uncertainty.natural_light(layer, normal);
        let seen = uncertainty.colour(ink, conditions.natural_light(study), sky)?;
        let mut notes = vec![note(NATURAL_LIGHT, seen)];
        if let Some((lit_at_45, light)) = conditions.lit_at_45().zip(print_light.as_ref()) {
            let lit = |layer: &LayerOnPaper| uncertainty.lit(layer, light, normal);
            notes.push(note(LIT_AT_45, uncertainty.colour(ink, lit_at_45, lit)?));
        }
        Ok(notes)
    };
    of().map_err(|error| error.to_string())
}

fn note(conditions: &str, colour: Colour) -> ColourNote {
    ColourNote {
        conditions: conditions.to_owned(),
        chroma: colour.chroma(),
        hue_deg: colour.hue_deg(),
        lab_standard_error: colour.lab_standard_error(),
        colour,
    }
}

fn spectra(study: &Study, seen: &Seen, uncertainty: &Uncertainty) -> Vec<SpectrumRow> {
    let mut rows: Vec<SpectrumRow> = seen.layer.iter().map(|layer| layer_row(layer, uncertainty)).collect();
    if let Ok((ink, Ok(conditions))) = seen.ink.as_ref().map(|ink| (ink, Conditions::new(ink))) {
        let natural = ink.spectrum(conditions.natural_light(study)).estimates();
        let lit = conditions.lit_at_45().map(|lit| ink.spectrum(lit).estimates());
        for (i, (row, layer)) in rows.iter_mut().zip(ink.layers()).enumerate() {
            let grid = uncertainty.natural_light(layer, &conditions.normal);
            row.natural_light = Some(uncertainty.widen(natural[i], grid));
            let light = lit.as_ref().zip(conditions.print_light.as_ref());
            row.lit_at_45 = light.map(|(lit, light)| {
                uncertainty.widen(lit[i], uncertainty.lit(layer, light, &conditions.normal))
            });
        }
    }
    rows
}

fn layer_row(layer: &LayerSeen, uncertainty: &Uncertainty) -> SpectrumRow {
    let [reflected, transmitted] = [Lobe::Reflected, Lobe::Transmitted].map(|lobe| layer.totals(lobe));
    let (r, t) = (uncertainty.grid.reflectance, uncertainty.grid.transmittance);
    SpectrumRow {
        wavelength_nm: layer.wavelength_nm,
        polar_deg: layer.bdfs[0].incidence().polar_deg,
        reflectance: uncertainty.widen(reflected.total, r),
        specular_reflectance: uncertainty.widen(reflected.specular, r),
        transmittance: uncertainty.widen(transmitted.total, t),
        specular_transmittance: uncertainty.widen(transmitted.specular, t),
        absorptance: uncertainty.widen(layer.absorptance, r + t),
        natural_light: None,
        lit_at_45: None,
    }
}
