//! Costs of every stage against the grid's size, for `scripts/bench-track`.
//!
//! 30 % spheres of 250 nm, 12 points per µm. Beside the times, counts of work go to target/criterion/work.csv: they
//! do not depend on the machine.

mod support;

use criterion::{BenchmarkId, Criterion};
use inkwave::appearance::bdf::{Bdf, Lobe, suggested_bandwidth};
use inkwave::ink::pack;
use inkwave::ink::{MethodChoice, PackingRequest, PigmentGrains};
use inkwave::numerics::fourier::PlaneFft;
use inkwave::solve::{Gmres, Goal, Registry, Silent, Solver};
use inkwave::wave::{Coverage, Field, Mean};
use serde::Serialize;
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

/// Counts of one bench.
#[derive(Serialize)]
struct Work {
    bench: String,
    unknowns: usize,
    applications: usize,
    bytes: usize,
}

const THICKNESS_UM: f64 = 1.0;
const CELLS: usize = 9;
/// Thin enough for the Born series to converge, and for dense matrices.
const THIN_UM: f64 = 0.4;
const THIN_CELLS: usize = 4;
const KAPPA: f64 = 0.1;

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1500))
        .configure_from_args();
    let mut work = Vec::new();
    operator(&mut criterion, &mut work);
    strategies(&mut criterion, &mut work);
    geometry(&mut criterion, &mut work);
    point(&mut criterion, &mut work);
    criterion.final_summary();
    write(&work);
}

/// One operator application beside its floor: the transforms alone.
fn operator(criterion: &mut Criterion, work: &mut Vec<Work>) {
    let mut group = criterion.benchmark_group("operator");
    for side in [1.0, 2.0, 4.0, 8.0] {
        let coverage = support::coverage(side, THICKNESS_UM, CELLS);
        let problem = support::problem(&coverage, KAPPA, Mean::default());
        let (n, planes) = (coverage.grid.resolution.nx, problem.shape().0);
        let (fft, field) = (PlaneFft::new(n, n), problem.background_wave());
        let mut out = Field::zeros(problem.shape());
        group.bench_function(BenchmarkId::new("application", side), |b| {
            b.iter(|| problem.scatter(black_box(&field), &mut out))
        });
        group.bench_function(BenchmarkId::new("floor", side), |b| {
            b.iter(|| support::transforms(&fft, n, planes))
        });
        for name in ["application", "floor"] {
            let bench = format!("operator/{name}/{side}");
            work.push(Work { bench, unknowns: problem.unknowns(), applications: 1, bytes: problem.bytes() });
        }
    }
    group.finish();
}

/// Every strategy to a residual of 1e-6 on the same layers.
fn strategies(criterion: &mut Criterion, work: &mut Vec<Work>) {
    let mut group = criterion.benchmark_group("strategy");
    let goal = Goal { tolerance: 1e-6, max_applications: 20_000 };
    for entry in Registry::default().entries() {
        let (name, solver) = (entry.name.as_str(), entry.build());
        let dense = solver.most_unknowns().is_some();
        let sides: &[f64] = if dense { &[0.55, 0.75, 0.9] } else { &[0.7, 1.4, 2.8] };
        for &side in sides {
            let coverage = support::coverage(side, THIN_UM, THIN_CELLS);
            let problem = support::problem(&coverage, KAPPA, solver.suited_mean());
            let solve = || solver.solve(&problem, goal, &mut Silent);
            let account = match solve() {
                Ok(solution) => solution.account,
                Err(error) => {
                    eprintln!("{name} at {side} µm is left out: {error}");
                    continue;
                }
            };
            work.push(Work {
                bench: format!("strategy/{name}/{side}"),
                unknowns: problem.unknowns(),
                applications: account.operator_applications,
                bytes: account.bytes + problem.bytes(),
            });
            group.bench_function(BenchmarkId::new(name, side), |b| b.iter(solve));
        }
    }
    group.finish();
}

/// Coverage and packing.
fn geometry(criterion: &mut Criterion, work: &mut Vec<Work>) {
    let mut group = criterion.benchmark_group("geometry");
    for side in [1.0, 2.0, 4.0] {
        let (scene, resolution) = (support::scene(side, THICKNESS_UM), support::resolution(side, CELLS));
        let coverage = Coverage::new(&scene, resolution).expect("coverage");
        work.push(Work {
            bench: format!("geometry/coverage/{side}"),
            unknowns: coverage.grid.planes() * coverage.grid.points(),
            applications: 0,
            bytes: coverage.bytes(),
        });
        group.bench_function(BenchmarkId::new("coverage", side), |b| {
            b.iter(|| Coverage::new(black_box(&scene), resolution))
        });
    }
    for fraction in [0.3, 0.5] {
        let mut stream = 0;
        let request = PackingRequest {
            period_um: [4.0; 2],
            pigments: vec![PigmentGrains::spheres(250.0, fraction)],
            method: MethodChoice::Relaxation,
            ..Default::default()
        };
        group.bench_function(BenchmarkId::new("packing", fraction), |b| {
            b.iter(|| {
                stream += 1;
                pack(&PackingRequest { stream, ..request.clone() }, &mut ()).expect("these fractions fit")
            })
        });
    }
    group.finish();
}

/// One point of a study, 4 × 4 × 1 µm: problem, solve, far field and distribution.
fn point(criterion: &mut Criterion, work: &mut Vec<Work>) {
    let coverage = support::coverage(4.0, THICKNESS_UM, CELLS);
    let goal = Goal { tolerance: 1e-4, ..Goal::default() };
    let solve = || {
        let problem = support::problem(&coverage, KAPPA, Mean::default());
        let solution = Gmres::default().solve(&problem, goal, &mut Silent).expect("converges");
        let far = problem.far_field(&solution.field);
        let bandwidth = suggested_bandwidth(far.incidence.wavelength_um, far.period_um);
        let bdf = Bdf::from_ensemble(&[far]).expect("one field");
        let seen = bdf.azimuthal_mean(Lobe::Transmitted, 30.0, bandwidth).expect("orders are near");
        (seen, solution.account, problem.unknowns(), problem.bytes())
    };
    let (_, account, unknowns, bytes) = solve();
    let applications = account.operator_applications;
    work.push(Work {
        bench: "study/bdf_point/4".into(),
        unknowns,
        applications,
        bytes: bytes + account.bytes,
    });
    let mut group = criterion.benchmark_group("study");
    group.bench_function(BenchmarkId::new("bdf_point", 4), |b| b.iter(solve));
    group.finish();
}

fn write(work: &[Work]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/criterion/work.csv");
    let mut table = csv::Writer::from_writer(Vec::new());
    work.iter().try_for_each(|w| table.serialize(w)).expect("counts are numbers");
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder for the counts");
    inkwave::store::safely::write(&path, &table.into_inner().expect("the table")).expect("the counts' file");
}
