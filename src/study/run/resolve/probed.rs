//! Test solves, and the grids they require.

use crate::input::study::{Study, WantedResolution};
use crate::input::variation::Draw;
use crate::run::point::Stopper;
use crate::run::watch::RunWatch;
use crate::solve::accuracy::{AccuracyError, Estimated, Task, smooth_size};
use crate::solve::{Coverages, Solver};
use crate::wave::contrast::coverage::Stop;
use crate::wave::{Incidence, Mean, Media, Precision, Resolution, Scene, Scheme};

/// Everything the test solves of one packing borrow.
pub(super) struct Prepared<'a> {
    study: &'a Study,
    coverages: Coverages<'a>,
    solver: Box<dyn Solver>,
    media: Vec<Media>,
    probes: &'a [Incidence],
    /// Maximum memory of one solve, bytes.
    memory: f64,
}

impl<'a> Prepared<'a> {
    pub fn new(
        study: &'a Study,
        scene: &'a Scene,
        probes: &'a [Incidence],
        memory: f64,
        stop: Stop<'a>,
    ) -> Self {
        let media = probes.iter().map(|probe| study.media(probe.wavelength_um)).collect();
        let precision = Precision { error: study.resolution.coverage_error(), stop };
        let coverages = Coverages::new(study.wave, scene, precision);
        Self { study, coverages, solver: study.solver.build(), media, probes, memory }
    }

    pub fn tasks(&self) -> Vec<Task<'_>> {
        let probes = self.media.iter().zip(self.probes);
        probes.map(|(media, incidence)| self.task(media, incidence)).collect()
    }

    /// The task of one test solve.
    fn task<'b>(&'b self, media: &'b Media, incidence: &'b Incidence) -> Task<'b> {
        Task {
            coverages: &self.coverages,
            media,
            incidence,
            mean: Mean::default(),
            scheme: self.study.resolution.scheme(),
            solver: &*self.solver,
            goal: self.study.goal,
            memory: self.memory,
        }
    }
}

/// Tries the grid found so far and refines it for this test solve if the accuracy is to be chosen.
pub(super) fn probe(
    study: &Study,
    draw: &Draw,
    task: &Task,
    before: Option<Resolution>,
    watch: &dyn RunWatch,
) -> Result<Estimated, AccuracyError> {
    let watch = &mut Stopper(watch);
    let accuracy = match study.resolution {
        WantedResolution::Grid { points_per_um, planes_per_um, scheme } => {
            let grid = grid(draw, points_per_um, planes_per_um, scheme);
            return task.solve_with_estimate(grid, watch);
        }
        WantedResolution::Accuracy { amplitude, .. } => amplitude,
    };
    if let Some(resolution) = before {
        let tried = task.solve_with_estimate(resolution, watch)?;
        if tried.error_estimate <= accuracy {
            return Ok(tried);
        }
    }
    let refined = task.solve_to_accuracy(accuracy, watch)?;
    let (fine, Some(coarse)) = (refined.system().grid().resolution, before) else { return Ok(refined) };
    let both = Resolution {
        nx: fine.nx.max(coarse.nx),
        ny: fine.ny.max(coarse.ny),
        cells: fine.cells.max(coarse.cells),
        scheme: fine.scheme,
    };
    if both == fine { Ok(refined) } else { task.solve_with_estimate(both, watch) }
}

/// Grid with at least the requested points and planes per µm, in sizes with fast Fourier
/// transforms.
pub(super) fn grid(draw: &Draw, points_per_um: f64, planes_per_um: f64, scheme: Scheme) -> Resolution {
    let points = draw.period_um.map(|period| smooth_size((points_per_um * period).ceil() as usize));
    let planes = planes_per_um * draw.thickness_um;
    let cells = (planes / scheme.degree() as f64).ceil().max(1.0) as usize;
    Resolution { nx: points[0], ny: points[1], cells, scheme }
}
