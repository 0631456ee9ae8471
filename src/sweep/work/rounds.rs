//! How many realisations a variant asks for when it is to end at a wanted bar (`run.target_delta_e`).
//!
//! The bar is looked at after every [`BATCH`] realisations, so that a variant ends at the same
//! realisation whoever runs it. All variants go through their realisations in rounds of that many; what a round is
//! follows from the store alone, so that every process of a folder finds the same. Without a wanted bar there is one
//! round.

use super::stored::{collect_some, stage_key};
use super::units::{Unit, units, units_within};
use crate::evaluate::summary::enough;
use crate::input::study::Study;
use crate::run::Stores;
use crate::run::realisation::point_keys;
use crate::run::resolve;
use crate::run::resolve::Resolved;
use crate::sweep::definition::load::{Sweep, Variant};
use std::ops::Range;

/// Realisations between two looks at the bar: the same for everybody, so that a study ends at the same realisation again.
const BATCH: usize = 8;

/// Where a variant stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Standing {
    /// Realisations up to the next look at the bar, or to the end.
    pub border: usize,
    /// Some of them have not ended.
    pub open: bool,
    /// The bar is reached with them.
    pub enough: bool,
}

impl Standing {
    /// What the store tells of a study whose bar is known to be too wide after `known` realisations.
    pub fn of(study: &Study, stores: &Stores, known: usize) -> Self {
        let all = study.realisations;
        let (closed, wants) = (Self { border: all, open: false, enough: false }, study.target_delta_e);
        if wants.is_none() {
            return closed;
        }
        let first = known / BATCH * BATCH + BATCH;
        for border in (first..all).step_by(BATCH).chain([all]) {
            if !has_ended(study, stores, border) {
                return Self { border, open: true, enough: false };
            }
            // What has no grid, or no packing of so many, has no more to hope for.
            if (0..border).all(|r| has_failed(study, stores, r)) {
                return Self { border, open: false, enough: false };
            }
            if border < all && collect_some(study, stores, border).is_some_and(|c| enough(study, &c)) {
                return Self { border, open: false, enough: true };
            }
        }
        closed
    }
}

impl Standing {
    /// What the store tells now of a variant that was open.
    fn after(self, study: &Study, stores: &Stores) -> Self {
        let border = study.realisations;
        match study.target_delta_e {
            None => Self { border, open: !has_ended(study, stores, border), enough: false },
            Some(_) => Self::of(study, stores, self.border.saturating_sub(BATCH)),
        }
    }

    /// The round that ends at the border.
    fn round(self, study: &Study) -> usize {
        if study.target_delta_e.is_some() { self.border.div_ceil(BATCH) } else { 1 }
    }
}

fn has_failed(study: &Study, stores: &Stores, realisation: usize) -> bool {
    stores.failures.has(stage_key(study, realisation).as_str())
}

/// Whether each of the first realisations has all its solves, or failed.
fn has_ended(study: &Study, stores: &Stores, realisations: usize) -> bool {
    let resolved = resolve::kept(study, &stores.grids);
    let solved = |r: usize| resolved.as_ref().is_some_and(|grid| has_all_solves(study, stores, grid, r));
    let ended = |r: usize| has_failed(study, stores, r) || solved(r);
    // The last ones are the likeliest to be missing.
    (0..realisations).rev().all(ended)
}

/// Whether all solves of a realisation are in the store, with or without a result.
fn has_all_solves(study: &Study, stores: &Stores, resolved: &Resolved, realisation: usize) -> bool {
    let is_kept = |key: &str| stores.points.has(key) || stores.failures.has(key);
    point_keys(study, resolved, realisation).iter().all(|(_, key)| is_kept(key.as_str()))
}

/// The rounds of a sweep, one after the other.
#[derive(Debug)]
pub(super) struct Rounds<'a> {
    sweep: &'a Sweep,
    /// What is known of each variant.
    standings: Vec<Standing>,
}

impl<'a> Rounds<'a> {
    /// Nothing is known yet.
    pub fn new(sweep: &'a Sweep) -> Self {
        let start = Standing { border: 0, open: true, enough: false };
        Self { sweep, standings: vec![start; sweep.variants.len()] }
    }

    /// True when some variant wants a bar.
    pub fn wanted(sweep: &Sweep) -> bool {
        sweep.variants.iter().any(|variant| variant.study.target_delta_e.is_some())
    }

    /// The number of the round under way, from 1, and its units; `None` when all variants have ended.
    pub fn next(&mut self, stores: &Stores) -> Option<(usize, Vec<Unit>)> {
        if !Self::wanted(self.sweep) {
            return Some((1, units(self.sweep)));
        }
        for (variant, standing) in self.sweep.variants.iter().zip(&mut self.standings) {
            if standing.open {
                *standing = standing.after(&variant.study, stores);
            }
        }
        let of = |(s, v): (&Standing, &Variant)| s.open.then(|| s.round(&v.study));
        let round = self.standings.iter().zip(&self.sweep.variants).filter_map(of).min()?;
        Some((round, units_within(self.sweep, &self.realisations(round))))
    }

    /// Realisations of each variant in a round; variants without a wanted bar have all of theirs in the first.
    fn realisations(&self, round: usize) -> Vec<Range<usize>> {
        let before = (round - 1) * BATCH;
        let of = |(standing, variant): (&Standing, &Variant)| match variant.study.target_delta_e {
            None if round == 1 => 0..variant.study.realisations,
            None => 0..0,
            Some(_) => before..standing.border.clamp(before, round * BATCH),
        };
        self.standings.iter().zip(&self.sweep.variants).map(of).collect()
    }
}
