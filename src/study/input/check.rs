//! Checks a study file and turns it into a [`Study`]; reports all errors at once.
//!
//! Every table checks itself and hands on what it says, as far as it is valid: the checks of other
//! tables go on with that, so that one reading of a file tells all of its errors. What several
//! tables must agree on is checked at the end, on the study.

mod backing;
mod cell;
mod composed;
mod dots;
mod grains;
mod index;
mod judgement;
mod light;
mod microstructure;
mod number;
mod paper;
mod pigments;
mod run;
mod stack;
mod stack_plates;

pub use grains::largest_extents_nm;

use super::fault::{Fault, Faults};
use super::file::StudyFile;
use super::forms::ThicknessWritten;
use super::limits;
use super::study::{Layer, Paper, Pigment, Study};
use super::variation::Variation;
use crate::appearance::fluorescence::{Fluorescence, SHORTEST_NM};
use crate::appearance::tristimulus::{Colorimeter, visible};
use crate::ink::PackingRequest;
use cell::NominalCell;
use light::Light;
use paper::{Directions, Surroundings};
use std::path::Path;

/// Checks every field of `file`. CSV paths are relative to `folder`; `name` is the default title.
///
/// # Errors
/// All errors of the file, each with the field, what was found, what is allowed and what to try.
pub fn check(file: &StudyFile, folder: &Path, name: &str) -> Result<Study, Vec<Fault>> {
    let Examined { mut study, packing_faults: mut faults, mut wave_faults } = examine(file, folder, name);
    faults.0.append(&mut wave_faults.0);
    if !file.layer.walls {
        let remedy = "leave it out; `inkwave pack` packs layers without walls";
        faults.add("layer.walls", "false", "true: waves need a layer between two faces", remedy);
    }
    check_relief(file, &study, &mut faults);
    if faults.0.is_empty() {
        faults.0.extend(study.grid_faults());
    }
    if let Some(surface) = study.scalar_surface().filter(|_| study.paper.measured.is_some()) {
        study.remarks.push(format!("paper.measured: {}", surface.in_words()));
    }
    if faults.0.is_empty() { Ok(study) } else { Err(faults.0) }
}

/// A rough face is the level to which the binder of its layer sinks between grains: without any it
/// is plane.
fn check_relief(file: &StudyFile, study: &Study, faults: &mut Faults) {
    if study.packing.relief.is_none() || !faults.0.is_empty() {
        return;
    }
    let rough = file.layer.stacked.iter().flatten().position(|layer| layer.relief.is_some());
    let own = rough.and_then(|i| study.stack.get(i));
    let has_grains = own.map_or(!study.pigments.is_empty(), |layer| layer.pigments > 0);
    let field = rough.map_or("layer.relief".to_owned(), |i| format!("layer[{i}].relief"));
    let allowed = "a relief over grains, between which the binder of the layer sinks";
    let remedy = "remove it, or add a pigment with grains to the layer";
    if !has_grains {
        faults.add(field, "a rough face of a layer without grains", allowed, remedy);
    }
}

/// Like [`check`], for packings only: errors in what only the wave needs are ignored.
///
/// # Errors
/// All errors in the layer, the pigments and the packing.
pub fn check_packing(file: &StudyFile, folder: &Path, name: &str) -> Result<Study, Vec<Fault>> {
    let Examined { study, packing_faults: mut faults, .. } = examine(file, folder, name);
    if study.pigments.is_empty() && pigments::packed(&file.pigments).next().is_none() {
        faults.add("pigment", "none", "at least one [[pigment]] with grains", "add one");
    }
    if faults.0.is_empty() { Ok(study) } else { Err(faults.0) }
}

/// Wavelengths at which tables of indices and albedos are needed, and the folder of their files.
#[derive(Clone, Copy)]
struct Tabulation<'a> {
    wavelengths_nm: &'a [f64],
    folder: &'a Path,
}

/// A study with all errors of its file.
struct Examined {
    /// The study as far as it is valid.
    study: Study,
    /// Errors in the layer, the grains and the run.
    packing_faults: Faults,
    /// Errors in what only the wave and its results need.
    wave_faults: Faults,
}

fn examine(written: &StudyFile, folder: &Path, name: &str) -> Examined {
    let mut examined = match &written.layer.stacked {
        Some(layers) => stack::examine(written, layers, folder, name),
        None => examine_single(written, folder, name),
    };
    examined.packing_faults.title(written.title.as_deref());
    examined
}

/// Examines a study that is not one of `[[layer]]`.
fn examine_single(written: &StudyFile, folder: &Path, name: &str) -> Examined {
    let mut examined = examine_layer(written, folder, name);
    if written.layer.composed.is_none() {
        check_whole_thickness(&mut examined);
    }
    if written.stack.is_some() {
        let allowed = "nothing beside a single [layer], which has these keys itself";
        examined.packing_faults.add("stack", "a table", allowed, "remove it, or write [[layer]]");
    }
    examined
}

/// No machine solves a layer of grains that is thicker as a whole; packings have no such limit.
fn check_whole_thickness(examined: &mut Examined) {
    let thickness_um = examined.study.layer.thickness_um;
    let has_grains = !examined.study.pigments.is_empty();
    if has_grains && limits::THICKNESS_UM.holds(thickness_um) && !limits::WHOLE_UM.holds(thickness_um) {
        let allowed = format!("{} for a layer with grains that is solved whole", limits::WHOLE_UM);
        let remedy = format!(
            "thicknesses are in µm, a printed layer is about 1 µm thick ({thickness_um} nm are {}); thick paints are composed: add [layer.composed]",
            thickness_um / 1e3
        );
        examined.wave_faults.add("layer.thickness_um", format!("{thickness_um} µm"), allowed, remedy);
    }
}

/// Examines a study of a single layer.
fn examine_layer(written: &StudyFile, folder: &Path, name: &str) -> Examined {
    let mut packing_faults = Faults::default();
    let mut wave_faults = Faults::default();
    // the file as if its layer were the thinnest slab, and its pigments those of given grains
    let mut file = written.clone();
    let composed = file.layer.composed(&mut packing_faults);
    if let Some(composed) = &composed {
        file.layer.thickness_um = ThicknessWritten::Even(0.5 * composed.slab_um);
    }
    let given = microstructure::fill(&mut file, folder, &mut packing_faults).unwrap_or_default();
    pigments::fill_profiles(&mut file, &mut packing_faults);
    let microstructure = file.layer.microstructure.as_ref();

    let Light { wavelengths_nm, rule: light } = file.light.checked(&mut wave_faults);
    let tables = Tabulation { wavelengths_nm: &wavelengths_nm, folder };
    let usual_period_um = grains::nominal_period_um(&file.pigments);
    let cell = NominalCell::new(&file.layer, usual_period_um, &mut packing_faults);
    let mut layer = file.layer.checked(&cell, &tables, &mut packing_faults, &mut wave_faults);
    let grains = pigments::grains(&file.pigments, microstructure, &cell, &mut packing_faults);
    let pigments = pigments::with_indices(&file.pigments, grains, &tables, &mut wave_faults);
    let dissolved = pigments::dissolved(&file.pigments, &tables, &mut wave_faults);
    pigments::dissolve(&mut layer, &dissolved, &pigments, file.layer.mixing_rule(file.light.wave));
    let drawn = file.packing_request(&layer, &pigments);
    let packing = PackingRequest { given: given.grains, voxels: given.voxels, ..drawn };
    if packing_faults.0.is_empty() {
        packing_faults.0.extend(pigments::packing_fault(&packing));
    }

    let mut remarks: Vec<String> = file.light.short_of_end(&wavelengths_nm).into_iter().collect();
    let paper = paper_in_dots(&file, &tables, &mut wave_faults, &mut remarks);
    let surroundings = Surroundings::of(&file.layer, &file.pigments, paper.coupling);
    let Directions { angles, kind } = file.angles.checked(&surroundings, &mut wave_faults);
    let has_target = file.run.target_delta_e.is_some();
    let resolution = file.resolution.checked(file.light.wave, has_target, &mut wave_faults);
    let goal = file.solver.checked(&resolution, &mut wave_faults);
    let realisations = file.run.checked(cell.rule, &mut packing_faults);
    let output = file.output.checked(&mut packing_faults);
    let conditions = file.colour.checked(&wavelengths_nm, &mut wave_faults);
    let judgement = file.compare.checked(conditions, &paper, &tables, &mut wave_faults, &mut remarks);
    let variation = Variation { cell: cell.rule, thickness_std_um: cell.thickness_std_um, light };
    // without grains and with a uniform thickness all realisations are equal
    let are_alike = pigments.is_empty() && variation.thickness_std_um == 0.0;
    let mut study = Study {
        title: file.title.clone().unwrap_or_else(|| name.to_owned()),
        layer,
        stack: Vec::new(),
        without_layers: false,
        pigments,
        dissolved,
        packing,
        paper,
        wavelengths_nm,
        wave: file.light.wave,
        angles,
        realisations: if are_alike { 1 } else { realisations },
        target_delta_e: file.run.target_delta_e,
        target_colour: file.run.target_colour,
        failed_packings: file.run.failed_packings,
        variation,
        resolution,
        solver: file.solver.strategy,
        goal,
        output,
        judgement,
        numbers: Vec::new(),
        kind,
        remarks,
    };
    study.remarks.extend(given.remarks);
    remark_on_inputs(&mut study);
    light::refusals(&file.pigments, &study, &mut wave_faults);
    pigments::crystal_faults(&file, &mut wave_faults);
    if let Some(composed) = composed {
        composed::refusals(&file, &study, &mut wave_faults);
        composed::complete(&mut study, composed);
        study.remarks.extend(study.errors_left_out());
    }
    let (numbers, remarks) = number::checked(&file.numbers, &study, folder, &mut wave_faults);
    study.numbers = numbers;
    study.remarks.extend(remarks);
    if packing_faults.0.is_empty() && wave_faults.0.is_empty() {
        wave_faults.0.extend(target_without_colour(&study));
    }
    Examined { study, packing_faults, wave_faults }
}

/// The paper, and the dots that the layer is printed on it in.
fn paper_in_dots(
    file: &StudyFile,
    tables: &Tabulation,
    faults: &mut Faults,
    remarks: &mut Vec<String>,
) -> Paper {
    let mut paper = file.paper.checked(file.layer.index_out, tables, faults, remarks);
    paper.dots = dots::DotsReader { file, tables, faults }.checked();
    paper
}

/// Adds what a user should know of the tables and of the colours' wavelengths.
fn remark_on_inputs(study: &mut Study) {
    study.remarks.extend(index::bridged(study));
    study.remarks.extend(study.undetermined_inputs());
    if let Some([first_nm, last_nm]) = study.paper.fluorescence.as_ref().and_then(Fluorescence::excited_nm)
        && study.judgement.viewing.power(first_nm.max(SHORTEST_NM)) == 0.0
    {
        let name = study.judgement.viewing.illuminant();
        study.remarks.push(format!(
            "paper.fluorescence: the table of illuminant {name} has no light at {first_nm} nm, where the brightener is excited (up to \
             {last_nm} nm): colours under it hold less emission than under a real lamp"
        ));
    }
    if study.realisations == 1 && !study.pigments.is_empty() {
        study.remarks.push(
            "run.realisations = 1: spectra, colours and numbers have no error bars, as one packing tells nothing of their scatter; 8 or more do"
                .into(),
        );
    }
    let visible_nm = &study.wavelengths_nm[visible(&study.wavelengths_nm)];
    if study.paper.dots.is_some()
        && let Err(error) = Colorimeter::new(visible_nm)
    {
        study.remarks.push(format!("dots: no prints, whose coverages are those of luminances: {error}"));
    }
    if study.no_paper().is_none() {
        study.remarks.extend(light::colour_takes_a_part(&study.wavelengths_nm));
        study.remarks.extend(light::colour_is_extrapolated(&study.wavelengths_nm));
    }
}

impl StudyFile {
    /// The grains that are drawn, in a checked layer.
    fn packing_request(&self, layer: &Layer, pigments: &[Pigment]) -> PackingRequest {
        PackingRequest {
            period_um: layer.period_um,
            thickness_um: layer.thickness_um,
            pigments: pigments.iter().map(|pigment| pigment.grains.clone()).collect(),
            method: self.packing.method,
            seed: self.run.seed,
            sequential: self.packing.sequential,
            relaxation: self.packing.relaxation,
            equilibration: self.packing.equilibration,
            relief: self.layer.relief,
            walls: self.layer.walls,
            ..PackingRequest::default()
        }
    }
}

/// `target_delta_e` needs a colour; without paper it can never be met.
fn target_without_colour(study: &Study) -> Option<Fault> {
    let target = study.target_delta_e?;
    let seen = &study.wavelengths_nm[visible(&study.wavelengths_nm)];
    let grid = Colorimeter::new(seen).err().map(|error| error.to_string());
    let reason = study.no_ink().or(grid)?;
    let remedy = "leave it out, or take angles.count and wavelengths from 400 to 700 nm";
    let allowed = format!("nothing where there is no colour: {reason}");
    Some(Fault::new("run.target_delta_e", target, allowed, remedy))
}
