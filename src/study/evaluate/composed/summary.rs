//! The published numbers of a composed layer, with everything that their bars are made of.

mod depth;
mod hiding;
mod left_out;
pub mod print;
mod remarks;
mod rows;

use super::errors::{JudgedNumbers, MovedLevels, with_errors};
use super::level::{Change, Level, Slabs, SolvedPortion};
use super::numbers::LayerTask;
use super::optics::layer_optics;
use super::prints::prints;
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::stack::PlateStack;
use crate::appearance::tristimulus::Colorimeter;
use crate::evaluate::gate::impossible;
use crate::evaluate::manifest::composed::SlabNotes;
use crate::evaluate::manifest::left_out::LeftOutNotes;
use crate::evaluate::manifest::{
    Count, FailureNote, Manifest, Provenance, PublishedColours, PublishedSpectra,
};
use crate::evaluate::published::Quantity;
use crate::input::study::Study;
use crate::run::MovedSolves;
use depth::{depth, depth_of_stack};
use hiding::{hiding_thickness, set_curve, spreading_rate};
use remarks::{far_apart, thin_slabs};
use rows::{ThicknessRows, absorbed, distributions, lost_in_words, medium_row};

/// All numbers of a composed layer; a reason where too little is solved.
///
/// # Errors
/// A portion without complete realisations, paper without an albedo.
pub fn summarise_slabs<'a>(study: &'a Study, solved: &[SolvedPortion]) -> Result<Manifest<'a>, String> {
    let [whole, half] = levels_of(study, solved)?;
    let mut task = LayerTask::new(study)?;
    let seen_nm = &study.wavelengths_nm[task.visible.clone()];
    let no_colour = Colorimeter::new(seen_nm).err().map(|error| error.to_string());
    let composed = task.composed;
    let slabs = if task.stack.is_some() { Vec::new() } else { whole.slabs(Change::default()) };
    let stacks = of_stack(&task, [&whole, &half])?;
    let no_hiding = set_curve(&mut task, &slabs).err();
    let moved = moved_levels(study, solved);
    let JudgedNumbers { numbers, replicates } = with_errors(&task, [&whole, &half], moved.as_ref())?;
    let requested = ThicknessRows::of(&task, &composed.thicknesses_um, &numbers.requested);
    let curve = ThicknessRows::of(&task, &task.curve_um, &numbers.curve);
    let layers: Vec<_> = composed.thicknesses_um.iter().copied().zip(&numbers.requested).collect();
    let prints = prints(&task, &layers, &whole);
    let mut withheld = [requested.withheld, curve.withheld].concat();
    let mut medium = Vec::new();
    let mut lost = Vec::new();
    for ((&nm, slabs), numbers) in study.wavelengths_nm.iter().zip(&slabs).zip(numbers.medium) {
        medium.push(medium_row(nm, slabs, numbers, &mut lost));
    }
    withheld.extend(lost_in_words(&lost));
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
    let left_out = LeftOutNotes::new(&task, &numbers.left_out, &mut withheld);
    let slabs = SlabNotes {
        composed,
        medium,
        distributions,
        absorbed,
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
        optics: layer_optics(&task, [&whole, &half], moved.as_ref()),
        scalar_surface: study.scalar_surface(),
        withheld,
        spectra: PublishedSpectra::Composed(requested.rows),
        absorbed: Vec::new(),
        left_out,
        slabs: Some(slabs),
        solve_seconds: records().map(|record| record.account.seconds).sum(),
        process_seconds: None,
        study,
    })
}

/// Whole slabs and halved ones; a reason where some portion is not solved yet.
fn levels_of(study: &Study, solved: &[SolvedPortion]) -> Result<[Level; 2], String> {
    let reason = "not every slab has a complete realisation yet";
    let whole = Level::complete(study, solved, false).ok_or(reason)?;
    let half = Level::complete(study, solved, true).ok_or(reason)?;
    Ok([whole, half])
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

/// Media in front of a layer or stack and behind it, at every wavelength.
fn media_of<'s>(slabs: &'s [Slabs], stacks: &'s [PlateStack]) -> Vec<[&'s Hemisphere; 2]> {
    let of_slabs = slabs.iter().map(|slabs| [&slabs.media[0], &slabs.media[2]]);
    of_slabs.chain(stacks.iter().map(|stack| [stack.before(), stack.behind()])).collect()
}

/// Packings and solves of one portion that have no result.
fn failures((study, collected): &SolvedPortion) -> Vec<String> {
    let words = study.portion().map(|p| p.in_words()).unwrap_or_default();
    let packings = collected.refused.iter().map(|r| (r.realisation, r.reason.clone()));
    let solves = collected.failures().map(|f| (f.point.realisation, f.reason.clone()));
    packings.chain(solves).map(|(r, reason)| format!("{words}, realisation {r}: {reason}")).collect()
}
