//! Method comparison: strategies × resolutions × discretisations on one geometry, side by side.

pub use super::error::CompareError;
pub use super::layer::PackedLayer;
use super::pages::{Comparison, Row};
use crate::input::case::Case;
use crate::input::fault::StudyError;
use crate::input::read::read as read_tree;
use crate::input::tree::parse_toml;
use crate::numerics::files;
use crate::run::memory;
use crate::solve::accuracy::{AccuracyError, Task, error_estimate, largest_difference};
use crate::solve::{Coverages, Gmres, Goal, Registry, Silent, SolveError, Solver, Watch};
use crate::wave::{FarField, Mean, Physical, Problem, Resolution, Scene, Scheme, TotalErrors};
use num_complex::Complex64;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A comparison as written (TOML). Lengths in the units of the key names; indices as [re, im].
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComparisonFile {
    /// Title, for people.
    #[serde(default)]
    pub title: String,
    /// A case file (relative to this file), instead of `layer`.
    pub case: Option<PathBuf>,
    /// A packed layer of equal spheres, instead of `case`.
    pub layer: Option<PackedLayer>,
    /// Many contrasts and periods around `layer` instead of many grids.
    pub matrix: Option<super::matrix::MatrixTable>,
    /// Names of strategies; all of the registry but those for tiny grids unless told.
    pub strategies: Option<Vec<String>>,
    /// Discretisations along z to compare.
    #[serde(default = "default_schemes")]
    pub schemes: Vec<Scheme>,
    /// Grids to compare.
    #[serde(default = "default_resolutions")]
    pub resolutions: Vec<Points>,
    /// Keeps absorption in ⟨k²⟩; relaxation is then left out. Off by default: all strategies share one problem.
    #[serde(default)]
    pub absorbing_mean: bool,
    /// Lets ⟨k²⟩ follow the composition along z, or takes one for the whole layer.
    #[serde(default = "default_true")]
    pub mean_depends_on_z: bool,
    /// Residual to reach, and the most operator applications.
    #[serde(default)]
    pub goal: Goal,
    /// Solves of each row; the median of their seconds is kept.
    #[serde(default = "default_repeats")]
    pub repeats: usize,
}

/// One resolution of the list.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Points {
    /// Points along x and y of one period.
    pub points: usize,
    /// Cells along z.
    pub cells: usize,
}

impl Default for ComparisonFile {
    fn default() -> Self {
        Self {
            title: String::new(),
            case: None,
            layer: None,
            matrix: None,
            strategies: None,
            schemes: default_schemes(),
            resolutions: default_resolutions(),
            absorbing_mean: false,
            mean_depends_on_z: true,
            goal: Goal::default(),
            repeats: default_repeats(),
        }
    }
}

fn default_schemes() -> Vec<Scheme> {
    vec![Scheme::Cubic, Scheme::SecondDifference]
}

fn default_resolutions() -> Vec<Points> {
    [(9, 8), (15, 12), (25, 20)].map(|(points, cells)| Points { points, cells }).to_vec()
}

fn default_true() -> bool {
    true
}

fn default_repeats() -> usize {
    3
}

/// The geometry, and the reference amplitudes if its file has them.
struct Subject {
    case: Case,
    known: Option<serde_json::Value>,
}

impl ComparisonFile {
    /// Reads a comparison; a plain case file is compared with the default lists.
    pub fn read(path: &Path) -> Result<ComparisonFile, CompareError> {
        let read =
            |message: std::io::Error| CompareError::Read { path: path.into(), message: message.to_string() };
        if path.extension().is_some_and(|e| e == "json") {
            let case = path.file_name().map(PathBuf::from);
            return Ok(ComparisonFile { case, ..ComparisonFile::default() });
        }
        let text = files::read_text(path, files::STUDY).map_err(read)?;
        let table = parse_toml(&text).map_err(|fault| fault.in_file(path, &text))?;
        let values = |faults| StudyError::Values { path: path.into(), text: text.clone(), faults };
        Ok(read_tree(table.into()).map_err(values)?)
    }

    /// The strategies to compare, each of them known.
    fn strategies(&self, registry: &Registry) -> Result<Vec<(String, Box<dyn Solver>)>, CompareError> {
        let by_name = |name: &String| Ok((name.clone(), registry.build(name)?));
        match &self.strategies {
            Some(names) => names.iter().map(by_name).collect(),
            None => {
                let all = registry.entries().iter().map(|e| (e.name().to_string(), e.build()));
                Ok(all.filter(|(_, solver)| solver.most_unknowns().is_none()).collect())
            }
        }
    }

    fn check(&self) -> Result<(), CompareError> {
        let empty = [
            ("strategies", self.strategies.as_ref().is_some_and(Vec::is_empty)),
            ("schemes", self.schemes.is_empty()),
            ("resolutions", self.resolutions.is_empty()),
            ("repeats", self.repeats == 0),
        ];
        if let Some((field, _)) = empty.into_iter().find(|(_, e)| *e) {
            let allowed = "at least one".to_string();
            return Err(CompareError::Field {
                field,
                found: "empty".into(),
                allowed,
                remedy: "add one or leave it out",
            });
        }
        if self.case.is_some() == self.layer.is_some() {
            return Err(CompareError::Field {
                field: "geometry",
                found: if self.case.is_some() { "given twice" } else { "missing" }.into(),
                allowed: "exactly one of `case` and `[layer]`".into(),
                remedy: "name a case file or describe a packed layer",
            });
        }
        Ok(())
    }

    fn subject(&self, folder: &Path) -> Result<Subject, CompareError> {
        if let Some(path) = &self.case {
            let path = folder.join(path);
            let case = Case::read(&path)?;
            let json = files::read_text(&path, files::CASE).ok().and_then(|t| serde_json::from_str(&t).ok());
            let known =
                json.and_then(|v: serde_json::Value| v.get("outputs").and_then(|o| o.get("orders")).cloned());
            return Ok(Subject { case, known });
        }
        let layer = self.layer.as_ref().expect("checked: a case or a layer");
        Ok(Subject { case: layer.case()?, known: None })
    }

    /// Runs the matrix, if one is asked for; `watch` sees each solve's steps and can stop it.
    ///
    /// # Errors
    /// Unknown strategies; layers that cannot be packed; cases that the reference strategy cannot solve; Ctrl-C.
    pub fn run_matrix(
        &self,
        registry: &Registry,
        watch: &mut dyn Watch,
        told: impl FnMut(&super::matrix::Cell),
    ) -> Result<Option<super::matrix::Matrix>, CompareError> {
        let (Some(matrix), Some(layer)) = (&self.matrix, &self.layer) else { return Ok(None) };
        self.check()?;
        let strategies = self.strategies(registry)?;
        let cells = matrix.run(layer, &strategies, watch, told)?;
        let names = strategies.into_iter().map(|(name, _)| name.to_string()).collect();
        let (title, accuracy) = (self.title.clone(), matrix.accuracy);
        Ok(Some(super::matrix::Matrix { title, accuracy, strategies: names, cells }))
    }

    /// Runs every row with the strategies of `registry`; `watch` sees each solve's steps and can stop the comparison.
    pub fn run(
        &self,
        registry: &Registry,
        folder: &Path,
        watch: &mut dyn Watch,
        mut told: impl FnMut(&Row),
    ) -> Result<Comparison, CompareError> {
        self.check()?;
        let strategies = self.strategies(registry)?;
        let subject = self.subject(folder)?;
        let (truth, reference) = self.reference(&subject)?;
        let coverages = Coverages::of(&subject.case.scene);
        let mut rows = Vec::new();
        for scheme in &self.schemes {
            for points in &self.resolutions {
                let resolution = resolution(&subject.case.scene, *points, *scheme);
                for (name, solver) in &strategies {
                    let row =
                        self.row((name, &**solver), resolution, &subject.case, &coverages, &truth, watch)?;
                    told(&row);
                    rows.push(row);
                }
            }
        }
        Ok(Comparison { title: self.title.clone(), reference, rows })
    }

    /// Amplitudes to compare with: those of the case file, or a solve at half as many points and cells again.
    fn reference(&self, subject: &Subject) -> Result<(FarField, String), CompareError> {
        let most = |f: fn(&Points) -> usize| self.resolutions.iter().map(f).max().unwrap_or(1);
        let finest = Points { points: 3 * most(|p| p.points) / 2, cells: 3 * most(|p| p.cells) / 2 };
        let resolution = resolution(&subject.case.scene, finest, Scheme::Cubic);
        let case = &subject.case;
        let task = Task {
            coverages: &Coverages::of(&case.scene),
            media: &case.media,
            incidence: &case.incidence,
            mean: Mean::default(),
            scheme: Scheme::Cubic,
            solver: &Gmres::default(),
            goal: Goal { tolerance: 1e-9, ..Goal::default() },
            memory: memory::usable(),
        };
        let (problem, solution, _) = task.solve(resolution, &mut Silent)?;
        let errors = TotalErrors::of_totals([1.0; 2], solution.account.residual);
        let mut far = Physical::judge(problem.far_field(&solution.field), errors)
            .map_err(AccuracyError::Unphysical)?
            .into_inner();
        if let Some(known) = subject.known.as_ref().and_then(|k| k.as_array()) {
            far.orders.retain_mut(|o| replace(o, known));
            return Ok((far, "the case file's own amplitudes".into()));
        }
        let name = format!(
            "krylov on {} × {} points and {} cubic cells",
            resolution.nx, resolution.ny, resolution.cells
        );
        Ok((far, name))
    }

    /// One line: a result, or the reason why there is none. Errors: the user stopped it.
    fn row(
        &self,
        (name, solver): (&str, &dyn Solver),
        resolution: Resolution,
        case: &Case,
        coverages: &Coverages,
        truth: &FarField,
        watch: &mut dyn Watch,
    ) -> Result<Row, CompareError> {
        let task = Task {
            coverages,
            media: &case.media,
            incidence: &case.incidence,
            mean: Mean { depends_on_z: self.mean_depends_on_z, absorbing: self.absorbing_mean },
            scheme: resolution.scheme,
            solver,
            goal: self.goal,
            memory: memory::usable(),
        };
        let mut row = Row::new(name, resolution);
        match self.measure(&task, resolution, truth, &mut row, watch) {
            Err(AccuracyError::Solve(cancelled @ SolveError::Cancelled { .. })) => Err(cancelled.into()),
            Err(error) => {
                let account = match &error {
                    AccuracyError::Solve(error) => error.account().cloned(),
                    _ => None,
                };
                account.iter().for_each(|account| row.take(account));
                row.outcome = error.to_string();
                Ok(row)
            }
            Ok(()) => Ok(row),
        }
    }

    /// Solves as often as was asked, and judges the first result.
    fn measure(
        &self,
        task: &Task,
        resolution: Resolution,
        truth: &FarField,
        row: &mut Row,
        watch: &mut dyn Watch,
    ) -> Result<(), AccuracyError> {
        let solver = task.admitted(resolution)?;
        let coverage = task.coverages.at(resolution)?;
        let problem = Problem::new(&coverage, task.media, task.incidence, task.mean)?;
        (row.unknowns, row.bytes) = (problem.unknowns(), problem.bytes());
        let solution = solver.solver().solve(&problem, task.goal, watch)?;
        row.take(&solution.account);
        let far = problem.far_field(&solution.field);
        let error = largest_difference(truth, &far);
        let residual = solution.account.residual;
        row.error_estimate = match task.estimate_parts((&problem, &solution), &far, watch) {
            Err(stopped @ AccuracyError::Solve(SolveError::Cancelled { .. })) => return Err(stopped),
            parts => parts.ok().map(|parts| error_estimate(parts, residual)),
        };
        let errors = TotalErrors::of_amplitudes(row.error_estimate.unwrap_or(error), residual);
        Physical::judge(far, errors)?;
        let mut seconds = vec![solution.account.seconds];
        for _ in 1..self.repeats {
            seconds.push(solver.solver().solve(&problem, task.goal, watch)?.account.seconds);
        }
        seconds.sort_by(f64::total_cmp);
        row.seconds = seconds[seconds.len() / 2];
        row.error = Some(error);
        row.outcome = "converged".into();
        Ok(())
    }
}

/// Puts a reference order's amplitudes in place; false where the reference does not list it.
fn replace(order: &mut crate::wave::Order, known: &[serde_json::Value]) -> bool {
    let same = |k: &&serde_json::Value| {
        k["m"] == order.m && (k["n"] == order.n || (k["n"].is_null() && order.n == 0))
    };
    let Some(found) = known.iter().find(same) else { return false };
    let amplitude = |key: &str| Some(Complex64::new(found[key][0].as_f64()?, found[key][1].as_f64()?));
    order.reflected = amplitude("R").unwrap_or(order.reflected);
    order.transmitted = amplitude("T").unwrap_or(order.transmitted);
    true
}

fn resolution(scene: &Scene, points: Points, scheme: Scheme) -> Resolution {
    let nx = if scene.uniform_in_plane() { 1 } else { points.points };
    let ny = if scene.uniform_in_y() { 1 } else { points.points };
    Resolution { nx, ny, cells: points.cells, scheme }
}
