//! Coverages of one scene on several grids, kept for those who try the same grid again.

use super::discretisation::Discretisation;
use crate::wave::contrast::coverage::EXACT;
use crate::wave::maxwell::NormalMoments;
use crate::wave::{Coverage, Resolution, Scene, WaveError};
use std::sync::{Arc, Mutex, MutexGuard};

/// Kept at most: a result, its two companions, and as many of the grid tried before.
const KEPT: usize = 6;

/// A scene with its latest coverages. Searches try several wavelengths and angles on the same grids; coverage costs
/// more than a solve where grains are small.
pub struct Coverages<'a, G = Coverage> {
    /// The geometry.
    pub scene: &'a Scene,
    /// Relative error of the coefficients, see [`Coverage::within`].
    error: f64,
    /// Asked whether to go on.
    stop: Box<dyn Fn() -> bool + Send + Sync + 'a>,
    latest: Mutex<Vec<Arc<G>>>,
}

impl<'a> Coverages<'a> {
    /// Coverages that are exact for all purposes.
    pub fn of(scene: &'a Scene) -> Self {
        Self::of_any(scene, EXACT)
    }

    /// Coverages with coefficients of a relative error, see [`Coverage::within`].
    pub fn within(scene: &'a Scene, error: f64) -> Self {
        Self::of_any(scene, error)
    }
}

impl<'a> Coverages<'a, NormalMoments> {
    /// For Maxwell's equations, with moments of a relative error, see [`NormalMoments::within`].
    pub fn vector(scene: &'a Scene, error: f64) -> Self {
        Self::of_any(scene, error)
    }
}

impl<'a, G: Discretisation> Coverages<'a, G> {
    /// For any discretisation, with coefficients of a relative error.
    pub fn of_any(scene: &'a Scene, error: f64) -> Self {
        Self { scene, error, stop: Box::new(|| false), latest: Mutex::default() }
    }

    /// The same, given up with [`WaveError::Stopped`] as soon as `stop` says so.
    pub fn unless(self, stop: impl Fn() -> bool + Send + Sync + 'a) -> Self {
        Self { stop: Box::new(stop), ..self }
    }

    /// The coverage on a grid, kept or new.
    ///
    /// # Errors
    /// As [`Coverage::new`].
    pub fn at(&self, resolution: Resolution) -> Result<Arc<G>, WaveError> {
        if let Some(found) = self.kept(resolution) {
            return Ok(found);
        }
        // Made without the lock: parallel loops inside may run other tasks that ask for a coverage.
        let new = Arc::new(G::build(self.scene, resolution, self.error, &*self.stop)?);
        let mut latest = self.lock();
        if latest.len() == KEPT {
            latest.remove(0);
        }
        latest.push(new.clone());
        Ok(new)
    }

    fn kept(&self, resolution: Resolution) -> Option<Arc<G>> {
        let mut latest = self.lock();
        let k = latest.iter().position(|c| c.grid().resolution == resolution)?;
        let found = latest.remove(k);
        latest.push(found.clone());
        Some(found)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Arc<G>>> {
        self.latest.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wave::Scheme;

    #[test]
    fn the_latest_grids_are_kept() {
        let scene = Scene::layer([0.5; 2], 0.4, Vec::new());
        let coverages = Coverages::of(&scene);
        let at = |cells| coverages.at(Resolution { nx: 1, ny: 1, cells, scheme: Scheme::Cubic }).unwrap();
        let first = at(2);
        assert!(Arc::ptr_eq(&first, &at(2)));
        (3..3 + KEPT).for_each(|cells| drop(at(cells)));
        assert!(!Arc::ptr_eq(&first, &at(2)), "older ones make room");
    }

    /// Stopped within the only cell: what is done of it is no coverage.
    #[test]
    fn a_stop_between_two_grains_is_heard() {
        use crate::ink::{PackingRequest, PigmentGrains, pack};
        use std::sync::atomic::{AtomicUsize, Ordering};
        let pigments = vec![PigmentGrains::spheres(100.0, 0.1)];
        let request =
            PackingRequest { period_um: [0.6; 2], thickness_um: 0.3, pigments, ..PackingRequest::default() };
        let scene = Scene::from_packing(&pack(&request, &mut ()).unwrap());
        let asked = AtomicUsize::new(0);
        let coverages = Coverages::of(&scene).unless(|| asked.fetch_add(1, Ordering::Relaxed) >= 3);
        let end = coverages.at(Resolution { nx: 5, ny: 5, cells: 1, scheme: Scheme::Cubic });
        assert_eq!(end.err(), Some(WaveError::Stopped));
        let (asked, grains) = (asked.load(Ordering::Relaxed), scene.bodies.len());
        assert!(asked < grains, "asked {asked} times for {grains} grains");
    }
}
