//! Units of work and shards.
//!
//! Variants with the same packings form a group, so that each packing is made once. A unit is one
//! realisation of a group; the workers of a folder take units in turn (see
//! [`crate::store::queue`]). A shard, for machines that do not share a folder, is a range of
//! consecutive units. Groups are ordered by content hash, which mixes expensive and cheap ones; at
//! most one group is split between two neighbouring shards.

use crate::store::identity::Key;
use crate::work::variant::Variant;
use std::collections::BTreeMap;
use std::ops::Range;

/// One realisation of the variants that share its packing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unit {
    /// Index of the group.
    pub group: usize,
    /// Indices of the variants in the list.
    pub variants: Vec<usize>,
    /// Number of the realisation, from 0.
    pub realisation: usize,
}

/// Part `index` (from 1) of `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the part, from 1 to `count`.
    pub index: usize,
    /// Number of parts.
    pub count: usize,
}

impl Shard {
    /// The whole list of variants.
    pub const ALL: Self = Self { index: 1, count: 1 };

    /// The range of `units` in this shard; may be empty if there are more shards than units.
    pub fn range(self, units: usize) -> Range<usize> {
        let up_to = |index: usize| (index as u128 * units as u128 / self.count as u128) as usize;
        up_to(self.index - 1)..up_to(self.index)
    }
}

/// Whether `run.target_delta_e` may end some variant before its last realisation.
pub fn ends_early(variants: &[Variant]) -> bool {
    variants.iter().any(|variant| variant.study.target_delta_e.is_some())
}

/// Groups of variants whose packings are equal in all realisations, ordered by the packings'
/// hashes.
pub fn groups(variants: &[Variant]) -> Vec<Vec<usize>> {
    let mut groups: BTreeMap<Key, Vec<usize>> = BTreeMap::new();
    for (v, variant) in variants.iter().enumerate() {
        groups.entry(variant.study.packings_key()).or_default().push(v);
    }
    groups.into_values().collect()
}

/// All units, group by group.
pub fn units(variants: &[Variant]) -> Vec<Unit> {
    let all: Vec<Range<usize>> = variants.iter().map(|v| 0..v.study.realisations).collect();
    units_within(variants, &all)
}

/// The units of some realisations of each variant, group by group.
pub fn units_within(variants: &[Variant], realisations: &[Range<usize>]) -> Vec<Unit> {
    let groups = groups(variants).into_iter().enumerate();
    groups.flat_map(|(group, members)| units_of(group, &members, realisations)).collect()
}

/// The units of one group.
fn units_of(group: usize, members: &[usize], realisations: &[Range<usize>]) -> Vec<Unit> {
    let first = members.iter().map(|&v| realisations[v].start).min().unwrap_or(0);
    let end = members.iter().map(|&v| realisations[v].end).max().unwrap_or(0);
    let unit = |realisation| Unit {
        group,
        variants: members.iter().copied().filter(|v| realisations[*v].contains(&realisation)).collect(),
        realisation,
    };
    (first..end).map(unit).filter(|unit| !unit.variants.is_empty()).collect()
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
        assert_eq!(Shard { index: usize::MAX, count: usize::MAX }.range(72), 71..72);
    }
}
