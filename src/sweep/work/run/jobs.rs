//! The tasks of a sweep: choosing the grids of groups, and computing units.

use super::super::units::Unit;
use super::{GRIDS_FIRST, Scope, solves_of};
use crate::store::queue::QueuedTask;
use crate::sweep::Sweep;
use std::collections::{BTreeMap, BTreeSet};

/// A task: to compute a unit, or to choose the grids of a group.
pub(super) struct Job {
    /// The unit; if grids are chosen, all variants of the group in their first realisation.
    pub unit: Unit,
    /// Number of the task that chooses the grids; `None` if this one does.
    pub grids: Option<usize>,
}

impl Job {
    pub fn task(&self, sweep: &Sweep) -> QueuedTask {
        let studies = self.unit.variants.iter().map(|v| &sweep.variants[*v].study);
        let cost = match self.grids {
            None => GRIDS_FIRST * studies.map(|study| study.volume_um3()).sum::<f64>(),
            // an estimate until the grid is known
            Some(_) => solves_of(sweep, &self.unit) as f64,
        };
        QueuedTask { cost, after: self.grids }
    }
}

/// The grids of all groups, followed by the units if these are to be solved.
pub(super) fn jobs(units: &[Unit], scope: Scope) -> Vec<Job> {
    let mut groups: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for unit in units {
        groups.entry(unit.group).or_default().extend(&unit.variants);
    }
    let mut jobs = Vec::new();
    for (&group, variants) in &groups {
        let unit = Unit { group, variants: variants.iter().copied().collect(), realisation: 0 };
        jobs.push(Job { unit, grids: None });
    }
    for unit in units.iter().filter(|_| scope == Scope::Solves) {
        jobs.push(Job { unit: unit.clone(), grids: groups.keys().position(|&group| group == unit.group) });
    }
    jobs
}
