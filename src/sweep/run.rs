//! Carries a sweep out, or one shard of it.
//!
//! Every solve is in the store before the next begins. What fails is recorded there too and does not stop the
//! rest; it is not tried again before that is asked.

use super::folder;
use super::load::Sweep;
use super::units::{Shard, Unit, units};
use crate::input::study::Study;
use crate::run::realisation::{Packings, RealisationRun};
use crate::run::resolve::resolve;
use crate::run::runner::{Realisation, RunError, RunSettings, Stores, stopped};
use crate::run::watch::RunWatch;
use crate::store::folder::OutputFolder;
use crate::store::identity::Key;
use crate::store::record::FailureRecord;
use crate::wave::Scene;
use std::io;

/// What a run of a sweep has come to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    pub asked: usize,
    pub finished: usize,
    pub failed: usize,
}

/// Number of solves of a shard, those that variants share counted for each of them.
pub fn solves(sweep: &Sweep, shard: Shard) -> usize {
    let units = units(sweep);
    let each =
        |unit: &Unit| unit.variants.iter().map(|&v| sweep.variants[v].study.solves_each()).sum::<usize>();
    units[shard.range(units.len())].iter().map(each).sum()
}

/// Runs a shard into `folder` until it is finished or stopped.
///
/// # Errors
/// Records that cannot be written, or threads that cannot be started; failures of variants are recorded.
pub fn run(
    sweep: &Sweep,
    folder: &OutputFolder,
    shard: Shard,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<Tally, RunError> {
    let stores = folder::stores(folder)?;
    let units = units(sweep);
    let mut tally = Tally { asked: solves(sweep, shard), ..Tally::default() };
    let mut packings: Option<(usize, Packings)> = None;
    for unit in &units[shard.range(units.len())] {
        let first = unit.variants[0];
        let shared = packings.take().filter(|(owner, _)| *owner == first);
        let mut shared =
            shared.map_or_else(|| Packings::new(&sweep.variants[first].study, watch), |(_, p)| p);
        for &v in &unit.variants {
            if watch.stop() {
                return Ok(tally);
            }
            let study = &sweep.variants[v].study;
            let work = Work { study, stores: &stores, settings, watch, realisation: unit.realisation };
            work.go(&sweep.variants[v].name, &mut shared, &mut tally)?;
        }
        packings = Some((first, shared));
    }
    Ok(tally)
}

/// Forgets all failures, so that they are tried again.
pub fn forget_failures(folder: &OutputFolder) -> io::Result<()> {
    match std::fs::remove_dir_all(folder.path().join(folder::FAILURES)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// One realisation of one variant.
struct Work<'a> {
    study: &'a Study,
    stores: &'a Stores,
    settings: RunSettings,
    watch: &'a dyn RunWatch,
    realisation: usize,
}

impl Work<'_> {
    fn go(&self, name: &str, packings: &mut Packings, tally: &mut Tally) -> Result<(), RunError> {
        let key = stage_key(self.study, self.realisation);
        let failures = self.stores.failures.as_ref();
        if failures.is_some_and(|store| store.has(key.as_str())) {
            tally.failed += self.study.solves_each();
            self.watch.kept(self.study, self.study.solves_each());
            return Ok(());
        }
        match self.realise(packings).map_err(stopped) {
            Ok(realisation) => {
                tally.finished += realisation.points.iter().flatten().count();
                tally.failed += realisation.failures.len();
                Ok(())
            }
            Err(RunError::Stopped) => Ok(()),
            Err(error @ (RunError::Packing { .. } | RunError::Resolution(_) | RunError::Wave(_))) => {
                let (variant, reason) = (name.to_owned(), error.to_string());
                self.watch.stage(&format!("{variant}: no result: {reason}"));
                self.watch.kept(self.study, self.study.solves_each());
                tally.failed += self.study.solves_each();
                let record =
                    FailureRecord { variant, realisation: self.realisation, incidence: None, reason };
                failures.map_or(Ok(()), |store| store.put(key.as_str(), &record)).map_err(RunError::Store)
            }
            Err(error) => Err(error),
        }
    }

    fn realise(&self, packings: &mut Packings) -> Result<Realisation, RunError> {
        let scene = |r: usize| packings.get(r).map(|packing| Scene::from_packing(&packing));
        let resolved = resolve(self.study, &self.stores.grids, self.watch, scene)?;
        let Self { study, stores, settings, watch, realisation } = *self;
        RealisationRun { study, resolved: &resolved, stores, settings, watch, realisation }.finish(packings)
    }
}

/// What a realisation's packing and grid depend on.
pub(crate) fn stage_key(study: &Study, realisation: usize) -> Key {
    let indices: Vec<_> = study.wavelengths_nm.iter().map(|nm| study.indices(1e-3 * nm)).collect();
    let light = (&study.wavelengths_nm, &study.angles, indices);
    let method = (&study.resolution, &study.solver, &study.goal);
    Key::of("stage", &(study.packing_request(realisation), light, method))
}
