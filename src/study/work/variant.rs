//! One of the studies that are worked off together.

use crate::input::study::Study;

/// One of the studies that are worked off together, such as one study of a sweep.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Its name, in messages; empty where there is only one.
    pub name: String,
    /// The checked study.
    pub study: Study,
}

/// A single study as a list of one variant; each slab of a composed layer is a variant.
pub fn of_one(name: &str, study: Study) -> Vec<Variant> {
    let slabs = study.portions();
    if slabs.is_empty() {
        return vec![Variant { name: name.to_owned(), study }];
    }
    let numbered = slabs.into_iter().enumerate();
    numbered.map(|(k, study)| Variant { name: format!("{name} slab {}", k + 1), study }).collect()
}
