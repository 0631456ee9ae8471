//! Contents of the report page of a study.

mod figures;
mod ink_maker;
mod limits;
mod tables;

use super::page::{hex, png_data};
use crate::appearance::paper::Coupling;
use crate::draw::OutputError;
use crate::evaluate::manifest::Manifest;
use crate::evaluate::seen::Seen;
use crate::ink::{PigmentGrains, SizeDistribution};
use crate::input::study::{Pigment, Study};
use crate::numerics::estimate::Estimate;
pub(super) use figures::shown_nm;
use minijinja::value::Serde;
use minijinja::{Value, context};
pub(super) use tables::grains;

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
        summary => summary(study),
        picture => picture.map(png_data),
        swatch => manifest.colours.first().map(|note| hex(note.colour.srgb8)),
        figures => Serde(figures),
        grains => Serde(tables::grains(study)),
        packed => tables::packings(study, manifest),
    };
    let [certainty, limits] = [tables::certainty(manifest, seen), limits::limits(study, manifest)];
    let provenance = tables::provenance(study, manifest);
    Ok(context!(..shown, ..certainty, ..limits, ..provenance, ..Value::from(Serde(manifest))))
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

/// The first colour in one line.
pub(super) fn colour_in_words(manifest: &Manifest<&Study>) -> Option<String> {
    let first = manifest.colours.first()?;
    let error = |i: usize| first.lab_standard_error.map(|errors| errors[i]);
    let lab = |i: usize| Estimate { value: first.colour.lab[i], standard_error: error(i) };
    let [l, a, b] = [0, 1, 2].map(|i| lab(i).in_words(2));
    let (chroma, conditions) = (first.chroma.in_words(2), &first.conditions);
    Some(format!("L* {l}, a* {a}, b* {b}, C* {chroma} under {conditions}"))
}
