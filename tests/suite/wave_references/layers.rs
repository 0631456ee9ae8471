//! Homogeneous and layered media: exact at any resolution, and convergent where interfaces miss the nodes.

use super::support::*;
use inkwave::input::case::Case;
use inkwave::wave::{
    Body, BodyShape, FarField, Incidence, Mean, Media, Resolution, Scene, Scheme, Side, Stratum,
};
use inkwave_validation::formulas::films::{Film, amplitudes};
use inkwave_validation::vector;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Identity: some hundred operations a node, none of which cancels; references carry 15 digits.
const EXACT_TOLERANCE: f64 = 1e-11;

fn of_kind(kind: &str) -> Vec<&'static Reference> {
    references().iter().filter(|r| r.kind == kind).collect()
}

#[test]
fn slabs_are_exact_on_any_grid() {
    let slabs = of_kind("slab");
    assert_eq!(slabs.len(), 6);
    for reference in slabs {
        for scheme in EXACT {
            for (nx, ny, cells) in [(1, 1, 1), (1, 1, 2), (4, 1, 3), (2, 5, 7), (1, 1, 60), (1, 1, 1000)] {
                let solved = solve_at(&reference.case, Resolution { nx, ny, cells, scheme }, 1e-12);
                let error = reference.largest_error(&solved.far);
                assert!(error <= EXACT_TOLERANCE, "{}, {scheme:?}, {cells} cells: {error:e}", reference.id);
                assert_eq!(solved.account.operator_applications, 0, "nothing is left to iterate on");
                assert!(solved.far.energy_error().abs() <= EXACT_TOLERANCE);
            }
        }
    }
}

#[test]
fn multilayers_are_exact_when_interfaces_are_nodes() {
    let stacks = of_kind("multilayer");
    assert_eq!(stacks.len(), 3);
    for reference in stacks {
        let least = reference.case.scene.strata.len();
        for scheme in EXACT {
            for cells in [least, least + 1, 40] {
                let solved = solve_at(&reference.case, Resolution { nx: 1, ny: 1, cells, scheme }, 1e-12);
                let error = reference.largest_error(&solved.far);
                assert!(error <= EXACT_TOLERANCE, "{}, {scheme:?}, {cells} cells: {error:e}", reference.id);
            }
        }
    }
}

/// (cells, error) with one mean for all strata, so that their differences are contrast.
fn constant_mean_errors(reference: &Reference, scheme: Scheme, cells: &[usize]) -> Vec<(f64, f64)> {
    let mean = Mean { depends_on_z: false, ..Mean::default() };
    let error = |&cells: &usize| {
        let resolution = Resolution { nx: 1, ny: 1, cells, scheme };
        let solved = solve_with_mean(&reference.case, resolution, 1e-13, mean);
        (cells as f64, reference.largest_error(&solved.far))
    };
    cells.iter().map(error).collect()
}

#[test]
fn contrast_between_nodes_converges_with_twice_the_degree() {
    // Order: Gauss–Lobatto moments of degree p integrate polynomials of degree 2p − 1, and amplitudes are
    // functionals of a symmetric problem, so piecewise constant contrast with interfaces on nodes gives 2p.
    let cases = [
        (Scheme::SecondDifference, 2.0, [40, 80, 160]),
        (Scheme::Tents, 2.0, [20, 40, 80]),
        (Scheme::Quadratic, 4.0, [20, 40, 80]),
        (Scheme::Cubic, 6.0, [20, 40, 80]),
        (Scheme::Quartic, 8.0, [20, 30, 40]),
    ];
    for id in ["multi01", "multi03"] {
        for (scheme, order, cells) in &cases {
            let slope = fitted_slope(&constant_mean_errors(reference(id), *scheme, cells));
            // The coarsest grids are not quite asymptotic: slopes up to a tenth above were seen.
            assert!((slope - order).abs() < 0.06 * order, "{id} {scheme:?}: order {slope:.2}, not {order}");
        }
    }
}

/// The strata as sheets inside one stratum of the first layer's medium: interfaces need not be nodes.
fn as_sheets(case: &Case) -> Case {
    let mut sheets = case.clone();
    let mut bottom = 0.0;
    for stratum in &case.scene.strata {
        let z_um = [bottom, bottom + stratum.thickness_um];
        if stratum.background != 0 {
            sheets.scene.bodies.push(Body::new(BodyShape::Sheet { z_um }, stratum.background));
        }
        bottom = z_um[1];
    }
    sheets.scene.strata = vec![Stratum { thickness_um: bottom, background: 0 }];
    sheets.media.inclusions = case.media.backgrounds.clone();
    sheets
}

#[test]
fn interfaces_between_nodes_converge_with_order_three() {
    // Order: u″ jumps inside a cell, so neither interpolation nor moments are better there than h² times the
    // cell's height: 3 for every degree above one. Tents have 2 from all other cells when ⟨k²⟩ is constant; a
    // mean that follows z leaves them no contrast elsewhere. Cells are 7 modulo 20, so that interfaces at
    // multiples of 0.05 H keep their place within a cell. Low degrees are still steeper here.
    let cells = [27, 47, 87, 167];
    let follows = Mean::default();
    let constant = Mean { depends_on_z: false, ..follows };
    let cases = [
        (Scheme::SecondDifference, follows, 1.8, 2.3),
        (Scheme::Tents, constant, 1.8, 2.3),
        (Scheme::Tents, follows, 2.8, 3.3),
        (Scheme::Quadratic, follows, 2.8, 4.2),
        (Scheme::Cubic, follows, 2.8, 3.7),
        (Scheme::Quartic, follows, 2.8, 3.3),
    ];
    for id in ["multi01", "multi03"] {
        let case = as_sheets(&reference(id).case);
        for (scheme, mean, low, high) in cases {
            let error = |&cells: &usize| {
                let solved = solve_with_mean(&case, Resolution { nx: 1, ny: 1, cells, scheme }, 1e-13, mean);
                (cells as f64, reference(id).largest_error(&solved.far))
            };
            let errors: Vec<_> = cells.iter().map(error).collect();
            let slope = fitted_slope(&errors);
            assert!((low..high).contains(&slope), "{id} {scheme:?}: order {slope:.2} from {errors:?}");
        }
    }
}

/// Identity: a box as wide as the cell is a film, wherever its sides lie; the strata of the other case are exact.
#[test]
fn a_box_that_fills_the_cell_is_a_film() {
    let common = r#""wavelength": 0.5, "sigma_deg": 25, "phi_deg": 30, "n_in": 1.0, "n_out": 1.2"#;
    let filled = format!(
        r#"{{{common}, "L": 0.5, "H": 0.6, "eta_binder": [1.5, 0], "bodies": [{{ "shape": {{ "kind": "box",
        "edges": [0.5, 0.5, 0.2] }}, "center": [0.1, 0.37, 0.3], "eta": [1.9, 0.1] }}]}}"#
    );
    let layer = |n: f64, k: f64| format!(r#"{{"thickness": 0.2, "eta": [{n}, {k}]}}"#);
    let binder = layer(1.5, 0.0);
    let film = layer(1.9, 0.1);
    let layers = format!(r#"{{{common}, "layers_from_z0": [{binder}, {film}, {binder}]}}"#);
    let [filled, layers] =
        [filled, layers].map(|text| Case::parse(&text, false).unwrap_or_else(|e| panic!("{e}")));
    let specular = |far: &FarField| [far.specular().reflected, far.specular().transmitted];
    let differ = |a: &FarField, b: &FarField| {
        let pairs = specular(a).into_iter().zip(specular(b));
        pairs.map(|(x, y)| (x - y).norm()).fold((a.reflectance - b.reflectance).abs(), f64::max)
    };
    let resolution = |n: usize| Resolution { nx: n, ny: n, cells: 12, scheme: Scheme::Cubic };
    let exact = solve_at(&layers, resolution(1), 1e-12).far;
    let error = differ(&solve_at(&filled, resolution(7), 1e-12).far, &exact);
    assert!(error < EXACT_TOLERANCE, "{error:e}");
    let vector = |case: &Case, points: usize| vector::solve(case, points, 12, 1e-12).far;
    for (own, film) in vector(&filled, 7).iter().zip(vector(&layers, 1)) {
        let error = differ(own, &film);
        assert!(error < EXACT_TOLERANCE, "{error:e}");
    }
}

const FILMS: [(f64, f64); 2] = [(1.5, 0.25), (1.52, 0.3)];
const SPHERE: &str = r#""spheres": [{ "center": [0.21, 0.13, 0.29], "radius": 0.12, "eta": [1.51, 0] }]"#;

/// First order of a small contrast: δr = i k₀²/(2κA) ∫ (η² − η_film²) u² dV with the field u of Airy's films. The
/// sphere lies across the face between the films, lighter than one and denser than the other.
fn first_order(wavelength: f64, side: f64) -> Complex64 {
    let films = FILMS.map(|(n, thickness_um)| Film { index: n.into(), thickness_um });
    let [_, transmitted] = amplitudes(1.0, &films, 1.3.into(), wavelength, 0.0);
    let k0 = TAU / wavelength;
    // Field and slope at the far face of each film, from the exit side.
    let mut field = transmitted;
    let mut slope = Complex64::I * k0 * 1.3 * transmitted;
    let mut top = FILMS.iter().map(|film| film.1).sum::<f64>();
    let center = 0.29;
    let radius = 0.12;
    let steps = 2000;
    let mut sum = Complex64::ZERO;
    for (index, thickness) in FILMS.into_iter().rev() {
        let k = k0 * index;
        let at = |z: f64| field * (k * (z - top)).cos() + slope / k * (k * (z - top)).sin();
        // midpoint rule: an error of the square of the step
        for i in 0..steps {
            let z = top - thickness * (f64::from(i) + 0.5) / f64::from(steps);
            let area = std::f64::consts::PI * (radius * radius - (z - center) * (z - center)).max(0.0);
            sum += at(z).powi(2) * (1.51 * 1.51 - index * index) * area * thickness / f64::from(steps);
        }
        let bottom = top - thickness;
        let below = at(bottom);
        slope = field * k * (k * thickness).sin() + slope * (k * thickness).cos();
        (field, top) = (below, bottom);
    }
    Complex64::I * k0 / (2.0 * side * side) * sum
}

/// Several layers of grains: a sphere across the face between two films changes r by what perturbation theory says
/// beyond Airy's films. *Planted*: a sphere that only one of the films holds is off by 40 %.
#[test]
fn a_sphere_across_two_films_adds_its_first_order_to_airy() {
    let common = r#""wavelength": 0.55, "L": 0.5, "n_in": 1.0, "n_out": 1.3"#;
    let film = |(n, um): (f64, f64)| format!(r#"{{ "thickness": {um}, "eta": [{n}, 0] }}"#);
    let films = FILMS.map(film).join(", ");
    let parse = |text: String| Case::parse(&text, false).unwrap_or_else(|e| panic!("{e}"));
    let with = parse(format!(r#"{{ {common}, "layers_from_z0": [{films}], {SPHERE} }}"#));
    let resolution = Resolution { nx: 24, ny: 24, cells: 22, scheme: Scheme::Cubic };
    let own = solve_at(&with, resolution, 1e-10).far;
    let stack = FILMS.map(|(n, thickness_um)| Film { index: n.into(), thickness_um });
    let [reflected, _] = amplitudes(1.0, &stack, 1.3.into(), 0.55, 0.0);
    let added = own.specular().reflected - reflected;
    let expected = first_order(0.55, 0.5);
    // second order: the phase that the contrast of 0.03 adds across the sphere, k₀ δε r = 0.04
    assert!((added - expected).norm() < 0.04 * expected.norm(), "{added} {expected}");
    assert!(own.energy_error().abs() < 1e-9);
    // identity: two films of one index are a binder
    let same = FILMS.map(|(_, um)| film((1.5, um))).join(", ");
    let two = parse(format!(r#"{{ {common}, "layers_from_z0": [{same}], {SPHERE} }}"#));
    let one = parse(format!(r#"{{ {common}, "H": 0.55, "eta_binder": [1.5, 0], {SPHERE} }}"#));
    let two = solve_at(&two, resolution, 1e-12).far.specular().reflected;
    let one = solve_at(&one, resolution, 1e-12).far.specular().reflected;
    assert!((two - one).norm() < 1e-7, "{two} {one}");
}

/// Fresnel–Airy: one film between two half-spaces, from interface coefficients; amplitudes at its faces.
fn airy(n: [Complex64; 3], thickness: f64, wavelength: f64, polar_deg: f64) -> [Complex64; 2] {
    let k0 = TAU / wavelength;
    let lateral = k0 * n[0].re * polar_deg.to_radians().sin();
    let normal = n.map(|n| {
        let root = (n * n * k0 * k0 - lateral * lateral).sqrt();
        if root.im < 0.0 { -root } else { root }
    });
    let r = |a: usize, b: usize| (normal[a] - normal[b]) / (normal[a] + normal[b]);
    let phase = (Complex64::I * normal[1] * thickness).exp();
    let echo = 1.0 + r(0, 1) * r(1, 2) * phase * phase;
    let reflected = (r(0, 1) + r(1, 2) * phase * phase) / echo;
    let transmitted = (1.0 + r(0, 1)) * (1.0 + r(1, 2)) * phase / echo;
    [reflected, transmitted]
}

#[test]
fn half_spaces_of_different_index_follow_fresnel_and_airy() {
    let real = |n: f64| Complex64::from(n);
    let films = [
        [real(1.0), real(1.558), real(1.5)],
        [real(1.5), real(1.33), real(1.0)],
        [real(1.33), Complex64::new(1.4, 0.2), real(2.4)],
        [real(1.0), real(1.5), Complex64::new(0.22, 6.71)],
    ];
    for n in films {
        for polar_deg in [0.0, 35.0, 62.0, 89.0] {
            for from in [Side::Incident, Side::Exit] {
                let ends = if from == Side::Incident { [n[0], n[2]] } else { [n[2], n[0]] };
                let scene = Scene::layer([0.7, 0.9], 0.43, Vec::new());
                let media =
                    Media { incident: ends[0], exit: ends[1], backgrounds: vec![n[1]], inclusions: vec![] };
                let incidence = Incidence { wavelength_um: 0.53, polar_deg, azimuth_deg: 117.0, from };
                let case = Case { scene, media, incidence, directions: Vec::new(), remarks: Vec::new() };
                let solved =
                    solve_at(&case, Resolution { nx: 3, ny: 2, cells: 2, scheme: Scheme::Cubic }, 1e-12);
                let own = solved.far.specular();
                let [reflected, transmitted] = airy(n, 0.43, 0.53, polar_deg);
                let error = (own.reflected - reflected).norm().max((own.transmitted - transmitted).norm());
                assert!(error <= EXACT_TOLERANCE, "{n:?} at {polar_deg}° {from:?}: {error:e}");
                assert!(solved.far.energy_error().abs() <= EXACT_TOLERANCE);
            }
        }
    }
}

#[test]
fn light_beyond_the_critical_angle_is_totally_reflected() {
    let media =
        Media { incident: 1.5.into(), exit: 1.0.into(), backgrounds: vec![1.5.into()], inclusions: vec![] };
    let incidence =
        Incidence { wavelength_um: 0.55, polar_deg: 60.0, azimuth_deg: 0.0, from: Side::Incident };
    let scene = Scene::layer([1.0; 2], 1.0, Vec::new());
    let case = Case { scene, media, incidence, directions: Vec::new(), remarks: Vec::new() };
    let solved = solve_at(&case, Resolution { nx: 1, ny: 1, cells: 5, scheme: Scheme::Cubic }, 1e-12);
    // Identity.
    assert!((solved.far.reflectance - 1.0).abs() < 1e-13 && solved.far.transmittance == 0.0);
    assert!(solved.far.specular().transmitted.norm() > 0.1, "the evanescent wave is there");
}

#[test]
fn second_differences_converge_with_order_two() {
    for reference in of_kind("slab") {
        let error = |cells: usize| {
            let resolution = Resolution { nx: 1, ny: 1, cells, scheme: Scheme::SecondDifference };
            (cells as f64, reference.largest_error(&solve_at(&reference.case, resolution, 1e-12).far))
        };
        // Order: P2 section 3 is central, and the ends are as accurate; 40 cells are still a little coarse.
        let slope = fitted_slope(&[40, 80, 160].map(error));
        assert!((slope - 2.0).abs() < 0.2, "{}: order {slope:.2}", reference.id);
    }
}

fn layered(layers: &[(f64, f64)]) -> String {
    let layer = |(thickness, n): &(f64, f64)| format!(r#"{{"thickness": {thickness}, "eta": [{n}, 0.0]}}"#);
    let layers: Vec<String> = layers.iter().map(layer).collect();
    format!(r#"{{"wavelength": 0.5, "sigma_deg": 20, "layers_from_z0": [{}]}}"#, layers.join(", "))
}

#[test]
fn films_of_zero_thickness_change_nothing() {
    let parse = |layers: &[(f64, f64)]| Case::parse(&layered(layers), false);
    let amplitudes = |layers: &[(f64, f64)]| {
        let case = parse(layers).expect("a valid stack");
        solve_at(&case, Resolution { nx: 1, ny: 1, cells: 6, scheme: Scheme::Cubic }, 1e-12).far
    };
    let plain = amplitudes(&[(0.3, 1.4), (0.2, 1.6)]);
    let with = amplitudes(&[(0.0, 3.0), (0.3, 1.4), (0.0, 2.0), (0.2, 1.6), (0.0, 1.0)]);
    assert!(largest_difference(&plain, &with, |m, n| (m, n)) == 0.0);
    // A film of two picometres hardly differs from none: r changes by at most about 2π n² d/λ.
    let thin = amplitudes(&[(0.3, 1.4), (2e-6, 2.0), (0.2, 1.6)]);
    let difference = largest_difference(&plain, &thin, |m, n| (m, n));
    assert!(difference > 0.0 && difference < TAU * 4.0 * 2e-6 / 0.5, "{difference:e}");
    for (layers, word) in
        [(vec![(0.0, 1.4)], "thickness"), (vec![], "layers_from_z0"), (vec![(-0.1, 1.4)], "thickness")]
    {
        let error = parse(&layers).expect_err("nothing is left").to_string();
        assert!(error.contains(word), "{error}");
    }
}
