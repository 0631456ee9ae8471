//! Coated and hollow spheres, also as ellipsoids of equal axes, and tilted ellipsoids against T-matrices, in both waves.

use crate::claim::{Claim, Findings, Level, short};
use crate::vector::{complex, order, pairs};
use crate::{support, vector};
use inkwave::input::case::Case;
use inkwave::wave::Scheme;
use serde_json::{Value, json};

pub const CLAIM: Claim = Claim {
    id: "27-coated-spheres",
    statement: "Layered and hollow spheres, given as spheres or as ellipsoids of equal axes, and tilted ellipsoids of three axes: every order's amplitude is as accurate as asked, and on a fine grid within 1e-4, in the scalar and in the vector wave.",
    because: "Arrays of coated spheres by multipoles: the series of each sphere (Bohren and Huffman, chapter 8; its scalar counterpart) with Ewald lattice sums, converged to 3e-10 (`validation/coated.py`), and of ellipsoids by the null-field method, converged to 2e-7 (`validation/ellipsoids.py`).",
    file: file!(),
    measure,
};

/// Points and cells of the fine grid.
const FINE: [usize; 2] = [25, 40];

struct Coated {
    id: String,
    vector: bool,
    case: Case,
    /// The spheres as ellipsoids.
    ellipsoids: Option<Case>,
    orders: Vec<Value>,
}

fn cases() -> Vec<Coated> {
    let files = [include_str!("../data/coated.json"), include_str!("../data/ellipsoids.json")];
    let read = |case: &Value| Coated {
        id: case["id"].as_str().expect("an id").into(),
        vector: case["wave"] == "vector",
        case: Case::parse(&case["inputs"].to_string(), false).expect("a case"),
        ellipsoids: with_ellipsoids(&case["inputs"])
            .map(|i| Case::parse(&i.to_string(), false).expect("a case")),
        orders: case["orders"].as_array().expect("orders").clone(),
    };
    let file = |text: &str| serde_json::from_str::<Value>(text).expect("JSON")["cases"].take();
    let listed = |text: &str| file(text).as_array().expect("cases").iter().map(read).collect::<Vec<_>>();
    files.into_iter().flat_map(listed).collect()
}

/// The inputs of a case with every sphere as an ellipsoid of three equal axes.
fn with_ellipsoids(inputs: &Value) -> Option<Value> {
    let mut inputs = inputs.clone();
    let spheres = inputs.as_object_mut()?.remove("spheres")?;
    let body = |s: &Value| {
        let axis = 2.0 * s["radius"].as_f64().expect("a radius");
        json!({"shape": {"kind": "ellipsoid", "axes": [axis, axis, axis]}, "center": s["center"], "eta": s["eta"]})
    };
    inputs["bodies"] = spheres.as_array()?.iter().map(body).collect();
    Some(inputs)
}

impl Coated {
    /// Largest error of all amplitudes; `amplitude` gives that of an order (m, n) on one side (0 reflected, 1 transmitted) from one
    /// polarisation to another.
    fn error(&self, amplitude: impl Fn([i32; 2], usize, [usize; 2]) -> num_complex::Complex64) -> f64 {
        let mut largest = 0.0_f64;
        for order in &self.orders {
            let at = ["m", "n"].map(|key| order[key].as_i64().expect("a whole number") as i32);
            let side = usize::from(order["side"] == "transmitted");
            let expected = &order["amplitude"];
            for (i, j) in (0..2).flat_map(|i| (0..2).map(move |j| (i, j))) {
                let listed = if self.vector { &expected[NAMES[i]][NAMES[j]] } else { expected };
                largest = largest.max((amplitude(at, side, [i, j]) - complex(listed)).norm());
            }
        }
        largest
    }

    fn error_to(&self, accuracy: f64) -> f64 {
        if self.vector {
            let solved = vector::solve_to(&self.case, accuracy).expect("solved");
            return self.error(|[m, n], side, [i, j]| pairs(order(&solved.far_fields, m, n))[side][i][j]);
        }
        let solved = support::solve_to(&self.case, accuracy).expect("solved");
        self.error(|[m, n], side, _| sides(support::order(solved.far_field(), m, n))[side])
    }

    fn error_at(&self, case: &Case, [points, cells]: [usize; 2]) -> f64 {
        if self.vector {
            let solved = vector::solve(case, points, cells, 1e-8);
            return self.error(|[m, n], side, [i, j]| pairs(order(&solved.far, m, n))[side][i][j]);
        }
        let grid = support::resolution(case, points, cells, Scheme::Cubic);
        let solved = support::solve_at(case, grid, 1e-8);
        self.error(|[m, n], side, _| sides(support::order(&solved.far, m, n))[side])
    }
}

const NAMES: [&str; 2] = ["s", "p"];

fn sides(order: &inkwave::wave::Order) -> [num_complex::Complex64; 2] {
    [order.reflected, order.transmitted]
}

fn measure(level: Level, findings: &mut Findings) {
    for coated in cases() {
        let asked = if coated.vector { level.pick(2e-3, 1e-3) } else { level.pick(1e-3, 1e-4) };
        let what = format!("{} at {}", coated.id, short(asked));
        findings.promise(what, coated.error_to(asked), asked, "the accuracy asked for");
        let what = format!("{} on {} points and {} cells", coated.id, FINE[0], FINE[1]);
        let because = "four digits for layers as for spheres";
        findings.promise(&what, coated.error_at(&coated.case, FINE), 1e-4, because);
        if let Some(ellipsoids) = &coated.ellipsoids {
            let what = format!("{what}, as ellipsoids");
            findings.promise(what, coated.error_at(ellipsoids, FINE), 1e-4, because);
        }
    }
}
