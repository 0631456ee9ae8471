//! The page's tables: uncertainty, settings, packings, limits, provenance.

use super::percent;
use crate::appearance::paper::{Coupling, MirroredSky};
use crate::evaluate::manifest::{Budget, Certainty, ColourNote, FailureNote, Manifest, SpectrumRow};
use crate::evaluate::seen::Seen;
use crate::ink::Method;
use crate::input::study::{Dissolved, IndexSpectrum, Pigment, Study, WantedResolution};
use crate::input::variation::CellRule;
use crate::report::page::{FailureRow, Meant, Named, Provenance};
use crate::store::packing_record::{PackingRecord, ShareRecord};
use crate::wave::Resolution;
use minijinja::{Value, context};

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

/// Wall time of the solves, and processor time of the whole process.
fn time_of(manifest: &Manifest<&Study>) -> String {
    let process = manifest
        .process_seconds
        .map_or_else(String::new, |s| format!("; {s:.1} processor seconds of the whole process"));
    format!("{:.1} s{process}", manifest.solve_seconds)
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
