//! The medium that slabs are against theories of light among hard spheres.

use super::{CLEAR, FARTHEST};
use crate::claim::{Bound, Findings, Reason};
use crate::formulas::mie::Sphere;
use serde_json::Value;
use std::f64::consts::{PI, TAU};

/// Largest volume fraction at which spheres scatter nearly one by one.
const ONE_BY_ONE: f64 = 0.1;

/// The medium within the slabs scatters as spheres with the structure factor of hard spheres do, and its coherent light
/// fades as quasi-crystalline theory says. Slabs between walls do not: their faces lack grains.
pub fn of_clear_spheres(share: f64, medium: &Value, findings: &mut Findings) {
    let [scattering, forward] = of_spheres(share);
    let single = [("scattering_per_um", scattering), ("transport_path_um", 1.0 / (scattering - forward))];
    let alone =
        "scattering by pairs, beyond the structure factor, is left out of the theory: some φ/3, at 10 % 3 %";
    let mut known: Vec<_> = single.map(|(key, truth)| (key, truth, "standard_error", alone)).to_vec();
    known.retain(|_| share <= ONE_BY_ONE);
    // What slabs of half the thickness change is mostly chance, and would hide a factor 2.
    let coherent = "few packings, and 3 % for the quasi-crystalline theory, whose two pair correlations differ by as much at 10 %";
    let [index, decay] = coherent_wave(share);
    known.push(("coherent_path_um", 1.0 / (2.0 * TAU / WAVELENGTH_UM * decay), "chance", coherent));
    for (key, truth, part, because) in known {
        let own = medium[key]["value"].as_f64().unwrap_or(f64::NAN);
        let error = medium[key][part].as_f64().unwrap_or(f64::NAN);
        findings.check(
            format!("{key} of {} % of spheres: slabs less theory, in errors", 100.0 * share),
            ((own - truth) / error.hypot(THEORY * truth)).abs(),
            Bound::AtMost(FARTHEST),
            Reason::Significance,
            because,
        );
    }
    // The theory's error is a share of what the grains add to the binder's index.
    let [own, error] =
        ["value", "standard_error"].map(|name| medium["effective_index"][name].as_f64().unwrap_or(f64::NAN));
    findings.check(
        format!("index of the mean wave among {} % of spheres: slabs less theory, in errors", 100.0 * share),
        ((own - index) / error.hypot(THEORY * (index - CLEAR.binder))).abs(),
        Bound::AtMost(FARTHEST),
        Reason::Significance,
        "the phase behind an inner slab, and 3 % of the theory's part",
    );
}

/// Wavelength of the case, µm.
const WAVELENGTH_UM: f64 = 0.55;

/// Index of the coherent wave, real and imaginary part, in the quasi-crystalline approximation with the pair correlation
/// of Percus and Yevick; `validation/effective_waves.py` solves its dispersion equation.
fn coherent_wave(share: f64) -> [f64; 2] {
    let data: Value = serde_json::from_str(include_str!("../../data/effective_waves.json")).expect("JSON");
    let number = |value: &Value| value.as_f64().expect("a number");
    let own = |case: &&Value| {
        let wanted = [("diameter_um", 0.25), ("host_index", CLEAR.binder), ("volume_fraction", share)];
        number(&case["sphere_index"][0]) == 2.0 && wanted.iter().all(|(key, x)| number(&case[*key]) == *x)
    };
    let case =
        data["cases"].as_array().and_then(|all| all.iter().find(own)).expect("a case of these spheres");
    assert_eq!(number(&case["wavelength_um"]), WAVELENGTH_UM);
    [0, 1].map(|part| number(&case["effective_index_percus_yevick"][part]))
}

/// Error of the theory of independent scattering with a structure factor at the shares asked for.
const THEORY: f64 = 0.03;

/// k_s and k_s g, 1/µm, of spheres of 250 nm and index 2 at 550 nm: ∫ |f|² S(q) over all directions times their number
/// density, with the structure factor of Percus and Yevick.
fn of_spheres(share: f64) -> [f64; 2] {
    let sphere = Sphere { wavelength_um: 0.55, radius_um: 0.125, index: 2.0.into(), host: CLEAR.binder };
    let mie = sphere.mie();
    let d = 2.0 * sphere.radius_um;
    let density = share / (PI / 6.0 * d.powi(3));
    let steps = 2000;
    (0..steps).fold([0.0; 2], |[all, forward], i| {
        let mu = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(steps);
        let q = mie.k * (2.0 * (1.0 - mu)).sqrt();
        let part =
            density * TAU * 2.0 / f64::from(steps) * mie.scalar(mu).norm_sqr() * percus_yevick(share, q * d);
        [all + part, forward + part * mu]
    })
}

/// S(q) of hard spheres at the volume fraction φ, with x = qd (N. W. Ashcroft and J. Lekner, Phys. Rev. 145 (1966) 83).
fn percus_yevick(share: f64, x: f64) -> f64 {
    let a = (1.0 + 2.0 * share).powi(2) / (1.0 - share).powi(4);
    let b = -6.0 * share * (1.0 + 0.5 * share).powi(2) / (1.0 - share).powi(4);
    let c = 0.5 * share * a;
    // ∫ s² (a + b s + c s³) sin(xs)/(xs) ds over the core, by the midpoint rule
    let steps = 400;
    let core = |i: i32| {
        let s = (f64::from(i) + 0.5) / f64::from(steps);
        let wave = if x * s > 0.0 { (x * s).sin() / (x * s) } else { 1.0 };
        s * s * (a + b * s + c * s.powi(3)) * wave / f64::from(steps)
    };
    1.0 / (1.0 + 24.0 * share * (0..steps).map(core).sum::<f64>())
}
