//! The published numbers of a composed layer, with everything that their bars are made of.

use super::errors::{JudgedNumbers, MovedLevels, with_errors};
use super::gate::{self, LayerInColour};
use super::level::{Change, Level, Slabs, SolvedPortion};
use super::numbers::{LayerTask, MOST_SLABS, lights, projected_sr};
use super::prints::prints;
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::plate::{Plate, total};
use crate::appearance::composed::stack::PlateStack;
use crate::appearance::tristimulus::Colorimeter;
use crate::evaluate::gate::impossible;
use crate::evaluate::manifest::composed::{
    AbsorbedRow, ComposedColours, ComposedRow, DensityRow, DepthRow, DistributionRow, LeftOutColours,
    LeftOutNotes, LeftOutRow, MediumRow, SlabNotes,
};
use crate::evaluate::manifest::{
    Count, FailureNote, Manifest, Provenance, PublishedColours, PublishedSpectra,
};
use crate::evaluate::published::{ErrorParts, NumberNote, NumberParts, Quantity, Withheld};
use crate::evaluate::quantities::{
    DensityNumbers, Distribution, HidingNumbers, LayerNumbers, LeftOutNumbers, MediumNumbers,
    ThicknessNumbers,
};
use crate::evaluate::wavelengths::nearest;
use crate::input::study::{Composed, Study};
use crate::run::MovedSolves;

/// Slabs of the curve against thickness, up to a layer that practically no light passes.
const CURVE: [usize; 16] = [2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 256, 1024, 4096];
/// Wavelength of the fluxes against depth, nm: the nearest one of the study is taken.
const SHOWN_NM: f64 = 550.0;
/// Most joints of the profile.
const MOST_JOINTS: usize = 60;
/// Share of unscattered light from which a slab that gives no coefficients is too thin, not too
/// thick, for them.
const CLEAR: f64 = 0.5;
/// Part of a bar of L*, a* or b* from which it is said where it comes from.
const LARGE: f64 = 1.0;

/// All numbers of a composed layer; a reason where too little is solved.
///
/// # Errors
/// A portion without complete realisations, paper without an albedo.
pub fn summarise_slabs<'a>(study: &'a Study, solved: &[SolvedPortion]) -> Result<Manifest<'a>, String> {
    let level = |halved| Level::new(solved, halved).ok_or("not every slab has a complete realisation yet");
    let whole = level(false)?;
    let half = level(true)?;
    let mut task = LayerTask::new(study)?;
    let seen_nm = &study.wavelengths_nm[task.visible.clone()];
    let no_colour = Colorimeter::new(seen_nm).err().map(|error| error.to_string());
    let composed = task.composed;
    let slabs = if task.stack.is_some() { Vec::new() } else { whole.slabs(Change::default()) };
    let stacks = of_stack(&task, [&whole, &half])?;
    let no_hiding = set_curve(&mut task, &slabs).err();
    let moved = moved_levels(study, solved);
    let JudgedNumbers { numbers, replicates } = with_errors(&task, [&whole, &half], moved.as_ref())?;
    let mut requested = Layers::default();
    for (um, layer) in composed.thicknesses_um.iter().zip(&numbers.requested) {
        requested.add(&task, *um, layer);
    }
    let mut curve = Layers::default();
    for (um, layer) in task.curve_um.iter().zip(&numbers.curve) {
        curve.add(&task, *um, layer);
    }
    let layers: Vec<_> = composed.thicknesses_um.iter().copied().zip(&numbers.requested).collect();
    let prints = prints(study, &layers);
    let mut withheld = [requested.withheld, curve.withheld].concat();
    let mut medium = Vec::new();
    for ((&nm, slabs), numbers) in study.wavelengths_nm.iter().zip(&slabs).zip(numbers.medium) {
        medium.push(medium_row(nm, slabs, numbers, &mut withheld));
    }
    let media = media_of(&slabs, &stacks);
    let distributions = distributions(study, &media, &composed.thicknesses_um, &numbers.distributions);
    let absorbed = absorbed(study, &composed.thicknesses_um, &numbers.absorbed);
    let hiding = task.around_hiding_um.zip(numbers.hiding);
    let hiding = hiding.map(|(around_um, hiding)| hiding_thickness(&task, around_um, &hiding));
    let impossible = hiding.and_then(|um| impossible(Quantity::Positive, um.estimate()));
    let hiding_thickness_um = hiding.filter(|_| impossible.is_none());
    let (depth_nm, depth) = match &task.stack {
        Some(_) => depth_of_stack(&task, &stacks),
        None => depth(&task, &slabs),
    };
    let records = || solved.iter().flat_map(|(_, c)| &c.realisations).flat_map(|r| r.points.iter().flatten());
    let finished = solved.iter().map(|(_, collected)| collected.finished()).sum();
    let solves = Count { asked: study.solves(), finished };
    let remarks = [thin_slabs(composed, &medium), far_apart(seen_nm, &requested.colours)];
    let slabs = SlabNotes {
        composed,
        medium,
        distributions,
        absorbed,
        left_out: LeftOutNotes::new(&task, &numbers.left_out, &mut withheld),
        curve: curve.rows,
        curve_colours: curve.colours,
        curve_numbers: curve.weighted,
        hiding_thickness_um,
        spreading_rate_m2_per_l: hiding_thickness_um.map(spreading_rate),
        no_hiding: no_hiding.or(impossible),
        remarks: remarks.into_iter().flatten().collect(),
        depth,
        depth_nm,
        replicates,
        realisations: solved.iter().map(|(_, c)| c.complete().count()).min().unwrap_or(0),
    };
    Ok(Manifest {
        origin: Provenance::new(study, records(), solves),
        solves,
        failures: solved.iter().flat_map(failures).map(FailureNote::Slab).collect(),
        ensemble: None,
        colours: PublishedColours::Composed(requested.colours),
        no_colour,
        ink_maker: None,
        no_ink_maker: None,
        numbers: requested.weighted,
        prints,
        optics: None,
        withheld,
        spectra: PublishedSpectra::Composed(requested.rows),
        absorbed: Vec::new(),
        slabs: Some(slabs),
        solve_seconds: records().map(|record| record.account.seconds).sum(),
        process_seconds: None,
        study,
    })
}

/// The whole slabs of a few realisations, as they are and with every move of a table; `None` where
/// there are no moves, or some portion has no such realisation yet.
fn moved_levels(study: &Study, solved: &[SolvedPortion]) -> Option<MovedLevels> {
    let moves = study.input_moves();
    let whole = |(portion, _): &&SolvedPortion| portion.portion().is_some_and(|portion| !portion.halved);
    let portions: Vec<&SolvedPortion> = solved.iter().filter(whole).collect();
    let few = |(_, collected): &&SolvedPortion| collected.moved_solves(moves.len());
    let solves = portions.iter().map(few).collect::<Option<Vec<_>>>()?;
    let level = |portions: Vec<SolvedPortion>| Level::new(&portions, false);
    let unmoved = portions.iter().zip(&solves).map(|((study, _), few)| (study.clone(), few.unmoved.clone()));
    let mut moved = Vec::new();
    for (i, by) in moves.iter().enumerate() {
        let of_move =
            |((study, _), few): (&&SolvedPortion, &MovedSolves)| (study.moved(by), few.moved[i].clone());
        moved.push((study.moved(by), level(portions.iter().zip(&solves).map(of_move).collect())?));
    }
    Some(MovedLevels { unmoved: level(unmoved.collect())?, moved })
}

/// The stack of the first thickness at every wavelength, of slabs that are whole; empty for a layer
/// that is alone. Those of half the thickness are tried as well.
fn of_stack(task: &LayerTask, levels: [&Level; 2]) -> Result<Vec<PlateStack>, String> {
    let Some(stack) = &task.stack else { return Ok(Vec::new()) };
    let um = task.composed.thicknesses_um[0];
    stack.stacks(levels[1], um, Change::default())?;
    stack.stacks(levels[0], um, Change::default())
}

/// Sets the thicknesses of the curve, and those around the one that hides; a reason where there is
/// none.
fn set_curve(task: &mut LayerTask, slabs: &[Slabs]) -> Result<(), String> {
    if task.stack.is_some() {
        return Err("of a stack there is the contrast ratio of every thickness".to_owned());
    }
    task.curve_um = CURVE.map(|count| count as f64 * task.composed.slab_um).to_vec();
    find_hiding(task, slabs)
}

/// Media in front of a layer or stack and behind it, at every wavelength.
fn media_of<'s>(slabs: &'s [Slabs], stacks: &'s [PlateStack]) -> Vec<[&'s Hemisphere; 2]> {
    let of_slabs = slabs.iter().map(|slabs| [&slabs.media[0], &slabs.media[2]]);
    of_slabs.chain(stacks.iter().map(|stack| [stack.before(), stack.behind()])).collect()
}

/// What every layer of a stack absorbs.
fn absorbed(study: &Study, thicknesses_um: &[f64], numbers: &[Vec<Vec<ErrorParts>>]) -> Vec<AbsorbedRow> {
    let mut rows = Vec::new();
    for (&thickness_um, spectra) in thicknesses_um.iter().zip(numbers) {
        for (&wavelength_nm, layers) in study.wavelengths_nm.iter().zip(spectra) {
            for (layer, &absorptance_normal) in study.stack.iter().zip(layers) {
                let layer = layer.name.clone();
                rows.push(AbsorbedRow { thickness_um, wavelength_nm, layer, absorptance_normal });
            }
        }
    }
    rows
}

impl LeftOutNotes {
    fn new(task: &LayerTask, numbers: &[LeftOutNumbers<ErrorParts>], withheld: &mut Vec<Withheld>) -> Self {
        let mut all = Self::default();
        for (&um, numbers) in task.composed.thicknesses_um.iter().zip(numbers) {
            for (w, &wavelength_nm) in task.study.wavelengths_nm.iter().enumerate() {
                for (k, layer) in task.study.stack.iter().enumerate() {
                    let without = numbers.without[k].spectra[w];
                    let alone = numbers.alone[k].spectra[w];
                    all.rows.push(LeftOutRow {
                        thickness_um: um,
                        wavelength_nm,
                        layer: layer.name.clone(),
                        lit_at_45_without: without.lit_at_45,
                        natural_light_without: without.natural_light,
                        lit_at_45_alone: alone.lit_at_45,
                        natural_light_alone: alone.natural_light,
                    });
                }
                all.densities.push(density_row([um, wavelength_nm], numbers.densities[w]));
            }
            for (k, layer) in task.study.stack.iter().enumerate() {
                let mut colours = |numbers: &ThicknessNumbers<ErrorParts>, words: &str| {
                    let mut layers = Layers::default();
                    layers.add(task, um, numbers);
                    withheld.extend(layers.withheld.into_iter().map(|reason| Withheld {
                        number: format!("{} {words} {}", reason.number, layer.name),
                        ..reason
                    }));
                    layers.colours.pop()
                };
                let without = colours(&numbers.without[k], "without");
                let alone = colours(&numbers.alone[k], "of only");
                if without.is_some() || alone.is_some() {
                    all.colours.push(LeftOutColours { layer: layer.name.clone(), without, alone });
                }
            }
        }
        all
    }
}

/// Sums of densities below this are too small to divide by.
const FAINT_DENSITY: f64 = 0.05;

fn density_row([thickness_um, wavelength_nm]: [f64; 2], numbers: DensityNumbers<ErrorParts>) -> DensityRow {
    let DensityNumbers { stack, layers, ratio } = numbers;
    DensityRow {
        thickness_um,
        wavelength_nm,
        density_of_stack: stack,
        density_of_layers: layers,
        density_ratio: (layers.value > FAINT_DENSITY).then_some(ratio),
    }
}

/// Fluxes against depth at the joints of a stack of the first thickness, on the paper.
fn depth_of_stack(task: &LayerTask, stacks: &[PlateStack]) -> (f64, Vec<DepthRow>) {
    let nm = &task.study.wavelengths_nm;
    let w = nearest(nm.iter().copied(), SHOWN_NM);
    let stack = &stacks[w];
    let light = &lights(stack.before(), task.study.wave)[0];
    let paper = Plate::lambertian(task.albedos[w], &stack.behind().weights());
    let reflected = total(&(&stack.plate().then(&paper).reflection[0] * light));
    let mut rows = vec![DepthRow { depth_um: 0.0, down: 1.0, up: reflected }];
    for joint in stack.joints(light, &paper) {
        rows.push(DepthRow { depth_um: joint.depth_um, down: joint.down, up: joint.up });
    }
    (nm[w], rows)
}

/// Slabs thinner than the mean free path of coherent light, where that is longest.
fn thin_slabs(composed: &Composed, medium: &[MediumRow]) -> Option<String> {
    let paths = medium.iter().filter_map(|row| Some((row.wavelength_nm, row.medium.coherent_path_um?.value)));
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
fn far_apart(nm: &[f64], colours: &[ComposedColours]) -> Option<String> {
    let all = colours.iter().flat_map(|colours| [colours.natural_light, colours.lit_at_45]).flatten();
    let widest = all.flatten().max_by(|a, b| a.wavelengths.total_cmp(&b.wavelengths))?;
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
fn hiding_thickness(
    task: &LayerTask,
    [below_um, above_um]: [f64; 2],
    hiding: &HidingNumbers<ErrorParts>,
) -> ErrorParts {
    let contrast_ratio = |um: f64, layer: &ThicknessNumbers<ErrorParts>| {
        let mut layers = Layers::default();
        layers.add(task, um, layer);
        layers.colours.first()?.contrast_ratio
    };
    let below = contrast_ratio(below_um, &hiding.below);
    let above = contrast_ratio(above_um, &hiding.above);
    let Some((from, to)) = below.zip(above) else {
        return ErrorParts { value: f64::NAN, ..hiding.thickness_um };
    };
    let per_um = (to.value - from.value) / (above_um - below_um);
    ErrorParts { wavelengths: from.wavelengths / per_um.abs(), ..hiding.thickness_um }.summed()
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
        inputs: relative(hiding.inputs),
    }
}

/// Packings and solves of one portion that have no result.
fn failures((study, collected): &SolvedPortion) -> Vec<String> {
    let words = study.portion().map(|p| p.in_words()).unwrap_or_default();
    let packings = collected.refused.iter().map(|r| (r.realisation, r.reason.clone()));
    let solves = collected.failures().map(|f| (f.point.realisation, f.reason.clone()));
    packings.chain(solves).map(|(r, reason)| format!("{words}, realisation {r}: {reason}")).collect()
}

/// Finds the two thicknesses around the one that hides; the reason if there is none.
fn find_hiding(task: &mut LayerTask, slabs: &[Slabs]) -> Result<(), String> {
    let hides = |count: usize| task.does_hide(slabs, count);
    let reason = "no contrast ratio without a colour";
    if hides(2).ok_or(reason)? {
        return Err(format!("two slabs, {} µm, hide already", 2.0 * task.composed.slab_um));
    }
    let mut most = 4;
    while !hides(most).ok_or(reason)? {
        if most >= MOST_SLABS {
            return Err(format!("{} µm do not hide", MOST_SLABS as f64 * task.composed.slab_um));
        }
        most *= 2;
    }
    let counts: Vec<usize> = (most / 2 + 1..most).collect();
    let first = most / 2 + 1 + counts.partition_point(|&count| hides(count) == Some(false));
    task.around_hiding_um = Some([first - 1, first].map(|count| count as f64 * task.composed.slab_um));
    Ok(())
}

/// The rows and colours of some thicknesses, and what of them cannot be.
#[derive(Default)]
struct Layers {
    rows: Vec<ComposedRow>,
    colours: Vec<ComposedColours>,
    weighted: Vec<NumberNote>,
    withheld: Vec<Withheld>,
}

impl Layers {
    /// Adds a layer of one thickness.
    fn add(&mut self, task: &LayerTask, thickness_um: f64, numbers: &ThicknessNumbers<ErrorParts>) {
        let row = |(&wavelength_nm, numbers): (&f64, &LayerNumbers<ErrorParts>)| ComposedRow {
            thickness_um,
            wavelength_nm,
            layer: numbers.map(Some),
        };
        let all: Vec<ComposedRow> = task.study.wavelengths_nm.iter().zip(&numbers.spectra).map(row).collect();
        let mut kept = all.clone();
        self.withheld.extend(gate::rows(&mut kept, task.daylight.is_some()));
        if let Some((eye, numbers)) = task.colorimeter.as_ref().zip(numbers.colours.as_ref()) {
            let seen = task.visible.clone();
            let layer = LayerInColour { eye, all: &all[seen.clone()], kept: &kept[seen] };
            let (colours, withheld) = layer.colours(numbers);
            self.colours.push(colours);
            self.withheld.extend(withheld);
        }
        self.add_weighted(task, thickness_um, numbers);
        self.rows.extend(kept);
    }
}

impl Layers {
    /// Adds the weighted numbers of a layer of one thickness.
    fn add_weighted(&mut self, task: &LayerTask, thickness_um: f64, numbers: &ThicknessNumbers<ErrorParts>) {
        let values: Vec<LayerNumbers<f64>> =
            numbers.spectra.iter().map(|row| row.map(|number| number.value)).collect();
        for (asked, number) in task.weighted.iter().zip(&numbers.weighted) {
            let spectra = task.weighted_spectra(asked, &values);
            let spectra: Vec<&[f64]> = spectra.iter().map(Vec::as_slice).collect();
            let ErrorParts { value, chance, model, grid, directions, inputs, .. } = *number;
            let wavelengths = asked.wavelength_error(&spectra, &[], true);
            let parts = NumberParts { chance, model, grid, directions, wavelengths, inputs };
            let error = parts.together();
            let impossible = asked.impossible(value, Some(error));
            let possible = impossible.is_none();
            self.weighted.push(NumberNote {
                name: asked.wanted.name.clone(),
                thickness_um: Some(thickness_um),
                value: possible.then_some(value),
                standard_error: possible.then_some(error),
                parts: if possible { parts } else { NumberParts::default() },
                deviations: Vec::new(),
                about: asked.wanted.in_words(),
            });
            self.withheld.extend(impossible.map(|reason| Withheld {
                number: format!("{} of {thickness_um} µm", reason.number),
                ..reason
            }));
        }
    }
}

/// The coefficients of the medium as far as they are possible; the others are withheld.
fn medium_row(
    wavelength_nm: f64,
    slabs: &Slabs,
    numbers: MediumNumbers<ErrorParts>,
    withheld: &mut Vec<Withheld>,
) -> MediumRow {
    // share of light at 0° that an inner slab passes straight on
    let straight = slabs.inner.transmission[0][(0, 0)];
    let remedy = if straight < CLEAR {
        "take thinner slabs or more realisations"
    } else {
        "so clear a slab hardly scatters: take thicker slabs or more realisations"
    };
    let mut medium = numbers.map(Some);
    for number in medium.named() {
        let reason = number.estimate.and_then(|estimate| impossible(number.quantity, estimate));
        let Some(reason) = reason else { continue };
        let reason = format!(
            "{reason} at {wavelength_nm} nm, where a slab passes {straight:.1e} of the light unscattered \
             in the mean of these realisations: {remedy}"
        );
        withheld.push(Withheld { number: number.in_words.to_owned(), reason });
        medium.withhold(number.name);
    }
    let embedding_index = slabs.media[1].ordinates.index;
    // The medium of transport theory has the index of the half-spaces; another one would change the
    // étendue of its light.
    let apart =
        medium.effective_index.map_or(0.0, |index| ((index.value / embedding_index).powi(2) - 1.0).abs());
    let embedded = |number: ErrorParts| number.with_model(apart * number.value.abs());
    let medium = MediumNumbers {
        absorption_per_um: medium.absorption_per_um.map(embedded),
        asymmetry: medium.asymmetry.map(embedded),
        transport_path_um: medium.transport_path_um.map(embedded),
        ..medium
    };
    MediumRow { wavelength_nm, embedding_index, medium }
}

/// Where light at 0° goes, of each requested thickness and wavelength.
fn distributions(
    study: &Study,
    media: &[[&Hemisphere; 2]],
    thicknesses_um: &[f64],
    numbers: &[Vec<Distribution<ErrorParts>>],
) -> Vec<DistributionRow> {
    let mut rows = Vec::new();
    for (&thickness_um, distributions) in thicknesses_um.iter().zip(numbers) {
        for ((&wavelength_nm, [before, behind]), distribution) in
            study.wavelengths_nm.iter().zip(media).zip(distributions)
        {
            let mut add = |reflected: bool, medium: &Hemisphere, lobe: &[ErrorParts]| {
                rows.extend(lobe.iter().enumerate().map(|(node, &bdf_per_sr)| DistributionRow {
                    thickness_um,
                    wavelength_nm,
                    reflected,
                    polar_out_deg: medium.ordinates.polar_deg(node),
                    projected_sr: projected_sr(medium, node),
                    bdf_per_sr,
                }));
            };
            add(true, before, &distribution.reflected);
            add(false, behind, &distribution.transmitted);
        }
    }
    rows
}

/// Fluxes against depth in the first thickness, rounded to whole slabs, on the paper.
fn depth(task: &LayerTask, slabs: &[Slabs]) -> (f64, Vec<DepthRow>) {
    let nm = &task.study.wavelengths_nm;
    let w = nearest(nm.iter().copied(), SHOWN_NM);
    let count = (task.composed.thicknesses_um[0] / task.composed.slab_um).round() as usize;
    let [before, _, behind] = &slabs[w].media;
    let light = &lights(before, task.study.wave)[0];
    let paper = Plate::lambertian(task.albedos[w], &behind.weights());
    let row = |depth_um: f64, [down, up]: [f64; 2]| DepthRow { depth_um, down, up };
    let depth_at = |k: usize| k as f64 * task.composed.slab_um;
    let whole = slabs[w].layer(count as f64);
    let mut rows = vec![row(0.0, [1.0, total(&(&whole.then(&paper).reflection[0] * light))])];
    for k in (1..count).step_by(count.div_ceil(MOST_JOINTS)) {
        let [front, back] = slabs[w].parted(count, k);
        rows.push(row(depth_at(k), front.between(&back.then(&paper), light).map(|flux| total(&flux))));
    }
    rows.push(row(depth_at(count), whole.between(&paper, light).map(|flux| total(&flux))));
    (nm[w], rows)
}
