//! The layers that benches share: 30 % spheres of 250 nm in a square cell, λ = 0.55 µm, normal incidence.
#![allow(dead_code, reason = "every bench uses its own part")]

use inkwave::ink::pack;
use inkwave::ink::{PackingRequest, PigmentGrains};
use inkwave::numerics::fourier::PlaneFft;
use inkwave::solve::accuracy::smooth_size;
use inkwave::wave::{Coverage, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
use num_complex::Complex64;
use rayon::prelude::*;
use std::sync::Arc;

/// Points per µm of all benches.
pub const POINTS_PER_UM: f64 = 12.0;

pub fn scene(side_um: f64, thickness_um: f64) -> Scene {
    let pigments = vec![PigmentGrains::spheres(250.0, 0.30)];
    let request =
        PackingRequest { period_um: [side_um; 2], thickness_um, pigments, ..PackingRequest::default() };
    Scene::from_packing(&pack(&request, &mut ()).expect("30 % of spheres pack"))
}

pub fn resolution(side_um: f64, cells: usize) -> Resolution {
    let points = smooth_size((POINTS_PER_UM * side_um).round() as usize);
    Resolution { nx: points, ny: points, cells, scheme: Scheme::Cubic }
}

pub fn coverage(side_um: f64, thickness_um: f64, cells: usize) -> Arc<Coverage> {
    Arc::new(Coverage::new(&scene(side_um, thickness_um), resolution(side_um, cells)).expect("coverage"))
}

pub fn problem(coverage: &Arc<Coverage>, kappa: f64, mean: Mean) -> Problem {
    let one = Complex64::ONE;
    let inclusions = vec![Complex64::new(1.4, kappa)];
    let media = Media { incident: one, exit: one, backgrounds: vec![1.558.into()], inclusions };
    let incidence = Incidence { wavelength_um: 0.55, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
    Problem::new(coverage, &media, &incidence, mean).expect("problem")
}

/// One forward and one inverse transform of every plane, on all cores: the floor of an operator application.
pub fn transforms(fft: &PlaneFft, points: usize, planes: usize) {
    let all = 0..points;
    (0..planes).into_par_iter().for_each_init(
        || fft.scratch(),
        |scratch, _| {
            fft.forward(scratch, std::slice::from_ref(&all));
            fft.inverse(scratch, std::slice::from_ref(&all));
        },
    );
}
