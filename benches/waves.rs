//! What Maxwell's equations cost against the scalar wave: the same packing, grid, light and residual in one run.
//!
//! `cargo bench --bench waves [-- PERIOD_UM …]` prints a table in Markdown: processor seconds of one solve with its problem (shared by
//! s and p in unpolarised light), operator applications, and bytes of the problem with the solver's vectors. Ink of 30 %
//! spheres of 250 nm, η = 1.4 + 0.1i, 1 µm, λ = 0.55 µm, 12 points and 18 planes a µm, residual 1e-4.

mod support;

use inkwave::run::crew::processor_seconds;
use inkwave::solve::{Gmres, Goal, Silent, Solver, System};
use inkwave::wave::maxwell::{Averaging, NormalMoments, Polarisation, VectorProblem};
use inkwave::wave::{Coverage, Incidence, Mean, Media, Problem, Resolution, Scheme, Side};
use num_complex::Complex64;
use std::sync::Arc;

/// Solves are repeated until they have taken so long, s: ticks of the processor's clock say little of less.
const LEAST_SECONDS: f64 = 1.0;
const POINTS_PER_UM: f64 = 12.0;
const CELLS: usize = 9;
const GOAL: Goal = Goal { tolerance: 1e-4, max_applications: 2000 };

/// What one kind of solve takes.
#[derive(Clone, Copy)]
struct Cost {
    seconds: f64,
    applications: usize,
    bytes: usize,
}

fn main() {
    let asked: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let periods = if asked.is_empty() { vec![1.2, 1.6, 2.4] } else { asked };
    println!(
        "| period, µm | wave | processor time, s | times the scalar's | applications | MB | times the scalar's |"
    );
    println!("|---|---|---|---|---|---|---|");
    periods.into_iter().for_each(compare);
}

fn compare(period: f64) {
    let n = (POINTS_PER_UM * period).round() as usize | 1;
    let grid = Resolution { nx: n, ny: n, cells: CELLS, scheme: Scheme::Quadratic };
    let scene = support::scene(period, 1.0);
    let coverage = Arc::new(Coverage::new(&scene, grid).expect("coverage"));
    let moments = Arc::new(NormalMoments::new(&scene, grid).expect("moments"));
    let scalar = repeated(|| scalar(&coverage));
    row(period, "scalar", scalar, scalar);
    row(period, "s", repeated(|| vector(&moments, &Polarisation::BOTH[..1])), scalar);
    row(period, "p", repeated(|| vector(&moments, &Polarisation::BOTH[1..])), scalar);
    row(period, "unpolarised", repeated(|| vector(&moments, &Polarisation::BOTH)), scalar);
}

fn row(period: f64, wave: &str, cost: Cost, scalar: Cost) {
    println!(
        "| {period} | {wave} | {:.3} | {:.2} | {} | {:.1} | {:.2} |",
        cost.seconds,
        cost.seconds / scalar.seconds,
        cost.applications,
        1e-6 * cost.bytes as f64,
        cost.bytes as f64 / scalar.bytes as f64
    );
}

/// Processor time of this process, s.
fn clock() -> f64 {
    processor_seconds().expect("the system tells processor time")
}

fn repeated(mut solve: impl FnMut() -> Cost) -> Cost {
    let mut cost = solve();
    let (start, mut count) = (clock(), 0);
    while clock() - start < LEAST_SECONDS {
        cost = solve();
        count += 1;
    }
    Cost { seconds: (clock() - start) / f64::from(count), ..cost }
}

fn light() -> (Media, Incidence) {
    let inclusions = vec![Complex64::new(1.4, 0.1)];
    let one = Complex64::ONE;
    let media = Media { incident: one, exit: one, backgrounds: vec![1.558.into()], inclusions };
    let incidence =
        Incidence { wavelength_um: 0.55, polar_deg: 30.0, azimuth_deg: 20.0, from: Side::Incident };
    (media, incidence)
}

fn scalar(coverage: &Arc<Coverage>) -> Cost {
    let (media, incidence) = light();
    let problem = Problem::new(coverage, &media, &incidence, Mean::default()).expect("problem");
    let (applications, bytes) = solve(&problem);
    Cost { seconds: 0.0, applications, bytes: bytes + problem.bytes() }
}

fn vector(moments: &Arc<NormalMoments>, polarisations: &[Polarisation]) -> Cost {
    let (media, incidence) = light();
    let problem = VectorProblem::new(moments, &media, &incidence, Mean::default(), Averaging::Normal);
    let problem = problem.expect("problem");
    let solves = polarisations.iter().map(|&p| solve(&problem.polarised(p)));
    let joint =
        solves.fold((0, 0), |(sum, most), (applications, bytes)| (sum + applications, bytes.max(most)));
    Cost { seconds: 0.0, applications: joint.0, bytes: joint.1 + problem.bytes() }
}

fn solve(system: &dyn System) -> (usize, usize) {
    let solution = Gmres::default().solve(system, GOAL, &mut Silent).expect("solve");
    (solution.account.operator_applications, solution.account.bytes)
}
