//! What Maxwell's equations cost against the scalar wave: the same packing, grid, light and residual in one run.
//!
//! `cargo bench --bench waves` prints a table in Markdown and writes `reports/speed/vector.csv`; `-- PERIOD_UM …` prints other
//! cells. Processor seconds of one solve with its problem (shared by s and p in unpolarised light), operator
//! applications, bytes of the problem with the solver's vectors, and processor seconds of the geometry, which all
//! wavelengths and directions share. Ink of 30 % spheres of 250 nm, η = 1.4 + 0.1i, 1 µm, λ = 0.55 µm, 12 points and 18
//! planes a µm, residual 1e-4. One thread: `RAYON_NUM_THREADS=1`.

mod support;

use inkwave::run::crew::processor_seconds;
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::maxwell::{Averaging, NormalMoments, Polarisation, VectorProblem};
use inkwave::wave::{Coverage, Incidence, Mean, Media, Precision, Problem, Resolution, Scheme, Side, System};
use num_complex::Complex64;
use std::sync::Arc;

/// Solves are repeated until they have taken so long, s: ticks of the processor's clock say little of less.
const LEAST_SECONDS: f64 = 1.0;
const POINTS_PER_UM: f64 = 12.0;
const CELLS: usize = 9;
/// Accuracy that the geometry's moments are made for.
const ACCURACY: f64 = 1e-3;
const GOAL: Goal = Goal { tolerance: 1e-4, max_applications: 2000 };

/// Periods of the published table, µm.
const PERIODS: [f64; 4] = [1.2, 1.6, 2.4, 10.0];
/// Most that is asked of one polarisation, of both, and of memory, over the scalar wave's.
const ASKED: [f64; 3] = [4.0, 7.0, 4.0];

/// What one kind of solve takes.
#[derive(Clone, Copy)]
struct Cost {
    seconds: f64,
    applications: usize,
    bytes: usize,
}

/// One line of the table.
struct Row {
    period: f64,
    wave: &'static str,
    cost: Cost,
    scalar: Cost,
    geometry: f64,
    most: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let periods = if asked.is_empty() { PERIODS.to_vec() } else { asked.clone() };
    println!(
        "| period, µm | wave | processor time, s | times the scalar's | asked | applications | MB | times the scalar's | geometry, s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let rows: Vec<Row> = periods.into_iter().flat_map(compare).collect();
    if asked.is_empty() { write(&rows) } else { Ok(()) }
}

fn compare(period: f64) -> Vec<Row> {
    let n = (POINTS_PER_UM * period).round() as usize | 1;
    let grid = Resolution { nx: n, ny: n, cells: CELLS, scheme: Scheme::Quadratic };
    let scene = support::scene(period, 1.0);
    let timed = |start: f64| clock() - start;
    let start = clock();
    let coverage = Arc::new(
        Coverage::with(&scene, grid, Precision::of(Precision::error_for(ACCURACY))).expect("coverage"),
    );
    let (covered, start) = (timed(start), clock());
    let moments = Arc::new(
        NormalMoments::with(&scene, grid, Precision::of(Precision::error_for(ACCURACY))).expect("moments"),
    );
    let made = timed(start);
    let scalar = repeated(|| scalar(&coverage));
    let [one, both, _] = ASKED;
    let lit = |p: &[Polarisation]| repeated(|| vector(&moments, p));
    let row = |wave, cost, geometry, most| {
        let row = Row { period, wave, cost, scalar, geometry, most };
        row.print();
        row
    };
    vec![
        row("scalar", scalar, covered, 1.0),
        row("s", lit(&Polarisation::BOTH[..1]), made, one),
        row("p", lit(&Polarisation::BOTH[1..]), made, one),
        row("unpolarised", lit(&Polarisation::BOTH), made, both),
    ]
}

impl Row {
    fn times(&self) -> [f64; 2] {
        [self.cost.seconds / self.scalar.seconds, self.cost.bytes as f64 / self.scalar.bytes as f64]
    }

    fn print(&self) {
        let Cost { seconds, applications, bytes } = self.cost;
        let ([times, memory], megabytes) = (self.times(), 1e-6 * bytes as f64);
        println!(
            "| {} | {} | {seconds:.4} | {times:.2} | {} | {applications} | {megabytes:.1} | {memory:.2} | {:.3} |",
            self.period, self.wave, self.most, self.geometry
        );
    }
}

fn write(rows: &[Row]) -> Result<(), Box<dyn std::error::Error>> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/speed/vector.csv");
    let mut table = csv::Writer::from_path(&path)?;
    table.write_record([
        "period_um",
        "wave",
        "seconds",
        "times_scalar",
        "times_asked",
        "applications",
        "megabytes",
        "memory_times_scalar",
        "memory_times_asked",
        "geometry_seconds",
    ])?;
    for row in rows {
        let ([times, memory], asked) = (row.times(), if row.wave == "scalar" { 1.0 } else { ASKED[2] });
        table.write_record([
            row.period.to_string(),
            row.wave.to_owned(),
            format!("{:.4}", row.cost.seconds),
            format!("{times:.2}"),
            row.most.to_string(),
            row.cost.applications.to_string(),
            format!("{:.1}", 1e-6 * row.cost.bytes as f64),
            format!("{memory:.2}"),
            asked.to_string(),
            format!("{:.3}", row.geometry),
        ])?;
    }
    table.flush()?;
    println!("written to {}", path.display());
    Ok(())
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
    Cost { seconds: 0.0, applications: joint.0, bytes: joint.1 + problem.polarised(polarisations[0]).bytes() }
}

fn solve(system: &dyn System) -> (usize, usize) {
    let solution = Gmres::default().solve(system, GOAL, &mut Silent).expect("solve");
    (solution.account.operator_applications, solution.account.bytes)
}
