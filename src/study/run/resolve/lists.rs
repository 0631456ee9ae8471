//! Grids of lists of wavelengths that are parts of a longer one, for the slabs of composed layers:
//! on the grid of the longer list, its solves are used again.

use super::Resolved;
use crate::input::study::Study;
use crate::solve::accuracy::grid_error::JUDGEMENT;
use crate::store::{Key, Store};
use std::io;

/// Content hash of a slab with a single wavelength of its list: all that its grid must resolve.
fn key_at(slab: &Study, wavelength_nm: f64) -> Key {
    let packing = Key::of_packing(&slab.packing_request(0));
    let indices = slab.indices(1e-3 * wavelength_nm);
    let method = (&slab.resolution, &slab.solver, &slab.goal, JUDGEMENT);
    Key::of_wave("grid at", &(packing, indices, wavelength_nm, method), slab.vector_wave())
}

/// Notes for every wavelength of a slab the grid that was chosen for its list, unless the
/// wavelength has one.
pub(super) fn keep_for_shorter_lists(
    study: &Study,
    resolved: &Resolved,
    store: &Store<Resolved>,
) -> io::Result<()> {
    if study.portion().is_none() {
        return Ok(());
    }
    for &nm in &study.wavelengths_nm {
        let key = key_at(study, nm);
        if !store.has(key.as_str()) {
            store.put(key.as_str(), resolved)?;
        }
    }
    Ok(())
}

/// The grid on which all wavelengths of a slab were solved before, as parts of a longer list.
pub(super) fn grid_of_longer_list(study: &Study, store: &Store<Resolved>) -> Option<Resolved> {
    study.portion()?;
    let grid_at = |nm: &f64| store.get(key_at(study, *nm).as_str());
    let grids: Vec<Resolved> = study.wavelengths_nm.iter().map(grid_at).collect::<Option<_>>()?;
    let (first, others) = grids.split_first()?;
    others.iter().all(|other| other == first).then_some(*first)
}
