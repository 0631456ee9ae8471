//! Number of realisations needed until the 95 % interval is below `run.target_delta_e`.
//!
//! The interval is checked after every `BATCH` realisations, so that a variant ends at the same
//! realisation whichever process runs it. All variants proceed in rounds of this size. A round is
//! determined by the store alone, so that all processes of a folder agree on it. Without a target
//! there is a single round.
//!
//! What is stored for a variant is read here without computing anything.

use super::units::{Unit, ends_early, units, units_within};
use crate::evaluate::summary::enough;
use crate::input::study::Study;
use crate::run::point::is_physical;
use crate::run::realisation::all_point_keys;
use crate::run::resolve::{self, Resolved};
use crate::run::{Collected, Realisation, Refused, Stores};
use crate::store::identity::Key;
use crate::store::{FailureRecord, PackingRecord, PointRecord, Record};
use crate::work::variant::Variant;
use std::ops::Range;

/// Realisations between two checks of the interval; fixed, so that a study always ends at the same
/// realisation.
const BATCH: usize = 8;

/// Progress of a variant.
#[derive(Clone, Copy, Debug)]
struct Standing {
    /// Number of realisations up to the next check, or to the end.
    border: usize,
    /// Whether some of these realisations are unfinished.
    open: bool,
    /// Whether the target is reached with these realisations.
    enough: bool,
}

impl Standing {
    /// Reads the progress of a study from the store; its target, if it has one, is known to be
    /// missed after `known` realisations.
    fn of(study: &Study, stores: &Stores, known: usize) -> Self {
        let all = study.realisations;
        let first = study.target_delta_e.map_or(all, |_| known / BATCH * BATCH + BATCH);
        for border in (first..all).step_by(BATCH).chain([all]) {
            if !has_ended(study, stores, border) {
                return Self { border, open: true, enough: false };
            }
            // Stop here: without a grid, or without a packing in this many attempts, more
            // realisations would not help.
            if (0..border).all(|r| has_failed(study, stores, r)) {
                return Self { border, open: false, enough: false };
            }
            if border < all && collect_some(study, stores, border).is_some_and(|c| enough(study, &c)) {
                return Self { border, open: false, enough: true };
            }
        }
        Self { border: all, open: false, enough: false }
    }

    /// The number of realisations with which the target is known to be missed.
    fn known(self) -> usize {
        self.border.saturating_sub(BATCH)
    }

    /// The round that ends at the border.
    fn round(self, study: &Study) -> usize {
        if study.target_delta_e.is_some() { self.border.div_ceil(BATCH) } else { 1 }
    }
}

/// Everything stored for a study; `None` before the first packing and grid.
///
/// A study with `run.target_delta_e` ends with the realisation that reaches it, even if more are
/// stored; it is known to miss it with `known` realisations.
pub fn collect(study: &Study, stores: &Stores, known: usize) -> Option<Collected> {
    let standing = study.target_delta_e.map(|_| Standing::of(study, stores, known));
    let reached = standing.filter(|standing| standing.enough);
    let realisations = reached.map_or(study.realisations, |standing| standing.border);
    let own = collect_some(study, stores, realisations)?;
    let substacks = study.substacks();
    let substacks = substacks.iter().map(|part| collect(&part.study, stores, 0));
    Some(Collected { enough: reached.is_some(), substacks: substacks.collect(), ..own })
}

/// Everything stored for the first realisations.
fn collect_some(study: &Study, stores: &Stores, tried: usize) -> Option<Collected> {
    let resolved = resolve::kept(study, &stores.grids)?;
    let realisations: Vec<Realisation> =
        (0..tried).filter_map(|r| collect_one(study, stores, &resolved, r)).collect();
    let refused = refused(study, stores, tried);
    (!realisations.is_empty()).then_some(Collected {
        resolved,
        realisations,
        refused,
        enough: false,
        substacks: Vec::new(),
        damages: Vec::new(),
    })
}

/// Realisations recorded as having no packing or no grid.
pub fn refused(study: &Study, stores: &Stores, tried: usize) -> Vec<Refused> {
    (0..tried)
        .filter_map(|realisation| {
            let record = stores.failures.get(stage_key(study, realisation).as_str())?;
            Some(Refused { realisation, reason: record.reason })
        })
        .collect()
}

/// Everything stored for a realisation; `None` if it is not packed.
fn collect_one(study: &Study, stores: &Stores, resolved: &Resolved, r: usize) -> Option<Realisation> {
    let packing = stores.packings.get(Key::of_packing(&study.packing_request(r)).as_str())?;
    let keyed = all_point_keys(study, resolved, r);
    let points = keyed.iter().map(|(_, key)| {
        stores.points.get(key.as_str()).filter(|record| is_physical(record, resolved.grid_error))
    });
    let mut points: Vec<_> = points.collect();
    let missing = keyed.iter().zip(&points).filter(|(_, record)| record.is_none());
    let failures = missing.filter_map(|(keyed, _)| stores.failure(keyed)).collect();
    let mut others = points.split_off(study.solves_each());
    let finer: Vec<_> = others.drain(..if study.is_checked(r) { study.solves_each() } else { 0 }).collect();
    let moved = others.chunks(study.solves_each().max(1)).map(<[_]>::to_vec).collect();
    Some(Realisation { packing, points, finer, moved, failures })
}

/// Content hash of what is stored for a study, by the seals of its records, which are not read: it
/// changes where a record is added, lost or replaced by another.
pub fn stored_seals(study: &Study, stores: &Stores) -> Key {
    let database = stores.database();
    let resolved = resolve::kept(study, &stores.grids);
    let mut seals = vec![database.seal(Resolved::KIND, resolve::key(study).as_str())];
    for r in 0..study.realisations {
        let packing = database.seal(PackingRecord::KIND, Key::of_packing(&study.packing_request(r)).as_str());
        if packing.is_none() {
            seals.push(database.seal(FailureRecord::KIND, stage_key(study, r).as_str()));
        }
        seals.push(packing);
        for (_, key) in resolved.iter().flat_map(|resolved| all_point_keys(study, resolved, r)) {
            let point = database.seal(PointRecord::KIND, key.as_str());
            if point.is_none() {
                seals.push(database.seal(FailureRecord::KIND, key.as_str()));
            }
            seals.push(point);
        }
    }
    let substacks = study.substacks();
    if !substacks.is_empty() {
        let of_parts: Vec<Key> = substacks.iter().map(|part| stored_seals(&part.study, stores)).collect();
        return Key::of("stored with substacks", &(seals, of_parts));
    }
    Key::of("stored", &seals)
}

/// Content hash of everything that a realisation's packing and grid depend on.
pub(super) fn stage_key(study: &Study, realisation: usize) -> Key {
    let indices: Vec<_> = study.wavelengths_nm.iter().map(|nm| study.indices(1e-3 * nm)).collect();
    let light = (&study.wavelengths_nm, study.written_angles(), indices);
    let method = (&study.resolution, &study.solver, &study.goal);
    let inputs = (resolve::key(study), study.packing_request(realisation), light, method);
    Key::of_wave("stage", &inputs, study.vector_wave())
}

fn has_failed(study: &Study, stores: &Stores, realisation: usize) -> bool {
    stores.failures.has(stage_key(study, realisation).as_str())
}

/// Whether each of the first realisations is either solved or failed.
fn has_ended(study: &Study, stores: &Stores, realisations: usize) -> bool {
    let resolved = resolve::kept(study, &stores.grids);
    let solved = |r: usize| resolved.as_ref().is_some_and(|grid| has_all_solves(study, stores, grid, r));
    // checked backwards, because the last ones are the most likely to be missing
    (0..realisations).rev().all(|r: usize| has_failed(study, stores, r) || solved(r))
}

/// Whether all solves of a realisation are recorded, with or without a result.
fn has_all_solves(study: &Study, stores: &Stores, resolved: &Resolved, realisation: usize) -> bool {
    let is_kept = |key: &str| stores.points.has(key) || stores.failures.has(key);
    all_point_keys(study, resolved, realisation).iter().all(|(_, key)| is_kept(key.as_str()))
}

/// The rounds of studies that are worked off together.
#[derive(Debug)]
pub(super) struct Rounds<'a> {
    variants: &'a [Variant],
    /// Progress of each variant, as far as known.
    standings: Vec<Standing>,
}

impl<'a> Rounds<'a> {
    /// Starts without any knowledge of the variants.
    pub fn new(variants: &'a [Variant]) -> Self {
        let start = Standing { border: 0, open: true, enough: false };
        Self { variants, standings: vec![start; variants.len()] }
    }

    /// The number of realisations with which each variant is known to miss its target.
    pub fn known(&self) -> Vec<usize> {
        self.standings.iter().map(|standing| standing.known()).collect()
    }

    /// Number of the current round, from 1, and its units; `None` if all variants are finished.
    pub fn next(&mut self, stores: &Stores) -> Option<(usize, Vec<Unit>)> {
        if !ends_early(self.variants) {
            return Some((1, units(self.variants)));
        }
        let mut open = Vec::new();
        for (Variant { study, .. }, standing) in self.variants.iter().zip(&mut self.standings) {
            if standing.open {
                *standing = Standing::of(study, stores, standing.known());
            }
            open.extend(standing.open.then(|| standing.round(study)));
        }
        let round = open.into_iter().min()?;
        Some((round, units_within(self.variants, &self.realisations(round))))
    }

    /// The realisations of each variant in a round; variants without a target have all of theirs in
    /// the first.
    fn realisations(&self, round: usize) -> Vec<Range<usize>> {
        let before = (round - 1) * BATCH;
        let range = |(standing, variant): (&Standing, &Variant)| match variant.study.target_delta_e {
            None if round == 1 => 0..variant.study.realisations,
            None => 0..0,
            Some(_) => before..standing.border.clamp(before, round * BATCH),
        };
        self.standings.iter().zip(self.variants).map(range).collect()
    }
}
