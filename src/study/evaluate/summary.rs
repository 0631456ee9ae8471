//! The numbers of a run, for `results.json`, tables and the page.

mod left_out;

use super::gate;
use super::ink::{InkError, InkOnPaper};
use super::ink_maker::ink_maker;
use super::layer::{EnsembleMean, LayerEnsemble, SpectrumEstimate, Total};
use super::manifest::left_out::LeftOutNotes;
use super::manifest::{
    AbsorbedNote, Certainty, ColourNote, Count, EnsembleNotes, FailureNote, Manifest, Provenance,
    PublishedColours, PublishedSpectra, SpectrumReplicates, SpectrumRow,
};
pub use super::manifest::{LIT_AT_45, NATURAL_LIGHT, program};
use super::numbers::numbers;
use super::on_paper::LayerOnPaper;
use super::printed::{ink_optics, ink_prints};
use super::published::Withheld;
use super::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength, TOTALS};
use super::seen::{LayerSeen, MovedLayers, NoInk, Seen, see};
use super::survivors::Survivors;
use super::uncertainty::{ColourParts, Conditions, Shift, UNMOVED, Uncertainty};
use crate::appearance::paper::MirroredSky;
use crate::input::study::{Study, TargetColour};
use crate::numerics::estimate::largest;
use crate::numerics::estimate::{Estimate, coverage_factor_95, jackknife_deviations};
use crate::run::Collected;
use crate::solve::accuracy::grid_error::GridError;
use crate::store::PointRecord;

/// Minimum number of packings before an interval can end the run: the scatter of fewer is too
/// uncertain, and studies that happen to scatter least would end first.
const FEWEST: usize = 16;

/// All numbers of a layer that is solved as a whole.
pub fn summarise<'a>(study: &'a Study, collected: &Collected, seen: &Seen) -> Manifest<'a> {
    let own_records = collected.realisations.iter().flat_map(|r| r.points.iter().flatten());
    let records = collected.records();
    let solves = Count { asked: study.solves() - collected.spared(study), finished: collected.finished() };
    let grid = seen.grid.largest(&study.wavelengths_nm);
    let certainty = certainty(collected, &own_records.collect::<Vec<_>>(), seen, grid);
    let survivors = Survivors::new(study, collected);
    let uncertainty = Uncertainty {
        grid: seen.grid.clone(),
        residual: certainty.mean_energy_error,
        missing_cells: survivors.largest_shift(seen.cells.len()),
        certain: study.pigments.is_empty() && study.variation.thickness_std_um == 0.0,
    };
    let ensemble = EnsembleNotes {
        realisations: Count { asked: study.realisations, finished: collected.complete().count() },
        tried_packings: survivors,
        resolution: collected.resolved.resolution,
        resolution_longest: Some(collected.resolved.longest(study))
            .filter(|longest| *longest != collected.resolved.resolution),
        certainty,
        packings: collected.realisations.iter().map(|r| r.packing.clone()).collect(),
    };
    let mut manifest = Manifest {
        origin: Provenance::new(study, records.iter().copied(), solves),
        solves,
        failures: [failures(collected), left_out::failures(study, collected)].concat(),
        ensemble: Some(ensemble),
        colours: PublishedColours::Whole(Vec::new()),
        no_colour: None,
        ink_maker: None,
        no_ink_maker: None,
        numbers: Vec::new(),
        prints: None,
        optics: None,
        scalar_surface: study.scalar_surface(),
        withheld: Vec::new(),
        spectra: PublishedSpectra::Whole(Vec::new()),
        absorbed: absorbed(study, seen, &uncertainty),
        left_out: LeftOutNotes::default(),
        slabs: None,
        solve_seconds: records.iter().map(|record| record.account.seconds).sum(),
        process_seconds: None,
        study,
    };
    let mut rows = spectra(study, seen, &uncertainty);
    enter_looks(&mut manifest, seen, &uncertainty);
    let reasons = gate::spectra(&mut rows, &manifest.withheld);
    manifest.spectra = PublishedSpectra::Whole(rows);
    manifest.withheld.extend(reasons);
    let (weighted, reasons) = numbers(study, seen, &uncertainty);
    manifest.numbers = weighted;
    manifest.withheld.extend(reasons);
    let (left_out, reasons) = left_out::left_out(&manifest, collected);
    manifest.left_out = left_out;
    manifest.withheld.extend(reasons);
    manifest
}

/// Enters colours and the numbers for ink makers, as far as they are possible, and why some are
/// missing.
fn enter_looks(manifest: &mut Manifest, seen: &Seen, uncertainty: &Uncertainty) {
    let ink = seen.ink.as_ref().map_err(NoInk::to_string);
    let colours = ink
        .and_then(|ink| colours(manifest.study, seen, ink, uncertainty).map_err(|error| error.to_string()));
    let is_coloured = colours.is_ok();
    let fluoresces = manifest.study.paper.fluorescence.is_some();
    match colours.map(|notes| gate::colours(notes, fluoresces)) {
        Ok(judged) => {
            let (notes, withheld) = judged;
            let reasons = withheld.iter().map(Withheld::in_words).collect::<Vec<_>>().join("; ");
            manifest.no_colour = (notes.is_empty() && !reasons.is_empty()).then_some(reasons);
            manifest.colours = PublishedColours::Whole(notes);
            manifest.withheld = withheld;
        }
        Err(reason) => manifest.no_colour = Some(reason),
    }
    let Ok(ink) = &seen.ink else { return };
    manifest.prints = ink_prints(manifest.study, ink, uncertainty).ok().flatten();
    manifest.optics = ink_optics(manifest.study, ink, uncertainty).ok();
    match ink_maker(manifest.study, ink, uncertainty, &seen.cells) {
        Ok(mut numbers) => match gate::ink_maker(&numbers, fluoresces) {
            None => {
                gate::kubelka_munk(&mut numbers);
                manifest.ink_maker = Some(numbers);
            }
            Some(impossible) => {
                manifest.no_ink_maker = Some(impossible.in_words());
                manifest.withheld.push(impossible);
            }
        },
        Err(reason) => manifest.no_ink_maker = is_coloured.then(|| reason.to_string()),
    }
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
    !manifest.colours.whole().is_empty() && aimed_at(study, &manifest).all(narrow)
}

/// The colours to which `run.target_delta_e` applies.
pub fn aimed_at<'a>(study: &Study, manifest: &'a Manifest<'_>) -> impl Iterator<Item = &'a ColourNote> {
    let target = study.target_colour;
    manifest.colours.whole().iter().filter(move |note| match target {
        TargetColour::Every => true,
        TargetColour::NaturalLight => note.conditions == NATURAL_LIGHT,
        TargetColour::LitAt45 => note.conditions == LIT_AT_45,
    })
}

fn failures(collected: &Collected) -> Vec<FailureNote> {
    let packings = collected.refused.iter().map(|r| (r.realisation, None, &r.reason));
    let solves = collected.failures().map(|f| (f.point.realisation, Some(f.point.incidence), &f.reason));
    let notes = packings.chain(solves).map(|(realisation, light, reason)| FailureNote::Whole {
        realisation,
        wavelength_nm: light.map(|light| 1e3 * light.wavelength_um),
        polar_deg: light.map(|light| light.polar_deg),
        reason: reason.clone(),
    });
    notes.collect()
}

fn certainty(collected: &Collected, records: &[&PointRecord], seen: &Seen, grid: GridError) -> Certainty {
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
    let layer = seen.layer.as_ref().filter(|layer| layer.ensemble.strata > 1)?;
    let mean = |(r, realisation): (usize, &SolvedRealisation)| {
        let all: Vec<f64> = realisation.wavelengths.iter().map(|w| alternating_mean(layer, r, w)).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    };
    Some(Estimate::of_mean(&seen.solved.iter().enumerate().map(mean).collect::<Vec<_>>()))
}

/// Mean over the strata of the difference of T from the film, with alternating signs that start
/// according to realisation `r`.
fn alternating_mean(layer: &LayerSeen, r: usize, w: &SolvedWavelength) -> f64 {
    let sign = |k: usize| if (k + r).is_multiple_of(2) { 1.0 } else { -1.0 };
    let film = layer.film(w.wavelength_nm);
    let difference = |s: &SolvedDirection| s.transmittance - film.reflectance_transmittance(s.polar_deg)[1];
    w.strata.iter().enumerate().map(|(k, s)| sign(k) * difference(s)).sum::<f64>() / w.strata.len() as f64
}

/// Difference between the two estimates of R̄ from the exit side, realisation by realisation; for
/// the film both agree.
fn exit_reflectance_difference(layer: &LayerSeen) -> Option<Estimate> {
    let ensemble = &layer.ensemble;
    // these columns exist only if there are solves from the exit side
    if !ensemble.exit {
        return None;
    }
    let index = layer.film(0.0).index_out();
    let samples = (0..ensemble.realisations()).map(|r| exit_difference(ensemble, index, r));
    Some(Estimate::of_mean(&samples.collect::<Vec<_>>()))
}

/// Mean over the wavelengths of R̄ + T̄/n² + Ā of one realisation, all relative to the film.
fn exit_difference(ensemble: &LayerEnsemble, index: f64, realisation: usize) -> f64 {
    let t = ensemble.mean_column(EnsembleMean::Transmittance);
    let a = ensemble.mean_column(EnsembleMean::ExitAbsorptance);
    let r = ensemble.mean_column(EnsembleMean::ExitReflectance);
    let wavelengths = ensemble.wavelengths_nm(realisation).len();
    let value = |j: usize, column: usize| ensemble.measured(realisation, j, column);
    let apart = |j: usize| value(j, r) + value(j, t) / (index * index) + value(j, a);
    (0..wavelengths).map(apart).sum::<f64>() / wavelengths.max(1) as f64
}

/// Colours of an ink under natural light and at 45:0.
fn colours(
    study: &Study,
    seen: &Seen,
    ink: &InkOnPaper,
    uncertainty: &Uncertainty,
) -> Result<Vec<ColourNote>, InkError> {
    let conditions = Conditions::new(ink, study.output.mirrored_sky)?;
    let sky = uncertainty.colour(ink, &seen.solved, &|l, by| conditions.natural_light(l, by))?;
    let print = uncertainty.colour(ink, &seen.solved, &|l, by| conditions.lit_at_45(l, by))?;
    Ok(vec![note(NATURAL_LIGHT, sky, seen), note(LIT_AT_45, print, seen)])
}

fn note(conditions: &str, (colour, budget, deviations): ColourParts, seen: &Seen) -> ColourNote {
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

/// A factor of the print in diffuse light: its place in a row, and its value with a shift.
type InDiffuseLight =
    (fn(&mut SpectrumRow) -> &mut Option<Estimate>, fn(&Conditions, &LayerOnPaper, Shift) -> f64);

/// All wavelengths of each angle in turn; the ink on its paper is included at the normal.
fn spectra(study: &Study, seen: &Seen, uncertainty: &Uncertainty) -> Vec<SpectrumRow> {
    let Some(layer) = &seen.layer else { return Vec::new() };
    let angles = 0..layer.ensemble.exact_deg.len();
    let mut rows: Vec<_> = angles.flat_map(|angle| rows_of(layer, angle, seen, uncertainty)).collect();
    let Ok(ink) = &seen.ink else { return rows };
    let Ok(conditions) = Conditions::new(ink, study.output.mirrored_sky) else { return rows };
    let natural_light = ink.spectrum(|l| conditions.natural_light(l, UNMOVED));
    let lit_at_45 = ink.spectrum(|l| conditions.lit_at_45(l, UNMOVED));
    let natural = natural_light.estimates();
    let lit = lit_at_45.estimates();
    let in_spheres: [InDiffuseLight; 3] = [
        (|row| &mut row.sphere_at_8, |c, layer, by| c.in_sphere(MirroredSky::Included, layer, by)),
        (|row| &mut row.sphere_at_8_excluded, |c, layer, by| c.in_sphere(MirroredSky::Excluded, layer, by)),
        (|row| &mut row.diffuse_normal, |c, layer, by| c.diffuse_normal(layer, by)),
    ];
    for (place, factor) in in_spheres {
        let normal = rows.iter_mut().filter(|row| row.polar_deg == 0.0);
        let own = ink.spectrum(|layer| factor(&conditions, layer, UNMOVED)).estimates();
        for (i, (row, layer)) in normal.zip(ink.layers()).enumerate() {
            let moved = |by: Shift| factor(&conditions, layer, by) - own[i].value;
            let inputs = ink.input_error(i, |l| factor(&conditions, l, UNMOVED));
            *place(row) = Some(uncertainty.widen_by(own[i], row.wavelength_nm, inputs, moved));
        }
    }
    let through = ink.spectrum(LayerOnPaper::mean_transmittance).estimates();
    let behind = ink.spectrum(LayerOnPaper::mean_absorptance_exit).estimates();
    let normal = rows.iter_mut().filter(|row| row.polar_deg == 0.0);
    for (i, (row, layer)) in normal.zip(ink.layers()).enumerate() {
        let sky = |by: Shift| conditions.natural_light(layer, by) - natural[i].value;
        let print = |by: Shift| conditions.lit_at_45(layer, by) - lit[i].value;
        let inputs_sky = ink.input_error(i, |l| conditions.natural_light(l, UNMOVED));
        let inputs_print = ink.input_error(i, |l| conditions.lit_at_45(l, UNMOVED));
        row.natural_light = Some(uncertainty.widen_by(natural[i], row.wavelength_nm, inputs_sky, sky));
        row.lit_at_45 = Some(uncertainty.widen_by(lit[i], row.wavelength_nm, inputs_print, print));
        let nm = row.wavelength_nm;
        let inputs_through = ink.input_error(i, LayerOnPaper::mean_transmittance);
        let inputs_behind = ink.input_error(i, LayerOnPaper::mean_absorptance_exit);
        let through = uncertainty.widen_by(through[i], nm, inputs_through, |[_, t]| t);
        let behind = uncertainty.widen_by(behind[i], nm, inputs_behind, |[r, t]| r + t);
        row.transmittance_diffuse = Some(gate::bounded(through));
        row.absorptance_behind = Some(gate::bounded(behind));
        row.replicates.natural_light = natural_light.without_each(i);
        row.replicates.lit_at_45 = lit_at_45.without_each(i);
    }
    rows
}

/// What every layer of a stack absorbs, angle by angle, layer by layer.
fn absorbed(study: &Study, seen: &Seen, uncertainty: &Uncertainty) -> Vec<AbsorbedNote> {
    let Some(seen_layer) = seen.layer.as_ref().filter(|layer| layer.ensemble.layers > 0) else {
        return Vec::new();
    };
    let mut rows = Vec::new();
    for (angle, &polar_deg) in seen_layer.ensemble.exact_deg.iter().enumerate() {
        let all = seen_layer.spectrum(angle, Total::Absorptance).values;
        for (number, layer) in study.stack.iter().enumerate() {
            let estimates = seen_layer.absorbed(angle, number).estimates();
            let inputs = seen.inputs.as_ref().map(|moved| moved.absorbed_errors(angle, number));
            for (i, &wavelength_nm) in seen_layer.wavelengths_nm.iter().enumerate() {
                // errors of R and T are errors of what all layers absorb, in proportion
                let share = if all[i] > 0.0 { (estimates[i].value / all[i]).clamp(0.0, 1.0) } else { 0.0 };
                let moved = |[r, t]: Shift| share * (r + t);
                let inputs = inputs.as_ref().map_or(0.0, |errors| errors[i]);
                let widened = uncertainty.widen_by(estimates[i], wavelength_nm, inputs, moved);
                let absorptance = gate::bounded(widened);
                let layer = layer.name.clone();
                rows.push(AbsorbedNote { layer, wavelength_nm, polar_deg, absorptance });
            }
        }
    }
    rows
}

/// The layer's totals at one angle against wavelength, with all errors and the contributions of the
/// cells to R and T, without the ink on its paper.
fn rows_of(layer: &LayerSeen, angle: usize, seen: &Seen, uncertainty: &Uncertainty) -> Vec<SpectrumRow> {
    // what errors of R and T do to R, specular R, T, specular T and A
    let moved: [fn(Shift) -> f64; TOTALS] = [|[r, _]| r, |[r, _]| r, |[_, t]| t, |[_, t]| t, |[r, t]| r + t];
    let spectra = Total::ALL.map(|total| layer.spectrum(angle, total));
    let estimates = spectra.each_ref().map(SpectrumEstimate::estimates);
    let [r, specular_r, t, specular_t, a] = &spectra;
    let coherent = layer.coherent_transmittance(angle);
    let of_inputs = |moved: &MovedLayers| Total::ALL.map(|total| moved.errors(angle, total)).to_vec();
    let inputs: Vec<Vec<f64>> = seen.inputs.as_ref().map_or(Vec::new(), of_inputs);
    let cells = &seen.cells;
    let mut rows = Vec::new();
    for (i, &wavelength_nm) in layer.wavelengths_nm.iter().enumerate() {
        let widened = |k: usize| {
            let inputs = inputs.get(k).map_or(0.0, |errors| errors[i]);
            gate::bounded(uncertainty.widen_by(estimates[k][i], wavelength_nm, inputs, moved[k]))
        };
        let replicates: Vec<_> = r.replicates.iter().zip(&t.replicates).map(|(r, t)| [r[i], t[i]]).collect();
        rows.push(SpectrumRow {
            wavelength_nm,
            polar_deg: layer.ensemble.exact_deg[angle],
            reflectance: widened(0),
            specular_reflectance: widened(1),
            transmittance: widened(2),
            specular_transmittance: widened(3),
            // Tables of indices move the unscattered light as they move the specular order, to
            // first order.
            coherent_transmittance: coherent.as_ref().map(|coherent| {
                let inputs = inputs.get(3).map_or(0.0, |errors| errors[i]);
                gate::bounded(uncertainty.widen_by(coherent[i], wavelength_nm, inputs, moved[3]))
            }),
            absorptance: widened(4),
            natural_light: None,
            lit_at_45: None,
            sphere_at_8: None,
            sphere_at_8_excluded: None,
            diffuse_normal: None,
            transmittance_diffuse: None,
            absorptance_behind: None,
            deviations: cells.iter().copied().zip(jackknife_deviations(&replicates)).collect(),
            replicates: SpectrumReplicates {
                reflectance: r.without_each(i),
                specular_reflectance: specular_r.without_each(i),
                transmittance: t.without_each(i),
                specular_transmittance: specular_t.without_each(i),
                absorptance: a.without_each(i),
                ..SpectrumReplicates::default()
            },
        });
    }
    rows
}
