//! One of the studies that are worked off together.

use crate::input::study::{Study, Substack};
use std::borrow::Cow;

/// One of the studies that are worked off together, such as one study of a sweep.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Its name, in messages; empty where there is only one.
    pub name: String,
    /// The checked study.
    pub study: Study,
}

/// A single study as a list of one variant.
pub fn of_one(name: &str, study: Study) -> Vec<Variant> {
    vec![Variant { name: name.to_owned(), study }]
}

/// The studies that are solved for these: of a composed layer its slabs, of any other study itself,
/// and behind it the parts of a stack that are asked for.
pub fn solved_for(variants: &[Variant]) -> Cow<'_, [Variant]> {
    let is_alone = |study: &Study| study.composed().is_none() && !study.without_layers;
    if variants.iter().all(|variant| is_alone(&variant.study)) {
        return Cow::Borrowed(variants);
    }
    let mut all = Vec::new();
    for variant in variants {
        let slabs = variant.study.portions();
        if slabs.is_empty() {
            all.push(variant.clone());
        }
        for (k, study) in slabs.into_iter().enumerate() {
            all.push(Variant { name: slab_name(&variant.name, k + 1, &study), study });
        }
        for Substack { name, study } in variant.study.substacks() {
            all.push(Variant { name: format!("{} {name}", variant.name).trim_start().to_owned(), study });
        }
    }
    Cow::Owned(all)
}

/// Name of a slab in messages: its number, or what it is where there is only one layer.
fn slab_name(layer: &str, number: usize, slab: &Study) -> String {
    match slab.portion() {
        Some(portion) if layer.is_empty() => portion.in_words(),
        _ => format!("{layer} slab {number}"),
    }
}
