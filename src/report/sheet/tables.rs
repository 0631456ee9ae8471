//! The page's tables: uncertainty, settings, packings, limits, provenance.

use super::percent;
use crate::appearance::paper::{Coupling, MirroredSky};
use crate::evaluate::manifest::{Budget, Certainty, ColourNote, FailureNote, Manifest, SpectrumRow};
use crate::evaluate::seen::Seen;
use crate::evaluate::summary::aimed_at;
use crate::evaluate::survivors::Survivors;
use crate::ink::Method;
use crate::input::study::{Dissolved, IndexSpectrum, Pigment, Study, WantedResolution};
use crate::input::variation::{CellRule, LightRule};
use crate::report::page::{FailureRow, Meant, Named, PackingRow, Provenance};
use crate::report::scalar_error;
use crate::store::packing_record::{PackingRecord, ShareRecord};
use crate::wave::Resolution;
use crate::wave::Wave;

pub(crate) fn certainty(manifest: &Manifest<&Study>, seen: &Seen) -> Vec<Meant> {
    let certainty = &manifest.certainty;
    let several = seen.realisations.len() > 1;
    let ensemble =
        if several { "independent packings averaged" } else { "one packing: the spread is unknown" };
    let mut rows = vec![Meant::new("realisations", seen.realisations.len().to_string(), ensemble)];
    if let Some(noise) = manifest.colours.first().and_then(|c| c.lab_standard_error) {
        let length = noise.iter().map(|x| x * x).sum::<f64>().sqrt();
        let meaning = "standard error of the colour, as a distance in Lab; its parts follow";
        rows.push(Meant::new("colour", format!("ΔE {length:.2}"), meaning));
    }
    rows.extend(manifest.colours.first().map(budget).unwrap_or_default());
    if let (Some(factor), degrees) = (certainty.coverage_factor_95, certainty.degrees_of_freedom) {
        let meaning = format!(
            "95 % intervals are ± this many standard errors (Student's t, {degrees} degrees of freedom)"
        );
        rows.push(Meant::new("95 %", format!("× {factor:.2}"), meaning));
    }
    if let Some(error) = largest_error(&manifest.spectra) {
        let meaning = "largest standard error of the layer's R or T";
        rows.push(Meant::new("spectra", format!("± {error:.4}"), meaning));
    }
    if let Some(error) = certainty.angle_error_estimate {
        let meaning = "standard error of the mean transmittance over the hemisphere from the placing of the directions, at the worst wavelength";
        rows.push(Meant::new("angles", format!("{error:.1e}"), meaning));
    }
    rows.extend(exactness(certainty));
    rows
}

/// Numerical errors of the solves.
fn exactness(certainty: &Certainty) -> [Meant; 4] {
    [
        Meant::new(
            "grid, R and T",
            format!("{:.1e}, {:.1e}", certainty.reflectance_grid_error, certainty.transmittance_grid_error),
            match certainty.packings_on_finer_grid {
                0 => "expected errors from the grid, by comparison with a coarser one at the hardest wavelengths and \
                      angles; part of all error bars"
                    .to_owned(),
                n => format!(
                    "what is left of the grid's error after a correction by {n} packings on a finer grid, at the worst \
                     wavelength and angle; part of all error bars"
                ),
            },
        ),
        Meant::new(
            "grid, orders",
            format!("{:.1e}", certainty.amplitude_error_estimate),
            "expected error of the complex amplitudes of single orders, from coarser and finer grids; sums over orders are \
             better known",
        ),
        Meant::new(
            "energy",
            format!("{:.1e}", certainty.largest_energy_error),
            "largest |R + T + A − 1| of all solves: the energy balance",
        ),
        Meant::new(
            "residual",
            format!("{:.1e}", certainty.largest_residual),
            format!("largest relative residual, after {:.0} steps on average", certainty.mean_steps),
        ),
    ]
}

/// Parts of the first colour's error: the largest one shows what to improve.
fn budget(note: &ColourNote) -> Vec<Meant> {
    let Budget { chance_and_cell, angles, wavelengths, grid, residual, missing_cells, beyond_range } =
        note.budget;
    let parts = [
        (
            "… chance and cell",
            chance_and_cell,
            "random packings in cells of their own: more realisations reduce it",
        ),
        (
            "… angles",
            angles,
            "directions over the hemisphere: more of them (angles.count) or more realisations reduce it",
        ),
        ("… grid", Some(grid), "a smaller resolution.accuracy reduces it"),
        ("… residual", Some(residual), "a smaller solver.tolerance reduces it"),
        (
            "… missing cells",
            Some(missing_cells).filter(|&part| part > 0.0),
            "packings without room: the largest change that their cells could cause, if they were the most extreme ones",
        ),
        (
            "… beyond the range",
            Some(beyond_range).filter(|&part| part > 0.0),
            "visible light outside the wavelengths, for which the spectrum's ends stand: light.from_nm = 400 and to_nm = 700 \
             leave none",
        ),
        (
            "… wavelengths",
            Some(wavelengths),
            "effect of their spacing; the colour is corrected for it, and the spread over realisations includes the rest",
        ),
    ];
    parts
        .into_iter()
        .filter_map(|(name, part, meaning)| Some(Meant::new(name, format!("ΔE {:.3}", part?), meaning)))
        .collect()
}

fn largest_error(rows: &[SpectrumRow]) -> Option<f64> {
    let errors = rows.iter().flat_map(|row| [row.reflectance, row.transmittance]);
    errors.filter_map(|estimate| estimate.standard_error).reduce(f64::max)
}

pub(crate) fn asked(study: &Study) -> Vec<Named> {
    let layer = &study.layer;
    let [x, y] = layer.period_um;
    let cell = match study.variation.cell {
        CellRule::Fixed => format!("{x} × {y} µm, periodic laterally"),
        CellRule::Varied => format!(
            "about {x:.1} × {y:.1} µm, periodic laterally; another size, shape and azimuth in every realisation"
        ),
    };
    let uneven = match study.variation.thickness_std_um {
        0.0 => String::new(),
        std => format!(" ± {std}"),
    };
    let cell = format!("{cell}; {}{uneven} µm thick", layer.thickness_um);
    let surroundings = format!("incident side {}, exit side {}", layer.index_in, layer.index_out);
    let mut rows = vec![
        Named::new("cell", cell),
        Named::new("binder", format!("index {}", layer.binder.source)),
        Named::new("half-spaces", format!("index {surroundings}")),
    ];
    rows.extend(study.pigments.iter().map(with_grains));
    rows.extend(study.dissolved.iter().map(without_grains));
    if study.angles.strata > 0 {
        rows.push(Named::new("paper", paper(study)));
    }
    rows.extend([
        Named::new("wavelengths", list(&study.wavelengths_nm, "nm")),
        Named::new("angles", angles(study)),
    ]);
    rows
}

/// A pigment with its volume fraction, its grains and its index.
fn with_grains(pigment: &Pigment) -> Named {
    let (grains, source) = (&pigment.grains, &pigment.material.source);
    let size = format!("{}, {}", grains.shape.name(), super::size(grains));
    let share = percent(grains.volume_fraction);
    let layer = |(nm, own): (&f64, &IndexSpectrum)| format!(", {nm} nm of index {}", own.source);
    let layers: String = grains.shell_nm.iter().zip(&pigment.shell).map(layer).collect();
    let layers = if layers.is_empty() { layers } else { format!("; layers from the core outwards{layers}") };
    let core = if layers.is_empty() { "" } else { " of the core" };
    let value = format!("{share} %, {size}; index{core} {source}{layers}");
    Named::new(format!("pigment {}", pigment.name), value)
}

/// A pigment of vanishing grains with its volume fraction and its index.
fn without_grains(pigment: &Dissolved) -> Named {
    let (share, source) = (percent(pigment.volume_fraction), &pigment.material.source);
    let value = format!("{share} %, dissolved in the binder (grain size → 0); index {source}");
    Named::new(format!("pigment {}", pigment.name), value)
}

/// What the error bars include.
fn held(study: &Study) -> &'static str {
    match (study.variation.cell, study.variation.light) {
        (CellRule::Varied, LightRule::Shifted { .. }) => {
            "Error bars include the spread over packings, cells, directions and wavelengths (two packings share theirs, one with \
             more pigment and one with less, as windows of a wide layer have; jackknife over such pairs), the grid and the \
             solver's residual."
        }
        (CellRule::Varied, LightRule::Listed) => {
            "Error bars include the spread over packings, cells and directions (two packings share theirs, one with more pigment \
             and one with less, as windows of a wide layer have; jackknife over such pairs), the grid and the solver's residual. The wavelengths were listed: what lies between them is not included."
        }
        (CellRule::Fixed, _) => {
            "The cell is fixed: error bars include the spread over packings and directions (jackknife over realisations), the grid and \
             the solver's residual, but not the effect of the period, which can be many times as large. cell = \"varied\" includes it."
        }
    }
}

fn angles(study: &Study) -> String {
    let solved = list(&study.angles.exact_deg, "°");
    match study.angles.strata {
        0 => solved,
        strata => format!("{solved}, and {strata} over the hemisphere, others in every realisation"),
    }
}

fn paper(study: &Study) -> String {
    let coupling = match study.paper.coupling {
        Coupling::Gap => "behind a thin air gap".to_owned(),
        Coupling::OpticalContact { index } => format!("in contact, scatterers in index {index}"),
    };
    let sky = match study.output.mirrored_sky {
        MirroredSky::Included => "with",
        MirroredSky::Excluded => "without",
    };
    format!("albedo {}, {coupling}; natural light {sky} the mirrored sky", study.paper.source)
}

fn list(values: &[f64], unit: &str) -> String {
    match values {
        [first, .., last] if values.len() > 8 => {
            format!("{} from {first:.1} to {last:.1} {unit}", values.len())
        }
        _ => {
            let all: Vec<String> = values.iter().map(|v| format!("{v:.1}")).collect();
            format!("{} {unit}", all.join(", "))
        }
    }
}

pub(crate) fn packings(study: &Study, manifest: &Manifest<&Study>) -> Vec<PackingRow> {
    let rows = manifest.packings.iter().flat_map(|packing| {
        let pigments = study.pigments.iter().zip(&packing.shares);
        pigments.map(|(pigment, share)| packing_row(packing, &pigment.name, share))
    });
    rows.collect()
}

/// A pigment's volume fractions, requested and reached, in one packing.
fn packing_row(packing: &PackingRecord, pigment: &str, share: &ShareRecord) -> PackingRow {
    PackingRow {
        realisation: packing.realisation + 1,
        pigment: pigment.to_owned(),
        grains: share.grains,
        asked: format!("{:.2}", 100.0 * share.requested_fraction),
        reached: format!("{:.2}", 100.0 * share.achieved_fraction),
        sizes: share.sizes.map_or_else(|| "–".to_owned(), |sizes| sizes.in_words()),
        method: method(packing),
    }
}

/// What follows from grains in given places.
fn placed(study: &Study) -> Option<String> {
    let voxels = &study.packing.voxels;
    let cuts = match study.packing.given.len() + voxels.len() {
        0 => return None,
        1 => "one cut".to_owned(),
        cuts => format!("{cuts} cuts"),
    };
    let seams = match voxels.first() {
        None => "",
        Some(cut) if cut.mirrored => {
            " Each was mirrored along x and y: grains at its faces meet their mirror images, which is not how grains lie."
        }
        Some(_) => {
            " Where opposite faces of a cut do not match, grains are cut off: the layer has more surface than the material."
        }
    };
    Some(format!(
        "The grains are given ({cuts}), not packed. Each cut is continued periodically: nothing wider than it is in them, \
         and error bars hold no scatter of packings but that between cuts.{seams}"
    ))
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

pub(crate) fn failures(manifest: &Manifest<&Study>) -> Vec<FailureRow> {
    manifest.failures.iter().map(failure_row).collect()
}

/// A solve or packing without a result, and the reason.
fn failure_row(note: &FailureNote) -> FailureRow {
    let realisation = format!("realisation {}", note.realisation + 1);
    let point = match note.wavelength_nm.zip(note.polar_deg) {
        Some((nm, deg)) => format!("{realisation}, {nm} nm, {deg:.1}°"),
        None => format!("{realisation}, packing"),
    };
    FailureRow { point, reason: note.reason.clone() }
}

pub(crate) fn limits(study: &Study, manifest: &Manifest<&Study>) -> Vec<String> {
    let mut lines = vec![
        wave_in_words(study.wave).to_owned(),
        "Every grain is resolved: no ray tracing, no radiative transfer, no fitted scattering parameters. The cell is periodic \
         laterally, so light leaves in discrete orders; averages over more or larger cells are smoother."
            .to_owned(),
    ];
    lines.splice(1..1, scalar_error::line(study));
    if let Some(reason) = &study.angles.no_paper {
        lines.insert(0, format!("There is no paper, colour or picture: {reason}."));
    }
    lines.splice(0..0, missing(study, manifest));
    if study.variation.thickness_std_um == 0.0 {
        let line = "The layer is flat and equally thick everywhere, so it shows the colours of a thin film; in a print of uneven \
                    thickness they wash out: thickness_um = { mean = …, std = … } models one.";
        lines.push(line.to_owned());
    }
    lines.push(held(study).to_owned());
    lines.extend(placed(study));
    if study.pigments.iter().any(|p| p.material.source.contains("synthetic")) {
        let line = "Built-in spectra are synthetic: smooth curves like those of printing inks, not measured pigments. Bring \
                    your own with index = { csv = \"…\" }.";
        lines.push(line.to_owned());
    }
    lines.extend(few_wavelengths(study, manifest));
    lines.extend(air_gap(study));
    if study.variation.light == LightRule::Listed && study.angles.strata > 0 {
        let line = "The wavelengths are a list, the same in every cell: the error bars of colours do not include the effect of their spacing. A \
                    range (from_nm, to_nm, step_nm) is sampled at shifted wavelengths, and has no such error.";
        lines.push(line.to_owned());
    }
    lines.splice(0..0, missing_cells(manifest));
    lines.extend(beyond_range(study, manifest));
    lines.extend(missed_target(study, manifest));
    if let Some(reason) = &manifest.no_ink_maker {
        let viewing = study.judgement.viewing.name();
        lines.insert(
            0,
            format!("There are no swatches, hiding power or comparisons under {viewing}: {reason}."),
        );
    }
    lines
}

/// Colours and numbers that are missing, and why.
fn missing(study: &Study, manifest: &Manifest<&Study>) -> Vec<String> {
    let reason = manifest.no_colour.iter().filter(|_| study.angles.no_paper.is_none());
    let colour = reason.map(|reason| format!("There is no colour: {reason}."));
    let help = "Curves through few angles, cells or points overshoot: angles.count, run.realisations or a finer grid help.";
    let withheld = manifest.withheld.iter().map(|number| format!("No result: {}. {help}", number.in_words()));
    colour.chain(withheld).collect()
}

/// Packings that are not in the means.
fn missing_cells(manifest: &Manifest<&Study>) -> Option<String> {
    let Survivors { packed, refused } = manifest.tried_packings;
    if refused == 0 {
        return None;
    }
    Some(format!(
        "{refused} of {} packings have no room: the means are those of the others, and all error bars include the largest change \
         that the missing cells could cause.",
        packed + refused
    ))
}

/// Visible light outside the spectra of the colours.
fn beyond_range(study: &Study, manifest: &Manifest<&Study>) -> Option<String> {
    let part = manifest.colours.first().map(|note| note.budget.beyond_range).filter(|&part| part > 0.0)?;
    let (first, last) = (study.wavelengths_nm.first()?, study.wavelengths_nm.last()?);
    Some(format!(
        "Colours need 400 to 700 nm, and the spectra reach from {first} to {last} nm: their ends stand for the rest, and the error bars of \
         colours include what it could be (ΔE {part:.2} of one standard error). light.from_nm = 400 and to_nm = 700 leave none."
    ))
}

/// Wavelengths that a colour needs.
const ENOUGH_WAVELENGTHS: usize = 8;

/// Warns of a colour from few wavelengths: those solved over all realisations where each has its
/// own.
fn few_wavelengths(study: &Study, manifest: &Manifest<&Study>) -> Option<String> {
    let solved = match study.variation.light {
        LightRule::Shifted { strata, .. } => strata * manifest.realisations.finished,
        LightRule::Listed => study
            .wavelengths_nm
            .iter()
            .filter(|nm| manifest.spectra.iter().any(|row| row.wavelength_nm == **nm))
            .count(),
    };
    (solved < ENOUGH_WAVELENGTHS && study.angles.strata > 0).then(|| {
        format!(
            "Only {solved} wavelengths were solved: the colour of a spectrum with steep edges can be off by several ΔE."
        )
    })
}

/// Limits of the assumption of an air gap before the paper.
const AIR_GAP: &str = "A thin air gap between layer and paper is assumed. Printed layers are mostly in optical contact with their \
    paper: [paper] coupling = \"optical_contact\", with the paper's index as [layer] index_out, makes them darker (the ink of \
    examples/yellow.toml with index_out = 1.5, under natural light: L* 89 → 83, a* −13 → −8, b* 83 → 82).";

fn air_gap(study: &Study) -> Option<String> {
    let assumed = study.paper.coupling == Coupling::Gap && study.angles.strata > 0;
    assumed.then(|| AIR_GAP.to_owned())
}

/// A `run.target_delta_e` that was not reached.
fn missed_target(study: &Study, manifest: &Manifest<&Study>) -> Option<String> {
    let target = study.target_delta_e?;
    let bars = aimed_at(study, manifest).filter_map(|note| note.delta_e_2000_95);
    let widest = bars.reduce(f64::max).filter(|&bar| bar > target)?;
    let cells = manifest.realisations.finished;
    Some(format!(
        "The 95 % interval of ΔE00 {target} wanted (run.target_delta_e) is not reached with {cells} cells: the widest is {widest:.2}."
    ))
}

/// Wall time of the solves, and processor time of the whole process.
fn time_of(manifest: &Manifest<&Study>) -> String {
    let process = manifest
        .process_seconds
        .map_or_else(String::new, |s| format!("; {s:.1} processor seconds of the whole process"));
    format!("{:.1} s{process}", manifest.solve_seconds)
}

fn wave_in_words(wave: Wave) -> &'static str {
    match wave {
        Wave::Scalar => {
            "The wave equation is solved as a scalar one: the field and its slope are continuous everywhere. That is exact for \
             s-polarised light on plane layers; for unpolarised light, and above all for p-polarised light at oblique angles, it is \
             an approximation."
        }
        Wave::Unpolarised => {
            "Maxwell's equations are solved for s and p polarisation, and the efficiencies averaged: unpolarised light. The paper depolarises."
        }
        Wave::S | Wave::P => {
            "Maxwell's equations are solved for light of one polarisation, and outgoing light is summed over both polarisations. The \
             paper depolarises, so what it reflects back through the layer is unpolarised."
        }
    }
}

pub(crate) fn provenance(study: &Study, manifest: &Manifest<&Study>) -> Provenance {
    let grid = match study.resolution {
        WantedResolution::Accuracy { amplitude, .. } => {
            format!("chosen for amplitude errors of {amplitude:.0e}")
        }
        WantedResolution::Grid { .. } => "as asked".to_owned(),
    };
    let words =
        |r: Resolution| format!("{} × {} points, {} cells ({} planes)", r.nx, r.ny, r.cells, r.planes());
    let longest = manifest.resolution_longest.map(|r| format!("; {} for the longest waves", words(r)));
    let resolution = format!("{}, {grid}{}", words(manifest.resolution), longest.unwrap_or_default());
    let solver = study.solver.build().name();
    let all: Vec<&str> = manifest.builds.iter().map(String::as_str).collect();
    let builds = if all.len() > 1 { format!("different builds: {}", all.join(", ")) } else { all.concat() };
    Provenance {
        program: manifest.program.clone(),
        rows: vec![
            Named::code("study", manifest.study_hash.clone()),
            Named::new("program", format!("{}, method {}", manifest.program, manifest.method_version)),
            Named::new("solves made by", builds),
            Named::new("seed", manifest.seed.to_string()),
            Named::new("wave", study.wave.in_words()),
            Named::new("grid", resolution),
            Named::new("solver", format!("{solver}, to a residual of {:.0e}", study.goal.tolerance)),
            Named::new("solves", format!("{} of {}", manifest.solves.finished, manifest.solves.asked)),
            Named::new("time in solves", time_of(manifest)),
        ],
    }
}
