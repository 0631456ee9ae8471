//! One solve of a search: inputs and results, and a cache of the coverages of its scene on several
//! grids.

use super::error::Result;
use crate::solve::demand::{Admitted, TooLarge};
use crate::solve::{Account, Goal, Size, Solution, Solver, Watch};
use crate::wave::{
    FarField, Geometry, Incidence, Mean, Media, Precision, Resolution, Scene, Scheme, System, Wave, WaveError,
};
use num_complex::Complex64;
use std::sync::{Mutex, MutexGuard};

/// Everything that defines a solve except the resolution.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The scene, and its geometry on the grids tried.
    pub coverages: &'a Coverages<'a>,
    /// Indices of all media.
    pub media: &'a Media,
    /// The incident light.
    pub incidence: &'a Incidence,
    /// Mean medium of the operator A.
    pub mean: Mean,
    /// Discretisation along z.
    pub scheme: Scheme,
    /// The strategy.
    pub solver: &'a dyn Solver,
    /// Requested residual, and the limit on operator applications.
    pub goal: Goal,
    /// Memory limit of one solve in bytes, including what is held for its companions.
    pub memory: f64,
}

/// One polarisation's problem on a grid, or that of the scalar wave, with its solution.
pub struct Solved {
    /// The discrete problem.
    pub system: Box<dyn System>,
    /// The strategy's result.
    pub solution: Solution,
}

impl Solved {
    /// Far field of the solution.
    pub fn far_field(&self) -> FarField {
        self.system.far_field(&self.solution.field)
    }
}

/// A solve with its error estimate.
pub struct Estimated {
    /// Solutions on the grid chosen: of the scalar wave, or of s and p light.
    pub solved: Vec<Solved>,
    /// Far field of each solution; all have passed the physical checks
    /// ([`FarField::judged`]).
    pub far_fields: Vec<FarField>,
    /// Largest expected error of any complex amplitude considered by
    /// [`largest_difference`](super::largest_difference).
    pub error_estimate: f64,
    /// Contributions of the grid to the estimate: plane, z.
    pub parts: [f64; 2],
    /// Time for coverage and factorisation, s.
    pub seconds_setup: f64,
    /// Time for the companions, s.
    pub seconds_estimate: f64,
}

impl Estimated {
    /// The first problem; the scalar wave has only one.
    pub fn system(&self) -> &dyn System {
        &*self.solved[0].system
    }

    /// Far field of the first polarisation, or of the scalar wave.
    pub fn far_field(&self) -> &FarField {
        &self.far_fields[0]
    }

    /// Combined account of all polarisations: sums of steps, applications and seconds, the larger
    /// residual.
    pub fn account(&self) -> Account {
        let mut joint = self.solved[0].solution.account.clone();
        self.solved[1..].iter().for_each(|solved| joint.join(&solved.solution.account));
        joint
    }
}

impl Task<'_> {
    /// The strategy adapted to the memory available on a grid, with permission to grow into the
    /// rest.
    ///
    /// # Errors
    /// The memory is too small for any variant of the strategy.
    pub fn admitted(&self, resolution: Resolution) -> Result<Admitted<'_>, TooLarge> {
        self.size(resolution).admit(self.solver, self.memory)
    }

    /// The discrete problems on a grid.
    ///
    /// # Errors
    /// Invalid grids, bodies, media or lights.
    pub fn systems(&self, resolution: Resolution) -> Result<Vec<Box<dyn System>>, WaveError> {
        self.coverages.at(resolution)?.systems(self.media, self.incidence, self.mean)
    }

    /// Solves on one grid; returns the solutions and the time for coverage and factorisation, s.
    pub fn solve(&self, resolution: Resolution, watch: &mut dyn Watch) -> Result<(Vec<Solved>, f64)> {
        self.solve_from(None, resolution, watch)
    }

    /// Solves on one grid, with other solutions as initial guesses.
    pub(super) fn solve_from(
        &self,
        guess: Option<&[Solved]>,
        resolution: Resolution,
        watch: &mut dyn Watch,
    ) -> Result<(Vec<Solved>, f64)> {
        let clock = std::time::Instant::now();
        let solver = self.admitted(resolution)?;
        let systems = self.systems(resolution)?;
        let setup = clock.elapsed().as_secs_f64();
        let mut solved = Vec::new();
        for (i, system) in systems.into_iter().enumerate() {
            let start =
                guess.and_then(|known| known[i].system.transferred(&known[i].solution.field, &*system));
            let solution = solver.solver().solve_from(&*system, start.as_ref(), self.goal, watch)?;
            solved.push(Solved { system, solution });
        }
        Ok((solved, setup))
    }

    /// Wavelengths per µm in the densest medium.
    pub(super) fn waves_per_um(&self) -> f64 {
        let backgrounds = self.media.backgrounds.iter().copied();
        backgrounds.chain(self.inclusions()).map(|eta| eta.norm()).fold(1.0, f64::max)
            / self.incidence.wavelength_um
    }

    /// Indices of the bodies' materials.
    pub(super) fn inclusions(&self) -> impl Iterator<Item = Complex64> {
        self.coverages.scene.bodies.iter().map(|b| self.media.index_of(b.material))
    }

    /// Size of a solve on a grid.
    pub(super) fn size(&self, resolution: Resolution) -> Size {
        let Coverages { wave, scene, .. } = *self.coverages;
        Size::new(wave, scene, self.media, self.incidence.wavelength_um, resolution)
    }
}

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
        let asked = asked.load(Ordering::Relaxed);
        let grains = scene.bodies.len();
        assert!(asked < grains, "asked {asked} times for {grains} grains");
    }
}
