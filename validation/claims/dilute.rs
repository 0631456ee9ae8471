//! One sphere alone: a periodic array in a matched host tends to scalar Mie theory as the cell grows.
//!
//! The array's specular amplitude is T₀₀ e^{−ikH} = 1 + 2πi f(0)/(k L²) + (waves between the spheres); those are of
//! relative size |f|·|S|, S the lattice sum of e^{ikr}/r without the plane waves it radiates. In the static limit
//! S = −3.900/L for a square lattice; the wave's phase turns it with L, so that cells of several sides are averaged
//! and the bound is |f| times the mean of 3.9/L.

use crate::claim::{Claim, Findings, Level};
use crate::formulas::mie::Sphere;
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::{Body, BodyShape, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
use num_complex::Complex64;
use std::f64::consts::TAU;

pub const CLAIM: Claim = Claim {
    id: "09-dilute-limit",
    statement: "Far-apart spheres scatter as one sphere does in scalar Mie theory.",
    because: "The array's specular amplitude tends to 1 + 2πi f(0)/(k L²) (optical theorem); Mie series with 40 digits.",
    file: file!(),
    measure,
};

/// One sphere of `waves.json` with its scattering amplitudes.
pub(super) struct Single {
    pub id: String,
    pub sphere: Sphere,
    /// (cos θ, f).
    pub amplitudes: Vec<(f64, Complex64)>,
}

impl Single {
    /// f(0).
    pub fn forward(&self) -> Complex64 {
        self.amplitudes[0].1
    }
}

pub(super) fn cases() -> Vec<Single> {
    let text = include_str!("../data/waves.json");
    let file: serde_json::Value = serde_json::from_str(text).expect("waves.json is JSON");
    let all = file["cases"].as_array().expect("cases").iter().filter(|c| c["kind"] == "mie_isolated_sphere");
    let pair = |v: &serde_json::Value| Complex64::new(v[0].as_f64().expect("re"), v[1].as_f64().expect("im"));
    let amplitude = |row: &serde_json::Value| {
        (row["theta_deg"].as_f64().expect("an angle").to_radians().cos(), pair(&row["f"]))
    };
    let read = |c: &serde_json::Value| Single {
        id: c["id"].as_str().expect("an id").into(),
        sphere: Sphere {
            wavelength_um: c["inputs"]["wavelength"].as_f64().expect("a wavelength"),
            radius_um: c["inputs"]["radius"].as_f64().expect("a radius"),
            index: pair(&c["inputs"]["eta"]),
            host: c["inputs"]["eta_host"].as_f64().expect("a host"),
        },
        amplitudes: c["outputs"]["amplitude_f"].as_array().expect("angles").iter().map(amplitude).collect(),
    };
    all.map(read).collect()
}

/// Where in its cell the sphere stands, over the side: at no symmetric place, so that lateral phases show.
pub(super) const PLACE: [f64; 2] = [0.3, 0.6];

/// A sphere in a cell of its host, with a grid that resolves it.
pub(super) fn array(sphere: &Sphere, side: f64) -> (Scene, Media, Resolution) {
    let height = 2.2 * sphere.radius_um;
    let ball = inkwave::ink::Sphere {
        center_um: [PLACE[0] * side, PLACE[1] * side, 0.5 * height],
        radius_um: sphere.radius_um,
    };
    let scene = Scene::layer([side; 2], height, vec![Body::new(BodyShape::Balls(vec![ball]), 0)]);
    let host = Complex64::from(sphere.host);
    let media = Media { incident: host, exit: host, backgrounds: vec![host], inclusions: vec![sphere.index] };
    let largest = sphere.index.norm().max(sphere.host);
    // Six points a wavelength, and two points a radius where the sphere is smaller than that.
    let finest = (6.0 * largest / sphere.wavelength_um).max(2.0 / sphere.radius_um);
    let points = inkwave::solve::accuracy::smooth_size((finest * side) as usize);
    let cells = (8.0 * height / sphere.wavelength_um * largest).ceil() as usize + 2;
    (scene, media, Resolution { nx: points, ny: points, cells, scheme: Scheme::Cubic })
}

/// f(0) as the array of period `side` shows it.
fn forward_amplitude(sphere: &Sphere, side: f64) -> Complex64 {
    let (scene, media, resolution) = array(sphere, side);
    let wavelength_um = sphere.wavelength_um;
    let incidence = Incidence { wavelength_um, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
    let problem =
        Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default()).expect("problem");
    let goal = Goal { tolerance: 1e-9, ..Goal::default() };
    let solution = Gmres::default().solve(&problem, goal, &mut Silent).expect("converges");
    let k = TAU / wavelength_um * sphere.host;
    let onwards = Complex64::cis(-k * scene.thickness_um());
    let transmitted = problem.far_field(&solution.field).specular().transmitted * onwards;
    (transmitted - 1.0) * (k * side * side) / (TAU * Complex64::I)
}

fn measure(level: Level, findings: &mut Findings) {
    for single in cases().into_iter().take(level.pick(2, 4)) {
        let count = level.pick(4, 6);
        let forward = single.forward();
        let sides: Vec<f64> =
            (0..count).map(|i| (3.3 + 0.37 * i as f64) * single.sphere.wavelength_um).collect();
        let mean = sides.iter().map(|&s| forward_amplitude(&single.sphere, s)).sum::<Complex64>()
            / sides.len() as f64;
        let error = (mean - forward).norm() / forward.norm();
        let lattice = forward.norm() * sides.iter().map(|s| 3.9 / s).sum::<f64>() / sides.len() as f64;
        findings.order_of_smallness(
            format!("{}: relative error of f(0)", single.id),
            error,
            // Never looser than 2 %: a lost factor or sign must show with strong scatterers, too.
            lattice.min(0.02),
            "waves between the spheres: |f| × 3.9/L, the static lattice sum, but never more than 2 %",
        );
    }
}
