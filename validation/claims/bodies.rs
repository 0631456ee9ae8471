//! Convex bodies with exact surfaces and their layers: weak contrast against form factors, and the order of convergence.

use crate::claim::{Claim, Findings, Level};
use crate::formulas::form_factors;
use crate::support::fitted_slope;
use crate::vector;
use inkwave::ink::{Grain, Packing};
use inkwave::input::case::Case;
use inkwave::numerics::vector::Rotation;
use inkwave::numerics::vector::unit;
use inkwave::solve::accuracy::largest_difference;
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::{BodyShape, FarField, Mean, Media, Order, Problem, Resolution, Scene, Scheme};
use num_complex::Complex64;
use serde_json::{Value, json};
use std::f64::consts::TAU;

pub const CLAIM: Claim = Claim {
    id: "28-bodies",
    statement: "Ellipsoids, boxes, discs and prisms in any orientation, with a layer or without, scatter weakly as their form factors say, in the scalar and the vector wave, and their amplitudes converge with the grid; layered boxes that fill the cell are films.",
    because: "To first order in the contrast an order's amplitude is the transform of the body at the change of the wavevector (Born and Wolf 13.1.2); the coverage is exact.",
    file: file!(),
    measure,
};

const WAVELENGTH: f64 = 0.5;
const PERIOD: [f64; 2] = [0.7, 0.8];
const HEIGHT: f64 = 0.6;
const CENTER: [f64; 3] = [0.3, 0.45, 0.28];
const HOST: f64 = 1.5;
const CORNERS: [[f64; 2]; 3] = [[-0.14, -0.1], [0.16, -0.1], [-0.02, 0.2]];
const AXIS: [f64; 3] = [0.4, -0.3, 0.8];
const TURN_DEG: f64 = 25.0;

/// The form factor at a wave vector, in the body's own frame.
type FormFactor = fn([f64; 3]) -> Complex64;

/// Thickness of the layer, µm.
const LAYER: f64 = 0.03;

/// The triangle inside the layer: it shrinks towards the centre of its inscribed circle.
fn core_corners() -> [[f64; 2]; 3] {
    let [a, b, c] = CORNERS;
    let side = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
    let opposite = [side(b, c), side(c, a), side(a, b)];
    let around = opposite.iter().sum::<f64>();
    let centre = [0, 1].map(|i| (0..3).map(|k| opposite[k] * CORNERS[k][i]).sum::<f64>() / around);
    let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let share = 1.0 - LAYER * around / twice;
    CORNERS.map(|corner| [0, 1].map(|i| centre[i] + share * (corner[i] - centre[i])))
}

/// Bodies by name, each with its `shape`, its form factor and that of its core under the layer.
fn bodies() -> Vec<(&'static str, Value, [FormFactor; 2])> {
    vec![
        (
            "ellipsoid",
            json!({"kind": "ellipsoid", "axes": [0.4, 0.3, 0.2]}),
            [
                |q| form_factors::ellipsoid(q, [0.2, 0.15, 0.1]).into(),
                |q| form_factors::ellipsoid(q, [0.2 - LAYER, 0.15 - LAYER, 0.1 - LAYER]).into(),
            ],
        ),
        (
            "sphere",
            json!({"kind": "ellipsoid", "axes": [0.36, 0.36, 0.36]}),
            [|q| form_factors::sphere(q, 0.18).into(), |q| form_factors::sphere(q, 0.18 - LAYER).into()],
        ),
        (
            "box",
            json!({"kind": "box", "edges": [0.3, 0.2, 0.25]}),
            [
                |q| form_factors::cuboid(q, [0.3, 0.2, 0.25]).into(),
                |q| form_factors::cuboid(q, [0.3, 0.2, 0.25].map(|e| e - 2.0 * LAYER)).into(),
            ],
        ),
        (
            "disc",
            json!({"kind": "disc", "diameter": 0.36, "thickness": 0.1}),
            [
                |q| form_factors::disc(q, 0.18, 0.1).into(),
                |q| form_factors::disc(q, 0.18 - LAYER, 0.1 - 2.0 * LAYER).into(),
            ],
        ),
        (
            "prism",
            json!({"kind": "prism", "corners": CORNERS, "length": 0.2}),
            [
                |q| form_factors::prism(q, &CORNERS, 0.2),
                |q| form_factors::prism(q, &core_corners(), 0.2 - 2.0 * LAYER),
            ],
        ),
    ]
}

fn case(shape: &Value, eta: f64) -> Case {
    let body =
        json!({"shape": shape, "center": CENTER, "axis": AXIS, "turn_deg": TURN_DEG, "eta": [eta, 0.0]});
    let inputs = json!({
        "wavelength": WAVELENGTH, "sigma_deg": 20.0, "phi_deg": 35.0, "L": PERIOD, "H": HEIGHT,
        "n_in": HOST, "n_out": HOST, "eta_binder": [HOST, 0.0], "bodies": [body],
    });
    Case::parse(&inputs.to_string(), false).unwrap_or_else(|e| panic!("{e}"))
}

/// The body with a layer, as studies make it.
fn layered(case: &Case, [core, layer]: [f64; 2]) -> Case {
    let BodyShape::Solid(solid) = &case.scene.bodies[0].shape else { panic!("a convex body") };
    let grain = Grain::convex(solid.clone(), 0);
    let packing = Packing::from_grains(PERIOD, HEIGHT, true, vec![grain]).expect("one body");
    let scene = Scene::from_packing(&packing.with_shells(vec![vec![LAYER]]).expect("a core"));
    let inclusions = [core, layer].map(Complex64::from).to_vec();
    Case { scene, media: Media { inclusions, ..case.media.clone() }, ..case.clone() }
}

fn measure(level: Level, findings: &mut Findings) {
    let points = level.pick(14, 20);
    for (name, shape, [whole, core]) in bodies() {
        let contrast = 1e-4;
        let of_core = -0.6e-4;
        let eta = |contrast: f64| (HOST * HOST + contrast).sqrt();
        let bare = case(&shape, eta(contrast));
        weak(findings, name, points, &bare, &|q| contrast * whole(q));
        let coated = layered(&bare, [of_core, contrast].map(eta));
        let form = |q| contrast * whole(q) + (of_core - contrast) * core(q);
        weak(findings, &format!("layered {name}"), points, &coated, &form);
    }
    films(findings);
    convergence(level, findings);
}

/// Amplitudes of a weakly scattering case against Δε F in the body's own frame.
fn weak(
    findings: &mut Findings,
    name: &str,
    points: usize,
    case: &Case,
    form: &dyn Fn([f64; 3]) -> Complex64,
) {
    let (worst, scale) = deviation(&scalar(case, points, 10), form);
    // The second order of the contrast, k² Δε a²/10, and the grid.
    let because = "second order of a contrast of 1e-4, some phases of the body's size, and the grid's error";
    findings.promise(format!("{name}, weak contrast"), worst / scale, 2e-4, because);
    let loss = vector_deviation(&vector::solve(case, points, 20, 1e-9).far, form);
    findings.promise(
        format!("{name}, weak contrast, vector wave"),
        loss,
        8e-4,
        "the grid's error, which falls with the fourth power of the cells' height: 4e-3 with 10, 2e-4 with 20",
    );
}

/// Boxes as wide as the cell, one inside the other, against the films that they are.
fn films(findings: &mut Findings) {
    let slab = |height: f64, eta: f64| json!({"shape": {"kind": "box", "edges": [PERIOD[0], PERIOD[1], height]}, "center": [0.1, 0.2, 0.3], "eta": [eta, 0.02]});
    let light =
        json!({"wavelength": WAVELENGTH, "sigma_deg": 20.0, "phi_deg": 35.0, "L": PERIOD, "n_out": 1.6});
    let with = |more: Value| {
        let mut inputs = light.clone();
        more.as_object().into_iter().flatten().for_each(|(key, value)| inputs[key] = value.clone());
        Case::parse(&inputs.to_string(), false).unwrap_or_else(|e| panic!("{e}"))
    };
    let boxes =
        with(json!({"H": HEIGHT, "eta_binder": [HOST, 0.0], "bodies": [slab(0.2, 1.4), slab(0.5, 2.2)]}));
    let film = |thickness: f64, eta: f64, kappa: f64| json!({"thickness": thickness, "eta": [eta, kappa]});
    let host = film(0.05, HOST, 0.0);
    let outer = film(0.15, 2.2, 0.02);
    let inner = film(0.2, 1.4, 0.02);
    let films = with(json!({"layers_from_z0": [host, outer, inner, outer, host]}));
    let because = "the same layers, to the residual";
    let off = largest_difference(&scalar(&films, 5, 20), &scalar(&boxes, 5, 20));
    findings.promise("layered box as wide as the cell, scalar wave", off, 1e-8, because);
    let films = vector::solve(&films, 5, 20, 1e-10).far;
    let boxes = vector::solve(&boxes, 5, 20, 1e-10).far;
    let off = (0..2).map(|i| largest_difference(&films[i], &boxes[i])).fold(0.0, f64::max);
    findings.promise("layered box as wide as the cell, vector wave", off, 1e-8, because);
}

/// Largest difference between amplitudes and those of first order, and the largest of the latter.
fn deviation(far: &FarField, form: &dyn Fn([f64; 3]) -> Complex64) -> (f64, f64) {
    let scattered = far.orders.iter().filter(|o| (o.m, o.n) != (0, 0) && o.transmitted_propagates);
    let mut worst = 0.0f64;
    let mut largest = 0.0f64;
    for order in scattered {
        let [reflected, transmitted] = first_order(order, form);
        worst = worst.max((order.reflected - reflected).norm()).max((order.transmitted - transmitted).norm());
        largest = largest.max(reflected.norm()).max(transmitted.norm());
    }
    (worst, largest)
}

/// i k₀² Δε F(q)/(2 κ Lx Ly), with the phases of the planes z = 0 and z = H that the amplitudes refer to.
fn first_order(order: &Order, form: &dyn Fn([f64; 3]) -> Complex64) -> [Complex64; 2] {
    let k0 = TAU / WAVELENGTH;
    let [lx, ly] = PERIOD;
    let [kx, ky] = order.direction.map(|d| d * k0);
    let kz = ((k0 * HOST).powi(2) - kx * kx - ky * ky).sqrt();
    let incident = wavevector();
    [-1.0, 1.0].map(|side| {
        let q = [kx - incident[0], ky - incident[1], side * kz - incident[2]];
        let phase = Complex64::cis(-(0..3).map(|i| q[i] * CENTER[i]).sum::<f64>());
        let plane = if side > 0.0 { Complex64::cis(kz * HEIGHT) } else { Complex64::ONE };
        let factor = Complex64::I * k0 * k0 / (2.0 * kz * lx * ly);
        factor * form(into_body(q)) * phase * plane
    })
}

fn wavevector() -> [f64; 3] {
    let k = TAU / WAVELENGTH * HOST;
    let polar = 20f64.to_radians();
    let azimuth = 35f64.to_radians();
    [k * polar.sin() * azimuth.cos(), k * polar.sin() * azimuth.sin(), k * polar.cos()]
}

fn into_body(q: [f64; 3]) -> [f64; 3] {
    let turn = Rotation::by([0.0, 0.0, TURN_DEG.to_radians()]);
    turn.then(Rotation::from_z_to(unit(AXIS))).inverse().turn(q)
}

/// As [`deviation`] for the power of both outgoing polarisations: |e_in|² less its part along the outgoing direction.
fn vector_deviation(far: &[FarField; 2], form: &dyn Fn([f64; 3]) -> Complex64) -> f64 {
    let mut worst = 0.0f64;
    let mut largest = 0.0f64;
    let along = wavevector();
    let s_in = unit([-along[1], along[0], 0.0]);
    for order in far[0].orders.iter().filter(|o| (o.m, o.n) != (0, 0) && o.transmitted_propagates) {
        let [x, y] = order.direction.map(|d| d / HOST);
        let z = (1.0 - x * x - y * y).sqrt();
        let scalars = first_order(order, form);
        for (i, side) in [-1.0, 1.0].into_iter().enumerate() {
            let cosine = s_in[0] * x + s_in[1] * y + s_in[2] * side * z;
            let expected = scalars[i].norm() * (1.0 - cosine * cosine).sqrt();
            let found = order.amplitudes().take(2).map(|pair| pair[i].norm_sqr()).sum::<f64>().sqrt();
            worst = worst.max((found - expected).abs());
            largest = largest.max(expected);
        }
    }
    worst / largest
}

fn scalar(case: &Case, points: usize, cells: usize) -> FarField {
    let resolution = Resolution { nx: points, ny: points, cells, scheme: Scheme::Cubic };
    let problem = Problem::from_scene(&case.scene, &case.media, &case.incidence, resolution, Mean::default())
        .unwrap_or_else(|e| panic!("{e}"));
    let goal = Goal { tolerance: 1e-10, ..Goal::default() };
    problem.far_field(
        &Gmres::default().solve(&problem, goal, &mut Silent).unwrap_or_else(|e| panic!("{e}")).field,
    )
}

/// Errors against a fine grid at an ink's contrast.
fn convergence(level: Level, findings: &mut Findings) {
    let counts: &[usize] = level.pick(&[10, 14, 20], &[10, 12, 14, 16, 20, 24]);
    for (name, shape, _) in bodies().into_iter().filter(|(name, ..)| ["box", "disc"].contains(name)) {
        let case = case(&shape, 1.7);
        let finest = scalar(&case, 40, 24);
        let error = |&n: &usize| (n as f64, largest_difference(&finest, &scalar(&case, n, 24)));
        let errors: Vec<(f64, f64)> = counts.iter().map(error).collect();
        let because = "4 with the folded harmonics, as for balls, ± the scatter of a line through few grids";
        findings.order(
            format!("{name}, order in the plane, scalar wave"),
            fitted_slope(&errors),
            [2.5, 6.5],
            because,
        );
        let finest = vector::solve(&case, 31, 24, 1e-8);
        let error = |&n: &usize| {
            let own = vector::solve(&case, n, 24, 1e-8);
            let off = (0..2).map(|i| largest_difference(&finest.far[i], &own.far[i])).fold(0.0, f64::max);
            (n as f64, off)
        };
        let errors: Vec<(f64, f64)> = counts.iter().map(error).collect();
        let because = "3 with the tensor, less where edges count, more while the grid is coarse";
        findings.order(
            format!("{name}, order in the plane, vector wave"),
            fitted_slope(&errors),
            [1.5, 6.0],
            because,
        );
    }
}
