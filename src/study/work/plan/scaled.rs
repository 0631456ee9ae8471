//! Estimates the cost of a variant from its size, where no trial finishes in time: unknowns ×
//! operator applications, and spheres to pack.

use super::trial::{Trial, drawn_volume_um3};
use super::usual_grid::usual_grid;
use crate::input::study::Study;
use crate::run::resolve::size;
use crate::work::variant::Variant;
use std::f64::consts::TAU;

/// Core seconds of an operator application and the strategy's own work, per field component and
/// unknown: krylov, inks of 30 % (reports/benchmarks, `study/bdf_point` and `strategy/krylov`).
const APPLICATION: f64 = 4e-8;
/// Core seconds of the coverage per grid point (`geometry/coverage` there).
const COVERAGE: f64 = 1.5e-6;
/// Core seconds to place a sphere, and to relax one among its neighbours (`geometry/packing`
/// there).
const SPHERE: [f64; 2] = [2e-5, 1e-3];
/// Volume fraction above which grains are relaxed.
const RELAXED: f64 = 0.25;
/// Cost of a grid search, in solves including their coverages.
const SEARCH: f64 = 12.0;

/// Estimate for a variant without a trial.
pub(super) fn scaled(variant: &Variant) -> Trial<'_> {
    let study = &variant.study;
    let resolution = usual_grid(study);
    let solve = size(study, resolution).unknowns() * applications(study) * APPLICATION;
    let coverage = (resolution.nx * resolution.ny * resolution.planes()) as f64 * COVERAGE;
    let each = 1.0 / drawn_volume_um3(study, 0);
    Trial {
        variant,
        study: study.clone(),
        packing: packing(study) * each,
        coverage: coverage * each,
        grid: SEARCH * (coverage + solve) * each,
        search: SEARCH,
        has_grid: false,
        solve: solve * each,
        resolution,
        longer_waves: 0.0,
    }
}

/// Operator applications per solve: a constant, plus a term proportional to the phase difference
/// between grains and binder across the layer.
fn applications(study: &Study) -> f64 {
    let um = 1e-3 * study.wavelengths_nm[0];
    let binders: Vec<_> = study.binders().iter().map(|binder| binder.index_at(um)).collect();
    let in_binders = study.materials().zip(study.layers_of_materials());
    let contrasts = in_binders.map(|(material, layer)| (material.index_at(um) - binders[layer]).norm());
    let contrast = contrasts.fold(0.0, f64::max);
    let phase = TAU / um * study.layer.thickness_um * contrast;
    (10.0 + APPLICATIONS_A_RADIAN * phase).min(study.goal.max_applications as f64)
}

/// Applications per radian of that phase: 17 applications for inks of 1.4 + 0.1i, 1 µm, and
/// hundreds for 2 µm of rutile.
const APPLICATIONS_A_RADIAN: f64 = 5.0;

/// Core seconds of one packing, proportional to its spheres.
fn packing(study: &Study) -> f64 {
    let in_layers = study.pigments.iter().zip(study.volumes_of_pigments_um3());
    let spheres =
        in_layers.map(|(p, um3)| p.grains.expected(um3) * p.grains.shape.template().spheres.len() as f64);
    let count: f64 = spheres.sum();
    let share: f64 = study.pigments.iter().map(|p| p.grains.volume_fraction).sum();
    count * SPHERE[usize::from(share > RELAXED)]
}
