//! A cache of the coverages of one scene on several grids.

use crate::wave::{Geometry, Precision, Resolution, Scene, Wave, WaveError};
use std::sync::{Mutex, MutexGuard};

/// Capacity of the cache: a result, its two companions, and the same for the previous grid.
const KEPT: usize = 6;

/// A scene with its latest coverages. Searches use the same grids for several wavelengths and
/// angles, and coverage costs more than a solve for small grains.
pub struct Coverages<'a> {
    /// Wave equation to be solved.
    pub wave: Wave,
    /// The geometry.
    pub scene: &'a Scene,
    precision: Precision<'a>,
    latest: Mutex<Vec<Geometry>>,
}

impl<'a> Coverages<'a> {
    /// A cache for the scalar wave with exact coverages.
    pub fn of(scene: &'a Scene) -> Self {
        Self::new(Wave::Scalar, scene, Precision::EXACT)
    }

    /// A cache for the given wave and precision.
    pub fn new(wave: Wave, scene: &'a Scene, precision: Precision<'a>) -> Self {
        Self { wave, scene, precision, latest: Mutex::default() }
    }

    /// The coverage on a grid, from the cache or newly computed.
    ///
    /// # Errors
    /// See [`Geometry::new`].
    pub fn at(&self, resolution: Resolution) -> Result<Geometry, WaveError> {
        if let Some(found) = self.kept(resolution) {
            return Ok(found);
        }
        // Computed without holding the lock: parallel loops inside may run other tasks that request
        // a coverage.
        let new = Geometry::new(self.wave, self.scene, resolution, self.precision)?;
        let mut latest = self.lock();
        if latest.len() == KEPT {
            latest.remove(0);
        }
        latest.push(new.clone());
        Ok(new)
    }

    fn kept(&self, resolution: Resolution) -> Option<Geometry> {
        let mut latest = self.lock();
        let k = latest.iter().position(|c| c.grid().resolution == resolution)?;
        let found = latest.remove(k);
        latest.push(found.clone());
        Some(found)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Geometry>> {
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
        assert!(std::ptr::eq(first.grid(), at(2).grid()));
        (3..3 + KEPT).for_each(|cells| drop(at(cells)));
        assert!(!std::ptr::eq(first.grid(), at(2).grid()), "older ones make room");
    }

    /// A computation stopped within its only cell returns no coverage.
    #[test]
    fn a_stop_between_two_grains_is_heard() {
        use crate::ink::{PackingRequest, PigmentGrains, pack};
        use std::sync::atomic::{AtomicUsize, Ordering};
        let pigments = vec![PigmentGrains::spheres(100.0, 0.1)];
        let request =
            PackingRequest { period_um: [0.6; 2], thickness_um: 0.3, pigments, ..PackingRequest::default() };
        let scene = Scene::from_packing(&pack(&request, &mut ()).unwrap());
        let asked = AtomicUsize::new(0);
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= 3;
        let precision = Precision { stop: &stop, ..Precision::EXACT };
        let coverages = Coverages::new(Wave::Scalar, &scene, precision);
        let end = coverages.at(Resolution { nx: 5, ny: 5, cells: 1, scheme: Scheme::Cubic });
        assert_eq!(end.err(), Some(WaveError::Stopped));
        let (asked, grains) = (asked.load(Ordering::Relaxed), scene.bodies.len());
        assert!(asked < grains, "asked {asked} times for {grains} grains");
    }
}
