//! References of the vector wave with their expected amplitudes, and short ways to solve them in both polarisations.

use inkwave::input::case::Case;
use inkwave::solve::accuracy::{AccuracyError, Estimated, Task};
use inkwave::solve::{Coverages, Gmres, Goal, Silent, Solver};
use inkwave::wave::contrast::coverage::error_for;
use inkwave::wave::maxwell::{
    Averaging, NormalMoments, Polarisation, VectorFarField, VectorOrder, VectorProblem,
};
use inkwave::wave::{Field, Mean, Resolution, Scheme};
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
    pub fn errors(&self, far: &VectorFarField) -> [[f64; 2]; 2] {
        let mut errors = [[0.0_f64; 2]; 2];
        for expected in &self.orders {
            let number = |key: &str| expected[key].as_i64().expect("orders are whole numbers") as i32;
            let (m, n) = (number("m"), number("n"));
            let travels = expected["propagating_R"] == true || expected["propagating_T"] == true;
            if !travels && (m.abs() > 1 || n.abs() > 1) {
                continue;
            }
            let own = order(far, m, n);
            for (i, input) in ["s", "p"].into_iter().enumerate() {
                for (j, output) in ["s", "p"].into_iter().enumerate() {
                    for (side, amplitudes) in [("R", own.reflected), ("T", own.transmitted)] {
                        let difference = complex(&expected[side][input][output]) - amplitudes[i][j];
                        errors[i][j] = errors[i][j].max(difference.norm());
                    }
                }
            }
        }
        errors
    }

    /// The largest of [`Reference::errors`].
    pub fn error(&self, far: &VectorFarField) -> f64 {
        self.errors(far).into_iter().flatten().fold(0.0, f64::max)
    }
}

fn complex(value: &Value) -> Complex64 {
    let part = |i: usize| value[i].as_f64().expect("amplitudes are pairs of numbers");
    Complex64::new(part(0), part(1))
}

/// The order (m, n) of a far field.
pub fn order(far: &VectorFarField, m: i32, n: i32) -> &VectorOrder {
    far.orders.iter().find(|o| (o.m, o.n) == (m, n)).unwrap_or_else(|| panic!("no order ({m}, {n})"))
}

/// Both solutions of a case and what leaves the layer.
pub struct Solved {
    pub problem: VectorProblem,
    pub fields: [Field; 2],
    pub far: VectorFarField,
}

/// The discrete problem of a case.
pub fn problem(case: &Case, resolution: Resolution, mean: Mean, averaging: Averaging) -> VectorProblem {
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
    let far = problem.far_field([&fields[0], &fields[1]]);
    Solved { problem, fields, far }
}

/// Points and cells, one point along directions in which nothing changes.
pub fn resolution(case: &Case, points: usize, cells: usize) -> Resolution {
    crate::support::resolution(case, points, cells, Scheme::Quadratic)
}

/// What `inkwave solve --wave vector --accuracy` does.
pub fn solve_to(case: &Case, accuracy: f64) -> Result<Estimated<NormalMoments>, AccuracyError> {
    let solver = Gmres::default();
    let task = Task {
        coverages: &Coverages::vector(&case.scene, error_for(accuracy)),
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
