//! Derivatives of R and T with respect to n and κ: tangent, adjoint and differences of solves.

use crate::cells::{Cell, solve};
use crate::claim::{Claim, Findings, Level};
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::solve::gradient::{FarSlopes, Neighbour, Slopes, adjoint, sensitivity, tangent};
use inkwave::solve::{Gmres, Goal, Silent};
use inkwave::wave::{DIRECTIONS, FarField, Field, Medium, Problem, Side, System};
use num_complex::Complex64;

pub const CLAIM: Claim = Claim {
    id: "31-gradients",
    statement: "Tangent and adjoint give the same derivatives of R and T with respect to n and κ, onto which central differences of solves fall with their fourth power; without absorption dR/dn = −dT/dn.",
    because: "The field is holomorphic in the index, so one solve gives both derivatives (M u′ = −M′ u). The adjoint solves the transposed operator, M(q)ᵀ = J M(−q) J, instead. Differences solve neighbouring layers and take A from the field within them.",
    file: file!(),
    measure,
};

const GOAL: Goal = Goal { tolerance: 1e-12, max_applications: 5000 };
const PIGMENT: Medium = Medium::Inclusion(0);

fn solved(problem: &Problem) -> Field {
    solve(&Gmres::default(), problem, GOAL.tolerance).expect("krylov").field
}

/// Derivatives by the tangent, with respect to the pigment's index.
fn by_tangent(problem: &Problem, u: &Field) -> FarSlopes {
    let neighbour = |direction: Complex64| {
        let step = 1e-4 * direction;
        let system = Box::new(problem.moved(PIGMENT, step).expect("sound")) as Box<dyn System>;
        Neighbour { step, system }
    };
    let neighbours = DIRECTIONS.map(neighbour);
    tangent(problem, u, &neighbours, &Gmres::default(), GOAL, &mut Silent).expect("converges")
}

/// Derivatives of c_R R + c_T T by the adjoint.
fn by_adjoint(problem: &Problem, u: &Field, weights: [f64; 2]) -> Slopes {
    let w = adjoint(problem, u, weights, &Gmres::default(), GOAL, &mut Silent).expect("converges");
    sensitivity(problem, u, &w, PIGMENT).expect("sound")
}

/// Differences of fourth order of R, T and A along n (0) or κ (1).
fn by_differences(problem: &Problem, along: usize, h: f64) -> [f64; 3] {
    let direction = [Complex64::ONE, Complex64::I][along];
    let at = |k: f64| {
        let moved = problem.moved(PIGMENT, k * h * direction).expect("sound");
        let FarField { reflectance, transmittance, absorptance, .. } = moved.far_field(&solved(&moved));
        [reflectance, transmittance, absorptance]
    };
    let a = at(-2.0);
    let b = at(-1.0);
    let c = at(1.0);
    let d = at(2.0);
    std::array::from_fn(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h))
}

/// Largest difference between the tangent's derivatives and those by differences.
fn apart(problem: &Problem, slopes: &FarSlopes, h: f64) -> f64 {
    let own = [slopes.reflectance, slopes.transmittance, slopes.absorptance];
    let error = |along: usize| {
        let differences = by_differences(problem, along, h);
        (0..3).map(|i| (differences[i] - own[i][along]).abs()).fold(0.0, f64::max)
    };
    error(0).max(error(1))
}

fn measure(level: Level, findings: &mut Findings) {
    let (points, cells) = level.pick(([8, 7], 5), ([12, 11], 8));
    let mut curves = Vec::new();
    for (kappa, from) in [(0.1, Side::Incident), (0.02, Side::Exit), (0.0, Side::Incident)] {
        let problem = Cell::new(kappa, points, cells).problem((25.0, 40.0, from));
        let u = solved(&problem);
        let slopes = by_tangent(&problem, &u);
        for (name, weights, own) in
            [("R", [1.0, 0.0], slopes.reflectance), ("T", [0.0, 1.0], slopes.transmittance)]
        {
            let adjoint = by_adjoint(&problem, &u, weights);
            let error = (0..2).map(|i| (adjoint[i] - own[i]).abs()).fold(0.0, f64::max);
            let because =
                "the residual 1e-12, amplified by the solve, and the tangent's step 1e-4 to its fourth power";
            findings.identity(format!("κ = {kappa}: {name}, adjoint less tangent"), error, 1e-9, because);
        }
        if kappa == 0.0 {
            let because = "nothing is absorbed at any n: the residual 1e-12, amplified by the solve";
            findings.identity("κ = 0: |dR/dn + dT/dn|", slopes.absorptance[0].abs(), 1e-9, because);
            // Differences along κ would leave the passive media.
            continue;
        }
        let steps = [8e-3, 4e-3, 2e-3];
        let errors = steps.map(|h| apart(&problem, &slopes, h));
        let order = (errors[0] / errors[1]).log2();
        let because = "four, but for the terms of sixth order";
        findings.order(format!("κ = {kappa}: order of the differences"), order, [3.8, 4.2], because);
        let points = steps.into_iter().zip(errors);
        curves.push(Curve::new(format!("κ = {kappa}"), Style::Data, points));
    }
    findings.plots.push(Chart::log_log(
        "Derivatives of R, T and A: differences of solves against the tangent",
        "step in n or κ",
        "largest difference",
        curves,
    ));
}
