//! `inkwave solve CASE`: one solve of an explicit geometry, as JSON on standard output.

mod list;

use super::progress::style;
use super::solve_options::{LightArgs, StudyPoint};
use super::solve_report;
use super::solve_report::{Gradient, gradients};
use super::terminal::say;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use inkwave::export::npz::operator;
use inkwave::input::case::Case;
use inkwave::input::wave_kind::WaveKind;
use inkwave::solve::accuracy::{Estimated, Solved, Task, suited_scheme};
use inkwave::solve::{Coverages, Goal, GridTrial, Solver, SolverChoice, Step, Watch};
use inkwave::wave::{Incidence, Mean, Precision, Resolution, Scheme, Wave};
use miette::{IntoDiagnostic, Result};
use serde_json::Value;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Accuracy if neither `--accuracy` nor a grid is given.
const DEFAULT_ACCURACY: f64 = 1e-3;

/// Solve one explicit geometry and print its orders as JSON
///
/// A case (JSON or TOML; `inkwave schema case --annotated` prints every key) describes one cell:
/// lengths in µm, angles in degrees, indices as [re, im]. A list of `directions` is solved on one
/// grid in one go: `solves` holds the result of each; the error estimate of all is the largest of
/// the directions numbered in `compared` (from 0), the steepest and the flattest of either side.
/// `remarks` in the result name lengths that
/// look as if they were in another unit. With the vector wave, `R.s.p` of an order is the amplitude
/// of the p light that leaves, for s light of amplitude 1 that arrives. With --realisation the
/// geometry is a realisation of a study instead.
#[derive(Args)]
pub struct SolveArgs {
    /// Case file; an object that holds the case as `inputs` is accepted too
    case: PathBuf,
    /// Requested amplitude error, for which a grid is searched (default: 1e-3 unless --nxy and --nz
    /// are given)
    #[arg(long, value_name = "ERROR", conflicts_with_all = ["nxy", "nz"], allow_negative_numbers = true)]
    accuracy: Option<f64>,
    /// Strategy that solves the discrete system; relaxation needs --real-mean
    #[arg(long, default_value = SolverChoice::NAMES[0], value_parser = PossibleValuesParser::new(SolverChoice::NAMES))]
    solver: String,
    /// Points along x and y of one period
    #[arg(long, value_name = "POINTS", requires = "nz")]
    nxy: Option<usize>,
    /// Cells along z
    #[arg(long, value_name = "CELLS")]
    nz: Option<usize>,
    /// Relative residual to reach (default: a fiftieth of the accuracy, or 1e-6 with --nz)
    #[arg(long, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Equation to solve (default: the study's, or scalar)
    #[arg(long, value_parser = wave_kinds())]
    wave: Option<WaveKind>,
    /// Discretisation along z (default: cubic; quartic if --accuracy is below 3e-3)
    #[arg(long, value_parser = PossibleValuesParser::new(SCHEMES).try_map(|name| scheme_named(&name)))]
    scheme: Option<Scheme>,
    /// Average ⟨k²⟩ over the whole layer instead of over each cell
    #[arg(long)]
    constant_mean: bool,
    /// Leave absorption out of ⟨k²⟩
    #[arg(long)]
    real_mean: bool,
    /// Memory for one solve, GB
    #[arg(long, default_value_t = 4.0)]
    memory_gb: f64,
    /// Write the discrete problem and its solution as NumPy arrays (scalar wave), which
    /// python/apply_operator.py reads
    #[arg(long, value_name = "FILE.npz")]
    export_operator: Option<PathBuf>,
    /// Add `gradients`, derivatives of orders and totals with respect to n and κ of every medium;
    /// `text` prints only those of the totals
    ///
    /// Each of `gradients` has `medium` (background or inclusion and its number), `index`, and `dn`
    /// and `dk` of `R_total`, `T_total`, `A_total` and of each order's `eff_R` and `eff_T`; `R` and
    /// `T` of an order are [re, im] of da/dη, from which da/dκ follows by the factor i.
    #[arg(long, value_enum, value_name = "FORM", num_args = 0..=1, default_missing_value = "json")]
    gradient: Option<GradientForm>,
    #[command(flatten)]
    point: StudyPoint,
    #[command(flatten)]
    light: LightArgs,
}

impl SolveArgs {
    /// Requested amplitude error.
    fn accuracy(&self) -> f64 {
        self.accuracy.unwrap_or(DEFAULT_ACCURACY)
    }

    fn wave(&self) -> WaveKind {
        self.wave.unwrap_or_default()
    }

    /// Whether only derivatives of the totals are printed.
    fn gradient_is_text(&self) -> bool {
        self.gradient == Some(GradientForm::Text)
    }
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum GradientForm {
    Json,
    Text,
}

/// Names of the discretisations along z.
const SCHEMES: [&str; 5] = ["tents", "quadratic", "cubic", "quartic", "second-difference"];

fn scheme_named(name: &str) -> serde_json::Result<Scheme> {
    serde_json::from_value(name.replace('-', "_").into())
}

/// The wave equations, by their names in files.
fn wave_kinds() -> impl TypedValueParser<Value = WaveKind> {
    let scalar = PossibleValue::new("scalar").help("The scalar wave equation");
    let vector = PossibleValue::new("vector").help("Maxwell's equations, for s and p light");
    PossibleValuesParser::new([scalar, vector])
        .map(|name| if name == "vector" { WaveKind::Vector } else { WaveKind::Scalar })
}

/// Runs the command.
pub fn run(mut args: SolveArgs) -> Result<()> {
    check(&args)?;
    let (case, wave) = args.point.case(&args.case)?;
    args.wave.get_or_insert(wave);
    let args = &args;
    check_case(args, &case)?;
    case.remarks.iter().for_each(|remark| note!("warning: {remark}"));
    // A grid given explicitly may be as fine as the user likes.
    let contrast = case.media.largest_contrast();
    let error = if args.nz.is_some() {
        Precision::EXACT.error
    } else {
        Precision::error_among(args.accuracy(), contrast)
    };
    let wave = args.wave().wave();
    let coverages = &Coverages::new(wave, &case.scene, Precision::of(error));
    let solver = &*SolverChoice::named(&args.solver).into_diagnostic()?.build();
    let memory = super::work::bytes(args.memory_gb)?;
    let solving = Solving { args, case: &case, wave, coverages, solver, memory };
    if case.directions.is_empty() { one_direction(&solving) } else { list::run(&solving) }
}

/// What the solves of a case share.
struct Solving<'a> {
    /// The options.
    args: &'a SolveArgs,
    /// The case.
    case: &'a Case,
    /// The wave equation.
    wave: Wave,
    coverages: &'a Coverages<'a>,
    solver: &'a dyn Solver,
    /// Memory for one solve, bytes.
    memory: f64,
}

impl Solving<'_> {
    /// The lights of the case, snapped if requested, each with its entry `snapped`.
    fn lights(&self) -> Result<Vec<(Incidence, Option<Value>)>> {
        let Case { incidence, directions, .. } = self.case;
        let listed = if directions.is_empty() { std::slice::from_ref(incidence) } else { directions };
        listed.iter().map(|light| self.args.light.snapped(self.case, *light)).collect()
    }

    /// The solve of one light.
    fn task<'a>(&'a self, incidence: &'a Incidence) -> Task<'a> {
        let args = self.args;
        Task {
            coverages: self.coverages,
            media: &self.case.media,
            incidence,
            mean: Mean { depends_on_z: !args.constant_mean, absorbing: !args.real_mean },
            scheme: scheme(args),
            solver: self.solver,
            goal: Goal { tolerance: tolerance(args), ..Goal::default() },
            memory: self.memory,
        }
    }

    /// The grid of the options; `None` if it is searched.
    fn resolution(&self) -> Option<Resolution> {
        self.args.nz.map(|cells| resolution(self.args, self.case, cells))
    }

    /// The derivatives if requested.
    fn gradients(&self, task: &Task, solved: &Estimated) -> Result<Vec<Gradient>> {
        let slopes = self.args.gradient.map(|_| gradients(task, solved));
        Ok(slopes.transpose().into_diagnostic()?.unwrap_or_default())
    }

    /// Everything that is printed of a solve but the remarks, and the first zero of a lit square's
    /// lobes, degrees.
    fn report(
        &self,
        solved: &Estimated,
        light: &Incidence,
        snapped: Option<&Value>,
        gradients: &[Gradient],
    ) -> Result<(Value, f64)> {
        let mut report = self.with_remarks(solve_report::report(solved, self.wave, light));
        let first_zero_deg = self.args.light.add_area(solved.far_field(), &self.case.media, &mut report)?;
        if let Some(snapped) = snapped {
            report["snapped"] = snapped.clone();
        }
        if self.args.gradient.is_some() {
            let orders = &solved.far_field().orders;
            report["gradients"] = gradients.iter().map(|gradient| gradient.json(orders)).collect();
        }
        Ok((report, first_zero_deg))
    }

    /// Adds the case's remarks, if there are any.
    fn with_remarks(&self, mut report: Value) -> Value {
        if !self.case.remarks.is_empty() {
            report["remarks"] = self.case.remarks.clone().into();
        }
        report
    }
}

/// Solves the only direction and prints its result.
fn one_direction(solving: &Solving) -> Result<()> {
    let args = solving.args;
    let (light, snapped) = solving.lights()?.swap_remove(0);
    let task = solving.task(&light);
    // cleared when it is dropped
    let mut bar = Bar::new();
    let solved = match solving.resolution() {
        Some(resolution) => task.solve_with_estimate(resolution, &mut bar),
        None => task.solve_to_accuracy(args.accuracy(), &mut bar),
    };
    let solved = solved.into_diagnostic()?;
    let gradients = solving.gradients(&task, &solved)?;
    drop(bar);
    if let Some(path) = &args.export_operator {
        export_operator(&solved, path)?;
    }
    if args.gradient_is_text() {
        if snapped.is_some() {
            let Incidence { polar_deg, azimuth_deg, .. } = light;
            note!("snapped: these are derivatives at polar_deg {polar_deg}, azimuth_deg {azimuth_deg}");
        }
        return say(gradient_text(&gradients).trim_end());
    }
    let (report, first_zero_deg) = solving.report(&solved, &light, snapped.as_ref(), &gradients)?;
    args.light.warn_of_step(first_zero_deg);
    say!("{report:#}")
}

/// The derivatives of the totals as a table.
fn gradient_text(gradients: &[Gradient]) -> String {
    gradients.iter().map(Gradient::text).collect()
}

/// Writes the discrete problem with its solution.
fn export_operator(solved: &Estimated, path: &Path) -> Result<()> {
    let Solved { system, solution } = &solved.solved[0];
    let split = system.split().ok_or_else(|| miette::miette!("--export-operator needs the scalar wave"))?;
    let bytes = operator(split, &solution.field, &solution.account).into_diagnostic()?;
    std::fs::write(path, bytes).map_err(|e| miette::miette!("cannot write {}: {e}", path.display()))
}

fn check(args: &SolveArgs) -> Result<()> {
    if let Some(tolerance) = args.tolerance.filter(|t| !(1e-15..1.0).contains(t)) {
        miette::bail!("--tolerance is {tolerance}; allowed is 1e-15 ≤ tolerance < 1: try 1e-6");
    }
    super::work::bytes(args.memory_gb).map(drop)
}

/// Checks options against the case and its wave.
fn check_case(args: &SolveArgs, case: &Case) -> Result<()> {
    if args.nz.is_some() && args.nxy.is_none() && !case.scene.uniform_in_plane() {
        miette::bail!(
            "--nxy is missing; a case with grains needs both: try --nxy 20, or --accuracy 1e-3 alone"
        );
    }
    let vector = args.wave() == WaveKind::Vector;
    if args.export_operator.is_some() && vector {
        miette::bail!("--export-operator writes the operator of the scalar wave: take --wave scalar");
    }
    args.light.check(case, vector)
}

/// Residual to reach; the amplitude error that it causes may be three times as large.
fn tolerance(args: &SolveArgs) -> f64 {
    let usual = if args.nz.is_some() { Goal::default().tolerance } else { args.accuracy() / 50.0 };
    args.tolerance.unwrap_or(usual)
}

fn resolution(args: &SolveArgs, case: &Case, cells: usize) -> Resolution {
    let points = args.nxy.unwrap_or(1);
    let nx = if case.scene.uniform_in_plane() { 1 } else { points };
    let ny = if case.scene.uniform_in_y() { 1 } else { points };
    Resolution { nx, ny, cells, scheme: scheme(args) }
}

fn scheme(args: &SolveArgs) -> Scheme {
    args.scheme.unwrap_or(match (args.wave(), args.nz) {
        (WaveKind::Vector, _) => Scheme::Quadratic,
        (WaveKind::Scalar, Some(_)) => Scheme::default(),
        (WaveKind::Scalar, None) => suited_scheme(args.accuracy()),
    })
}

/// Grid trials that take longer than this are reported even without a terminal.
const SAID_SECONDS: f64 = 2.0;

/// Spinner on standard error that shows the residual; hidden if this is not a terminal.
struct Bar(indicatif::ProgressBar);

impl Bar {
    fn new() -> Bar {
        let bar = indicatif::ProgressBar::new_spinner();
        bar.set_style(style("{spinner} {prefix}  {msg}"));
        bar.enable_steady_tick(std::time::Duration::from_millis(200));
        Bar(bar)
    }
}

impl Watch for Bar {
    fn step(&mut self, step: &Step) -> ControlFlow<()> {
        self.0.set_message(format!("step {}: residual {:.1e}", step.step, step.residual));
        ControlFlow::Continue(())
    }

    fn grid(&mut self, trial: &GridTrial) {
        self.0.set_prefix(format!("{trial}"));
        // Without a terminal, short searches print nothing.
        if trial.estimate.is_some() && (!self.0.is_hidden() || trial.seconds > SAID_SECONDS) {
            self.0.suspend(|| note!("grid tried: {trial}"));
        }
    }
}
