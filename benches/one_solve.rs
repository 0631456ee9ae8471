//! Where the time of one production solve goes: 10 × 10 × 1 µm, 30 % spheres of 250 nm, κ = 0.1, λ = 0.55 µm.
//!
//! `cargo bench --bench one_solve [-- POINTS_PER_UM CELLS TOLERANCE PERIOD_UM KAPPA]` prints medians of each part measured in the
//! same run, and the ratio of the solve to its floor: one forward and one inverse transform of every plane a step.

mod support;

use inkwave::numerics::fourier::PlaneFft;
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::{Coverage, Field, Mean, Resolution, Scheme};
use std::sync::Arc;
use std::time::Instant;

const REPEATS: usize = 5;

fn main() {
    let numbers: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let number = |i: usize, default: f64| numbers.get(i).copied().unwrap_or(default);
    let period = number(3, 10.0);
    let n = (number(0, 12.0) * period).round() as usize;
    let resolution = Resolution { nx: n, ny: n, cells: number(1, 9.0) as usize, scheme: Scheme::Cubic };
    let tolerance = number(2, 1e-4);
    let scene = support::scene(period, 1.0);
    let coverage = Arc::new(Coverage::new(&scene, resolution).expect("coverage"));
    let problem = support::problem(&coverage, number(4, 0.1), Mean::default());
    println!(
        "{} bodies, {} unknowns, {} planes of {n} × {n}",
        scene.bodies.len(),
        problem.unknowns(),
        problem.shape().0
    );
    let coverage_s = median(|| drop(Coverage::new(&scene, resolution)));
    let factors_s = median(|| drop(support::problem(&coverage, 0.1, Mean::default())));
    let goal = Goal { tolerance, ..Goal::default() };
    let solution = Gmres::default().solve(&problem, goal, &mut Silent).expect("solve");
    let solve_s = median(|| drop(Gmres::default().solve(&problem, goal, &mut Silent)));
    let applications = solution.account.operator_applications as f64;
    let mut out = Field::zeros(problem.shape());
    let loads_s = median(|| problem.double().contrast_loads(solution.field.view(), &mut out)) * applications;
    let (fft, planes) = (PlaneFft::new(n, n), problem.shape().0);
    let floor_s = median(|| support::transforms(&fft, n, planes)) * applications;
    let mean_s = median(|| problem.mean.inverse.solve_loads(&mut out)) * applications;
    let rows = [
        ("coverage (once per geometry)", coverage_s),
        ("factors (once per wavelength and angle)", factors_s),
        ("solve", solve_s),
        ("  floor: transforms alone", floor_s),
        ("  products, plane values, gather and scatter", loads_s - floor_s),
        ("  mean solves", mean_s),
        ("  orthogonalisation and the rest", solve_s - loads_s - mean_s),
    ];
    rows.iter().for_each(|(name, seconds)| println!("{name:48} {:8.1} ms", seconds * 1e3));
    let bytes = solution.account.bytes + problem.bytes();
    println!("{applications} operator applications, residual {:.1e}", solution.account.residual);
    let finer = Resolution { nx: n * 4 / 3, ny: n * 4 / 3, cells: resolution.cells * 4 / 3, ..resolution };
    let finer = Arc::new(Coverage::new(&scene, finer).expect("coverage"));
    let finer = support::problem(&finer, number(4, 0.1), Mean::default());
    let reference = Gmres::default().solve(&finer, Goal::default(), &mut Silent).expect("solve");
    let error = inkwave::solve::accuracy::largest_difference(
        &problem.far_field(&solution.field),
        &finer.far_field(&reference.field),
    );
    println!("largest difference of any amplitude to a grid 4/3 as fine: {error:.1e}");
    println!("solve / floor = {:.2}", solve_s / floor_s);
    println!(
        "{:.0} bytes per unknown, {:.2} GB in all",
        bytes as f64 / problem.unknowns() as f64,
        bytes as f64 / 1e9
    );
}

fn median(mut run: impl FnMut()) -> f64 {
    let mut seconds: Vec<f64> = (0..REPEATS)
        .map(|_| {
            let clock = Instant::now();
            run();
            clock.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[REPEATS / 2]
}
