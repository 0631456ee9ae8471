//! The tasks of a sweep: grids of groups, and units.

use super::super::units::Unit;
use super::{GRIDS_FIRST, solves_of};
use crate::store::queue::QueuedTask;
use crate::sweep::Sweep;
use std::collections::BTreeMap;

/// A task of the queue in full.
pub(super) enum Job {
    /// The choice of a group's grids, and the places of the tasks that wait for it.
    Grids(Vec<usize>),
    /// A unit, and the place of its group's grids.
    Unit(Unit, usize),
}

impl Job {
    pub fn task(&self, sweep: &Sweep) -> QueuedTask {
        let volume = |v: &usize| sweep.variants[*v].study.volume_um3();
        match self {
            Self::Grids(variants) => {
                QueuedTask { cost: GRIDS_FIRST * variants.iter().map(volume).sum::<f64>(), after: None }
            }
            // Until the grid is known.
            Self::Unit(unit, grids) => {
                QueuedTask { cost: solves_of(sweep, unit) as f64, after: Some(*grids) }
            }
        }
    }
}

/// Units, and before them the grids of their groups.
pub(super) fn jobs(units: &[Unit]) -> Vec<Job> {
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for unit in units {
        let group = groups.entry(unit.group).or_default();
        group.extend(&unit.variants);
        group.sort_unstable();
        group.dedup();
    }
    let place = |group: usize| groups.keys().position(|&g| g == group).unwrap_or(0);
    let of_unit: Vec<Job> = units.iter().map(|unit| Job::Unit(unit.clone(), place(unit.group))).collect();
    groups.into_values().map(Job::Grids).chain(of_unit).collect()
}
