//! Test solves, and the grids they require.

use crate::input::study::{Study, WantedResolution};
use crate::input::variation::Draw;
use crate::numerics::estimate::largest;
use crate::run::point::Stopper;
use crate::run::watch::RunWatch;
use crate::solve::Coverages;
use crate::solve::accuracy::{AccuracyError, Estimated, Task};
use crate::wave::{Incidence, Mean, Media, Precision, Resolution, Scene};

/// One packing for test solves.
pub(super) struct Probing<'a> {
    pub study: &'a Study,
    pub realisation: usize,
    pub draw: Draw,
    pub scene: &'a Scene,
    /// Maximum memory of one solve, bytes.
    pub memory: f64,
    pub watch: &'a dyn RunWatch,
}

impl Probing<'_> {
    /// Runs `work` on test solves.
    pub fn with_tasks<T>(&self, probes: &[Incidence], work: impl FnOnce(&[Task]) -> T) -> T {
        let Self { study, scene, memory, watch, .. } = *self;
        let stop = || watch.stop();
        let precision = Precision { error: study.resolution.coverage_error(), stop: &stop };
        let coverages = Coverages::new(study.wave, scene, precision);
        let solver = study.solver.build();
        let media: Vec<Media> = probes.iter().map(|probe| study.media(probe.wavelength_um)).collect();
        let tasks = media.iter().zip(probes).map(|(media, incidence)| Task {
            coverages: &coverages,
            media,
            incidence,
            mean: Mean::default(),
            scheme: study.resolution.scheme(),
            solver: &*solver,
            goal: study.goal,
            memory,
        });
        work(&tasks.collect::<Vec<_>>())
    }

    /// The grid that suffices for all test solves, and the largest of their error estimates.
    pub fn grid(&self, tasks: &[Task]) -> Result<(Resolution, f64), AccuracyError> {
        let mut resolution = None;
        let mut error_estimate = 0.0_f64;
        for task in tasks {
            let probed = self.refined(task, resolution)?;
            error_estimate = largest([error_estimate, probed.error_estimate]);
            resolution = Some(probed.system().grid().resolution);
        }
        Ok((resolution.ok_or(AccuracyError::Accuracy(f64::NAN))?, error_estimate))
    }

    /// Tries the grid found so far and refines it for this test solve if the accuracy is to be
    /// chosen.
    fn refined(&self, task: &Task, before: Option<Resolution>) -> Result<Estimated, AccuracyError> {
        let watch = &mut Stopper(self.watch);
        if let Some(grid) = self.study.given_grid(&self.draw) {
            return task.solve_with_estimate(grid, watch);
        }
        let WantedResolution::Accuracy { amplitude: accuracy, .. } = self.study.resolution else {
            return Err(AccuracyError::Accuracy(f64::NAN));
        };
        task.solve_to_accuracy_from(before, accuracy, watch)
    }
}
