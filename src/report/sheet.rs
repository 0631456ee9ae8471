//! Contents of the report page of a study.

mod figures;
mod ink_maker;
mod limits;
mod tables;

use super::page::{Page, Picture, hex, png_data};
use crate::appearance::paper::{Coupling, MirroredSky};
use crate::draw::OutputError;
use crate::evaluate::manifest::{ColourNote, Manifest, Status};
use crate::evaluate::seen::Seen;
use crate::evaluate::summary::{LIT_AT_45, NATURAL_LIGHT};
use crate::ink::{PigmentGrains, SizeDistribution};
use crate::input::study::{Pigment, Study};
use crate::numerics::estimate::Estimate;
pub(super) use figures::shown_nm;
use minijinja::{Value, context};
pub(super) use tables::asked;

/// The page of a run; `picture` is the labelled picture as PNG.
///
/// # Errors
/// A figure cannot be drawn.
pub fn sheet(
    study: &Study,
    manifest: &Manifest<&Study>,
    seen: &Seen,
    picture: Option<&[u8]>,
) -> Result<Page, OutputError> {
    let picture = picture.map(|png| Picture { data: png_data(png), caption: picture_caption(study) });
    Ok(Page {
        title: study.title.clone(),
        summary: summary(study),
        partial: partial(manifest, seen),
        picture,
        colour: colour_block(manifest),
        figures: [figures::figures(study, manifest, seen)?, ink_maker::figures(manifest)?].concat(),
        ink_maker: manifest.ink_maker.as_ref().map(ink_maker::block),
        certainty: tables::certainty(manifest, seen),
        asked: tables::asked(study),
        packings: tables::packings(study, manifest),
        failures: tables::failures(manifest),
        limits: limits::limits(study, manifest),
        provenance: tables::provenance(study, manifest),
    })
}

/// Share, name, shape and size of a packed pigment.
fn packed(pigment: &Pigment) -> String {
    let (share, shape) = (percent(pigment.grains.volume_fraction), pigment.grains.shape.name());
    let plural = if shape.ends_with('x') { "es" } else { "s" };
    format!("{share} % {} ({shape}{plural} of {})", pigment.name, size(&pigment.grains))
}

pub(super) fn summary(study: &Study) -> String {
    let shares = study.pigments.iter().map(packed);
    let dissolved = study
        .dissolved
        .iter()
        .map(|d| format!("{} % {} (molecular mixture)", percent(d.volume_fraction), d.name));
    let shares: Vec<String> = shares.chain(dissolved).collect();
    let pigments = if shares.is_empty() { "A clear layer".to_owned() } else { shares.join(" and ") };
    let paper = match (study.angles.strata, study.paper.coupling) {
        (0, _) => String::new(),
        (_, Coupling::Gap) => format!(", on paper of albedo {}", study.paper.source),
        (_, Coupling::OpticalContact { .. }) => {
            format!(", in optical contact with paper of albedo {}", study.paper.source)
        }
    };
    format!("{pigments} in a layer {} µm thick{paper}.", study.layer.thickness_um)
}

/// The grains' size: one diameter, or the largest.
fn size(grains: &PigmentGrains) -> String {
    match grains.size {
        SizeDistribution::Constant { value_nm, .. } => format!("{value_nm} nm"),
        _ => format!("up to {:.0} nm", grains.size.largest_nm()),
    }
}

fn percent(share: f64) -> f64 {
    (share * 1e4).round() / 1e2
}

fn partial(manifest: &Manifest<&Study>, seen: &Seen) -> Option<String> {
    if manifest.status == Status::Complete {
        return None;
    }
    let (solves, realisations) = (manifest.solves, manifest.realisations);
    let rest = match &seen.ink {
        Ok(_) => format!("The numbers below are means over {} realisations.", seen.realisations.len()),
        Err(reason) => format!("There is no colour yet: {reason}."),
    };
    Some(format!(
        "{} of {} solves are finished ({} of {} realisations complete). {rest} Run the study again to continue.",
        solves.finished, solves.asked, realisations.finished, realisations.asked
    ))
}

pub(super) fn picture_caption(study: &Study) -> String {
    let sky = match study.output.mirrored_sky {
        MirroredSky::Included => "with the sky it mirrors",
        MirroredSky::Excluded => "without the sky it mirrors",
    };
    format!(
        "Left: the ink under natural light (a uniform sky, {sky}), viewing angle 0° at the top to {max}° at the \
         bottom. Right: π times its diffuse BRDF, viewing angle downwards, illumination angle to the right. A \
         perfect white would be white everywhere.",
        max = study.angles.picture_max_deg
    )
}

/// Colour numbers beside the picture, one column for each condition; the patch is the first one's.
fn colour_block(manifest: &Manifest<&Study>) -> Option<Value> {
    let notes = || manifest.colours.iter();
    let row = |name: &str, of: &dyn Fn(&ColourNote) -> String| context!(name, values => notes().map(of).collect::<Vec<_>>());
    let rows = vec![
        row("L*", &|note| lab(note, 0).in_words(2)),
        row("a*", &|note| lab(note, 1).in_words(2)),
        row("b*", &|note| lab(note, 2).in_words(2)),
        row("C*", &|note| note.chroma.in_words(2)),
        row("h, °", &|note| note.hue_deg.in_words(2)),
        row("sRGB", &|note| note.colour.srgb8.map(|c| c.to_string()).join(" ")),
    ];
    let conditions: Vec<String> = notes().map(|note| note.conditions.clone()).collect();
    let hex = hex(manifest.colours.first()?.colour.srgb8);
    Some(context!(hex, conditions, rows, note => colour_note(manifest)))
}

/// The first colour in one line.
pub(super) fn colour_in_words(manifest: &Manifest<&Study>) -> Option<String> {
    let first = manifest.colours.first()?;
    let [l, a, b] = [0, 1, 2].map(|i| lab(first, i).in_words(2));
    let (chroma, conditions) = (first.chroma.in_words(2), &first.conditions);
    Some(format!("L* {l}, a* {a}, b* {b}, C* {chroma} under {conditions}"))
}

/// L*, a* or b* of a colour.
fn lab(note: &ColourNote, i: usize) -> Estimate {
    let standard_error = note.lab_standard_error.map(|errors| errors[i]);
    Estimate { value: note.colour.lab[i], standard_error }
}

fn colour_note(manifest: &Manifest<&Study>) -> String {
    let mut note = format!(
        "Under {NATURAL_LIGHT}: a uniform sky, seen along the normal; {LIT_AT_45}: lit at 45°, seen along the normal, as \
         prints are measured. CIE 1931 observer, illuminant D65. C* is the chroma, h the hue. The patch shows the first column; ± is one \
         standard error of everything in the budget below."
    );
    let outside: Vec<&str> =
        manifest.colours.iter().filter(|c| c.colour.out_of_gamut).map(|c| c.conditions.as_str()).collect();
    if !outside.is_empty() {
        let line = format!(
            " The colour at {} lies outside sRGB: screens show the nearest colour they can.",
            outside.join(" and ")
        );
        note.push_str(&line);
    }
    note
}
