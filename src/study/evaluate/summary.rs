//! The numbers of a run, for `results.json`, tables and the page.

use super::gate;
use super::ink::{InkError, InkOnPaper};
use super::ink_maker::{InkMaker, ink_maker};
use super::layer::{EnsembleMean, LayerEnsemble, Total};
use super::manifest::{Certainty, ColourNote, Count, FailureNote, Manifest, SpectrumRow, Status, Withheld};
use super::on_paper::{LayerOnPaper, PolarAngle};
use super::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength};
use super::seen::{LayerSeen, NoInk, Seen, see};
use super::survivors::Survivors;
use super::uncertainty::{Shift, Sure, UNMOVED, Uncertainty, lit, natural_light};
use crate::appearance::paper::{MirroredSky, PRINT_DEG};
use crate::input::study::{Study, TargetColour};
use crate::numerics::estimate::{Estimate, coverage_factor_95, jackknife_deviations};
use crate::run::{Collected, Failure, Refused};
use crate::solve::accuracy::grid_error::GridError;
use crate::store::identity::METHOD_VERSION;
use crate::store::record::PointRecord;
use crate::wave::physical::largest;

/// Name of the standard geometry of print measurement, lit at 45° and viewed along the normal.
pub const LIT_AT_45: &str = "45°:0°";
/// Name of illumination by a uniform sky, viewed along the normal.
pub const NATURAL_LIGHT: &str = "natural light";

/// Minimum number of packings before an interval can end the run: the scatter of fewer is too
/// uncertain, and studies that happen to scatter least would end first.
const FEWEST: usize = 16;

/// The program and its version.
pub fn program() -> String {
    concat!("inkwave ", env!("CARGO_PKG_VERSION")).to_owned()
}

/// All numbers of a run.
pub fn summarise<'a>(study: &'a Study, collected: &Collected, seen: &Seen) -> Manifest<&'a Study> {
    let records = || collected.realisations.iter().flat_map(|r| r.points.iter().flatten());
    let finished = collected.finished();
    let asked = if collected.enough { finished } else { study.solves() };
    let grid = seen.grid.largest(&study.wavelengths_nm);
    let certainty = certainty(collected, records().collect(), (seen, grid));
    let survivors = Survivors { packed: collected.realisations.len(), refused: collected.refused.len() };
    let uncertainty = Uncertainty {
        grid: seen.grid.clone(),
        residual: certainty.mean_energy_error,
        missing_cells: survivors.largest_shift(seen.realisations.len()),
        certain: study.pigments.is_empty() && study.variation.thickness_std_um == 0.0,
    };
    let mut spectra = spectra(study, seen, &uncertainty);
    let Looks { colours, no_colour, ink_maker, no_ink_maker, mut withheld } =
        looks(study, seen, &uncertainty);
    withheld.extend(gate::spectra(&mut spectra));
    Manifest {
        status: if finished == asked || collected.enough { Status::Complete } else { Status::Partial },
        title: study.title.clone(),
        study_hash: study.key().to_string(),
        program: program(),
        builds: records().map(|record| record.build.clone()).collect(),
        method_version: METHOD_VERSION,
        seed: study.packing.seed,
        realisations: Count { asked: study.realisations, finished: collected.complete().count() },
        solves: Count { asked, finished },
        failures: failures(collected),
        tried_packings: survivors,
        resolution: collected.resolved.resolution,
        resolution_longest: Some(collected.resolved.longest(study))
            .filter(|longest| *longest != collected.resolved.resolution),
        certainty,
        packings: collected.realisations.iter().map(|r| r.packing.clone()).collect(),
        colours,
        no_colour,
        ink_maker,
        no_ink_maker,
        withheld,
        spectra,
        solve_seconds: records().map(|record| record.account.seconds).sum(),
        process_seconds: None,
        study,
    }
}

/// Colours of the ink on its paper, and why some are missing.
struct Looks {
    colours: Vec<ColourNote>,
    no_colour: Option<String>,
    ink_maker: Option<InkMaker>,
    no_ink_maker: Option<String>,
    withheld: Vec<Withheld>,
}

/// Colours and the numbers for ink makers, as far as they are possible.
fn looks(study: &Study, seen: &Seen, uncertainty: &Uncertainty) -> Looks {
    let (colours, mut no_colour, mut withheld) = match colours(study, seen, uncertainty) {
        Ok(all) => {
            let (kept, withheld) = gate::colours(all);
            (kept, None, withheld)
        }
        Err(reason) => (Vec::new(), Some(reason), Vec::new()),
    };
    let maker = |ink| ink_maker(study, ink, uncertainty, &seen.cells);
    let (mut ink_maker, mut no_ink_maker) = match seen.ink.as_ref().map(maker) {
        Ok(Ok(numbers)) => (Some(numbers), None),
        Ok(Err(reason)) => (None, no_colour.is_none().then(|| reason.to_string())),
        Err(_) => (None, None),
    };
    if colours.is_empty() && !withheld.is_empty() {
        no_colour = Some(withheld.iter().map(Withheld::in_words).collect::<Vec<_>>().join("; "));
    }
    if let Some(impossible) = ink_maker.as_ref().and_then(gate::ink_maker) {
        (ink_maker, no_ink_maker) = (None, Some(impossible.in_words()));
        withheld.push(impossible);
    }
    Looks { colours, no_colour, ink_maker, no_ink_maker, withheld }
}

/// Whether the 95 % intervals of all selected colours are below `run.target_delta_e`; false without
/// a target.
pub fn enough(study: &Study, collected: &Collected) -> bool {
    let Some(target) = study.target_delta_e else { return false };
    if collected.realisations.len() < FEWEST {
        return false;
    }
    let Ok(seen) = see(study, collected) else { return false };
    let manifest = summarise(study, collected, &seen);
    let narrow = |note: &ColourNote| note.delta_e_2000_95.is_some_and(|bar| bar <= target);
    !manifest.colours.is_empty() && aimed_at(study, &manifest).all(narrow)
}

/// The colours to which `run.target_delta_e` applies.
pub fn aimed_at<'a>(study: &Study, manifest: &'a Manifest<&Study>) -> impl Iterator<Item = &'a ColourNote> {
    let wanted = study.target_colour;
    manifest.colours.iter().filter(move |note| match wanted {
        TargetColour::Every => true,
        TargetColour::NaturalLight => note.conditions == NATURAL_LIGHT,
        TargetColour::LitAt45 => note.conditions == LIT_AT_45,
    })
}

fn failures(collected: &Collected) -> Vec<FailureNote> {
    let packings = collected.refused.iter().map(packing_failure);
    packings.chain(collected.failures().map(solve_failure)).collect()
}

/// Note on a realisation without a packing.
fn packing_failure(refused: &Refused) -> FailureNote {
    let (realisation, reason) = (refused.realisation, refused.reason.clone());
    FailureNote { realisation, wavelength_nm: None, polar_deg: None, reason }
}

/// Note on a solve without a result.
fn solve_failure(failure: &Failure) -> FailureNote {
    FailureNote {
        realisation: failure.point.realisation,
        wavelength_nm: Some(1e3 * failure.point.incidence.wavelength_um),
        polar_deg: Some(failure.point.incidence.polar_deg),
        reason: failure.reason.clone(),
    }
}

fn certainty(
    collected: &Collected,
    records: Vec<&PointRecord>,
    (seen, grid): (&Seen, GridError),
) -> Certainty {
    let count = records.len().max(1) as f64;
    let most = |f: &dyn Fn(&PointRecord) -> f64| largest(records.iter().map(|r| f(r)));
    let steps: usize = records.iter().map(|r| r.account.steps).sum();
    let degrees_of_freedom = seen.cells.len().saturating_sub(1);
    let ink = seen.ink.as_ref().ok();
    Certainty {
        amplitude_error_estimate: collected.resolved.error_estimate,
        reflectance_grid_error: grid.reflectance,
        transmittance_grid_error: grid.transmittance,
        packings_on_finer_grid: seen.grid.checked(),
        degrees_of_freedom,
        coverage_factor_95: coverage_factor_95(degrees_of_freedom),
        angle_error_estimate: ink.and_then(|ink| ink.angle_errors(&seen.solved).into_iter().reduce(f64::max)),
        half_strata_difference: half_strata_difference(seen),
        exit_reflectance_difference: seen.layer.as_ref().and_then(exit_reflectance_difference),
        mean_energy_error: records.iter().map(|r| r.energy_error().abs()).sum::<f64>() / count,
        largest_energy_error: most(&|r| r.energy_error().abs()),
        largest_residual: most(&|r| r.account.residual),
        mean_steps: steps as f64 / count,
        operator_applications: records.iter().map(|r| r.account.operator_applications).sum(),
    }
}

/// Even and odd strata alternate between realisations, each with double weight: (1/n) Σ ± T_k
/// relative to the film.
fn half_strata_difference(seen: &Seen) -> Option<Estimate> {
    let layer = seen.layer.as_ref().filter(|layer| layer.ensemble().strata > 1)?;
    let of = |(r, realisation): (usize, &SolvedRealisation)| {
        let all: Vec<f64> = realisation.wavelengths.iter().map(|w| alternating_mean(layer, r, w)).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    };
    Some(Estimate::of_mean(&seen.solved.iter().enumerate().map(of).collect::<Vec<_>>()))
}

/// Mean over the strata of the difference of T from the film, with alternating signs that start
/// according to realisation `r`.
fn alternating_mean(layer: &LayerSeen, r: usize, w: &SolvedWavelength) -> f64 {
    let sign = |k: usize| if (k + r).is_multiple_of(2) { 1.0 } else { -1.0 };
    let film = layer.film(w.wavelength_nm);
    let difference = |s: &SolvedDirection| s.transmittance - film.reflectance_transmittance(s.polar_deg)[1];
    let sum: f64 = w.strata.iter().enumerate().map(|(k, s)| sign(k) * difference(s)).sum();
    sum / w.strata.len() as f64
}

/// Difference between the two estimates of R̄ from the exit side, realisation by realisation; for
/// the film both agree.
fn exit_reflectance_difference(layer: &LayerSeen) -> Option<Estimate> {
    let ensemble = layer.ensemble();
    // these columns exist only if there are solves from the exit side
    if !ensemble.exit {
        return None;
    }
    let index = layer.index_out()?;
    let realisations = 0..ensemble.realisations();
    let samples: Vec<f64> = realisations.map(|r| exit_difference(ensemble, index, r)).collect();
    Some(Estimate::of_mean(&samples))
}

/// Mean over the wavelengths of R̄ + T̄/n² + Ā of one realisation, all relative to the film.
fn exit_difference(ensemble: &LayerEnsemble, index: f64, realisation: usize) -> f64 {
    let [t, a, r] =
        [EnsembleMean::Transmittance, EnsembleMean::ExitAbsorptance, EnsembleMean::ExitReflectance]
            .map(|m| ensemble.mean_column(m));
    let wavelengths = ensemble.wavelengths_nm(realisation).len();
    let value = |j: usize, column: usize| ensemble.measured(realisation, j, column);
    let apart = |j: usize| value(j, r) + value(j, t) / (index * index) + value(j, a);
    (0..wavelengths).map(apart).sum::<f64>() / wavelengths.max(1) as f64
}

/// Directions of the two standard conditions.
struct Conditions {
    normal: PolarAngle,
    print_light: PolarAngle,
    sky: MirroredSky,
}

impl Conditions {
    fn new(study: &Study, ink: &InkOnPaper) -> Result<Self, InkError> {
        let sky = study.output.mirrored_sky;
        Ok(Self { normal: ink.at(0.0)?, print_light: ink.at(PRINT_DEG)?, sky })
    }

    fn natural_light(&self, layer: &LayerOnPaper, by: Shift) -> f64 {
        natural_light(layer, &self.normal, self.sky, by)
    }

    fn lit_at_45(&self, layer: &LayerOnPaper, by: Shift) -> f64 {
        lit(layer, &self.print_light, &self.normal, by)
    }
}

/// Colours under both conditions, or why there are none.
fn colours(study: &Study, seen: &Seen, uncertainty: &Uncertainty) -> Result<Vec<ColourNote>, String> {
    let ink = seen.ink.as_ref().map_err(NoInk::to_string)?;
    colours_of(study, seen, ink, uncertainty).map_err(|error| error.to_string())
}

/// Colours of an ink under natural light and at 45:0.
fn colours_of(
    study: &Study,
    seen: &Seen,
    ink: &InkOnPaper,
    uncertainty: &Uncertainty,
) -> Result<Vec<ColourNote>, InkError> {
    let conditions = Conditions::new(study, ink)?;
    let sky = uncertainty.colour(ink, &seen.solved, &|l, by| conditions.natural_light(l, by))?;
    let print = uncertainty.colour(ink, &seen.solved, &|l, by| conditions.lit_at_45(l, by))?;
    Ok(vec![note(NATURAL_LIGHT, sky, seen), note(LIT_AT_45, print, seen)])
}

fn note(conditions: &str, Sure { colour, budget, deviations }: Sure, seen: &Seen) -> ColourNote {
    let factor = coverage_factor_95(seen.cells.len().saturating_sub(1));
    ColourNote {
        conditions: conditions.to_owned(),
        chroma: colour.chroma(),
        hue_deg: colour.hue_deg(),
        lab_standard_error: colour.lab_standard_error(),
        delta_e_2000_95: colour.delta_e_2000_noise().zip(factor).map(|(noise, factor)| factor * noise),
        budget,
        deviations: seen.cells.iter().copied().zip(deviations).collect(),
        colour,
    }
}

/// All wavelengths of each angle in turn; the ink on its paper is included at the normal.
fn spectra(study: &Study, seen: &Seen, uncertainty: &Uncertainty) -> Vec<SpectrumRow> {
    let Some(layer) = &seen.layer else { return Vec::new() };
    let angles = 0..layer.angles_deg().len();
    let mut rows: Vec<SpectrumRow> =
        angles.flat_map(|angle| rows_of(study, seen, (layer, angle), uncertainty)).collect();
    if let Ok((ink, Ok(conditions))) = seen.ink.as_ref().map(|ink| (ink, Conditions::new(study, ink))) {
        let natural = ink.spectrum(|l| conditions.natural_light(l, UNMOVED)).estimates();
        let lit = ink.spectrum(|l| conditions.lit_at_45(l, UNMOVED)).estimates();
        let normal = rows.iter_mut().filter(|row| row.polar_deg == 0.0);
        for (i, (row, layer)) in normal.zip(ink.layers()).enumerate() {
            let sky = |by: Shift| conditions.natural_light(layer, by) - natural[i].value;
            let print = |by: Shift| conditions.lit_at_45(layer, by) - lit[i].value;
            row.natural_light = Some(uncertainty.widen_by(natural[i], row.wavelength_nm, sky));
            row.lit_at_45 = Some(uncertainty.widen_by(lit[i], row.wavelength_nm, print));
        }
    }
    rows
}

fn rows_of(
    study: &Study,
    seen: &Seen,
    (layer, angle): (&LayerSeen, usize),
    uncertainty: &Uncertainty,
) -> Vec<SpectrumRow> {
    let totals = AngleTotals::new(layer, angle, uncertainty);
    let wavelengths = study.wavelengths_nm.iter().enumerate();
    wavelengths.map(|(i, &nm)| totals.row(i, nm, &seen.cells)).collect()
}

/// The layer's totals at one angle against wavelength, with all errors.
struct AngleTotals {
    polar_deg: f64,
    reflectance: Vec<Estimate>,
    specular_reflectance: Vec<Estimate>,
    transmittance: Vec<Estimate>,
    specular_transmittance: Vec<Estimate>,
    absorptance: Vec<Estimate>,
    /// R and T as \[realisation left out\]\[wavelength\].
    replicates: [Vec<Vec<f64>>; 2],
}

impl AngleTotals {
    fn new(layer: &LayerSeen, angle: usize, uncertainty: &Uncertainty) -> Self {
        let of = |total: Total, moved: fn(Shift) -> f64| -> Vec<Estimate> {
            let estimates = layer.spectrum(angle, total).estimates();
            let places = estimates.into_iter().zip(&layer.wavelengths_nm);
            let widened = places.map(|(estimate, &nm)| uncertainty.widen_by(estimate, nm, moved));
            widened.map(gate::bounded).collect()
        };
        let (reflected, transmitted): (fn(Shift) -> f64, fn(Shift) -> f64) = (|[r, _]| r, |[_, t]| t);
        let varied = [Total::Reflectance, Total::Transmittance];
        Self {
            polar_deg: layer.angles_deg()[angle],
            reflectance: of(Total::Reflectance, reflected),
            specular_reflectance: of(Total::SpecularReflectance, reflected),
            transmittance: of(Total::Transmittance, transmitted),
            specular_transmittance: of(Total::SpecularTransmittance, transmitted),
            // A's error: the sum of both
            absorptance: of(Total::Absorptance, |[r, t]| r + t),
            replicates: varied.map(|total| layer.spectrum(angle, total).replicates),
        }
    }

    /// The totals at the `i`-th wavelength, without the ink on its paper.
    fn row(&self, i: usize, wavelength_nm: f64, realisations: &[usize]) -> SpectrumRow {
        SpectrumRow {
            wavelength_nm,
            polar_deg: self.polar_deg,
            reflectance: self.reflectance[i],
            specular_reflectance: self.specular_reflectance[i],
            transmittance: self.transmittance[i],
            specular_transmittance: self.specular_transmittance[i],
            absorptance: self.absorptance[i],
            natural_light: None,
            lit_at_45: None,
            deviations: self.deviations(i, realisations),
        }
    }

    /// Contributions of the realisations to R and T at the `i`-th wavelength.
    fn deviations(&self, i: usize, realisations: &[usize]) -> Vec<(usize, [f64; 2])> {
        let [r, t] = &self.replicates;
        let replicates: Vec<[f64; 2]> = r.iter().zip(t).map(|(r, t)| [r[i], t[i]]).collect();
        realisations.iter().copied().zip(jackknife_deviations(&replicates)).collect()
    }
}
