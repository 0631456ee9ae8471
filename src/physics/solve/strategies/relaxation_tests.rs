//! One relaxation step as a full matrix: contraction, and what breaks it.

use super::*;
use crate::ink::Sphere;
use crate::wave::{Body, BodyShape, Incidence, Mean, Media, Resolution, Scene, Scheme, Side};
use faer::Mat;
use num_complex::Complex64;

const SCHEMES: [Scheme; 4] = [Scheme::Tents, Scheme::Quadratic, Scheme::Cubic, Scheme::SecondDifference];

fn problem([nx, ny]: [usize; 2], scheme: Scheme, kappa: f64, absorbing_mean: bool) -> Problem {
    let ball = Sphere { center_um: [0.1, 0.13, 0.12], radius_um: 0.1 };
    let scene = Scene::layer([0.34, 0.3], 0.24, vec![Body::new(BodyShape::Balls(vec![ball]), 0)]);
    let media = Media {
        incident: 1.0.into(),
        exit: 1.2.into(),
        backgrounds: vec![1.5.into()],
        inclusions: vec![Complex64::new(1.8, kappa)],
    };
    let incidence =
        Incidence { wavelength_um: 0.7, polar_deg: 25.0, azimuth_deg: 40.0, from: Side::Incident };
    let mean = Mean { depends_on_z: true, absorbing: absorbing_mean };
    let resolution = Resolution { nx, ny, cells: 2, scheme };
    Problem::from_scene(&scene, &media, &incidence, resolution, mean).expect("a small problem")
}

/// The homogeneous part of a step between states scaled by √D, the norm of the theory.
fn step_matrix(march: &mut March) -> Mat<Complex64> {
    let (planes, points) = march.state.dim();
    let n = planes * points;
    let step = |march: &mut March, unit: Option<usize>| {
        march.state.fill(Complex64::default());
        unit.iter().for_each(|&j| march.state[[j / points, j % points]] = Complex64::ONE);
        march.step();
        march.state.clone()
    };
    let driven = step(march, None);
    let mass = march.shifted.mass.clone();
    let mut matrix = Mat::zeros(n, n);
    for j in 0..n {
        let column = step(march, Some(j)) - &driven;
        for (i, z) in column.iter().enumerate() {
            matrix[(i, j)] = z * (mass[i / points] / mass[j / points]).sqrt();
        }
    }
    matrix
}

fn norm_and_radius(problem: &Problem, tau: f64) -> [f64; 2] {
    let mut march = March::new(problem, tau, &problem.background_wave());
    let matrix = step_matrix(&mut march);
    let radius = matrix.eigenvalues().expect("finite").iter().map(|z| z.norm()).fold(0.0, f64::max);
    [matrix.singular_values().expect("finite")[0], radius]
}

/// Largest |(1 + cV)/(1 − cV)| at any point: above 1 only where Im V < 0.
fn largest_gain(problem: &Problem, tau: f64) -> f64 {
    let contrast = contrasts(problem);
    let largest = contrast.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let c = Complex64::new(0.0, 0.5 * tau / largest);
    contrast.iter().map(|v| ((1.0 + c * v) / (1.0 - c * v)).norm()).fold(0.0, f64::max)
}

#[test]
fn a_step_without_absorption_is_a_contraction() {
    // Theory: a product of Cayley transforms, that of V unitary and that of A a contraction (P2,
    // below (3.13)), so the norm is at most 1 for every τ, and radiation makes every eigenvalue
    // smaller than that.
    for grid in [[5, 3], [6, 3]] {
        for scheme in SCHEMES {
            for tau in [0.5, 6.0, 40.0] {
                let [norm, radius] = norm_and_radius(&problem(grid, scheme, 0.0, false), tau);
                println!("{grid:?} {scheme:?} {tau}: {norm} {radius}");
                // Rounding of some 100 singular values.
                assert!(norm < 1.0 + 1e-12, "{scheme:?} τ = {tau}: norm {norm}");
                // The Nyquist harmonic of even grids carries no field and keeps its size.
                assert!(grid[0] == 6 || radius < 1.0 - 1e-7, "{scheme:?} τ = {tau}: radius {radius}");
            }
        }
    }
}

#[test]
fn with_absorption_a_step_grows_at_most_by_the_contrasts_gain() {
    // The band-limited contrast rings: where Im V < 0 its Cayley factor exceeds 1, and the radius
    // may too, so a plain march can grow slowly. A single point with tents has nothing to ring, and
    // the step contracts.
    for (grid, schemes, rings) in [([5, 3], &SCHEMES[..], true), ([1, 1], &[Scheme::Tents][..], false)] {
        for &scheme in schemes {
            for tau in [0.5, 6.0] {
                let problem = problem(grid, scheme, 0.2, false);
                let [norm, radius] = norm_and_radius(&problem, tau);
                let gain = largest_gain(&problem, tau);
                assert_eq!(gain > 1.0, rings, "{scheme:?}: {gain}");
                // Rounding, as above.
                assert!(norm <= gain.max(1.0) * (1.0 + 1e-12), "{scheme:?} τ = {tau}: {norm} against {gain}");
                assert!(rings || radius < 1.0, "{scheme:?} τ = {tau}: radius {radius}");
            }
        }
    }
}

#[test]
fn a_complex_mean_breaks_the_contraction() {
    for scheme in SCHEMES {
        let [real, complex] =
            [false, true].map(|absorbing| norm_and_radius(&problem([5, 3], scheme, 0.2, absorbing), 6.0));
        println!("{scheme:?}: {real:?} {complex:?}");
        assert!(complex[0] > real[0].max(1.01), "{scheme:?}: {real:?} {complex:?}");
    }
}
