//! The relaxation's result does not depend on its parameter.

use crate::cells::{Cell, REAL, solve};
use crate::claim::{Claim, Findings, Level, Table, short};
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::solve::{Account, Gmres, Relaxation};
use inkwave::wave::{Field, Problem, Side};

pub const CLAIM: Claim = Claim {
    id: "05-tau-independence",
    statement: "Relaxation ends in the same field for every step τ over two decades.",
    because: "The fixed point of the split step is the solution of (A + V) u = b whatever τ is (P2 section 3, corrected (3.13)).",
    file: file!(),
    measure,
};

const TOLERANCE: f64 = 1e-10;

/// Largest difference of two fields over the largest value.
pub fn distance(a: &Field, b: &Field) -> f64 {
    let largest = |f: &Field| f.iter().map(|z| z.norm()).fold(0.0, f64::max);
    largest(&(a - b)) / largest(b)
}

/// Residual against operator applications, spread evenly over the looks at it.
pub fn history(name: impl Into<String>, account: &Account) -> Curve {
    let each = account.operator_applications as f64 / (account.history.len().max(2) - 1) as f64;
    let points = account.history.iter().enumerate().skip(1).map(|(i, &r)| (i as f64 * each, r));
    Curve::new(name, Style::Data, points)
}

fn measure(level: Level, findings: &mut Findings) {
    let taus: &[f64] = level.pick(&[0.6, 6.0, 60.0], &[0.6, 1.2, 3.0, 6.0, 12.0, 30.0, 60.0]);
    for kappa in [0.0, 0.1] {
        let cell = Cell { mean: REAL, ..Cell::new(kappa, level.pick([8, 7], [12, 11]), 5) };
        let problem = cell.problem((25.0, 40.0, Side::Incident));
        let truth = solve(&Gmres::default(), &problem, 0.1 * TOLERANCE).expect("krylov").field;
        let mut histories = Vec::new();
        let mut largest = 0.0f64;
        for &tau in taus {
            let relaxation = Relaxation { tau, ..Relaxation::default() };
            let solution = solve(&relaxation, &problem, TOLERANCE)
                .unwrap_or_else(|e| panic!("τ = {tau}, κ = {kappa}: {e}"));
            largest = largest.max(distance(&solution.field, &truth));
            histories.push(history(format!("τ = {tau}"), &solution.account));
        }
        let what = format!("spread over τ = {} … {}, κ = {kappa}", taus[0], taus[taus.len() - 1]);
        findings.identity(
            what,
            largest,
            100.0 * TOLERANCE,
            "the residual, amplified by at most 100 on so small a cell",
        );
        findings.plots.push(Chart::log_log(
            &format!("Relaxation, κ = {kappa}"),
            "operator applications",
            "relative residual",
            histories,
        ));
    }
    if level == Level::Full {
        optimum(findings);
    }
}

/// Absorption of the grains, which makes contrasts |V| of one to seven.
const KAPPAS: [f64; 5] = [0.05, 0.2, 0.4, 0.7, 1.0];
/// Steps in units of 1/|V|.
const STEPS: [f64; 6] = [0.75, 1.5, 3.0, 6.0, 12.0, 24.0];

/// The step that converges fastest, for contrasts of different size. P2 gives τ ~ 1/|V| as its authors' experience; with averaging
/// restarts the optimum is flat, and the table says how flat.
fn optimum(findings: &mut Findings) {
    let row = |&kappa: &f64| {
        let problem =
            Cell { mean: REAL, ..Cell::new(kappa, [10, 9], 5) }.problem((25.0, 40.0, Side::Incident));
        let applications = |&tau: &f64| {
            let relaxation = Relaxation { tau, ..Relaxation::default() };
            solve(&relaxation, &problem, 1e-8)
                .map_or("none".into(), |s| s.account.operator_applications.to_string())
        };
        let counts = STEPS.iter().map(applications);
        [short(kappa), short(largest_contrast(&problem))].into_iter().chain(counts).collect()
    };
    let steps = STEPS.iter().map(|tau| format!("τ‖V‖ = {tau}"));
    findings.tables.push(Table {
        title: "Applications of relaxation to 1e-8 against its step".into(),
        columns: ["κ of the grains", "‖V‖, 1/µm²"].map(String::from).into_iter().chain(steps).collect(),
        rows: KAPPAS.iter().map(row).collect(),
    });
}

/// Largest |k² − ⟨k²⟩| at the points of all planes, 1/µm².
fn largest_contrast(problem: &Problem) -> f64 {
    let plane = |(p, mass): (usize, f64)| {
        problem.contrast_per_mass(p, mass).into_iter().map(|v| v.norm()).fold(0.0, f64::max)
    };
    problem.mean.plane_mass().into_iter().enumerate().map(plane).fold(0.0, f64::max)
}
