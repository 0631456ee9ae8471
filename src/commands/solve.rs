//! `inkwave solve CASE`: one solve of an explicit geometry, as JSON on standard output.

use clap::Args;
use inkwave::solve::{Goal, Silent, SolverChoice};
use inkwave::study::case::Case;
use inkwave::wave::{FarField, Mean, Problem, Resolution, Scheme};
use miette::{IntoDiagnostic, Result};
use serde_json::json;
use std::path::PathBuf;

/// Solves one explicit geometry.
#[derive(Args)]
pub struct SolveArgs {
    /// Case file: JSON or TOML, the inputs themselves or an object holding them as `inputs`.
    case: PathBuf,
    #[arg(long, default_value = "krylov")]
    solver: String,
    #[arg(long)]
    nxy: Option<usize>,
    #[arg(long)]
    nz: Option<usize>,
    #[arg(long, default_value_t = 1e-6)]
    tolerance: f64,
    #[arg(long, default_value_t = 3)]
    degree: usize,
    #[arg(long)]
    constant_mean: bool,
    #[arg(long)]
    real_mean: bool,
}

pub fn run(args: &SolveArgs) -> Result<()> {
    let case = Case::read(&args.case).into_diagnostic()?;
    let n = args.nxy.unwrap_or(16);
    let ny = if case.scene.uniform_in_y() { 1 } else { n };
    let scheme = [Scheme::SecondDifference, Scheme::Tents, Scheme::Quadratic, Scheme::Cubic, Scheme::Quartic]
        [args.degree];
    let resolution = Resolution { nx: n, ny, cells: args.nz.unwrap_or(16), scheme };
    let mean = Mean { depends_on_z: !args.constant_mean, absorbing: !args.real_mean };
    let clock = std::time::Instant::now();
    let problem =
        Problem::from_scene(&case.scene, &case.media, &case.incidence, resolution, mean).into_diagnostic()?;
    let setup = clock.elapsed().as_secs_f64();
    let goal = Goal { tolerance: args.tolerance, ..Goal::default() };
    let solver = SolverChoice::named(&args.solver).into_diagnostic()?.build();
    let solution = solver.solve(&problem, goal, &mut Silent).into_diagnostic()?;
    let far: FarField = problem.far_field(&solution.field);
    let orders: Vec<_> = far
        .orders
        .iter()
        .map(|o| {
            json!({
        "m": o.m, "n": o.n, "propagating": o.reflected_propagates || o.transmitted_propagates,
        "R": [o.reflected.re, o.reflected.im], "T": [o.transmitted.re, o.transmitted.im],
        "eff_R": o.reflected_efficiency, "eff_T": o.transmitted_efficiency})
        })
        .collect();
    let a = &solution.account;
    println!(
        "{}",
        json!({"orders": orders, "R_total": far.reflectance, "T_total": far.transmittance, "A_total": far.absorptance,
        "energy": far.energy_error(),
        "residual": a.residual, "steps": a.steps, "operator_applications": a.operator_applications, "seconds": a.seconds,
        "seconds_setup": setup, "coverage": problem.coverage.seconds, "unknowns": problem.unknowns()})
    );
    Ok(())
}
