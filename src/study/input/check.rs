//! Checks a study file and turns it into a [`Study`]; reports all errors at once.

mod composed;
mod grains;
mod index;
mod judgement;
mod light;
mod microstructure;
mod paper;
mod pigments;

pub use grains::largest_extents_nm;

use super::fault::{Allowed, Fault, Faults, keys_in_words};
use super::file::{LayerTable, SolverTable, StudyFile};
use super::limits;
use super::study::{IndexSpectrum, Layer, Study, WantedResolution};
use super::variation::{CellRule, THICKNESS_CUT, Variation};
use crate::appearance::tristimulus::{Colorimeter, visible};
use crate::solve::Goal;
use index::Tabulation;
use paper::Directions;
use std::path::Path;

/// Default number of packings with varied cells.
const VARIED_CELLS: usize = 24;
/// Default maximum number of packings with `run.target_delta_e`.
const MOST_CELLS: usize = 400;
/// Default number of packings with fixed cells.
const FIXED_CELLS: usize = 4;

/// Checks every field of `file`. CSV paths are relative to `folder`; `name` is the default title.
///
/// # Errors
/// All errors of the file, each with the field, what was found, what is allowed and what to try.
pub fn check(file: &StudyFile, folder: &Path, name: &str) -> Result<Study, Vec<Fault>> {
    let (study, mut faults, mut optics) = examine(file, folder, name);
    faults.0.append(&mut optics.0);
    if !file.layer.walls {
        let remedy = "leave it out; `inkwave pack` packs layers without walls";
        faults.add("layer.walls", "false", "true: waves need a layer between two faces", remedy);
    }
    if faults.0.is_empty() { Ok(study) } else { Err(faults.0) }
}

/// Like [`check`], for packings only: errors in what only the wave needs are ignored.
///
/// # Errors
/// All errors in the layer, the pigments and the packing.
pub fn check_packing(file: &StudyFile, folder: &Path, name: &str) -> Result<Study, Vec<Fault>> {
    let (study, mut faults, _) = examine(file, folder, name);
    if grains::packed(file).next().is_none() {
        faults.add("pigment", "none", "at least one [[pigment]] with grains", "add one");
    }
    if faults.0.is_empty() { Ok(study) } else { Err(faults.0) }
}

/// The study as far as it is valid; the errors in the layer, the grains and the run; and those in
/// what only the wave and its results need.
fn examine(file: &StudyFile, folder: &Path, name: &str) -> (Study, Faults, Faults) {
    let (mut faults, mut optics) = (Faults::default(), Faults::default());
    let composed = composed::composed(file, &mut faults);
    let slab = composed.as_ref().map(|composed| composed::slab_file(file, composed));
    let file = slab.as_ref().unwrap_or(file);
    let (filled, given) = microstructure::given(file, folder, &mut faults).unzip();
    let file = filled.as_ref().unwrap_or(file);
    let wavelengths_nm = light::wavelengths(&file.light, &mut optics);
    let period_um = period(file, &mut faults);
    let indices = Tabulation { wavelengths_nm: &wavelengths_nm, folder };
    let binder = indices.tabulate("layer.binder.index", &file.layer.binder.index, &mut optics);
    let mut layer = layer(&file.layer, period_um, binder, &mut faults);
    let grains = pigments::grains(file, period_um, &mut faults);
    let pigments = pigments::pigments(file, grains, &indices, &mut optics);
    let dissolved = pigments::dissolved(file, &indices, &mut optics);
    pigments::dissolve(&mut layer, &dissolved, &pigments, light::mixing(file));
    let of_files = given.as_ref().map(|given| given.remarks.clone()).unwrap_or_default();
    let placed = given.map(|given| (given.grains, given.voxels)).unwrap_or_default();
    let packing = pigments::packing(file, &layer, &pigments, placed, &mut faults);
    let mut remarks: Vec<String> = light::short_of_end(&file.light, &wavelengths_nm).into_iter().collect();
    let paper = paper::paper(file, &wavelengths_nm, folder, &mut optics, &mut remarks);
    let Directions { angles, kind } = paper::directions(file, paper.coupling, &mut optics);
    let resolution = resolution(file, &mut optics);
    let goal = goal(&file.solver, &resolution, &mut optics);
    counts(file, &mut faults);
    let variation = Variation {
        cell: file.layer.cell,
        thickness_std_um: file.layer.thickness_um.std(),
        light: light::light_rule(&file.light, &wavelengths_nm, &mut optics),
    };
    // without grains and with a uniform thickness all realisations are equal
    let alike = pigments.is_empty() && variation.thickness_std_um == 0.0;
    let realisations = if alike { 1 } else { realisations(file) };
    let judgement = judgement::judgement(file, &wavelengths_nm, folder, &mut optics, &mut remarks);
    let mut study = Study {
        title: file.title.clone().unwrap_or_else(|| name.to_owned()),
        layer,
        pigments,
        dissolved,
        packing,
        paper,
        wavelengths_nm,
        wave: file.light.wave,
        angles,
        realisations,
        target_delta_e: file.run.target_delta_e,
        target_colour: file.run.target_colour,
        failed_packings: file.run.failed_packings,
        variation,
        resolution,
        solver: file.solver.strategy,
        goal,
        output: file.output.clone(),
        judgement,
        kind,
        remarks,
    };
    study.remarks.extend(of_files);
    study.remarks.extend(index::bridged(&study));
    study.remarks.extend(study.undetermined_inputs());
    if study.no_paper().is_none() {
        study.remarks.extend(light::colour_takes_a_part(&study.wavelengths_nm));
        study.remarks.extend(light::colour_is_extrapolated(&study.wavelengths_nm));
    }
    light::refusals(file, &study, &mut optics);
    if let Some(composed) = composed {
        composed::refusals(file, &study, &mut optics);
        composed::complete(&mut study, composed);
        study.remarks.extend(study.errors_left_out());
    }
    if faults.0.is_empty() && optics.0.is_empty() {
        optics.0.extend(aim(&study));
    }
    (study, faults, optics)
}

/// `target_delta_e` needs a colour; without paper it can never be met.
fn aim(study: &Study) -> Option<Fault> {
    let target = study.target_delta_e?;
    let seen = &study.wavelengths_nm[visible(&study.wavelengths_nm)];
    let grid = Colorimeter::new(seen).err().map(|error| error.to_string());
    let reason = study.no_ink().or(grid)?;
    let remedy = "leave it out, or take angles.count and wavelengths from 400 to 700 nm";
    let allowed = format!("nothing where there is no colour: {reason}");
    Some(Fault::new("run.target_delta_e", target, allowed, remedy))
}

fn layer(table: &LayerTable, period_um: [f64; 2], binder: IndexSpectrum, faults: &mut Faults) -> Layer {
    let (mean, std) = (table.thickness_um.mean(), table.thickness_um.std());
    faults.number("layer.thickness_um", mean, limits::THICKNESS_UM, "a printed layer is about 1 µm thick");
    if mean > 0.0 {
        let allowed = Allowed::between(0.0, mean / (THICKNESS_CUT + 1.0), "µm");
        let remedy =
            "a tenth of the mean is usual; at most a quarter of it keeps every layer thicker than nothing";
        faults.number("layer.thickness_um.std", std, allowed, remedy);
    }
    let remedy = "give the real refractive index, 1 for air";
    faults.number("layer.index_in", table.index_in, limits::INDEX, remedy);
    faults.number("layer.index_out", table.index_out, limits::INDEX, remedy);
    Layer {
        period_um,
        thickness_um: mean,
        index_in: table.index_in,
        index_out: table.index_out,
        contrast: table.contrast,
        binder,
    }
}

/// Nominal period of the cells: as given, or as the grains require.
fn period(file: &StudyFile, faults: &mut Faults) -> [f64; 2] {
    let Some(written) = file.layer.period_um else {
        // files of grains give it, unless they cannot be read
        if file.layer.cell == CellRule::Fixed && file.layer.microstructure.is_none() {
            let allowed = "one number or [x, y], µm, for cell = \"fixed\"";
            faults.add("layer.period_um", "nothing", allowed, "write period_um = 2.4, or let cells vary");
        }
        return [grains::nominal_period_um(file); 2];
    };
    let remedy = "1.6 µm is usual, larger cells cost more; leave it out, and it follows from the grains";
    for period in written.xy() {
        faults.number("layer.period_um", period, limits::PERIOD_UM, remedy);
    }
    written.xy()
}

/// Default number of packings.
fn realisations(file: &StudyFile) -> usize {
    file.run.realisations.unwrap_or(match file.layer.cell {
        _ if file.run.target_delta_e.is_some() => MOST_CELLS,
        CellRule::Varied => VARIED_CELLS,
        CellRule::Fixed => FIXED_CELLS,
    })
}

/// Accuracy at which a grid per wavelength pays: 1.2 to 1.5 times faster at 1e-3 to 3e-4 (inks of
/// 15–30 %, 200–300 nm).
const PER_WAVELENGTH: f64 = 1e-3;

fn resolution(file: &StudyFile, faults: &mut Faults) -> WantedResolution {
    let table = &file.resolution;
    let scheme = file.light.wave.scheme(table.scheme);
    match (table.accuracy, table.points_per_um, table.planes_per_um) {
        (accuracy, None, None) => {
            // with `run.target_delta_e` the grid's error is corrected by solves on a finer one, so
            // that it only has to be regular
            let usual = if file.run.target_delta_e.is_some() { 3e-2 } else { 1e-2 };
            let accuracy = accuracy.unwrap_or(usual);
            let remedy = "1e-2 for pictures, 1e-3 for numbers to publish";
            faults.number("resolution.accuracy", accuracy, limits::ACCURACY, remedy);
            let per_wavelength = table.per_wavelength.unwrap_or(accuracy <= PER_WAVELENGTH);
            WantedResolution::Accuracy { amplitude: accuracy, scheme, per_wavelength }
        }
        (None, Some(points_per_um), Some(planes_per_um)) => {
            let allowed = limits::PER_UM;
            faults.number("resolution.points_per_um", points_per_um, allowed, "12 to 16 is usual");
            faults.number("resolution.planes_per_um", planes_per_um, allowed, "20 to 40 is usual");
            if table.per_wavelength == Some(true) {
                let remedy = "leave it out, or write accuracy instead of points and planes";
                let found = "true beside points_per_um and planes_per_um, which are one grid";
                faults.add("resolution.per_wavelength", found, "with accuracy", remedy);
            }
            WantedResolution::Grid { points_per_um, planes_per_um, scheme }
        }
        _ => {
            let allowed = "either accuracy alone, or both points_per_um and planes_per_um";
            let found = keys_in_words(table, &["accuracy", "points_per_um", "planes_per_um"]);
            faults.add("resolution", found, allowed, "write accuracy = 1e-2");
            WantedResolution::Accuracy { amplitude: 1e-2, scheme, per_wavelength: false }
        }
    }
}

fn goal(table: &SolverTable, resolution: &WantedResolution, faults: &mut Faults) -> Goal {
    let tolerance = table.tolerance.unwrap_or(match resolution {
        // an amplitude's error is up to three times the residual: a third of the accuracy, and
        // random from solve to solve
        WantedResolution::Accuracy { amplitude, .. } => (0.1 * amplitude).clamp(1e-13, 1e-3),
        WantedResolution::Grid { .. } => Goal::default().tolerance,
    });
    let remedy = "leave it out: a tenth of resolution.accuracy is ample";
    faults.number("solver.tolerance", tolerance, limits::TOLERANCE, remedy);
    faults.whole("solver.max_applications", table.max_applications, limits::APPLICATIONS, "2000 is usual");
    Goal { tolerance, max_applications: table.max_applications }
}

fn counts(file: &StudyFile, faults: &mut Faults) {
    let remedy = "0.1 leaves out every tenth; with more of them the means are those of different cells";
    faults.number("run.failed_packings", file.run.failed_packings, limits::FAILED_PACKINGS, remedy);
    if let Some(target) = file.run.target_delta_e {
        let remedy = "0.3 is hard to see; a hundredth of that needs 10 000 times the cells";
        faults.number("run.target_delta_e", target, limits::TARGET_DELTA_E, remedy);
        if file.run.realisations == Some(1) {
            let allowed = "2 or more with run.target_delta_e: one packing has no interval";
            let remedy = "leave it out: the run ends when the target is reached";
            faults.add("run.realisations", 1, allowed, remedy);
        }
    }
    let remedy = "24 small cells are a fair start";
    faults.whole("run.realisations", realisations(file), limits::REALISATIONS, remedy);
    faults.whole("output.picture_pixels", file.output.picture_pixels, limits::PICTURE_PIXELS, "360 is usual");
}
