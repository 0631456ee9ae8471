//! Grains far smaller than the wavelength: the layer's coherent light is that of the layered film of its own profile φ(z).
//!
//! With V = k0²(ε_p − ε_b) and fluctuations of short range the mean field obeys k² + V²∫C(r) e^{ikr}/(4πr) d³r instead of ⟨k²⟩ (second
//! order; the first is the profile itself). For spheres placed independently of each other C is the overlap of two of them,
//! φ(1 − 3r/2d + r³/2d³), so that ε shifts by k0²(ε_p − ε_b)² φ d²/10: quadratic in the size. That hard spheres keep apart
//! only lessens it.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::formulas::films::{Film, amplitudes};
use crate::support::fitted_slope;
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::ink::{Packing, PackingRequest, PigmentGrains, pack};
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::{Coverage, Incidence, Mean, Media, Precision, Problem, Resolution, Scene, Scheme, Side};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

pub const CLAIM: Claim = Claim {
    id: "23-small-grains",
    statement: "A packed layer of small grains has the coherent light of the layered film of its profile φ(z), but for the square of the grains' size.",
    because: "To first order in the contrast only the lateral mean of k² counts; the second order of short-range fluctuations is V²φd²/10 for independent spheres, and less where they keep apart.",
    file: file!(),
    measure,
};

const THICKNESS_UM: f64 = 0.36;
const WAVELENGTH_UM: f64 = 0.7;
const BINDER: f64 = 1.558;
const FRACTION: f64 = 0.3;
const ANGLES_DEG: [f64; 2] = [0.0, 40.0];
/// Slices of the film: far thinner than the smallest grains.
const SLICES: usize = 360;
/// Side of the cell over the grains' diameter.
const SIDE: f64 = 8.0;

fn pigment() -> Complex64 {
    Complex64::new(1.4, 0.1)
}

fn contrast() -> Complex64 {
    pigment() * pigment() - BINDER * BINDER
}

fn packed(diameter: f64, stream: u64) -> Packing {
    let request = PackingRequest {
        period_um: [SIDE * diameter; 2],
        thickness_um: THICKNESS_UM,
        pigments: vec![PigmentGrains::spheres(1e3 * diameter, FRACTION)],
        stream,
        ..PackingRequest::default()
    };
    pack(&request, &mut ()).expect("30 % of spheres pack")
}

/// φ of each slice, from the spheres' caps.
fn profile(packing: &Packing) -> Vec<f64> {
    let [x, y] = packing.period_um();
    let step = THICKNESS_UM / SLICES as f64;
    let below = |z: f64, radius: f64| {
        let z = z.clamp(-radius, radius);
        PI * (radius * radius * z - z * z * z / 3.0)
    };
    let spheres: Vec<_> = packing.grains().iter().flat_map(|g| &g.spheres).collect();
    let share = |slice: usize| {
        let from = slice as f64 * step;
        let to = (slice + 1) as f64 * step;
        let volume = |s: &&inkwave::ink::Sphere| {
            below(to - s.center_um[2], s.radius_um) - below(from - s.center_um[2], s.radius_um)
        };
        spheres.iter().map(volume).sum::<f64>() / (x * y * step)
    };
    (0..SLICES).map(share).collect()
}

/// (r, t) at both angles of the film of a profile whose ε is shifted by `shift` times φ.
fn film(profile: &[f64], shift: Complex64) -> Vec<Complex64> {
    let thickness_um = THICKNESS_UM / SLICES as f64;
    let slice = |phi: &f64| {
        let square = BINDER * BINDER + (contrast() + shift) * phi;
        Film { index: square.sqrt(), thickness_um }
    };
    let films: Vec<Film> = profile.iter().map(slice).collect();
    ANGLES_DEG.iter().flat_map(|&deg| amplitudes(1.0, &films, 1.0.into(), WAVELENGTH_UM, deg)).collect()
}

/// (r, t) of the specular order at both angles, from all grains.
fn solved(packing: &Packing, diameter: f64) -> Vec<Complex64> {
    let cells = (4.0 * THICKNESS_UM / diameter).ceil() as usize;
    let points = 6 * SIDE as usize;
    let resolution = Resolution { nx: points, ny: points, cells, scheme: Scheme::Quadratic };
    let scene = Scene::from_packing(packing);
    let one = Complex64::ONE;
    let media =
        Media { incident: one, exit: one, backgrounds: vec![BINDER.into()], inclusions: vec![pigment()] };
    let coverage = Arc::new(Coverage::with(&scene, resolution, Precision::of(1e-5)).expect("a layer"));
    let coherent = |&polar_deg: &f64| {
        let light =
            Incidence { wavelength_um: WAVELENGTH_UM, polar_deg, azimuth_deg: 15.0, from: Side::Incident };
        let problem = Problem::new(&coverage, &media, &light, Mean::default()).expect("a layer");
        // A hundredth of the smallest difference.
        let goal = Goal { tolerance: 5e-6, ..Goal::default() };
        let field = Gmres::default().solve(&problem, goal, &mut Silent).expect("converges").field;
        let far = problem.far_field(&field);
        [far.specular().reflected, far.specular().transmitted]
    };
    ANGLES_DEG.iter().flat_map(coherent).collect()
}

fn largest(values: impl Iterator<Item = Complex64>) -> f64 {
    values.map(|z| z.norm()).fold(0.0, f64::max)
}

/// Differences of one size, each the mean over packings: from the film of the profile, from the film of the mean fraction, and what
/// independent grains would differ by.
fn differences(diameter: f64, packings: u64) -> [f64; 3] {
    let k0 = TAU / WAVELENGTH_UM;
    let second_order = contrast() * contrast() * (k0 * k0 * diameter * diameter / 10.0);
    let mut sums = [const { Vec::new() }; 3];
    for stream in 0..packings {
        let packing = packed(diameter, stream);
        let found = solved(&packing, diameter);
        let phi = profile(&packing);
        let even = vec![phi.iter().sum::<f64>() / SLICES as f64; SLICES];
        let layered = film(&phi, Complex64::default());
        let even = film(&even, Complex64::default());
        let shifted = film(&phi, second_order);
        let pairs = [[&found, &layered], [&found, &even], [&shifted, &layered]];
        for (sum, [a, b]) in sums.iter_mut().zip(pairs) {
            sum.resize(a.len(), Complex64::default());
            sum.iter_mut().zip(a.iter().zip(b)).for_each(|(s, (a, b))| *s += (a - b) / packings as f64);
        }
    }
    sums.map(|sum| largest(sum.into_iter()))
}

fn measure(level: Level, findings: &mut Findings) {
    let diameters: &[f64] = level.pick(&[0.08, 0.056, 0.04], &[0.08, 0.067, 0.056, 0.047, 0.04, 0.033]);
    // Equal numbers of cells along z for every size: large grains are cheap, and chance falls with the number.
    let packings = |d: f64| (level.pick(6.0, 16.0) * d / 0.04).round() as u64;
    let found: Vec<(f64, [f64; 3])> = diameters.iter().map(|&d| (d, differences(d, packings(d)))).collect();
    let layered: Vec<(f64, f64)> = found.iter().map(|(d, f)| (1.0 / d, f[0])).collect();
    findings.order(
        "order in the grains' size",
        fitted_slope(&layered),
        [1.5, 2.8],
        "2 by theory, between the profile's own 1 and 3, the order of scattered light",
    );
    for (d, [layered, _, independent]) in &found {
        findings.order_of_smallness(
            format!("{:.0} nm: difference from the film of φ(z)", 1e3 * d),
            *layered,
            *independent,
            "the second order of grains placed independently of each other, in the same film",
        );
    }
    if let Some((_, [layered, even, _])) = found.last() {
        findings.check(
            "smallest grains: the film of the mean fraction is farther off, times",
            even / layered,
            Bound::AtLeast(4.0),
            Reason::Order,
            "walls keep grains away: of first order in their size",
        );
    }
    let curve = |name: &str, i: usize| {
        Curve::new(name, Style::Data, found.iter().map(|(d, f)| (1e3 * d, f[i])).collect::<Vec<_>>())
    };
    let layered = curve("film of φ(z)", 0);
    let even = curve("film of the mean fraction", 1);
    let guide = Curve::guide("order 2", &layered, 2.0);
    findings.plots.push(Chart::log_log(
        "Small grains and the layered film",
        "diameter of the grains, nm",
        "difference of the coherent amplitudes",
        vec![layered, even, guide],
    ));
}
