//! Coverages of one scene on several grids, kept for those who try the same grid again.

use crate::wave::{Coverage, Resolution, Scene, WaveError};
use std::sync::{Arc, Mutex};

/// Kept at most: a result, its two companions, and as many of the grid tried before.
const KEPT: usize = 6;

/// A scene with its latest coverages. Searches try several wavelengths and angles on the same grids; coverage costs
/// more than a solve where grains are small.
pub struct Coverages<'a> {
    pub scene: &'a Scene,
    latest: Mutex<Vec<Arc<Coverage>>>,
}

impl<'a> Coverages<'a> {
    pub fn of(scene: &'a Scene) -> Self {
        Self { scene, latest: Mutex::default() }
    }

    /// The coverage on a grid, kept or new.
    ///
    /// # Errors
    /// As [`Coverage::new`].
    pub fn at(&self, resolution: Resolution) -> Result<Arc<Coverage>, WaveError> {
        let mut latest = self.latest.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some(k) = latest.iter().position(|c| c.grid.resolution == resolution) {
            let found = latest.remove(k);
            latest.push(found.clone());
            return Ok(found);
        }
        let new = Arc::new(Coverage::new(self.scene, resolution)?);
        if latest.len() == KEPT {
            latest.remove(0);
        }
        latest.push(new.clone());
        Ok(new)
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
}
