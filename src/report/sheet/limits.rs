//! What the page says that its numbers do not hold: assumptions, and what is missing.

use crate::appearance::paper::Coupling;
use crate::evaluate::manifest::Manifest;
use crate::evaluate::summary::aimed_at;
use crate::evaluate::survivors::Survivors;
use crate::input::study::Study;
use crate::input::variation::{CellRule, LightRule};
use crate::report::scalar_error;
use crate::wave::Wave;

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
