//! Maxwell's equations: grains far smaller than the wavelength mix by Maxwell Garnett's rule, not to ⟨ε⟩.
//!
//! A simple cubic lattice of balls has a permittivity in closed form (Rayleigh, Phil. Mag. 34 (1892) 481, with the factor of
//! McPhedran and McKenzie, Proc. R. Soc. A 359 (1978) 45): ε/ε_b = 1 + 3f/(1/β − f − 1.305 f^{10/3} (ε_i − ε_b)/(ε_i + 4ε_b/3)),
//! β = (ε_i − ε_b)/(ε_i + 2ε_b); without its last term it is Maxwell Garnett's. Light comes from the binder and leaves into it, so
//! that no ball has an image and the film's faces lie half a lattice constant beyond its outer balls.

use crate::claim::{Claim, Findings, Level};
use crate::support::{ball, fitted_slope};
use crate::vector::{far_fields, order};
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::material::mixing::MixingRule;
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::maxwell::{Averaging, NormalMoments, Polarisation, VectorProblem};
use inkwave::wave::{Incidence, Mean, Media, Resolution, Scene, Scheme, Side};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

pub const CLAIM: Claim = Claim {
    id: "25-maxwell-garnett",
    statement: "Maxwell's equations: as grains shrink at a fixed fraction, s and p light sees the film of the lattice's own permittivity (Maxwell Garnett's and Rayleigh's term), quadratically in their size, and not that of ⟨ε⟩.",
    because: "Rayleigh's lattice sum knows nothing of this scheme; charges on the balls' surfaces, which the scalar wave lacks, make the difference to ⟨ε⟩.",
    file: file!(),
    measure,
};

const THICKNESS_UM: f64 = 0.48;
const WAVELENGTH_UM: f64 = 0.9;
const BINDER: f64 = 1.5;
const FRACTION: f64 = 0.3;
const POLAR_DEG: f64 = 40.0;

fn pigment() -> Complex64 {
    Complex64::new(2.0, 0.1)
}

/// Permittivity of the lattice, and of the plain average.
fn permittivities() -> [Complex64; 2] {
    let host = Complex64::from(BINDER * BINDER);
    let grain = pigment() * pigment();
    let f = FRACTION;
    let beta = (grain - host) / (grain + 2.0 * host);
    let octupole = 1.305 * f.powf(10.0 / 3.0) * (grain - host) / (grain + 4.0 / 3.0 * host);
    [host * (1.0 + 3.0 * f / (1.0 / beta - f - octupole)), f * grain + (1.0 - f) * host]
}

/// Airy's r and t of a film in the binder: E along the plane, or H.
fn film(permittivity: Complex64, polarisation: Polarisation) -> [Complex64; 2] {
    let k0 = TAU / WAVELENGTH_UM;
    let host = Complex64::from(BINDER * BINDER);
    let lateral = host * POLAR_DEG.to_radians().sin().powi(2);
    let normal = |e: Complex64| (e - lateral).sqrt();
    let admittance = |e: Complex64| match polarisation {
        Polarisation::S => normal(e),
        Polarisation::P => normal(e) / e,
    };
    let face = (admittance(host) - admittance(permittivity)) / (admittance(host) + admittance(permittivity));
    let phase = (Complex64::I * k0 * normal(permittivity) * THICKNESS_UM).exp();
    let many = 1.0 - face * face * phase * phase;
    [face * (1.0 - phase * phase) / many, (1.0 - face * face) * phase / many]
}

/// Specular \[r, t\] of `layers` layers of the lattice, s and p.
fn lattice(layers: usize) -> [[Complex64; 2]; 2] {
    let a = THICKNESS_UM / layers as f64;
    let radius = a * (3.0 * FRACTION / (4.0 * PI)).cbrt();
    let bodies = (0..layers).map(|i| ball([0.5 * a, 0.5 * a, (i as f64 + 0.5) * a], radius)).collect();
    let scene = Scene::layer([a; 2], THICKNESS_UM, bodies);
    let binder = Complex64::from(BINDER);
    let media = Media {
        incident: BINDER.into(),
        exit: binder,
        backgrounds: vec![binder],
        inclusions: vec![pigment()],
    };
    let from = Side::Incident;
    let incidence = Incidence { wavelength_um: WAVELENGTH_UM, polar_deg: POLAR_DEG, azimuth_deg: 0.0, from };
    let resolution = Resolution { nx: 17, ny: 17, cells: 8 * layers, scheme: Scheme::Quadratic };
    let moments = Arc::new(NormalMoments::new(&scene, resolution).expect("a lattice"));
    let problem = VectorProblem::new(&moments, &media, &incidence, Mean::default(), Averaging::Normal);
    let problem = problem.expect("a lattice");
    let goal = Goal { tolerance: 1e-8, ..Goal::default() };
    let fields = Polarisation::BOTH
        .map(|p| Gmres::default().solve(&problem.polarised(p), goal, &mut Silent).expect("converges").field);
    order(&far_fields(&problem, &fields), 0, 0).map(|straight| [straight.reflected, straight.transmitted])
}

fn distance(a: [Complex64; 2], b: [Complex64; 2]) -> f64 {
    (a[0] - b[0]).norm().max((a[1] - b[1]).norm())
}

fn measure(level: Level, findings: &mut Findings) {
    let layers: &[usize] = level.pick(&[3, 4, 6, 8], &[3, 4, 6, 8, 12, 16]);
    let solved: Vec<(usize, [[Complex64; 2]; 2])> = layers.iter().map(|&n| (n, lattice(n))).collect();
    let [own, average] = permittivities();
    let mut curves = Vec::new();
    for (name, polarisation) in ["s", "p"].into_iter().zip(Polarisation::BOTH) {
        let to = |permittivity: Complex64| -> Vec<(f64, f64)> {
            let film = film(permittivity, polarisation);
            solved.iter().map(|(n, got)| (*n as f64, distance(got[polarisation as usize], film))).collect()
        };
        let errors = to(own);
        let others = to(average);
        let because = "2 by theory; a line through few sizes";
        findings.order(
            format!("{name}: order in the lattice constant"),
            fitted_slope(&errors),
            [1.7, 2.6],
            because,
        );
        let share = errors[errors.len() - 1].1 / others[others.len() - 1].1;
        let because = "the two films are that far apart, and (k a)² is small";
        findings.promise(format!("{name}: distance to the own film over that to ⟨ε⟩'s"), share, 0.1, because);
        let sizes = |points: Vec<(f64, f64)>| points.into_iter().map(|(n, e)| (1e3 * THICKNESS_UM / n, e));
        curves.push(Curve::new(format!("{name}, the lattice's own film"), Style::Data, sizes(errors)));
        curves.push(Curve::new(format!("{name}, the film of ⟨ε⟩"), Style::Data, sizes(others)));
    }
    let ruled = MixingRule::MaxwellGarnett.mix(BINDER.into(), &[(FRACTION, pigment())]);
    let rest = (ruled * ruled - own).norm() / (own - average).norm();
    let because = "Rayleigh's next term is of the order of f^{10/3}";
    findings.order_of_smallness(
        "the mixing rule of studies, of the way to ⟨ε⟩",
        rest,
        FRACTION.powf(10.0 / 3.0),
        because,
    );
    let title = "Balls of a lattice as they shrink, Maxwell's equations";
    let size = "lattice constant a, nm";
    findings.plots.push(Chart::log_log(title, size, "difference of r, t", curves));
}
