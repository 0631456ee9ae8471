//! The published numbers of a composed layer, with everything that their bars are made of.

use super::gate::{self as composed_gate, LayerSpectra};
use super::level::{Change, Level, Slabs, SolvedPortion};
use super::manifest::{
    ComposedColours, ComposedManifest, ComposedRow, DepthRow, DistributionRow, ErrorParts, MediumRow,
};
use super::numbers::{LayerTask, MOST_SLABS, NumberPlace, SPECTRAL, lights, projected_sr};
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
/// Wavelengths on either side over which the squared error of composing is averaged: that error is
/// smooth, and chance is not.
const NEIGHBOURS: usize = 2;
/// What slabs of half the thickness change, over the error of whole ones. That error falls to a
/// third or less when slabs are twice as thick (*measured* on coherent stacks of 4 to 16 µm: 1.4 to
/// 1.9 % with slabs of 1 µm, 0.4 to 0.6 % of 2 µm, at most 0.03 % of 4 µm), so the change is twice
/// the error or more.
const HALVED: f64 = 2.0;
/// Share of unscattered light from which a slab that gives no coefficients is too thin, not too
/// thick, for them.
const CLEAR: f64 = 0.5;
/// Part of a bar of L*, a* or b* from which it is said where it comes from.
const LARGE: f64 = 1.0;

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
    let asked = Layers::new(&question, asked_um, &mut all);
    let curve = Layers::new(&question, &others_um[..CURVE.len()], &mut all);
    let around_hiding = Layers::new(&question, &others_um[CURVE.len()..], &mut all);
    let mut withheld = [asked.withheld, curve.withheld].concat();
    let mut medium = Vec::new();
    for (&nm, slabs) in study.wavelengths_nm.iter().zip(&slabs) {
        medium.push(medium_row(nm, slabs, &mut all, &mut withheld));
    }
    let distributions = distributions(&question, &slabs, &composed.thicknesses_um, &mut all);
    let hiding = if question.hides { all.next() } else { None };
    let hiding = hiding.map(|um| hiding_with_wavelengths(um, &around_hiding.colours));
    let impossible = hiding.and_then(|um| gate::impossible(Quantity::Positive, um.estimate()));
    let hiding_thickness_um = hiding.filter(|_| impossible.is_none());
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
        spectra: asked.rows,
        remarks: [thin_slabs(composed, &medium), far_apart(study, &asked.colours)]
            .into_iter()
            .flatten()
            .collect(),
        colours: asked.colours,
        no_colour,
        distributions,
        withheld,
        curve: curve.rows,
        curve_colours: curve.colours,
        hiding_thickness_um,
        spreading_rate_m2_per_l: hiding_thickness_um.map(spreading_rate),
        no_hiding: no_hiding.or(impossible),
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

/// Wavelengths so far apart that they make up most of a colour's bar.
fn far_apart(study: &Study, colours: &[ComposedColours]) -> Option<String> {
    let all = colours.iter().flat_map(|colours| [colours.natural_light, colours.lit_at_45]).flatten();
    let widest = all.flatten().max_by(|a, b| a.wavelengths.total_cmp(&b.wavelengths))?;
    let nm = &study.wavelengths_nm;
    let apart = nm.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let words = format!(
        "light.wavelengths_nm: found {} wavelengths, up to {apart:.0} nm apart; what spectra may be between them is most of \
         the colours' bars, up to {:.1} in L*, a* or b*: list wavelengths {:.0} nm apart or closer, from 400 to 700 nm",
        nm.len(),
        widest.wavelengths,
        (0.5 * apart).min(20.0)
    );
    let most = widest.wavelengths > LARGE && 2.0 * widest.wavelengths.powi(2) > widest.standard_error.powi(2);
    most.then_some(words)
}

/// The hiding thickness with what the wavelengths leave open of the contrast ratios around it.
fn hiding_with_wavelengths(um: ErrorParts, around: &[ComposedColours]) -> ErrorParts {
    let [below, above] = around else { return um };
    let Some((from, to)) = below.contrast_ratio.zip(above.contrast_ratio) else {
        return ErrorParts { value: f64::NAN, ..um };
    };
    let per_um = (to.value - from.value) / (above.thickness_um - below.thickness_um);
    ErrorParts { wavelengths: from.wavelengths / per_um.abs(), ..um }.summed()
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
        directions: relative(hiding.directions),
        wavelengths: relative(hiding.wavelengths),
    }
}

/// Packings and solves of one portion that have no result.
fn failures((study, collected): &SolvedPortion) -> Vec<String> {
    let words = study.portion().map(|p| p.in_words()).unwrap_or_default();
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
    let moved = question.numbers(whole, Change { grid: true, ..Change::default() });
    let fewer = question.numbers(whole, Change { fewer_directions: true, ..Change::default() });
    let (chance, chance_of_half) = (variances(question, whole, &own), variances(question, half, &own));
    // a single realisation tells nothing about chance
    let is_known = whole.realisations().into_iter().chain(half.realisations()).all(|count| count > 1);
    let by_chance = |k: usize| if is_known { chance[k] + chance_of_half[k] } else { 0.0 };
    let changed: Vec<f64> = (0..own.len()).map(|k| halved[k] - own[k]).collect();
    let by_chance: Vec<f64> = (0..own.len()).map(by_chance).collect();
    let model = errors_of_composing(&question.places(&whole.slabs(Change::default())), &changed, &by_chance);
    let parts = |k: usize| ErrorParts {
        value: own[k],
        chance: chance[k].sqrt(),
        model: model[k],
        grid: (moved[k] - own[k]).abs(),
        directions: (fewer[k] - own[k]).abs(),
        ..ErrorParts::default()
    };
    (0..own.len()).map(|k| parts(k).summed()).collect()
}

/// Jackknife variances over the realisations of every portion.
fn variances(question: &LayerTask, level: &Level, own: &[f64]) -> Vec<f64> {
    let mut variances = vec![0.0; own.len()];
    for (portion, count) in level.realisations().into_iter().enumerate().filter(|(_, count)| *count > 1) {
        let without =
            |r: usize| question.numbers(level, Change { left_out: Some([portion, r]), ..Change::default() });
        let replicates: Vec<Vec<f64>> = (0..count).map(without).collect();
        let n = count as f64;
        for (k, variance) in variances.iter_mut().enumerate() {
            let mean = replicates.iter().map(|x| x[k]).sum::<f64>() / n;
            *variance += (n - 1.0) / n * replicates.iter().map(|x| (x[k] - mean).powi(2)).sum::<f64>();
        }
    }
    variances
}

/// The errors of composing, from what slabs of half the thickness change and the variances that
/// this has by chance: of its square beyond them, the mean over a quantity's neighbours in
/// wavelength.
fn errors_of_composing(places: &[NumberPlace], changed: &[f64], by_chance: &[f64]) -> Vec<f64> {
    let beyond = |k: usize| changed[k].powi(2) - by_chance[k];
    let of = |own: &NumberPlace| {
        let near = |other: &NumberPlace| {
            other.series == own.series && other.wavelength.abs_diff(own.wavelength) <= NEIGHBOURS
        };
        let near: Vec<f64> = (0..places.len()).filter(|&k| near(&places[k])).map(beyond).collect();
        (near.iter().sum::<f64>() / near.len() as f64).max(0.0).sqrt() / HALVED
    };
    places.iter().map(of).collect()
}

/// The rows and colours of some thicknesses, and what of them cannot be.
struct Layers {
    rows: Vec<ComposedRow>,
    colours: Vec<ComposedColours>,
    withheld: Vec<Withheld>,
}

impl Layers {
    /// The next of all numbers.
    fn new(question: &LayerTask, thicknesses_um: &[f64], all: &mut impl Iterator<Item = ErrorParts>) -> Self {
        let mut layers = Self { rows: Vec::new(), colours: Vec::new(), withheld: Vec::new() };
        for &um in thicknesses_um {
            let wavelengths_nm = &question.study.wavelengths_nm;
            let spectra: LayerSpectra = wavelengths_nm.iter().map(|_| take(all)).collect();
            let mut rows: Vec<ComposedRow> =
                wavelengths_nm.iter().zip(&spectra).map(|(&nm, numbers)| row(um, nm, numbers)).collect();
            layers.withheld.extend(composed_gate::rows(&mut rows));
            if let Some(eye) = &question.colorimeter {
                let (colours, withheld) = composed_gate::colours(eye, &spectra, &rows, &take(all));
                layers.colours.push(colours);
                layers.withheld.extend(withheld);
            }
            layers.rows.extend(rows);
        }
        layers
    }
}

/// The next numbers of the list.
fn take<const N: usize>(all: &mut impl Iterator<Item = ErrorParts>) -> [ErrorParts; N] {
    let nothing = ErrorParts { value: f64::NAN, ..ErrorParts::default() };
    std::array::from_fn(|_| all.next().unwrap_or(nothing))
}

fn row(thickness_um: f64, wavelength_nm: f64, of: &[ErrorParts; SPECTRAL]) -> ComposedRow {
    ComposedRow {
        thickness_um,
        wavelength_nm,
        reflectance_normal: Some(of[0]),
        transmittance_normal: Some(of[1]),
        reflectance_45: Some(of[2]),
        transmittance_45: Some(of[3]),
        reflectance_diffuse: Some(of[4]),
        transmittance_diffuse: Some(of[5]),
        coherent_transmittance: Some(of[6]),
        mirrored: Some(of[7]),
        natural_light: Some(of[8]),
        lit_at_45: Some(of[9]),
        over_black: Some(of[10]),
        over_white: Some(of[11]),
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
        let remedy = if straight < CLEAR {
            "take thinner slabs or more realisations"
        } else {
            "so clear a slab hardly scatters: take thicker slabs or more realisations"
        };
        let why = format!(
            "{reason} at {wavelength_nm} nm, where a slab passes {straight:.1e} of the light unscattered \
             in the mean of these realisations: {remedy}"
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
    let whole = slabs[w].layer(count as f64);
    let mut rows = vec![row(0.0, [1.0, total(&(&whole.then(&paper).reflection[0] * light))])];
    for k in (1..count).step_by(count.div_ceil(MOST_JOINTS)) {
        let [front, back] = slabs[w].parted(count, k);
        rows.push(row(at(k), front.between(&back.then(&paper), light).map(|flux| total(&flux))));
    }
    rows.push(row(at(count), whole.between(&paper, light).map(|flux| total(&flux))));
    (nm[w], rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is chance alone adds little to a bar; a change that chance does not explain adds half
    /// of it, at all wavelengths near it. *Planted*: chance not taken off.
    #[test]
    fn the_error_of_composing_is_what_chance_does_not_explain() {
        let places: Vec<NumberPlace> =
            (0..40).map(|k| NumberPlace { series: k % 2, wavelength: k / 2 }).collect();
        // differences of two means with a standard error of 0.01 each: a variance of 2e-4
        let chance: Vec<f64> = (0..40).map(|k| 0.01 * 2.0 * ((7 * k + 3) as f64).sin()).collect();
        let by_chance = vec![2e-4; 40];
        let alone = errors_of_composing(&places, &chance, &by_chance);
        let square = alone.iter().map(|error| error * error).sum::<f64>() / 40.0;
        assert!(square.sqrt() < 0.004, "{}", square.sqrt());
        // one series is off by 0.06 besides
        let shifted: Vec<f64> = (0..40).map(|k| chance[k] + if k % 2 == 0 { 0.06 } else { 0.0 }).collect();
        let errors = errors_of_composing(&places, &shifted, &by_chance);
        for k in 0..40 {
            let is_right = if k % 2 == 0 { (0.02..0.04).contains(&errors[k]) } else { errors[k] == alone[k] };
            assert!(is_right, "{k}: {}", errors[k]);
        }
    }
}
