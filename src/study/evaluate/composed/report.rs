//! The published numbers of a composed layer, with everything that their bars are made of.

use super::level::{Change, Level, Slabs, SolvedPortion};
use super::manifest::{
    ComposedColours, ComposedManifest, ComposedRow, DepthRow, DistributionRow, ErrorParts, MediumRow,
};
use super::numbers::{COLOURS, LayerTask, MOST_SLABS, SPECTRAL, lights, projected_sr};
use crate::appearance::composed::plate::{Plate, total};
use crate::appearance::tristimulus::Colorimeter;
use crate::evaluate::gate::{self, Quantity};
use crate::evaluate::manifest::{Count, Status, Withheld};
use crate::evaluate::summary::program;
use crate::evaluate::wavelengths::nearest;
use crate::input::study::{Composed, Study};
use crate::store::identity::METHOD_VERSION;

/// Slabs of the curve against thickness, up to a layer that practically no light passes.
const CURVE: [usize; 16] = [2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 256, 1024, 4096];
/// Wavelength of the fluxes against depth, nm: the nearest one of the study is taken.
const SHOWN_NM: f64 = 550.0;
/// Most joints of the profile.
const MOST_JOINTS: usize = 60;

/// Evaluates a composed layer; a reason where too little is solved.
///
/// # Errors
/// A portion without complete realisations, paper without an albedo.
pub fn report<'a>(study: &'a Study, solved: &[SolvedPortion]) -> Result<ComposedManifest<'a>, String> {
    let level = |halved| Level::new(solved, halved).ok_or("not every slab has a complete realisation yet");
    let (whole, half) = (level(false)?, level(true)?);
    let no_colour = Colorimeter::new(&study.wavelengths_nm).err().map(|error| error.to_string());
    let mut question = LayerTask::new(study)?;
    let composed = question.composed;
    question.thicknesses_um.extend(CURVE.map(|count| count as f64 * composed.slab_um));
    let slabs = whole.slabs(Change::default());
    let no_hiding = hiding(&mut question, &slabs).err();
    let mut all = judged(&question, &whole, &half).into_iter();
    let (asked_um, others_um) = question.thicknesses_um.split_at(composed.thicknesses_um.len());
    let (spectra, colours) = layers(&question, asked_um, &mut all);
    let (curve, curve_colours) = layers(&question, &others_um[..CURVE.len()], &mut all);
    layers(&question, &others_um[CURVE.len()..], &mut all);
    let mut withheld = Vec::new();
    let mut medium = Vec::new();
    for (&nm, slabs) in study.wavelengths_nm.iter().zip(&slabs) {
        medium.push(medium_row(nm, slabs, &mut all, &mut withheld));
    }
    let distributions = distributions(&question, &slabs, &composed.thicknesses_um, &mut all);
    let hiding_thickness_um = if question.hides { all.next() } else { None };
    let (depth_nm, depth) = depth(&question, &slabs);
    let records = || solved.iter().flat_map(|(_, c)| &c.realisations).flat_map(|r| r.points.iter().flatten());
    let finished = solved.iter().map(|(_, collected)| collected.finished()).sum();
    let solves = Count { asked: study.solves(), finished };
    Ok(ComposedManifest {
        status: if finished == solves.asked { Status::Complete } else { Status::Partial },
        title: study.title.clone(),
        study_hash: study.key().to_string(),
        program: program(),
        builds: records().map(|record| record.build.clone()).collect(),
        method_version: METHOD_VERSION,
        seed: study.packing.seed,
        composed,
        solves,
        failures: solved.iter().flat_map(failures).collect(),
        spectra,
        colours,
        no_colour,
        distributions,
        withheld,
        curve,
        curve_colours,
        hiding_thickness_um,
        spreading_rate_m2_per_l: hiding_thickness_um.map(spreading_rate),
        no_hiding,
        remarks: thin_slabs(composed, &medium).into_iter().collect(),
        medium,
        depth,
        depth_nm,
        solve_seconds: records().map(|record| record.account.seconds).sum(),
        process_seconds: None,
        study,
    })
}

/// Slabs thinner than the mean free path of coherent light, where that is longest.
fn thin_slabs(composed: &Composed, medium: &[MediumRow]) -> Option<String> {
    let paths = medium.iter().filter_map(|row| Some((row.wavelength_nm, row.coherent_path_um?.value)));
    let (wavelength_nm, path_um) = paths.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let slab_um = composed.slab_um;
    let words = format!(
        "layer.composed.slab_um: found slabs of {slab_um:.2} µm, thinner than the mean free path of coherent light, \
         {path_um:.2} µm at {wavelength_nm} nm; interference between the surfaces is corrected for, that between inner slabs is left \
         to the model's error bar: take thicker slabs, or solve the layer at once"
    );
    (path_um > slab_um).then_some(words)
}

/// 1000/H m² a litre.
fn spreading_rate(hiding: ErrorParts) -> ErrorParts {
    let value = 1e3 / hiding.value;
    let relative = |error: f64| value * error / hiding.value;
    ErrorParts {
        value,
        standard_error: relative(hiding.standard_error),
        chance: relative(hiding.chance),
        model: relative(hiding.model),
        grid: relative(hiding.grid),
    }
}

/// Packings and solves of one portion that have no result.
fn failures((study, collected): &SolvedPortion) -> Vec<String> {
    let words = study.portion.as_ref().map(|p| p.in_words()).unwrap_or_default();
    let packings = collected.refused.iter().map(|r| (r.realisation, r.reason.clone()));
    let solves = collected.failures().map(|f| (f.point.realisation, f.reason.clone()));
    packings.chain(solves).map(|(r, reason)| format!("{words}, realisation {r}: {reason}")).collect()
}

/// Adds the two thicknesses around the one that hides.
fn hiding(question: &mut LayerTask, slabs: &[Slabs]) -> Result<(), String> {
    let hides = |count: usize| question.does_hide(slabs, count);
    let reason = "no contrast ratio without a colour";
    if hides(2).ok_or(reason)? {
        return Err(format!("two slabs, {} µm, hide already", 2.0 * question.composed.slab_um));
    }
    let mut most = 4;
    while !hides(most).ok_or(reason)? {
        if most >= MOST_SLABS {
            return Err(format!("{} µm do not hide", MOST_SLABS as f64 * question.composed.slab_um));
        }
        most *= 2;
    }
    let counts: Vec<usize> = (most / 2 + 1..most).collect();
    let first = most / 2 + 1 + counts.partition_point(|&count| hides(count) == Some(false));
    question.thicknesses_um.extend([first - 1, first].map(|count| count as f64 * question.composed.slab_um));
    question.hides = true;
    Ok(())
}

/// All numbers with their bars.
fn judged(question: &LayerTask, whole: &Level, half: &Level) -> Vec<ErrorParts> {
    let own = question.numbers(whole, Change::default());
    let halved = question.numbers(half, Change::default());
    let moved = question.numbers(whole, Change { grid: true, left_out: None });
    let mut squares = vec![0.0; own.len()];
    for (portion, count) in whole.realisations().into_iter().enumerate().filter(|(_, count)| *count > 1) {
        let without =
            |r: usize| question.numbers(whole, Change { left_out: Some([portion, r]), grid: false });
        let replicates: Vec<Vec<f64>> = (0..count).map(without).collect();
        let n = count as f64;
        for (k, square) in squares.iter_mut().enumerate() {
            let mean = replicates.iter().map(|x| x[k]).sum::<f64>() / n;
            *square += (n - 1.0) / n * replicates.iter().map(|x| (x[k] - mean).powi(2)).sum::<f64>();
        }
    }
    let parts = |k: usize| [squares[k].sqrt(), halved[k] - own[k], moved[k] - own[k]];
    (0..own.len()).map(|k| ErrorParts::new(own[k], parts(k))).collect()
}

/// The rows and colours of some thicknesses.
fn layers(
    question: &LayerTask,
    thicknesses_um: &[f64],
    all: &mut impl Iterator<Item = ErrorParts>,
) -> (Vec<ComposedRow>, Vec<ComposedColours>) {
    let (mut rows, mut all_colours) = (Vec::new(), Vec::new());
    for &um in thicknesses_um {
        let own: Vec<_> = question.study.wavelengths_nm.iter().map(|&nm| row(um, nm, &take(all))).collect();
        all_colours.extend(question.colorimeter.as_ref().map(|eye| colours(eye, &own, &take(all))));
        rows.extend(own);
    }
    (rows, all_colours)
}

fn colours(eye: &Colorimeter, rows: &[ComposedRow], of: &[ErrorParts; COLOURS]) -> ComposedColours {
    let lab = |k: usize| [of[k], of[k + 1], of[k + 2]];
    let spectrum: Vec<f64> = rows.iter().map(|row| row.natural_light.value).collect();
    let [r, g, b] = eye.colour(&spectrum).map_or([0; 3], |colour| colour.srgb8);
    ComposedColours {
        thickness_um: rows.first().map_or(f64::NAN, |row| row.thickness_um),
        hex: format!("#{r:02x}{g:02x}{b:02x}"),
        natural_light: lab(0),
        lit_at_45: lab(3),
        over_black: lab(6),
        contrast_ratio: of[9],
    }
}

/// The next numbers of the list.
fn take<const N: usize>(all: &mut impl Iterator<Item = ErrorParts>) -> [ErrorParts; N] {
    let nothing = ErrorParts { value: f64::NAN, standard_error: 0.0, chance: 0.0, model: 0.0, grid: 0.0 };
    std::array::from_fn(|_| all.next().unwrap_or(nothing))
}

fn row(thickness_um: f64, wavelength_nm: f64, of: &[ErrorParts; SPECTRAL]) -> ComposedRow {
    ComposedRow {
        thickness_um,
        wavelength_nm,
        reflectance_normal: of[0],
        transmittance_normal: of[1],
        reflectance_45: of[2],
        transmittance_45: of[3],
        reflectance_diffuse: of[4],
        transmittance_diffuse: of[5],
        coherent_transmittance: of[6],
        mirrored: of[7],
        natural_light: of[8],
        lit_at_45: of[9],
        over_black: of[10],
        over_white: of[11],
    }
}

/// The next coefficients of the list as far as they are possible; the others are withheld.
fn medium_row(
    wavelength_nm: f64,
    slabs: &Slabs,
    all: &mut impl Iterator<Item = ErrorParts>,
    withheld: &mut Vec<Withheld>,
) -> MediumRow {
    // share of light at 0° that an inner slab passes straight on
    let straight = slabs.inner.transmission[0][(0, 0)];
    let mut next = |name: &str, quantity: Quantity| {
        let number = all.next()?;
        let Some(reason) = gate::impossible(quantity, number.estimate()) else { return Some(number) };
        let why = format!(
            "{reason} at {wavelength_nm} nm, where a slab passes {straight:.1e} of the light unscattered \
             in the mean of these realisations: take thinner slabs or more realisations"
        );
        withheld.push(Withheld { number: name.to_owned(), reason: why });
        None
    };
    let embedding_index = slabs.media[1].ordinates.index;
    let effective_index = next("effective index", Quantity::Positive);
    // The medium of transport theory has the index of the half-spaces; another one would change the
    // étendue of its light.
    let apart = effective_index.map_or(0.0, |own| ((own.value / embedding_index).powi(2) - 1.0).abs());
    let embedded = |number: Option<ErrorParts>| number.map(|own| own.with_model(apart * own.value.abs()));
    MediumRow {
        wavelength_nm,
        embedding_index,
        effective_index,
        coherent_path_um: next("mean free path of coherent light", Quantity::Positive),
        scattering_per_um: next("scattering coefficient", Quantity::Size),
        absorption_per_um: embedded(next("absorption coefficient", Quantity::Size)),
        asymmetry: embedded(next("asymmetry", Quantity::Cosine)),
        transport_path_um: embedded(next("transport mean free path", Quantity::Positive)),
        kubelka_munk_absorption_per_um: next("Kubelka and Munk's K", Quantity::Size),
        kubelka_munk_scattering_per_um: next("Kubelka and Munk's S", Quantity::Size),
    }
}

/// Where light at 0° goes, of each thickness asked for and wavelength.
fn distributions(
    question: &LayerTask,
    slabs: &[Slabs],
    thicknesses_um: &[f64],
    all: &mut impl Iterator<Item = ErrorParts>,
) -> Vec<DistributionRow> {
    let mut rows = Vec::new();
    for &thickness_um in thicknesses_um {
        for (&wavelength_nm, Slabs { media: [before, _, behind], .. }) in
            question.study.wavelengths_nm.iter().zip(slabs)
        {
            for (reflected, medium) in [(true, before), (false, behind)] {
                let nodes = (0..medium.ordinates.count()).zip(&mut *all);
                rows.extend(nodes.map(|(node, bdf_per_sr)| DistributionRow {
                    thickness_um,
                    wavelength_nm,
                    reflected,
                    polar_out_deg: medium.ordinates.polar_deg(node),
                    projected_sr: projected_sr(medium, node),
                    bdf_per_sr,
                }));
            }
        }
    }
    rows
}

/// Fluxes against depth in the first thickness, rounded to whole slabs, on the paper.
fn depth(question: &LayerTask, slabs: &[Slabs]) -> (f64, Vec<DepthRow>) {
    let nm = &question.study.wavelengths_nm;
    let w = nearest(nm.iter().copied(), SHOWN_NM);
    let count = (question.thicknesses_um[0] / question.composed.slab_um).round() as usize;
    let [before, _, behind] = &slabs[w].media;
    let light = &lights(before, question.study.wave)[0];
    let paper = Plate::lambertian(question.albedos[w], &behind.weights());
    let row = |depth_um: f64, [down, up]: [f64; 2]| DepthRow { depth_um, down, up };
    let at = |k: usize| k as f64 * question.composed.slab_um;
    let whole = slabs[w].layer(count);
    let mut rows = vec![row(0.0, [1.0, total(&(&whole.then(&paper).reflection[0] * light))])];
    for k in (1..count).step_by(count.div_ceil(MOST_JOINTS)) {
        let [front, back] = slabs[w].parted(count, k);
        rows.push(row(at(k), front.between(&back.then(&paper), light).map(|flux| total(&flux))));
    }
    rows.push(row(at(count), whole.between(&paper, light).map(|flux| total(&flux))));
    (nm[w], rows)
}
