//! Contents of the report page of a study.

mod figures;
mod ink_maker;
mod limits;
mod tables;

use super::page::{hex, png_data};
use crate::draw::OutputError;
use crate::evaluate::manifest::Manifest;
use crate::evaluate::seen::Seen;
use crate::ink::{PigmentGrains, SizeDistribution};
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
pub(super) use figures::shown_nm;
use minijinja::value::Serde;
use minijinja::{Value, context};

/// What the page of a run shows; `picture` is the labelled picture as PNG.
///
/// # Errors
/// A figure cannot be drawn.
pub fn sheet(
    study: &Study,
    manifest: &Manifest<&Study>,
    seen: &Seen,
    picture: Option<&[u8]>,
) -> Result<Value, OutputError> {
    let figures = [figures::figures(study, manifest, seen)?, ink_maker::figures(manifest)?].concat();
    let shown = context! {
        picture => picture.map(png_data),
        swatch => manifest.colours.first().map(|note| hex(note.colour.srgb8)),
        figures => Serde(figures),
        shapes => Serde(shapes(study)),
        packed => tables::packings(study, manifest),
    };
    let [certainty, limits] = [tables::certainty(manifest, seen), limits::limits(study, manifest)];
    let provenance = tables::provenance(study, manifest);
    Ok(context!(..shown, ..certainty, ..limits, ..provenance, ..Value::from(Serde(manifest))))
}

/// Shape and size of the grains of every packed pigment.
pub(super) fn shapes(study: &Study) -> Vec<[String; 2]> {
    let grains = study.pigments.iter().map(|pigment| &pigment.grains);
    grains.map(|grains| [grains.shape.name().to_owned(), size(grains)]).collect()
}

/// The grains' size: one diameter, or the largest.
fn size(grains: &PigmentGrains) -> String {
    match grains.size {
        SizeDistribution::Constant { value_nm, .. } => format!("{value_nm} nm"),
        _ => format!("up to {:.0} nm", grains.size.largest_nm()),
    }
}

/// The first colour in one line.
pub(super) fn colour_in_words(manifest: &Manifest<&Study>) -> Option<String> {
    let first = manifest.colours.first()?;
    let [l, a, b] = [0, 1, 2].map(|i| {
        let standard_error = first.lab_standard_error.map(|errors| errors[i]);
        Estimate { value: first.colour.lab[i], standard_error }.in_words(2)
    });
    let (chroma, conditions) = (first.chroma.in_words(2), &first.conditions);
    Some(format!("L* {l}, a* {a}, b* {b}, C* {chroma} under {conditions}"))
}
