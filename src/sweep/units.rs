//! What is computed together, and by whom.
//!
//! Variants with the same packings form a group: its packings are made once. A unit is one realisation of a group.
//! Groups are ordered by their content hash, which mixes costly and cheap ones; a shard is a run of
//! consecutive units, so that at most one group is divided between two neighbouring shards.

use super::load::Sweep;
use crate::store::identity::Key;
use std::collections::BTreeMap;
use std::ops::Range;

/// One realisation of the variants that share its packing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unit {
    pub variants: Vec<usize>,
    pub realisation: usize,
}

/// Part `index` (from 1) of `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    pub index: usize,
    pub count: usize,
}

impl Shard {
    /// The whole sweep.
    pub const ALL: Self = Self { index: 1, count: 1 };

    /// The part of `units` that is this shard's.
    pub fn range(self, units: usize) -> Range<usize> {
        (self.index - 1) * units / self.count..self.index * units / self.count
    }
}

/// Variants with equal packings, in the order of the packings' hashes.
pub fn groups(sweep: &Sweep) -> Vec<Vec<usize>> {
    let mut groups: BTreeMap<Key, Vec<usize>> = BTreeMap::new();
    for (v, variant) in sweep.variants.iter().enumerate() {
        groups.entry(Key::of("packing", &variant.study.packing_request(0))).or_default().push(v);
    }
    groups.into_values().collect()
}

/// All units, group by group.
pub fn units(sweep: &Sweep) -> Vec<Unit> {
    let realisations = |v: &usize| sweep.variants[*v].study.realisations;
    let of_group = |group: Vec<usize>| {
        let most = group.iter().map(realisations).max().unwrap_or(0);
        (0..most).map(move |realisation| Unit {
            variants: group.iter().copied().filter(|v| realisations(v) > realisation).collect(),
            realisation,
        })
    };
    groups(sweep).into_iter().flat_map(of_group).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_disjoint_and_complete() {
        for (units, count) in [(1, 1), (3, 7), (10, 3), (1000, 17)] {
            let parts = (1..=count).flat_map(|index| Shard { index, count }.range(units));
            assert!(parts.eq(0..units), "{units} in {count}");
        }
    }
}
