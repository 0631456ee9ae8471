//! Reads what is stored for a variant, without computing anything.

use crate::input::study::Study;
use crate::run::point::is_physical;
use crate::run::realisation::all_point_keys;
use crate::run::resolve;
use crate::run::resolve::Resolved;
use crate::run::{Collected, Realisation, Refused, Stores};
use crate::store::identity::Key;

/// Everything stored for the first realisations.
pub(super) fn collect_some(study: &Study, stores: &Stores, tried: usize) -> Option<Collected> {
    let resolved = resolve::kept(study, &stores.grids)?;
    let realisations: Vec<Realisation> =
        (0..tried).filter_map(|r| collect_one(study, stores, &resolved, r)).collect();
    let refused = refused(study, stores, tried);
    let (enough, damages) = (false, Vec::new());
    (!realisations.is_empty()).then_some(Collected { resolved, realisations, refused, enough, damages })
}

/// Realisations recorded as having no packing or no grid.
pub(crate) fn refused(study: &Study, stores: &Stores, tried: usize) -> Vec<Refused> {
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
    let missing = keyed.iter().zip(&points).filter(|(_, found)| found.is_none());
    let failures = missing.filter_map(|(keyed, _)| stores.failure(keyed)).collect();
    let finer = points.split_off(study.solves_each());
    Some(Realisation { packing, points, finer, failures })
}

/// Content hash of everything that a realisation's packing and grid depend on.
pub(super) fn stage_key(study: &Study, realisation: usize) -> Key {
    let indices: Vec<_> = study.wavelengths_nm.iter().map(|nm| study.indices(1e-3 * nm)).collect();
    let light = (&study.wavelengths_nm, &study.angles, indices);
    let method = (&study.resolution, &study.solver, &study.goal);
    let inputs = (resolve::key(study), study.packing_request(realisation), light, method);
    Key::of_wave("stage", &inputs, study.vector_wave())
}
