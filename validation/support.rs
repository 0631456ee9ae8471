//! Reference cases with their expected amplitudes, and short ways to solve and to compare.

use inkwave::ink::Sphere;
use inkwave::input::case::Case;
use inkwave::solve::accuracy::{AccuracyError, Estimated, Task, suited_scheme};
use inkwave::solve::{Account, Coverages, Gmres, Goal, Silent, Solution, Solver};
use inkwave::wave::{Body, BodyShape, FarField, Mean, Order, Problem, Resolution, Scheme};
use num_complex::Complex64;
use serde::Deserialize;
use std::sync::OnceLock;

/// All schemes whose mean operator is exact.
pub const EXACT: [Scheme; 4] = [Scheme::Tents, Scheme::Quadratic, Scheme::Cubic, Scheme::Quartic];

/// A case of validation/data/waves.json.
#[derive(Clone, Debug)]
pub struct Reference {
    pub id: String,
    pub kind: String,
    pub case: Case,
    pub orders: Vec<ReferenceOrder>,
}

/// Amplitudes of one order as the reference gives them; some list only one side.
#[derive(Clone, Debug, Deserialize)]
pub struct ReferenceOrder {
    pub m: i32,
    pub n: i32,
    pub propagating: bool,
    #[serde(rename = "R")]
    pub reflected: Option<[f64; 2]>,
    #[serde(rename = "T")]
    pub transmitted: Option<[f64; 2]>,
}

/// All scattering cases (isolated spheres have no orders and are left out).
pub fn references() -> &'static [Reference] {
    static ALL: OnceLock<Vec<Reference>> = OnceLock::new();
    ALL.get_or_init(|| {
        let text = include_str!("data/waves.json");
        let file: serde_json::Value = serde_json::from_str(text).expect("waves.json is JSON");
        let cases = file["cases"].as_array().expect("waves.json lists cases");
        cases.iter().filter(|c| c["outputs"]["orders"].is_array()).map(read).collect()
    })
}

fn read(case: &serde_json::Value) -> Reference {
    let text = |key: &str| case[key].as_str().expect("ids and kinds are text").to_string();
    let id = text("id");
    Reference {
        case: Case::parse(&case.to_string(), false).unwrap_or_else(|e| panic!("{id}: {e}")),
        orders: serde_json::from_value(case["outputs"]["orders"].clone()).expect("orders"),
        kind: text("kind"),
        id,
    }
}

/// The case of that id.
pub fn reference(id: &str) -> &'static Reference {
    references().iter().find(|r| r.id == id).unwrap_or_else(|| panic!("no case {id}"))
}

impl Reference {
    /// Largest |difference| of any amplitude; every propagating order of the reference must be there.
    pub fn largest_error(&self, far: &FarField) -> f64 {
        self.orders.iter().map(|o| self.order_error(o, far)).fold(0.0, f64::max)
    }

    fn order_error(&self, expected: &ReferenceOrder, far: &FarField) -> f64 {
        let Some(own) = far.orders.iter().find(|o| (o.m, o.n) == (expected.m, expected.n)) else {
            assert!(!expected.propagating, "{}: order ({}, {}) is missing", self.id, expected.m, expected.n);
            return 0.0;
        };
        let difference =
            |a: Complex64, b: Option<[f64; 2]>| b.map_or(0.0, |[re, im]| (a - Complex64::new(re, im)).norm());
        difference(own.reflected, expected.reflected).max(difference(own.transmitted, expected.transmitted))
    }

    pub fn is_uniform(&self) -> bool {
        self.case.scene.uniform_in_plane()
    }

    /// Points and cells for this case, one point along directions in which nothing changes.
    pub fn resolution(&self, points: usize, cells: usize, scheme: Scheme) -> Resolution {
        resolution(&self.case, points, cells, scheme)
    }
}

/// Points and cells, one point along directions in which nothing changes.
pub fn resolution(case: &Case, points: usize, cells: usize, scheme: Scheme) -> Resolution {
    let nx = if case.scene.uniform_in_plane() { 1 } else { points };
    let ny = if case.scene.uniform_in_y() { 1 } else { points };
    Resolution { nx, ny, cells, scheme }
}

/// One solve: the problem, its field's account, and what leaves the layer.
pub struct Solved {
    pub problem: Problem,
    pub account: Account,
    pub far: FarField,
}

/// Solves at one resolution to a relative residual.
pub fn solve_at(case: &Case, resolution: Resolution, tolerance: f64) -> Solved {
    solve_with_mean(case, resolution, tolerance, Mean::default())
}

/// [`solve_at`] with another mean.
pub fn solve_with_mean(case: &Case, resolution: Resolution, tolerance: f64, mean: Mean) -> Solved {
    let problem = Problem::from_scene(&case.scene, &case.media, &case.incidence, resolution, mean)
        .unwrap_or_else(|e| panic!("{e}"));
    let goal = Goal { tolerance, ..Goal::default() };
    let solution: Solution =
        Gmres::default().solve(&problem, goal, &mut Silent).unwrap_or_else(|e| panic!("{e}"));
    let far = problem.far_field(&solution.field);
    Solved { far, account: solution.account, problem }
}

/// What `inkwave solve --accuracy` does.
pub fn solve_to(case: &Case, accuracy: f64) -> Result<Estimated, AccuracyError> {
    let solver = Gmres::default();
    let task = Task {
        coverages: &Coverages::of(&case.scene),
        media: &case.media,
        incidence: &case.incidence,
        mean: Mean::default(),
        scheme: suited_scheme(accuracy),
        solver: &solver,
        goal: Goal::default(),
        memory: 4e9,
    };
    task.solve_to_accuracy(accuracy, &mut Silent)
}

/// The order (m, n) of a far field.
pub fn order(far: &FarField, m: i32, n: i32) -> &Order {
    far.orders.iter().find(|o| (o.m, o.n) == (m, n)).unwrap_or_else(|| panic!("no order ({m}, {n})"))
}

/// Largest |difference| of any amplitude, where `map` gives the second field's order for (m, n) of the first.
/// Evanescent orders at the end of a list may be missing in the other; propagating ones may not.
pub fn largest_difference(a: &FarField, b: &FarField, map: impl Fn(i32, i32) -> (i32, i32)) -> f64 {
    let mut largest: f64 = 0.0;
    for o in &a.orders {
        let (m, n) = map(o.m, o.n);
        let Some(p) = b.orders.iter().find(|p| (p.m, p.n) == (m, n)) else {
            assert!(!o.reflected_propagates && !o.transmitted_propagates, "order ({m}, {n}) is missing");
            continue;
        };
        largest = largest.max((o.reflected - p.reflected).norm());
        largest = largest.max((o.transmitted - p.transmitted).norm());
    }
    largest
}

/// Slope of a least-squares line through log error against log resolution: steadier than single slopes.
pub fn fitted_slope(errors: &[(f64, f64)]) -> f64 {
    let points: Vec<[f64; 2]> = errors.iter().map(|(n, e)| [n.ln(), e.ln()]).collect();
    let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64;
    let x = mean(0);
    let y = mean(1);
    let covariance: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    -covariance / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
}

/// A grain of one ball.
pub fn ball(center_um: [f64; 3], radius_um: f64) -> Body {
    Body::new(BodyShape::Balls(vec![Sphere { center_um, radius_um }]), 0)
}
