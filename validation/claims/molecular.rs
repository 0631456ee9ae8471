//! Grains far smaller than the wavelength: the layer becomes homogeneous with ⟨η²⟩.

use crate::claim::{Claim, Findings, Level};
use crate::formulas::films::{Film, amplitudes};
use crate::support::{ball, fitted_slope};
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::{Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
use num_complex::Complex64;
use std::f64::consts::PI;

pub const CLAIM: Claim = Claim {
    id: "10-molecular-limit",
    statement: "As grains shrink at a fixed fraction, the layer tends to the homogeneous one of ⟨η²⟩, quadratically in their size.",
    because: "The scalar equation has k²(x) as its only coefficient, so its homogenised value is the mean; symmetric cells leave a remainder O((k a)²).",
    file: file!(),
    measure,
};

const THICKNESS_UM: f64 = 0.48;
const WAVELENGTH_UM: f64 = 0.6;
const BINDER: f64 = 1.558;
const FRACTION: f64 = 0.3;
const POLAR_DEG: f64 = 30.0;

fn pigment() -> Complex64 {
    Complex64::new(1.4, 0.1)
}

/// Specular (r, t) of a simple cubic lattice of spheres with `layers` layers; the lattice fills the thickness evenly.
fn lattice(layers: usize) -> [Complex64; 2] {
    let a = THICKNESS_UM / layers as f64;
    let radius = a * (3.0 * FRACTION / (4.0 * PI)).cbrt();
    let bodies = (0..layers).map(|i| ball([0.5 * a, 0.5 * a, (i as f64 + 0.5) * a], radius)).collect();
    let scene = Scene::layer([a; 2], THICKNESS_UM, bodies);
    let media = Media {
        incident: 1.0.into(),
        exit: 1.0.into(),
        backgrounds: vec![BINDER.into()],
        inclusions: vec![pigment()],
    };
    let incidence = Incidence {
        wavelength_um: WAVELENGTH_UM,
        polar_deg: POLAR_DEG,
        azimuth_deg: 0.0,
        from: Side::Incident,
    };
    let resolution = Resolution { nx: 16, ny: 16, cells: 6 * layers, scheme: Scheme::default() };
    let problem =
        Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default()).expect("a lattice");
    let goal = Goal { tolerance: 1e-9, ..Goal::default() };
    let field = Gmres::default().solve(&problem, goal, &mut Silent).expect("converges").field;
    let far = problem.far_field(&field);
    [far.specular().reflected, far.specular().transmitted]
}

fn measure(level: Level, findings: &mut Findings) {
    let square = FRACTION * pigment() * pigment() + (1.0 - FRACTION) * BINDER * BINDER;
    let film = Film { index: square.sqrt(), thickness_um: THICKNESS_UM };
    let limit = amplitudes(1.0, &[film], 1.0.into(), WAVELENGTH_UM, POLAR_DEG);
    let layers: &[usize] = level.pick(&[4, 6, 8, 12], &[4, 6, 8, 12, 16, 24]);
    let error = |&n: &usize| {
        let got = lattice(n);
        (n as f64, (got[0] - limit[0]).norm().max((got[1] - limit[1]).norm()))
    };
    let errors: Vec<(f64, f64)> = layers.iter().map(error).collect();
    let smallest = errors.last().map_or(f64::NAN, |e| e.1);
    findings.order(
        "order in the lattice constant",
        fitted_slope(&errors),
        [1.7, 2.4],
        "2 by theory; a line through few sizes",
    );
    let a = THICKNESS_UM / layers[layers.len() - 1] as f64;
    let ka = 2.0 * PI * BINDER * a / WAVELENGTH_UM;
    findings.order_of_smallness(
        "difference of the smallest grains",
        smallest,
        0.005 * ka * ka,
        "(k a)² times an empirical factor, two to three times what is seen",
    );
    let sizes = errors.iter().map(|(n, e)| (1e3 * THICKNESS_UM / n, *e));
    let curve = Curve::new("cubic lattice, 30 %", Style::Data, sizes);
    let guide = Curve::guide("order 2", &curve, 2.0);
    findings.plots.push(Chart::log_log(
        "Towards the molecular limit",
        "lattice constant a, nm",
        "difference to the layer of ⟨η²⟩",
        vec![curve, guide],
    ));
}
