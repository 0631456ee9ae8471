//! Every reference case through the search for a resolution: errors and honesty of the estimates.

use crate::support::*;
use inkwave::solve::accuracy::Estimated;

struct Row {
    id: &'static str,
    error: f64,
    estimate: f64,
    solved: Estimated,
}

fn row(reference: &'static Reference, accuracy: f64) -> Row {
    let solved = solve_to(&reference.case, accuracy).unwrap_or_else(|e| panic!("{}: {e}", reference.id));
    let error = reference.largest_error(&solved.far_field);
    let estimate = solved.error_estimate;
    println!("{:24} error {error:.1e}, estimate {estimate:.1e}", reference.id);
    Row { id: &reference.id, error, estimate, solved }
}

/// Indices far outside an ink's: judged at a lower accuracy below.
const HIGH_CONTRAST: [&str; 3] = ["sph15", "sph16", "lam10_metal_published"];

fn rows(accuracy: f64) -> Vec<Row> {
    let wanted = |r: &&Reference| !r.is_uniform() && !HIGH_CONTRAST.contains(&r.id.as_str());
    references().iter().filter(wanted).map(|r| row(r, accuracy)).collect()
}

#[test]
fn every_case_is_as_accurate_as_asked_and_the_estimates_are_honest() {
    let rows = rows(1e-3);
    assert_eq!(rows.len(), 23, "all cylinder, lamellar, sphere and ink cases");
    for row in &rows {
        // The accuracy asked for.
        assert!(row.error <= 1e-3 && row.estimate <= 1e-3, "{}: {:e}", row.id, row.error);
        // Identity: exact balance of the discrete problem, to its residual.
        let residual = row.solved.solution.account.residual;
        assert!(row.solved.far_field.energy_error().abs() <= 10.0 * residual, "{}", row.id);
    }
    let share =
        |holds: &dyn Fn(&Row) -> bool| rows.iter().filter(|r| holds(r)).count() as f64 / rows.len() as f64;
    // The stated promise: nine cases of ten either way.
    assert!(share(&|r| r.estimate >= r.error) >= 0.9);
    assert!(share(&|r| r.estimate <= 30.0 * r.error) >= 0.9);
}

#[test]
fn a_tenth_of_the_error_can_be_had() {
    for id in ["sph06", "sph14", "inka1", "inkb2", "cyl07", "lam03"] {
        let row = row(reference(id), 1e-4);
        assert!(row.error <= 1e-4, "{id}: {:e}", row.error);
    }
}

#[test]
fn ink_cells_need_few_points() {
    // A claim about cost: 20 points and 30 planes per µm for grains of an ink's contrast. In inkb3 an order just beyond
    // grazing resonates: its amplitude alone has an error of 1e-3 on 30 planes per µm, so the search goes on to 40.
    let of_grains = |r: &&Reference| ["ink3d", "spheres3d"].contains(&r.kind.as_str());
    let cases: Vec<_> =
        references().iter().filter(of_grains).filter(|r| !HIGH_CONTRAST.contains(&r.id.as_str())).collect();
    assert_eq!(cases.len(), 14);
    for reference in cases.into_iter().filter(|r| r.id != "inkb3") {
        let row = row(reference, 1e-3);
        let grid = &row.solved.problem.coverage.grid;
        let points = grid.resolution.nx as f64 / grid.period_um[0];
        let planes = (grid.planes() - 1) as f64 / grid.nodes_um[grid.cells()];
        let few = points < 20.01 && planes < 30.01;
        assert!(few && row.error <= 1e-3, "{}: {points} points, {planes} planes per µm", reference.id);
    }
}

#[test]
fn high_contrast_is_solved_to_a_hundredth() {
    for id in HIGH_CONTRAST {
        let row = row(reference(id), 1e-2);
        assert!(row.error <= 1e-2, "{id}: {:e}", row.error);
    }
}

#[test]
fn accuracies_beyond_reach_are_refused() {
    for accuracy in [0.0, -1e-3, 1e-10, 0.9, f64::NAN] {
        let error = solve_to(&reference("sph02").case, accuracy).err().expect("out of range");
        assert!(error.to_string().contains("1e-9 … 0.5"), "{error}");
    }
}
