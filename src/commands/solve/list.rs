//! `inkwave solve` of a list of directions: one grid and one set-up for all of them.

use super::{Bar, Solving, gradient_text};
use crate::commands::solve_report::{POLARISATIONS, wave_name};
use crate::commands::terminal::say;
use inkwave::run::crew::processor_seconds;
use inkwave::solve::accuracy::{SharedGrid, Task, compared_directions};
use inkwave::solve::{Silent, Watch};
use inkwave::wave::Incidence;
use miette::{IntoDiagnostic, Result, WrapErr};
use rayon::prelude::*;
use serde_json::{Value, json};

/// Planes × points of a problem below which one solve does not use all processors, so that
/// directions are solved side by side.
const SIDE_BY_SIDE: usize = 40_000;

/// One direction's result.
struct Listed {
    report: Value,
    text: String,
    /// From the middle of a lobe of the lit square to its first zero, degrees.
    first_zero_deg: f64,
}

/// Solves all directions of the case and prints their results.
///
/// # Errors
/// One of the directions has no result.
pub fn run(solving: &Solving) -> Result<()> {
    let args = solving.args;
    if args.export_operator.is_some() {
        miette::bail!(
            "--export-operator writes one problem; the case lists `directions`: give one direction"
        );
    }
    let lights = solving.lights()?;
    let incidences: Vec<Incidence> = lights.iter().map(|(light, _)| *light).collect();
    let compared = compared_directions(&incidences);
    let shared = shared_grid(solving, &incidences, &compared)?;
    let one = |i: usize| {
        let (light, snapped) = &lights[i];
        listed(solving, &shared, light, snapped.as_ref()).wrap_err_with(|| format!("directions[{i}]"))
    };
    let unknowns = |grid: &SharedGrid| {
        let r = grid.resolution;
        r.nx * r.ny * r.cells * r.scheme.degree()
    };
    let solved: Vec<Listed> = if unknowns(&shared) < SIDE_BY_SIDE {
        (0..lights.len()).into_par_iter().map(one).collect::<Result<_>>()?
    } else {
        (0..lights.len()).map(one).collect::<Result<_>>()?
    };
    args.light.warn_of_step(solved.iter().map(|one| one.first_zero_deg).fold(f64::INFINITY, f64::min));
    if args.gradient_is_text() {
        return say(solved.iter().map(|one| &*one.text).collect::<String>().trim_end());
    }
    let report = json!({
        "wave": wave_name(solving.wave),
        "solves": solved.into_iter().map(|one| one.report).collect::<Vec<_>>(),
        // Directions, by number, whose error was estimated; the largest estimate is that of all.
        "compared": compared,
        "process_seconds": processor_seconds(),
        "version": env!("CARGO_PKG_VERSION"),
        "polarisations": if solving.wave.is_vector() { POLARISATIONS } else { "none: the scalar wave" },
    });
    say!("{:#}", solving.with_remarks(report))
}

/// The grid given, or the one that the directions compared need.
fn shared_grid(solving: &Solving, lights: &[Incidence], compared: &[usize]) -> Result<SharedGrid> {
    let tasks: Vec<Task> = compared.iter().map(|&i| solving.task(&lights[i])).collect();
    // cleared when it is dropped
    let bar: &mut dyn Watch = &mut Bar::new();
    let shared = match solving.resolution() {
        Some(resolution) => SharedGrid::given(&tasks, resolution, bar),
        None => SharedGrid::found(&tasks, solving.args.accuracy(), bar),
    };
    shared.into_diagnostic()
}

/// Solves one direction.
fn listed(
    solving: &Solving,
    shared: &SharedGrid,
    light: &Incidence,
    snapped: Option<&Value>,
) -> Result<Listed> {
    let task = solving.task(light);
    let solved = shared.solve(&task, &mut Silent).into_diagnostic()?;
    let gradients = solving.gradients(&task, &solved)?;
    let (mut report, first_zero_deg) = solving.report(&solved, light, snapped, &gradients)?;
    let said_once = ["process_seconds", "version", "polarisations", "remarks"];
    if let Some(entries) = report.as_object_mut() {
        entries.retain(|key, _| !said_once.contains(&key.as_str()));
    }
    let heading = format!("polar_deg {}, azimuth_deg {}\n", light.polar_deg, light.azimuth_deg);
    Ok(Listed { report, text: heading + &gradient_text(&gradients), first_zero_deg })
}
