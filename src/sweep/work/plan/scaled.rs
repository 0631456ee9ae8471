//! What a variant costs by its size alone, where no trial ends in time: unknowns × operator applications, and spheres to pack.

use super::trial::{Trial, density, volume};
use crate::input::study::{Study, WantedResolution};
use crate::run::resolve::size;
use crate::solve::accuracy::smooth_size;
use crate::wave::Resolution;
use std::f64::consts::TAU;

/// Core seconds of an operator application with the strategy's own work, a component of the field and unknown: krylov, inks of
/// 30 % (`study/bdf_point` and `strategy/krylov` of reports/benchmarks).
const APPLICATION: f64 = 4e-8;
/// Core seconds of the coverage a grid point (`geometry/coverage` there).
const COVERAGE: f64 = 1.5e-6;
/// Core seconds of a sphere put down, and of one among relaxing neighbours (`geometry/packing` there).
const SPHERE: [f64; 2] = [2e-5, 1e-3];
/// Volume fraction from which grains are relaxed.
const RELAXED: f64 = 0.25;
/// Solves with their coverages that a search for the grid is worth.
const SEARCH: f64 = 12.0;
/// Points and planes a wavelength in the densest medium at an error of 1e-2, where searches end on inks of 30 %.
const PER_WAVE: [f64; 2] = [4.5, 8.0];

/// Trial of a variant that was not tried.
pub(super) fn scaled(variant: usize, study: &Study) -> Trial {
    let resolution = grid(study);
    let unknowns = size(study, resolution).unknowns();
    let solve = unknowns * applications(study) * APPLICATION;
    let coverage = (resolution.nx * resolution.ny * resolution.planes()) as f64 * COVERAGE;
    let each = 1.0 / volume(study);
    Trial {
        variant,
        period_um: study.layer.period_um,
        thickness_um: study.layer.thickness_um,
        wanted: study.resolution,
        density: density(study),
        packing: packing(study) * each,
        coverage: coverage * each,
        grid: SEARCH * (coverage + solve) * each,
        search: SEARCH,
        solve: solve * each,
        resolution,
        longer_waves: 0.0,
    }
}

/// Points and planes as asked, or as many as the accuracy takes.
fn grid(study: &Study) -> Resolution {
    let scheme = study.resolution.scheme();
    let [points_per_um, planes_per_um] = match study.resolution {
        WantedResolution::Grid { points_per_um, planes_per_um, .. } => [points_per_um, planes_per_um],
        WantedResolution::Accuracy { amplitude, .. } => {
            let (waves, finer) =
                (densest(study) / (1e-3 * study.wavelengths_nm[0]), (1e-2 / amplitude).max(1.0));
            [PER_WAVE[0] * finer.powf(0.25) * waves, PER_WAVE[1] * finer.powf(0.2) * waves]
        }
    };
    let points = |um: f64| smooth_size((points_per_um * um).ceil() as usize);
    let [nx, ny] = if study.pigments.is_empty() { [1, 1] } else { study.layer.period_um.map(points) };
    let cells = (planes_per_um * study.layer.thickness_um / scheme.degree() as f64).ceil().max(1.0) as usize;
    Resolution { nx, ny, cells, scheme }
}

/// Largest |η| of any medium at the shortest wavelength.
fn densest(study: &Study) -> f64 {
    indices(study).map(|eta| eta.norm()).fold(1.0, f64::max)
}

fn indices(study: &Study) -> impl Iterator<Item = num_complex::Complex64> {
    study.indices(1e-3 * study.wavelengths_nm[0]).into_iter()
}

/// Operator applications of a solve: some, and more with the phase that grains and binder differ by through the layer.
fn applications(study: &Study) -> f64 {
    let um = 1e-3 * study.wavelengths_nm[0];
    let binder = study.layer.binder.index_at(um);
    let of = |p: &crate::input::study::Pigment| (p.material.index_at(um) - binder).norm();
    let contrast = study.pigments.iter().map(of).fold(0.0, f64::max);
    let phase = TAU / um * study.layer.thickness_um * contrast;
    (10.0 + APPLICATIONS_A_RADIAN * phase).min(study.goal.max_applications as f64)
}

/// Of that phase: 17 applications for inks of 1.4 + 0.1i, 1 µm, and hundreds for 2 µm of rutile.
const APPLICATIONS_A_RADIAN: f64 = 5.0;

/// Core seconds of one packing: every sphere of every grain, while the other cores wait.
fn packing(study: &Study) -> f64 {
    let spheres = |p: &crate::input::study::Pigment| {
        p.grains.expected(volume(study)) * p.grains.shape.template().spheres.len() as f64
    };
    let count: f64 = study.pigments.iter().map(spheres).sum();
    let share: f64 = study.pigments.iter().map(|p| p.grains.volume_fraction).sum();
    count * SPHERE[usize::from(share > RELAXED)] * rayon::current_num_threads() as f64
}
