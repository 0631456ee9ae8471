//! The tasks of a sweep: choosing the grids of groups, and computing units.

use super::super::units::Unit;
use super::{GRIDS_FIRST, solves_of};
use crate::store::queue::QueuedTask;
use crate::sweep::Sweep;
use std::collections::BTreeMap;

/// The content of a task.
pub(super) enum Job {
    /// Choose the grids of these variants.
    Grids(Vec<usize>),
    /// Compute a unit; the index is that of its group's grids.
    Unit(Unit, usize),
}

impl Job {
    pub fn task(&self, sweep: &Sweep) -> QueuedTask {
        match self {
            Self::Grids(variants) => QueuedTask {
                cost: GRIDS_FIRST
                    * variants.iter().map(|v| sweep.variants[*v].study.volume_um3()).sum::<f64>(),
                after: None,
            },
            // an estimate until the grid is known
            Self::Unit(unit, grids) => {
                QueuedTask { cost: solves_of(sweep, unit) as f64, after: Some(*grids) }
            }
        }
    }
}

/// The grids of all groups, followed by the units.
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
