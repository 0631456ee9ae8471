//! Birefringent films, spheres and pairs of spheres against methods that share nothing with the program.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::formulas::uniaxial::{self, UniaxialFilm};
use crate::support::fitted_slope;
use crate::vector::{complex, order, pairs, solve, solve_to};
use inkwave::input::case::Case;
use num_complex::Complex64;
use serde_json::Value;
use std::f64::consts::{PI, TAU};

pub const CLAIM: Claim = Claim {
    id: "48-birefringent",
    statement: "Birefringent films, grains far below the wavelength, single spheres and pairs reflect and transmit both polarisations into both as Berreman's matrices, Rayleigh's tensor and coupled dipoles say.",
    because: "ε = ε_o + (ε_e − ε_o) a aᵀ holds in every grain whatever continues the normals inside it; what is continuous across its surface is the field along it and εE across it.",
    file: file!(),
    measure,
};

/// Optic axes of the films: along z, tilted, in the plane.
const AXES: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [0.48, 0.36, 0.8], [0.6, -0.8, 0.0]];

fn measure(level: Level, findings: &mut Findings) {
    films(level, findings);
    small_sphere(findings);
    dipoles(findings);
}

/// A clear film between two crystals, lit obliquely out of all planes of symmetry.
fn film_case(axis: [f64; 3]) -> (Case, uniaxial::FilmLight, Vec<UniaxialFilm>) {
    let rutile = UniaxialFilm { rays: [2.6.into(), Complex64::new(2.9, 0.02)], axis, thickness_um: 0.2 };
    let clear = UniaxialFilm { rays: [1.5.into(); 2], axis, thickness_um: 0.15 };
    let calcite = UniaxialFilm { rays: [1.66.into(), 1.49.into()], thickness_um: 0.3, ..rutile };
    let text = format!(
        "wavelength = 0.5\nsigma_deg = 50\nphi_deg = 25\nn_out = 1.5\n\
         [[layers_from_z0]]\nthickness = 0.2\neta = [2.6, 0]\neta_extraordinary = [2.9, 0.02]\noptic_axis = {axis:?}\n\
         [[layers_from_z0]]\nthickness = 0.15\neta = [1.5, 0]\n\
         [[layers_from_z0]]\nthickness = 0.3\neta = [1.66, 0]\neta_extraordinary = [1.49, 0]\noptic_axis = {axis:?}\n"
    );
    let light = uniaxial::FilmLight {
        wavelength_um: 0.5,
        polar_deg: 50.0,
        azimuth_deg: 25.0,
        half_spaces: [1.0, 1.5],
    };
    (Case::parse(&text, true).unwrap_or_else(|e| panic!("{e}")), light, vec![rutile, clear, calcite])
}

/// Largest difference of any amplitude, in both polarisations and into both.
fn largest(a: [[[Complex64; 2]; 2]; 2], b: [[[Complex64; 2]; 2]; 2]) -> f64 {
    let both = a.into_iter().flatten().flatten().zip(b.into_iter().flatten().flatten());
    both.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn films(level: Level, findings: &mut Findings) {
    let cells: &[usize] = level.pick(&[26, 52, 104], &[26, 39, 52, 78, 104, 156]);
    for axis in AXES {
        let (case, light, films) = film_case(axis);
        let want = uniaxial::amplitudes(&light, &films);
        let error = |&cells: &usize| {
            let solved = solve(&case, 1, cells, 1e-11);
            (cells as f64, largest(pairs(order(&solved.far, 0, 0)), want))
        };
        let errors: Vec<(f64, f64)> = cells.iter().map(error).collect();
        let because = "two moments a cell leave an error of the cell's height to the fourth power";
        findings.order(format!("films, axis {axis:?}"), fitted_slope(&errors), [3.5, 5.0], because);
        let because =
            "k0² (ε_e − ε_o) ∫ |E − ΠE|² / 2k of cells of 6 nm is 3e-6; ten times that for resonances";
        let finest = errors.iter().map(|e| e.1).fold(f64::INFINITY, f64::min);
        findings.promise(format!("films, axis {axis:?}: finest grid"), finest, 3e-5, because);
        let crossed = want.iter().map(|side| side[0][1].norm()).fold(0.0, f64::max);
        if axis[0] != 0.0 {
            let because = "s must turn into p by a tilted axis, or the comparison says little";
            let what = format!("films, axis {axis:?}: s into p");
            findings.check(what, crossed, Bound::AtLeast(0.01), Reason::Promise, because);
        }
    }
}

/// Polarisability of Clausius and Mossotti along both axes, in a square lattice of dipoles that are static at its scale.
fn small_sphere(findings: &mut Findings) {
    let side = 0.4;
    let height = 0.14;
    let radius = 0.05;
    let host = 1.5;
    let axis = [0.48, 0.36, 0.8];
    let o = 1.7;
    let e = 2.4;
    let text = format!(
        "wavelength_um = 12\nsigma_deg = 50\nphi_deg = 20\nL = {side}\nH = {height}\nn_in = {host}\nn_out = {host}\n\
         eta_binder = [{host}, 0]\n[[spheres]]\ncenter = [0.2, 0.2, 0.07]\nradius = {radius}\neta = [{o}, 0]\n\
         eta_extraordinary = [{e}, 0]\noptic_axis = {axis:?}\n"
    );
    let case = Case::parse(&text, true).unwrap_or_else(|e| panic!("{e}"));
    let found = pairs(order(&solve(&case, 36, 14, 1e-10).far, 0, 0));
    let of_ray = |n: f64| {
        let ratio = (n / host) * (n / host);
        4.0 * PI * radius * radius * radius * (ratio - 1.0) / (ratio + 2.0)
    };
    // Σ 1/r³ over the square lattice: half of it acts in the plane, minus all of it across.
    let lattice = 9.0336 / (4.0 * PI * side * side * side);
    let alone: Tensor = tensor(of_ray(o), of_ray(e) - of_ray(o), axis);
    let mut inverse = inverted(alone);
    for (i, field) in [0.5 * lattice, 0.5 * lattice, -lattice].into_iter().enumerate() {
        inverse[i][i] -= field;
    }
    let alpha = inverted(inverse);
    let k = TAU / 12.0 * host;
    let (sin, cos) = 50f64.to_radians().sin_cos();
    let (sin_a, cos_a) = 20f64.to_radians().sin_cos();
    let vectors = |sign: f64| [[-sin_a, cos_a, 0.0], [sign * cos * cos_a, sign * cos * sin_a, -sin]];
    let strength = Complex64::new(0.0, k / (2.0 * side * side * cos));
    let scattered = |out: [f64; 3], input: [f64; 3]| -> Complex64 {
        let sum: f64 = (0..3).map(|i| (0..3).map(|j| out[i] * alpha[i][j] * input[j]).sum::<f64>()).sum();
        strength * sum
    };
    let onwards = Complex64::cis(k * cos * height);
    let mut want = found;
    for i in 0..2 {
        for j in 0..2 {
            let identity = f64::from(u8::from(i == j));
            // the sphere is in the middle: both faces are half of the height away
            want[0][i][j] = scattered(vectors(-1.0)[j], vectors(1.0)[i]) * onwards;
            want[1][i][j] = (identity + scattered(vectors(1.0)[j], vectors(1.0)[i])) * onwards;
        }
    }
    let size = want[0].iter().flatten().map(|v| v.norm()).fold(0.0, f64::max);
    let because =
        "(kR)² and (kL)² of the lattice's field are 0.3 %, the grid of nine points a diameter leaves 2 %";
    findings.order_of_smallness(
        "Rayleigh's tensor, relative error",
        largest(found, want) / size,
        0.03,
        because,
    );
    let crossed = want[0][0][1].norm() / size;
    let because = "or the tensor would not be seen";
    findings.check("Rayleigh's tensor: s into p", crossed, Bound::AtLeast(0.05), Reason::Promise, because);
}

type Tensor = [[f64; 3]; 3];

fn tensor(across: f64, step: f64, axis: [f64; 3]) -> Tensor {
    let kronecker = |i: usize, j: usize| f64::from(u8::from(i == j));
    std::array::from_fn(|i| std::array::from_fn(|j| across * kronecker(i, j) + step * axis[i] * axis[j]))
}

fn inverted(m: Tensor) -> Tensor {
    let cofactor = |i: usize, j: usize| {
        let r = (i + 1) % 3;
        let s = (i + 2) % 3;
        let p = (j + 1) % 3;
        let q = (j + 2) % 3;
        m[r][p] * m[s][q] - m[r][q] * m[s][p]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| cofactor(j, i) / determinant))
}

/// Spheres of a wavelength's size, one and two, in all orders.
fn dipoles(findings: &mut Findings) {
    let text = include_str!("../data/crystals.json");
    let file: Value = serde_json::from_str(text).expect("crystals.json is JSON");
    for reference in file["cases"].as_array().expect("cases") {
        let id = reference["id"].as_str().expect("an id");
        let case =
            Case::parse(&reference["inputs"].to_string(), false).unwrap_or_else(|e| panic!("{id}: {e}"));
        let solved = solve_to(&case, 1e-3).unwrap_or_else(|e| panic!("{id}: {e}"));
        let own_error = reference["error"].as_f64().expect("an error");
        let mut worst: f64 = 0.0;
        for expected in reference["orders"].as_array().expect("orders") {
            let number = |key: &str| expected[key].as_i64().expect("a whole number") as i32;
            let found = pairs(order(&solved.far_fields, number("m"), number("n")));
            for (side, amplitudes) in ["R", "T"].into_iter().zip(found) {
                for i in 0..2 {
                    for j in 0..2 {
                        worst = worst.max((complex(&expected[side][i][j]) - amplitudes[i][j]).norm());
                    }
                }
            }
        }
        let because = "the accuracy asked for, 1e-3, and twice the last step of the dipoles' extrapolation";
        findings.promise(
            format!("{id} of spheres by coupled dipoles"),
            worst,
            1e-3 + 2.0 * own_error,
            because,
        );
    }
}
