//! Tiny problems on awkward grids, and small helpers for full matrices.

use inkwave::ink::Sphere;
use inkwave::wave::{
    Body, BodyShape, Field, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side,
};
use num_complex::Complex64;

pub const REAL: Mean = Mean { depends_on_z: true, absorbing: false };
pub const SCHEMES: [Scheme; 5] =
    [Scheme::Cubic, Scheme::Quadratic, Scheme::Quartic, Scheme::Tents, Scheme::SecondDifference];

/// nx, ny, cells, κ, polar, azimuth, side: awkward sizes, absorbing and lossless, normal, oblique and conical.
pub type Setting = (usize, usize, usize, f64, f64, f64, Side);
pub const SETTINGS: [Setting; 6] = [
    (5, 5, 4, 0.1, 0.0, 0.0, Side::Incident),
    (7, 5, 4, 0.0, 25.0, 0.0, Side::Incident),
    (6, 7, 5, 0.05, 40.0, 33.0, Side::Exit),
    (11, 1, 4, 0.0, 10.0, 0.0, Side::Incident),
    (1, 1, 5, 0.2, 60.0, 0.0, Side::Exit),
    (2, 9, 4, 0.1, 0.0, 0.0, Side::Incident),
];

/// A grain of one ball.
pub fn ball(center_um: [f64; 3], radius_um: f64) -> Body {
    Body::new(BodyShape::Balls(vec![Sphere { center_um, radius_um }]), 0)
}

pub fn problem(setting: Setting, scheme: Scheme, mean: Mean) -> Problem {
    problem_of(Complex64::new(1.4, setting.3), setting, scheme, mean)
}

/// The same with grains of another index; that of the binder, 1.5, leaves no contrast.
pub fn problem_of(grains: Complex64, setting: Setting, scheme: Scheme, mean: Mean) -> Problem {
    let (nx, ny, cells, _, polar_deg, azimuth_deg, from) = setting;
    let bodies = match (nx, ny) {
        (1, 1) => vec![Body::new(BodyShape::Sheet { z_um: [0.11, 0.27] }, 0)],
        (_, 1) => {
            vec![Body::new(BodyShape::CylinderY { x_um: 0.1, z_um: 0.2, radius_um: 0.09 }, 0)]
        }
        _ => vec![ball([0.08, 0.12, 0.15], 0.09), ball([0.22, 0.12, 0.3], 0.09)],
    };
    let scene = Scene::layer([0.33, 0.3], 0.4, bodies);
    let media = Media {
        incident: 1.0.into(),
        exit: 1.2.into(),
        backgrounds: vec![1.5.into()],
        inclusions: vec![grains],
    };
    let incidence = Incidence { wavelength_um: 0.75, polar_deg, azimuth_deg, from };
    let resolution = Resolution { nx, ny, cells, scheme };
    Problem::from_scene(&scene, &media, &incidence, resolution, mean).expect("a small problem")
}

/// Numbers of size one without any structure: what a reused buffer might hold.
pub fn garbage(problem: &Problem) -> Field {
    Field::from_shape_fn(problem.shape(), |(i, j)| Complex64::cis((7 * i * i + 13 * j) as f64))
}

/// Largest difference relative to the largest value of `b`.
pub fn distance(a: &Field, b: &Field) -> f64 {
    let largest = |f: &Field| f.iter().map(|z| z.norm()).fold(0.0, f64::max);
    largest(&(a - b)) / largest(b)
}
