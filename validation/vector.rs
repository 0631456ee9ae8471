//! References of the vector wave with their expected amplitudes, and short ways to solve them in both polarisations.

use inkwave::input::case::Case;
use inkwave::solve::accuracy::{AccuracyError, Estimated, Task};
use inkwave::solve::{Coverages, Gmres, Goal, Silent, Solver};
use inkwave::wave::maxwell::{Averaging, NormalMoments, Polarisation, VectorProblem};
use inkwave::wave::{FarField, Field, Mean, Order, Precision, Resolution, Scheme, System, Wave};
use num_complex::Complex64;
use serde_json::Value;
use std::sync::{Arc, OnceLock};

/// A case of validation/data/vector.json with its expected orders as they are written there.
pub struct Reference {
    pub id: String,
    pub case: Case,
    pub orders: Vec<Value>,
}

/// All cases.
pub fn references() -> &'static [Reference] {
    static ALL: OnceLock<Vec<Reference>> = OnceLock::new();
    ALL.get_or_init(|| {
        let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/vector.json"));
        let file: Value = serde_json::from_str(text).expect("vector.json is JSON");
        file["cases"].as_array().expect("vector.json lists cases").iter().map(read).collect()
    })
}

fn read(case: &Value) -> Reference {
    let id = case["id"].as_str().expect("ids are text").to_string();
    let parsed = Case::parse(&case["inputs"].to_string(), false).unwrap_or_else(|e| panic!("{id}: {e}"));
    let orders = case["outputs"]["orders"].as_array().expect("orders").clone();
    Reference { id, case: parsed, orders }
}

/// The case of that id.
pub fn reference(id: &str) -> &'static Reference {
    references().iter().find(|r| r.id == id).unwrap_or_else(|| panic!("no case {id}"))
}

impl Reference {
    /// Largest error of the amplitudes in → out of orders that propagate or neighbour the specular one.
    pub fn errors(&self, far: &[FarField]) -> [[f64; 2]; 2] {
        let mut errors = [[0.0_f64; 2]; 2];
        for expected in &self.orders {
            let number = |key: &str| expected[key].as_i64().expect("orders are whole numbers") as i32;
            let m = number("m");
            let n = number("n");
            let travels = expected["propagating_R"] == true || expected["propagating_T"] == true;
            if !travels && (m.abs() > 1 || n.abs() > 1) {
                continue;
            }
            let own = order(far, m, n);
            for (i, input) in ["s", "p"].into_iter().enumerate() {
                for (j, output) in ["s", "p"].into_iter().enumerate() {
                    for (side, amplitudes) in ["R", "T"].into_iter().zip(pairs(own)) {
                        let difference = complex(&expected[side][input][output]) - amplitudes[i][j];
                        errors[i][j] = errors[i][j].max(difference.norm());
                    }
                }
            }
        }
        errors
    }

    /// The largest of [`Reference::errors`].
    pub fn error(&self, far: &[FarField]) -> f64 {
        self.errors(far).into_iter().flatten().fold(0.0, f64::max)
    }
}

/// A complex number of a data file.
pub fn complex(value: &Value) -> Complex64 {
    let part = |i: usize| value[i].as_f64().expect("amplitudes are pairs of numbers");
    Complex64::new(part(0), part(1))
}

/// The order (m, n) of s and p light.
pub fn order(far: &[FarField], m: i32, n: i32) -> [&Order; 2] {
    [0, 1].map(|i| crate::support::order(&far[i], m, n))
}

/// Amplitudes \[reflected, transmitted\]\[in\]\[out\] of one order of s and p light.
pub fn pairs(orders: [&Order; 2]) -> [[[Complex64; 2]; 2]; 2] {
    [0, 1].map(|side| {
        [0, 1].map(|i| {
            let own = orders[i].amplitudes().next().expect("four")[side];
            let crossed = orders[i].amplitudes().nth(1).expect("four")[side];
            if i == 0 { [own, crossed] } else { [crossed, own] }
        })
    })
}

/// Both solutions of a case and what leaves the layer.
pub struct Solved {
    pub problem: Arc<VectorProblem>,
    pub fields: [Field; 2],
    pub far: [FarField; 2],
}

/// The discrete problem of a case.
pub fn problem(case: &Case, resolution: Resolution, mean: Mean, averaging: Averaging) -> Arc<VectorProblem> {
    let moments = Arc::new(NormalMoments::new(&case.scene, resolution).unwrap_or_else(|e| panic!("{e}")));
    VectorProblem::new(&moments, &case.media, &case.incidence, mean, averaging)
        .unwrap_or_else(|e| panic!("{e}"))
}

/// Solves in both polarisations at one resolution to a relative residual.
pub fn solve(case: &Case, points: usize, cells: usize, tolerance: f64) -> Solved {
    solve_as(case, points, cells, tolerance, Mean::default(), Averaging::Normal)
}

/// [`solve`] with another mean or averaging.
pub fn solve_as(
    case: &Case,
    points: usize,
    cells: usize,
    tolerance: f64,
    mean: Mean,
    averaging: Averaging,
) -> Solved {
    let problem = problem(case, resolution(case, points, cells), mean, averaging);
    let goal = Goal { tolerance, ..Goal::default() };
    let fields = Polarisation::BOTH.map(|polarisation| {
        let solved = Gmres::default().solve(&problem.polarised(polarisation), goal, &mut Silent);
        solved.unwrap_or_else(|e| panic!("{e}")).field
    });
    let far = far_fields(&problem, &fields);
    Solved { problem, fields, far }
}

/// What leaves the layer in s and p light.
pub fn far_fields(problem: &Arc<VectorProblem>, fields: &[Field; 2]) -> [FarField; 2] {
    [0, 1].map(|i| problem.polarised(Polarisation::BOTH[i]).far_field(&fields[i]))
}

/// Points and cells, one point along directions in which nothing changes.
pub fn resolution(case: &Case, points: usize, cells: usize) -> Resolution {
    crate::support::resolution(case, points, cells, Scheme::Quadratic)
}

/// What `inkwave solve --wave vector --accuracy` does.
pub fn solve_to(case: &Case, accuracy: f64) -> Result<Estimated, AccuracyError> {
    let solver = Gmres::default();
    let task = Task {
        coverages: &Coverages::new(
            Wave::Unpolarised,
            &case.scene,
            Precision::of(Precision::error_for(accuracy)),
        ),
        media: &case.media,
        incidence: &case.incidence,
        mean: Mean::default(),
        scheme: Scheme::Quadratic,
        solver: &solver,
        goal: Goal::default(),
        memory: 4e9,
    };
    task.solve_to_accuracy(accuracy, &mut Silent)
}
